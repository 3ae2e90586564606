//! Labels that keep clear of each other and of what is drawn.

use std::f64::consts::TAU;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, DrawingOutcome, text, write};
use super::theme::SMALL;

/// Left, upper, right and lower end, pixels.
type Bounds = [i32; 4];

/// What labels keep free beside a line, to each side, and the distance of the places at which that is checked, pixels.
const BESIDE: i32 = 5;
const STEP: f64 = 6.0;
/// The first ring of places is this far from the point that a label names, pixels.
const NEAREST: i32 = 18;
/// Rings of places about a point: near enough to see what a label belongs to.
const RINGS: i32 = 6;
/// Places on a ring.
const PLACES: i32 = 16;

/// The labels of a picture.
#[derive(Default)]
pub(super) struct Labels {
    /// What they must not cover: marks and arrows.
    kept: Vec<Bounds>,
    /// What they cover only where there is no room else: thin lines.
    avoided: Vec<Bounds>,
    /// Where they are.
    written: Vec<Bounds>,
    /// The picture's size, pixels; nothing is written beyond.
    size: (i32, i32),
}

/// True for boxes that have nothing in common.
fn are_apart(a: &Bounds, b: &Bounds) -> bool {
    a[2] < b[0] || b[2] < a[0] || a[3] < b[1] || b[3] < a[1]
}

fn about((x, y): (i32, i32), half: i32) -> Bounds {
    [x - half, y - half, x + half, y + half]
}

/// Boxes along a line.
fn along(from: (i32, i32), to: (i32, i32)) -> impl Iterator<Item = Bounds> {
    let step = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
    let pieces = (step.0.hypot(step.1) / STEP).ceil().max(1.0) as i32;
    (0..=pieces).map(move |k| {
        let share = f64::from(k) / f64::from(pieces);
        let at = |from: i32, step: f64| from + (share * step).round() as i32;
        about((at(from.0, step.0), at(from.1, step.1)), BESIDE)
    })
}

impl Labels {
    /// No labels yet, in a picture of this size.
    pub fn within((width, height): (u32, u32)) -> Self {
        Self { size: (width as i32, height as i32), ..Self::default() }
    }

    /// Keeps a square about a point free of labels.
    pub fn keep(&mut self, at: (i32, i32), half: i32) {
        self.kept.push(about(at, half));
    }

    /// Keeps a line free of labels.
    pub fn keep_line(&mut self, from: (i32, i32), to: (i32, i32)) {
        self.kept.extend(along(from, to));
    }

    /// Keeps thin lines through these points free of labels where there is room.
    pub fn avoid(&mut self, line: &[(i32, i32)]) {
        line.windows(2).for_each(|ends| self.avoided.extend(along(ends[0], ends[1])));
    }

    /// Writes a label beside a point, where the nearest free place is.
    pub fn write<B: DrawingBackend>(
        &mut self,
        area: &Area<B>,
        words: &str,
        at: (i32, i32),
    ) -> DrawingOutcome<B> {
        let (width, height) = area.estimate_text_size(words, &text(SMALL))?;
        let bounds = self.place(at, (width as i32, height as i32 + 4));
        self.written.push(bounds);
        let middle = ((bounds[0] + bounds[2]) / 2, (bounds[1] + bounds[3]) / 2);
        write(area, words, middle, (HPos::Center, VPos::Center), SMALL)
    }

    /// The nearest place for a label of this size that is free, else one that covers thin lines only, else the one
    /// above.
    fn place(&self, at: (i32, i32), (width, height): (i32, i32)) -> Bounds {
        let boxed = |(dx, dy): (i32, i32)| {
            let (x, y) = (at.0 + dx, at.1 + dy);
            [x - width / 2, y - height / 2, x + width / 2, y + height / 2]
        };
        let rings = (0..RINGS).map(|ring| NEAREST + ring * (height + 2));
        let places: Vec<Bounds> = rings
            .flat_map(|far| (0..PLACES).map(move |k| beside(far, k, (width, height))))
            .map(boxed)
            .filter(|bounds| self.is_allowed(bounds))
            .collect();
        let is_clear = |bounds: &&Bounds| self.avoided.iter().all(|other| are_apart(bounds, other));
        let bounds = places.iter().find(is_clear).or(places.first());
        bounds.copied().unwrap_or_else(|| boxed((0, -NEAREST)))
    }

    /// Whether a label may be there.
    fn is_allowed(&self, bounds: &Bounds) -> bool {
        let (width, height) = self.size;
        let is_inside =
            bounds[0] >= 0 && bounds[1] >= 0 && bounds[2] <= width && bounds[3] <= height;
        is_inside && self.kept.iter().chain(&self.written).all(|other| are_apart(bounds, other))
    }
}

/// The middle of a label of this size from its point, on a ring of this radius.
fn beside(far: i32, k: i32, (width, height): (i32, i32)) -> (i32, i32) {
    let (sin, cos) = (TAU * f64::from(k) / f64::from(PLACES)).sin_cos();
    let far = f64::from(far);
    let x = cos * (far + f64::from(width) / 2.0);
    let y = sin * (far + f64::from(height) / 4.0);
    (x.round() as i32, y.round() as i32)
}

#[cfg(test)]
impl Labels {
    /// The number of labels.
    pub fn count(&self) -> usize {
        self.written.len()
    }

    /// The labels that cover another or what they must not.
    pub fn collisions(&self) -> Vec<Bounds> {
        let covers = |(place, label): &(usize, &Bounds)| {
            let others = self.written[..*place].iter().chain(&self.kept);
            others.into_iter().any(|other| !are_apart(label, other))
        };
        self.written.iter().enumerate().filter(covers).map(|(_, label)| *label).collect()
    }

    /// The labels that thin lines strike through.
    pub fn struck(&self) -> usize {
        let is_struck =
            |label: &&Bounds| self.avoided.iter().any(|avoided| !are_apart(label, avoided));
        self.written.iter().filter(is_struck).count()
    }
}
