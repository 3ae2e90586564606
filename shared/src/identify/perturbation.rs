//! A small change of the data or of the layout, the same for every method.

use crate::capacity::Capacity;
use crate::layout::Layout;
use crate::real::Real;

/// A small change of the data or of the layout.
#[derive(Clone, Copy, Debug)]
pub struct Perturbation<'a, R: Real, C: Capacity> {
    /// The layout.
    pub layout: &'a Layout<R, C>,
    /// Place of the uncertain quantity by which the layout was shifted, in
    /// [`Layout::uncertain_quantities`](crate::layout::Layout::uncertain_quantities).
    pub quantity: Option<usize>,
    /// Number of the draw of noise that is added to the readings.
    pub draw: Option<u32>,
}

/// Two random signs that belong to a draw and the place of a reading: the noise of a reading, in its standard
/// deviations. Only its mean and its variance matter, so signs do as well as normal numbers. The final mixing of
/// MurmurHash3 (Appleby, public domain).
///
/// ```
/// # use massline_shared::identify::random_signs;
/// let sum = |k: usize| (0..10_000).map(|place| random_signs(7, place)[k]).sum::<i32>();
/// // Four standard deviations of the sum of so many signs.
/// assert!(sum(0).abs() < 400 && sum(1).abs() < 400);
/// ```
pub fn random_signs(draw: u32, place: usize) -> [i32; 2] {
    let place = u32::try_from(place).unwrap_or(u32::MAX);
    let mut hash = place.wrapping_mul(0x9E37_79B1) ^ draw.wrapping_add(1).wrapping_mul(0x85EB_CA77);
    hash ^= hash >> 16;
    hash = hash.wrapping_mul(0x85EB_CA6B);
    hash ^= hash >> 13;
    hash = hash.wrapping_mul(0xC2B2_AE35);
    hash ^= hash >> 16;
    [hash & 1, hash >> 31].map(|bit| if bit == 0 { -1 } else { 1 })
}
