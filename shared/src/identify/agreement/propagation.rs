//! The same small changes put through several methods at once.

use nalgebra::{SMatrix, SVector};

use crate::capacity::Capacity;
use crate::identify::Perturbation;
use crate::layout::Layout;
use crate::real::Real;

/// Draws of noise. The covariance of six methods has to be known well enough to weigh them: with 100 draws the
/// intervals of the combined estimate cover 91 % instead of 95 %.
pub const NOISE_DRAWS: u32 = 200;
/// Part of the draws that a method may leave unanswered.
const MOST_UNANSWERED: f64 = 0.05;

/// Answers of `M` methods to one change; `None` where a method has none.
pub type Answers<R, const M: usize> = [Option<SVector<R, 10>>; M];

/// What the changes have shown: covariance of the answers of `M` methods with each other.
#[derive(Clone, Debug)]
pub struct Propagation<R, const M: usize> {
    /// Sums of the products of the deviations under noise, and their number.
    noise: Sums<R, M>,
    /// The same under errors of the layout.
    layout: Sums<R, M>,
    asked: u32,
    /// Errors of the layout that were asked about.
    shifts: u32,
}

#[derive(Clone, Debug)]
struct Sums<R, const M: usize> {
    products: [[SMatrix<R, 10, 10>; M]; M],
    counts: [[u32; M]; M],
}

impl<R: Real, const M: usize> Sums<R, M> {
    fn new() -> Self {
        Self { products: [[SMatrix::zeros(); M]; M], counts: [[0; M]; M] }
    }

    fn add(&mut self, deviations: &Answers<R, M>) {
        for (a, first) in deviations.iter().enumerate() {
            for (b, second) in deviations.iter().enumerate().take(a + 1) {
                let Some((first, second)) = first.as_ref().zip(second.as_ref()) else { continue };
                self.products[a][b].ger(R::one(), first, second, R::one());
                self.counts[a][b] += 1;
            }
        }
    }

    fn element(&self, a: usize, b: usize, k: usize, l: usize) -> (R, u32) {
        if a >= b {
            (self.products[a][b][(k, l)], self.counts[a][b])
        } else {
            (self.products[b][a][(l, k)], self.counts[b][a])
        }
    }
}

impl<R: Real, const M: usize> Propagation<R, M> {
    /// Nothing has been asked yet.
    pub fn empty() -> Self {
        Self { noise: Sums::new(), layout: Sums::new(), asked: 0, shifts: 0 }
    }

    /// What the answers to all [`changes`] show, in their order.
    pub fn of(answers: impl IntoIterator<Item = Option<Answers<R, M>>>) -> Self {
        let mut propagation = Self { asked: NOISE_DRAWS, ..Self::empty() };
        let mut answers = answers.into_iter();
        let Some(unchanged) = answers.next().flatten() else { return propagation };
        for (place, changed) in answers.enumerate() {
            let Some(changed) = changed else { continue };
            let deviations =
                core::array::from_fn(|m| changed[m].zip(unchanged[m]).map(|(new, old)| new - old));
            if place < NOISE_DRAWS as usize {
                propagation.noise.add(&deviations);
            } else {
                propagation.shifts += 1;
                propagation.layout.add(&deviations);
            }
        }
        propagation
    }

    /// Covariance of one property of the answer of a method with one property of the answer of another.
    pub fn element(&self, [first, second]: [usize; 2], [k, l]: [usize; 2]) -> R {
        let (noise, draws) = self.noise.element(first, second, k, l);
        noise / R::of(f64::from(draws.max(1))) + self.layout.element(first, second, k, l).0
    }

    /// Covariance of `theta` of a method.
    pub fn of_method(&self, method: usize) -> SMatrix<R, 10, 10> {
        SMatrix::from_fn(|k, l| self.element([method; 2], [k, l]))
    }

    /// The share of the changes that a method has not answered, if it is so large that its answer is not stable: more
    /// than a few draws of noise, or any error of the layout, whose effect is then unknown.
    pub fn unstable(&self, method: usize) -> Option<f64> {
        let missing = |sums: &Sums<R, M>, asked: u32| {
            f64::from(asked - sums.counts[method][method]) / f64::from(asked.max(1))
        };
        let of_draws = missing(&self.noise, self.asked);
        let of_shifts = missing(&self.layout, self.shifts);
        let is_answered = self.noise.counts[method][method] > 0;
        let is_unstable = of_draws > MOST_UNANSWERED || of_shifts > 0.0 || !is_answered;
        is_unstable.then_some(of_draws.max(of_shifts))
    }

    /// Number of draws of noise.
    pub(super) fn draws(&self) -> u32 {
        self.asked
    }
}

/// Number of changes that are asked about: none, [`NOISE_DRAWS`] draws of noise, then every error of the layout with
/// one standard deviation.
pub fn changes<R: Real, C: Capacity>(layout: &Layout<R, C>) -> u32 {
    let quantities = u32::try_from(layout.uncertain_quantities().count()).unwrap_or(0);
    1 + NOISE_DRAWS + quantities
}

/// Asks about the change of this number; `None` for an error that the layout does not have.
pub fn ask<T, R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    change: u32,
    answers: impl FnOnce(&Perturbation<'_, R, C>) -> T,
) -> Option<T> {
    if change <= NOISE_DRAWS {
        let draw = change.checked_sub(1);
        return Some(answers(&Perturbation { layout, quantity: None, draw }));
    }
    let mut shifted = layout.clone();
    let quantity = Some((change - 1 - NOISE_DRAWS) as usize);
    let uncertain = layout.uncertain_quantities().nth(quantity?)?;
    shifted
        .shift(uncertain)
        .then(|| answers(&Perturbation { layout: &shifted, quantity, draw: None }))
}
