//! Motions of the reference point, in full precision or in 16 bits.
//!
//! A rig keeps the motions under six forces at 128 lines in 18 KiB: 16-bit integers, and one power of two for each component
//! under each force. Half of the last bit is 1/65536 of the highest peak. A mode with 1 % damping stands 50 times above its
//! mass line, and noise of 0.1 % of that line is as large as the last bit; noise of a test is larger.

use nalgebra::{Complex, Vector6};

use super::{MOST_FORCES, MOST_LINES};
use crate::Real;

/// Largest integer.
const LARGEST: f64 = 32_767.0;
/// Smallest exponent of a unit, so that its inverse is a number in single precision as well.
const SMALLEST_EXPONENT: i32 = -120;
/// Room above the largest number, for motions that are changed a little.
const HEADROOM: f64 = 1.25;
/// Integers of one component under one force: real and imaginary part of every line.
const BLOCK: usize = 2 * MOST_LINES;

/// The motions `[a; α]` per newton of every force at every line.
#[derive(Clone, Copy, Debug)]
pub enum Motions<'a, R> {
    /// In full precision, line by line, force by force.
    Full(&'a [Vector6<Complex<R>>]),
    /// In 16 bits.
    Compact(CompactMotions<'a, R>),
}

impl<R: Real> Motions<'_, R> {
    /// True when there is a finite motion for each of so many lines and forces.
    pub(super) fn are_sound(&self, lines: usize, forces: usize) -> bool {
        match self {
            Self::Full(all) => {
                let finite = |z: &Complex<R>| z.re.finite() && z.im.finite();
                all.len() == lines * forces && all.iter().flatten().all(finite)
            }
            Self::Compact(_) => lines <= MOST_LINES && forces <= MOST_FORCES,
        }
    }

    /// One component of a motion; `forces` is their number.
    pub(super) fn component(
        &self,
        line: usize,
        force: usize,
        component: usize,
        forces: usize,
    ) -> Complex<R> {
        match self {
            Self::Full(all) => all[line * forces + force][component],
            Self::Compact(compact) => compact.component(line, force, component),
        }
    }
}

/// The exponents of the units of the integers of each component under each force: the unit is this power of two, in the unit
/// of the motions.
pub type Exponents = [[i8; 6]; MOST_FORCES];

/// Motions in 16 bits: force by force, component by component, line by line.
#[derive(Clone, Copy, Debug)]
pub struct CompactMotions<'a, R> {
    codes: &'a [u16],
    units: [[R; 6]; MOST_FORCES],
}

impl<'a, R: Real> CompactMotions<'a, R> {
    /// Integers of the motions under as many forces and at as many lines as there may be.
    pub const CODES: usize = MOST_FORCES * 6 * BLOCK;

    /// The motions that [`store`](Self::store) has written; `None` when there are fewer than [`CODES`](Self::CODES).
    pub fn new(codes: &'a [u16], exponents: &Exponents) -> Option<Self> {
        let units = exponents.map(|of_force| of_force.map(unit));
        (codes.len() >= Self::CODES).then_some(Self { codes, units })
    }

    /// The motion under a force at a line.
    pub(crate) fn motion(&self, line: usize, force: usize) -> Vector6<Complex<R>> {
        Vector6::from_fn(|component, _| self.component(line, force, component))
    }

    fn component(&self, line: usize, force: usize, component: usize) -> Complex<R> {
        let at = (force * 6 + component) * BLOCK + 2 * line;
        let unit = self.units[force][component];
        let part = |code: u16| R::of(f64::from(code.cast_signed())) * unit;
        Complex::new(part(self.codes[at]), part(self.codes[at + 1]))
    }

    /// Stores one component of the motion under a force at all lines, and returns false for numbers that are not finite or
    /// for a place that does not exist.
    pub fn store(
        codes: &mut [u16],
        exponents: &mut Exponents,
        place: (usize, usize),
        values: impl Iterator<Item = Complex<R>> + Clone,
    ) -> bool {
        let (force, component) = place;
        let largest = values.clone().fold(R::zero(), |top, z| {
            // A maximum that passes over what is not a number would hide it.
            let finite = z.re.finite() && z.im.finite();
            if finite { top.max(z.re.abs()).max(z.im.abs()) } else { R::one() / R::zero() }
        });
        let start = (force * 6 + component) * BLOCK;
        let block = codes.get_mut(start..start + BLOCK);
        let exponent = exponents.get_mut(force).and_then(|of_force| of_force.get_mut(component));
        let both = block.zip(exponent).filter(|_| largest.finite());
        let Some((block, exponent)) = both else { return false };
        *exponent = exponent_of(largest.to_f64() * HEADROOM);
        let per_unit = unit::<R>(*exponent).recip();
        for (to, z) in block.chunks_exact_mut(2).zip(values) {
            to.copy_from_slice(&codes_of(z, per_unit));
        }
        true
    }

