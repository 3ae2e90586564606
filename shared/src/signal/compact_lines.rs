//! The frequency responses of one DOF in half the memory, as block floating point numbers.
//!
//! The lines of one response share an exponent `e`. It is followed by the real and the imaginary part of each
//! line, two mantissas of 16 bits that stand for `mantissa · 2^e`:
//!
//! ```text
//! response = e i8 ‖ SPECTRUM_BINS × ( re i16 LE ‖ im i16 LE )
//! ```
//! All responses together are these blocks, one after another. `e` is the smallest exponent with which every mantissa
//! is at most 32767, but not below −128. Every part is rounded to the nearest multiple of `2^e`, so its error is at
//! most `2^e/2`: at most 1/32767 of the largest part of its response, unless this is smaller than 2⁻¹¹⁴. A block of
//! zeros has the exponent −128. The largest exponent is 113, so that `f32` holds everything.

use core::fmt;

use heapless::Vec;
use nalgebra::Complex;

use super::{RESPONSES, SPECTRUM_BINS};
use crate::real::Real;

/// Bytes of one response: the exponent and two mantissas for each line.
pub const COMPACT_RESPONSE: usize = 1 + 4 * SPECTRUM_BINS;

/// Binary digits of the largest mantissa.
const MANTISSA_BITS: i32 = 15;
const LARGEST_MANTISSA: f64 = i16::MAX as f64;
const LARGEST_EXPONENT: i8 = 113;

/// Why frequency responses cannot be made compact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CompactLinesError {
    /// There are more than [`RESPONSES`].
    TooManyResponses,
    /// A line is infinite or not a number.
    NotFinite {
        /// Index of the response.
        response: usize,
        /// Index of the line.
        line: usize,
    },
    /// A part of a line would be rounded to more than 32767 · 2¹¹³, 3.4 · 10³⁸.
    TooLarge {
        /// Index of the response.
        response: usize,
    },
}

impl fmt::Display for CompactLinesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyResponses => write!(f, "there are more than {RESPONSES} responses"),
            Self::NotFinite { response, line } => {
                write!(f, "line {line} of response {response} is infinite or not a number")
            }
            Self::TooLarge { response } => write!(f, "response {response} is too large"),
        }
    }
}

impl core::error::Error for CompactLinesError {}

/// The compact bytes of the frequency responses of one DOF, encoded while they are read.
///
/// The lines come from a function of response and line, which must return the same value each time. Only the
/// exponents are in memory.
///
/// ```
/// # use massline_shared::nalgebra::Complex;
/// # use massline_shared::signal::{COMPACT_RESPONSE, CompactLines, expand_response};
/// let h = |response: usize, line: usize| Complex::new(response as f32 - 0.8, line as f32 / 128.0);
/// let compact = CompactLines::new(2, h)?;
/// let mut bytes = [0; 2 * COMPACT_RESPONSE];
/// assert_eq!(compact.read(0, &mut bytes), bytes.len());
/// let (_, second) = bytes.split_at(COMPACT_RESPONSE);
/// let lines = expand_response::<f32>(second.try_into().unwrap()).expect("as it was encoded");
/// // Half a unit of the block's exponent, -15: the largest part is 0.99.
/// assert!((lines[100] - h(1, 100)).re.abs() <= 0.5 / 32768.0);
/// # Ok::<(), massline_shared::signal::CompactLinesError>(())
/// ```
#[derive(Clone, Debug)]
pub struct CompactLines<F> {
    exponents: Vec<i8, RESPONSES>,
    lines: F,
}

impl<R: Real, F: Fn(usize, usize) -> Complex<R>> CompactLines<F> {
    /// The first `responses` responses of `lines`, whose arguments are the index of the response and that of the
    /// line. Reads every line once.
    ///
    /// # Errors
    /// [`CompactLinesError`] when there are too many responses, or a line is not finite or too large.
    pub fn new(responses: usize, lines: F) -> Result<Self, CompactLinesError> {
        let mut exponents = Vec::new();
        for response in 0..responses {
            let largest = largest_part(response, &lines)?;
            let exponent = exponent_for(largest.to_f64());
            let exponent = i8::try_from(exponent).ok().filter(|&e| e <= LARGEST_EXPONENT);
            let exponent = exponent.ok_or(CompactLinesError::TooLarge { response })?;
            exponents.push(exponent).map_err(|_| CompactLinesError::TooManyResponses)?;
        }
        Ok(Self { exponents, lines })
    }

