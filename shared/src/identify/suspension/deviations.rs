//! What small changes do to the modes.

use nalgebra::{Vector3, Vector6};

use crate::layout::motion_at;
use crate::modes::{Mode, SUSPENSION_MODES};
use crate::real::Real;

/// Numbers of a mode: frequency, damping ratio, shape.
const FIGURES: usize = 8;

/// What small changes of the data and of the layout do to the modes.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeDeviations<R> {
    /// The point that the shapes of the fit refer to, m.
    reference: Vector3<R>,
    unchanged: Option<[[R; FIGURES]; SUSPENSION_MODES]>,
    /// Sums of squares under noise and under errors of the layout.
    noise: [[R; FIGURES]; SUSPENSION_MODES],
    layout: [[R; FIGURES]; SUSPENSION_MODES],
    draws: u32,
}

impl<R: Real> ModeDeviations<R> {
    /// Nothing is known; `reference` is the point that the shapes of the fit refer to, in the body frame, m.
    pub fn new(reference: Vector3<R>) -> Self {
        let zero = [[R::zero(); FIGURES]; SUSPENSION_MODES];
        Self { reference, unchanged: None, noise: zero, layout: zero, draws: 0 }
    }

    /// Adds changed modes; the first ones are the unchanged ones. `noise` tells a draw of noise from an error of the
    /// layout.
    pub fn add(&mut self, changed: &[Mode<R>], noise: bool) {
        let Some(unchanged) = &self.unchanged else {
            let mut unchanged = [[R::zero(); FIGURES]; SUSPENSION_MODES];
            unchanged.iter_mut().zip(changed).for_each(|(to, mode)| *to = figures(mode));
            self.unchanged = Some(unchanged);
            return;
        };
        self.draws += u32::from(noise);
        let sums = if noise { &mut self.noise } else { &mut self.layout };
        for (sums, (new, old)) in sums.iter_mut().zip(changed.iter().zip(unchanged)) {
            let was = shape(old);
            // A shape has no sign.
            let sign = if new.shape.dot(&was) < R::zero() { -R::one() } else { R::one() };
            let moved = motion_at(&(new.shape * sign - was), &-self.reference);
            let mut change = figures(new);
            change[0] -= old[0];
            change[1] -= old[1];
            change[2..].copy_from_slice(moved.as_slice());
            sums.iter_mut().zip(change).for_each(|(sum, change)| *sum += change * change);
        }
    }

    /// Standard deviations of frequency (Hz), damping ratio and shape at the origin of the body frame of the mode at
    /// this place; not a number when nothing was changed, and for a mode that there is not.
    pub fn sigma(&self, place: usize) -> [R; FIGURES] {
        let draws = R::of(f64::from(self.draws));
        let sums = self.noise.get(place).zip(self.layout.get(place));
        let [noise, layout] = sums.map_or([[R::zero() / R::zero(); FIGURES]; 2], |(n, l)| [*n, *l]);
        core::array::from_fn(|k| (noise[k] / draws + layout[k]).sqrt())
    }
}

fn figures<R: Real>(mode: &Mode<R>) -> [R; FIGURES] {
    let mut figures = [mode.frequency_hz; FIGURES];
    figures[1] = mode.damping_ratio;
    figures[2..].copy_from_slice(mode.shape.as_slice());
    figures
}

fn shape<R: Real>(figures: &[R; FIGURES]) -> Vector6<R> {
    Vector6::from_fn(|i, _| figures[2 + i])
}
