//! The covariances of several methods in little memory.

use nalgebra::Complex;

use super::propagation::{Answers, JointCovariances, too_few};
use crate::Real;

/// What the changes have shown, as [`Propagation`](super::Propagation), in lent memory: the lower triangle of the covariance of
/// all answers of `M` methods, two numbers in each complex one. The draws of noise come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PackedPropagation<const M: usize> {
    /// Numbers of draws that two methods have both answered.
    draws: [[u16; M]; M],
    /// Numbers of errors of the layout that each has answered.
    shifts: [u16; M],
    /// Numbers of draws and of errors of the layout that were asked about.
    asked: [u16; 2],
}

impl<const M: usize> PackedPropagation<M> {
    /// Complex numbers of memory.
    pub const MEMORY: usize = (10 * M * (10 * M + 1) / 2).div_ceil(2);

    /// Nothing has been asked yet. Clears the memory; `None` when it is too small.
    pub fn new<R: Real>(memory: &mut [Complex<R>]) -> Option<Self> {
        memory.get_mut(..Self::MEMORY)?.fill(Complex::new(R::zero(), R::zero()));
        Some(Self { draws: [[0; M]; M], shifts: [0; M], asked: [0; 2] })
    }

    /// Adds what a draw of noise has changed in the answers; nothing when no method was asked.
    pub fn add_draw<R: Real>(&mut self, memory: &mut [Complex<R>], deviations: &Answers<R, M>) {
        self.asked[0] = self.asked[0].saturating_add(1);
        for (a, first) in deviations.iter().enumerate() {
            for (b, second) in deviations.iter().enumerate() {
                self.draws[a][b] += u16::from(first.is_some() && second.is_some());
            }
        }
        add(memory, deviations);
    }

    /// Divides the sums by the numbers of draws, after the last of them.
    pub fn end_draws<R: Real>(&self, memory: &mut [Complex<R>]) {
        for row in 0..10 * M {
            for column in 0..=row {
                let draws = self.draws[row / 10][column / 10].max(1);
                let at = place(row, column);
                *number(memory, at) /= R::of(f64::from(draws));
            }
        }
    }

    /// Adds what an error of the layout has changed in the answers.
    pub fn add_shift<R: Real>(&mut self, memory: &mut [Complex<R>], deviations: &Answers<R, M>) {
        self.asked[1] = self.asked[1].saturating_add(1);
        for (count, deviation) in self.shifts.iter_mut().zip(deviations) {
            *count += u16::from(deviation.is_some());
        }
        add(memory, deviations);
    }

    /// The covariances in this memory.
    pub fn covariances<'m, R: Real>(
        &'m self,
        memory: &'m [Complex<R>],
    ) -> impl JointCovariances<R> + 'm {
        View { counts: self, memory }
    }
}

struct View<'m, R, const M: usize> {
    counts: &'m PackedPropagation<M>,
    memory: &'m [Complex<R>],
}

impl<R: Real, const M: usize> JointCovariances<R> for View<'_, R, M> {
    fn element(&self, methods: [usize; 2], properties: [usize; 2]) -> R {
        let [row, column] = [0, 1].map(|k| 10 * methods[k] + properties[k]);
        let at = place(row.max(column), row.min(column));
        let both = self.memory[at / 2];
        if at.is_multiple_of(2) { both.re } else { both.im }
    }

    fn unstable(&self, method: usize) -> Option<f64> {
        let PackedPropagation { draws, shifts, asked } = self.counts;
        let answered = [draws[method][method], shifts[method]];
        too_few(answered.map(u32::from), asked.map(u32::from))
    }

    fn draws(&self) -> u32 {
        u32::from(self.counts.asked[0])
    }
}

fn add<R: Real, const M: usize>(memory: &mut [Complex<R>], deviations: &Answers<R, M>) {
    for (a, first) in deviations.iter().enumerate() {
        for (b, second) in deviations.iter().enumerate().take(a + 1) {
            let Some((first, second)) = first.as_ref().zip(second.as_ref()) else { continue };
            for k in 0..10 {
                let last = if a == b { k } else { 9 };
                for l in 0..=last {
                    *number(memory, place(10 * a + k, 10 * b + l)) += first[k] * second[l];
                }
            }
        }
    }
}

/// The place of an element of the lower triangle, row by row.
fn place(row: usize, column: usize) -> usize {
    row * (row + 1) / 2 + column
}

fn number<R>(memory: &mut [Complex<R>], at: usize) -> &mut R {
    let both = &mut memory[at / 2];
    if at.is_multiple_of(2) { &mut both.re } else { &mut both.im }
}

#[cfg(test)]
mod tests {
    use super::super::{NOISE_DRAWS, Propagation};
    use super::*;
    use crate::identify::random_signs;
    use nalgebra::SVector;
    use std::vec::Vec;

    #[test]
    fn the_covariances_are_those_of_the_large_memory() {
        // The second method leaves every fortieth draw unanswered.
        let answer = |change: u32| -> Answers<f64, 3> {
            core::array::from_fn(|m| {
                let silent = m == 1 && change % 40 == 3;
                let of = |k: usize| {
                    f64::from(random_signs(change, k)[0] + 2 * random_signs(change, m * k)[1])
                };
                (!silent).then(|| SVector::<f64, 10>::from_fn(|k, _| of(k)))
            })
        };
        let changes = 1 + NOISE_DRAWS + 3;
        let whole = Propagation::of((0..changes).map(|change| Some(answer(change))));
        let mut memory: Vec<Complex<f64>> =
            (0..PackedPropagation::<3>::MEMORY).map(|_| Complex::new(1.0, 1.0)).collect();
        let mut packed = PackedPropagation::<3>::new(&mut memory).unwrap();
        let unchanged = answer(0);
        for change in 1..changes {
            let now = answer(change);
            let deviations =
                core::array::from_fn(|m| now[m].zip(unchanged[m]).map(|(new, old)| new - old));
            if change <= NOISE_DRAWS {
                packed.add_draw(&mut memory, &deviations);
            } else {
                if change == NOISE_DRAWS + 1 {
                    packed.end_draws(&mut memory);
                }
                packed.add_shift(&mut memory, &deviations);
            }
        }
        let packed = packed.covariances(&memory);
        assert_eq!(packed.draws(), whole.draws());
        for a in 0..3 {
            assert_eq!(packed.unstable(a), whole.unstable(a));
            for b in 0..3 {
                for (k, l) in (0..10).flat_map(|k| (0..10).map(move |l| (k, l))) {
                    let [small, large] =
                        [packed.element([a, b], [k, l]), whole.element([a, b], [k, l])];
                    // The sums are those of whole numbers below a thousand.
                    assert!((small - large).abs() < 1e-12 * large.abs().max(1.0), "{a} {b}");
                }
            }
        }
    }

    #[test]
    fn memory_that_is_too_small_is_refused() {
        let mut memory = [Complex::new(0.0_f32, 0.0); PackedPropagation::<2>::MEMORY - 1];
        assert!(PackedPropagation::<2>::new(&mut memory).is_none());
    }
}