    /// Number of bytes.
    pub fn length(&self) -> usize {
        self.exponents.len() * COMPACT_RESPONSE
    }

    /// Fills `out` with the bytes from `offset` on; returns their number, which is smaller than the length of `out`
    /// at the end.
    pub fn read(&self, offset: usize, out: &mut [u8]) -> usize {
        let places = offset..self.length();
        let count = places.len().min(out.len());
        let mut known = None;
        for (to, at) in out.iter_mut().zip(places) {
            let (response, at) = (at / COMPACT_RESPONSE, at % COMPACT_RESPONSE);
            let Some(&exponent) = self.exponents.get(response) else { break };
            *to = match at.checked_sub(1) {
                None => exponent.to_le_bytes()[0],
                Some(at) => {
                    let line = (response, at / 4);
                    let bytes = match known {
                        Some((same, bytes)) if same == line => bytes,
                        _ => mantissas((self.lines)(line.0, line.1), exponent),
                    };
                    known = Some((line, bytes));
                    bytes[at % 4]
                }
            };
        }
        count
    }
}

/// Decodes one response: its lines, in the unit in which they were encoded. `None` when the exponent or a mantissa is
/// one that no response is encoded with.
pub fn expand_response<R: Real>(
    bytes: &[u8; COMPACT_RESPONSE],
) -> Option<[Complex<R>; SPECTRUM_BINS]> {
    let [exponent, mantissas @ ..] = bytes;
    let exponent = i8::from_le_bytes([*exponent]);
    let mut lines = [Complex::new(R::zero(), R::zero()); SPECTRUM_BINS];
    let (numbers, _) = mantissas.as_chunks::<4>();
    for (line, &[r0, r1, i0, i1]) in lines.iter_mut().zip(numbers) {
        let part = |bytes| match i16::from_le_bytes(bytes) {
            i16::MIN => None,
            mantissa => Some(scaled(R::of(f64::from(mantissa)), exponent.into())),
        };
        *line = Complex::new(part([r0, r1])?, part([i0, i1])?);
    }
    (exponent <= LARGEST_EXPONENT).then_some(lines)
}

/// The largest absolute value of the parts of a response.
fn largest_part<R: Real>(
    response: usize,
    lines: impl Fn(usize, usize) -> Complex<R>,
) -> Result<R, CompactLinesError> {
    let mut largest = R::zero();
    for line in 0..SPECTRUM_BINS {
        let Complex { re, im } = lines(response, line);
        if !re.finite() || !im.finite() {
            return Err(CompactLinesError::NotFinite { response, line });
        }
        largest = largest.max(re.abs()).max(im.abs());
    }
    Ok(largest)
}

/// The smallest exponent of the format with which a finite positive number rounds to a mantissa.
fn exponent_for(largest: f64) -> i32 {
    // Biased exponent of the number, 0 for zero and subnormal numbers: 2^E ≤ largest < 2^(E + 1).
    let biased = (largest.to_bits() >> 52 & 0x7FF) as i32;
    let exponent = (biased - 1023 + 1 - MANTISSA_BITS).max(i8::MIN.into());
    let rounds_up = scaled(largest, -exponent) >= LARGEST_MANTISSA + 0.5;
    exponent + i32::from(rounds_up)
}

/// The bytes of a line with this exponent.
fn mantissas<R: Real>(line: Complex<R>, exponent: i8) -> [u8; 4] {
    let part = |part: R| {
        let mantissa = scaled(part, -i32::from(exponent)).round();
        // Exact: an integer of 16 bits.
        (mantissa.to_f32() as i16).to_le_bytes()
    };
    let ([r0, r1], [i0, i1]) = (part(line.re), part(line.im));
    [r0, r1, i0, i1]
}

/// `value · 2^exponent` in two steps, because a power of two of the format may be no normal `f32`.
fn scaled<R: Real>(value: R, exponent: i32) -> R {
    let half = exponent / 2;
    value * power_of_two(half) * power_of_two(exponent - half)
}

/// 2 to the power of `exponent`, which is that of a normal number.
fn power_of_two<R: Real>(exponent: i32) -> R {
    R::of(f64::from_bits(u64::from((1023 + exponent).unsigned_abs()) << 52))
}

#[cfg(test)]
mod tests;
