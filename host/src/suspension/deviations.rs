//! What small changes of data and layout do to the modes.

use massline_shared::layout::motion_at;
use massline_shared::modes::{MOST_PAIRS, Modes};
use nalgebra::Vector3;

/// Numbers of a mode: frequency, damping ratio, shape.
const FIGURES: usize = 8;

/// What small changes do to the modes.
#[derive(Clone, Debug)]
pub(super) struct Deviations {
    /// The point that the shapes of the fit refer to, m.
    reference: Vector3<f64>,
    unchanged: Option<Modes<f64>>,
    /// Sums of squares under noise and under errors of the layout.
    noise: [[f64; FIGURES]; MOST_PAIRS],
    layout: [[f64; FIGURES]; MOST_PAIRS],
    draws: u32,
}

impl Deviations {
    pub(super) fn new(reference: Vector3<f64>) -> Self {
        let zero = [[0.0; FIGURES]; MOST_PAIRS];
        Self { reference, unchanged: None, noise: zero, layout: zero, draws: 0 }
    }

    /// Adds changed modes; the first ones are the unchanged ones. `noise` tells a draw of noise from an error of the layout.
    pub(super) fn add(&mut self, changed: &Modes<f64>, noise: bool) {
        let Some(unchanged) = &self.unchanged else {
            self.unchanged = Some(changed.clone());
            return;
        };
        self.draws += u32::from(noise);
        let sums = if noise { &mut self.noise } else { &mut self.layout };
        for (sums, (new, old)) in sums.iter_mut().zip(changed.modes.iter().zip(&unchanged.modes)) {
            // A shape has no sign.
            let sign = if new.shape.dot(&old.shape) < 0.0 { -1.0 } else { 1.0 };
            sums[0] += (new.frequency_hz - old.frequency_hz).powi(2);
            sums[1] += (new.damping_ratio - old.damping_ratio).powi(2);
            let moved = motion_at(&(new.shape * sign - old.shape), &-self.reference);
            for (sum, moved) in sums[2..].iter_mut().zip(&moved) {
                *sum += moved.powi(2);
            }
        }
    }

    /// Standard deviations; NaN when nothing was perturbed.
    pub(super) fn sigma(&self, place: usize) -> [f64; FIGURES] {
        let draws = f64::from(self.draws);
        std::array::from_fn(|k| (self.noise[place][k] / draws + self.layout[place][k]).sqrt())
    }
}