    /// Stores a motion under a force at one line, with units that are known; what is beyond the integers is cut off. The
    /// place exists.
    pub(crate) fn store_line(
        codes: &mut [u16],
        exponents: &Exponents,
        (line, force): (usize, usize),
        motion: &Vector6<Complex<R>>,
    ) {
        for (component, z) in motion.iter().enumerate() {
            let at = (force * 6 + component) * BLOCK + 2 * line;
            let per_unit = unit::<R>(exponents[force][component]).recip();
            codes[at..at + 2].copy_from_slice(&codes_of(*z, per_unit));
        }
    }

    /// The exponent with which there is room for this much more than one that was stored with leaves.
    pub(crate) fn exponent_with_room(exponent: i8, more: R) -> i8 {
        let most = libm::ldexp((LARGEST + 1.0) / HEADROOM, i32::from(exponent)) + more.to_f64();
        exponent_of(most).max(exponent)
    }
}

/// The unit of an exponent.
fn unit<R: Real>(exponent: i8) -> R {
    R::of(libm::ldexp(1.0, i32::from(exponent)))
}

fn codes_of<R: Real>(z: Complex<R>, per_unit: R) -> [u16; 2] {
    // The conversion keeps what is beyond the integers at their end.
    [z.re, z.im].map(|part| ((part * per_unit).round().to_f32() as i16).cast_unsigned())
}

/// The smallest exponent with whose unit this number is within the integers; no number of single precision needs more.
fn exponent_of(largest: f64) -> i8 {
    let (fraction, exponent) = libm::frexp(largest);
    // The fraction is below one, so the exponent less 15 gives integers below 32 768, which may be rounded to that.
    let exponent = exponent - 15 + i32::from(fraction * (LARGEST + 1.0) > LARGEST);
    exponent.clamp(SMALLEST_EXPONENT, i32::from(i8::MAX)) as i8
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// What is read of these values, at a place between others.
    fn read<R: Real>(values: &[Complex<R>]) -> Vec<Complex<R>> {
        let mut codes = vec![0; CompactMotions::<R>::CODES];
        let mut units = [[0; 6]; MOST_FORCES];
        let stored = CompactMotions::store(&mut codes, &mut units, (2, 3), values.iter().copied());
        assert!(stored);
        let compact = CompactMotions::new(&codes, &units).unwrap();
        (0..values.len()).map(|line| compact.component(line, 2, 3)).collect()
    }

    #[test]
    fn motions_of_any_size_keep_their_largest_fifteen_bits() {
        for size in [1e-30_f32, 1e-3, 1.0, 32_767.0, 32_767.6, 32_768.0, 1e30] {
            let values: Vec<_> = (0..MOST_LINES)
                .map(|k| Complex::new(size * (k as f32).sin(), -size / (k + 1) as f32))
                .collect();
            for (value, read) in values.iter().zip(read(&values)) {
                let error = (value.re - read.re).abs().max((value.im - read.im).abs());
                // Half a unit, which is at most 1.25 times the largest number over 2^14, and the rounding of the numbers.
                assert!(error <= 1.251 * size * 0.5_f32.powi(15), "{value} {read}");
            }
        }
    }

    #[test]
    fn no_motion_stays_none_and_a_number_that_is_not_finite_is_refused() {
        let zero = Complex::new(0.0_f32, 0.0);
        assert_eq!(read(&[zero; 3]), [zero; 3]);
        let tiny = Complex::new(f32::MIN_POSITIVE, 0.0);
        assert!(read(&[tiny])[0].re.abs() <= f32::MIN_POSITIVE * 2.0);
        let mut codes = vec![0; CompactMotions::<f32>::CODES];
        let mut units = [[0; 6]; MOST_FORCES];
        for bad in [f32::NAN, f32::INFINITY] {
            let values = [Complex::new(1.0, 0.0), Complex::new(0.0, bad), Complex::new(2.0, 0.0)];
            assert!(!CompactMotions::store(&mut codes, &mut units, (0, 0), values.into_iter()));
        }
        assert!(!CompactMotions::store(&mut codes, &mut units, (6, 0), [zero].into_iter()));
        assert!(CompactMotions::<f32>::new(&codes[1..], &units).is_none());
    }
}
