//! Averages several raw scans into one scan with a higher resolution.

/// Resolution of the raw codes, and how they are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decimation {
    /// Bits of a raw code.
    pub raw_bits: u8,
    /// The largest raw code. It is less than `2^raw_bits - 1` if the converter itself sums several
    /// conversions.
    pub raw_full: u16,
    /// Number of raw scans averaged into one scan.
    pub ratio: u16,
    /// Fractional bits of the mean.
    pub fraction_bits: u8,
}

impl Decimation {
    /// Bits of a scan's code, as `AdcProperties::bits` states them.
    pub const fn bits(&self) -> u8 {
        self.raw_bits + self.fraction_bits
    }

    /// True when there is something to average and a code fits 16 bits.
    pub const fn is_usable(&self) -> bool {
        self.raw_bits > 0
            && self.ratio > 0
            && self.raw_bits as u32 + self.fraction_bits as u32 <= u16::BITS
    }

    /// The largest code of a scan.
    const fn full(&self) -> u16 {
        ((1_u32 << self.bits()) - 1) as u16
    }
}

/// The codes of a scan and of the other inputs of the sequence.
pub type DecimatedScan<const RANKS: usize> = [u16; RANKS];

/// Sums of the raw scans added so far.
#[derive(Debug)]
pub(super) struct Sums<const RANKS: usize> {
    sums: [u32; RANKS],
    /// Inputs that were at the top or at the bottom of the converter's range.
    clipped: [ClippedSides; RANKS],
    count: u16,
}

#[derive(Clone, Copy, Debug, Default)]
struct ClippedSides {
    low: bool,
    high: bool,
}

impl<const RANKS: usize> Sums<RANKS> {
    pub const ZERO: Self = Self {
        sums: [0; RANKS],
        clipped: [ClippedSides { low: false, high: false }; RANKS],
        count: 0,
    };

    /// Adds a raw scan; returns the mean with the last one of `ratio`. An input that clipped in any of
    /// them reads as clipped, because a mean would hide it.
    pub fn add(
        &mut self,
        raw: &[u16; RANKS],
        decimation: &Decimation,
    ) -> Option<DecimatedScan<RANKS>> {
        let full = decimation.raw_full;
        for ((sum, clipped), &code) in self.sums.iter_mut().zip(&mut self.clipped).zip(raw) {
            *sum += u32::from(code);
            clipped.low |= code == 0;
            clipped.high |= code >= full;
        }
        self.count += 1;
        if self.count < decimation.ratio {
            return None;
        }
        let codes = core::array::from_fn(|rank| match self.clipped[rank] {
            ClippedSides { high: true, .. } => decimation.full(),
            ClippedSides { low: true, .. } => 0,
            _ => mean(self.sums[rank], decimation),
        });
        *self = Self::ZERO;
        Some(codes)
    }
}

/// The mean, rounded to nearest. The sum fits 32 bits: there are fewer than 2¹⁶ codes, of at most 16 bits
/// after the shift.
fn mean(sum: u32, decimation: &Decimation) -> u16 {
    let ratio = u32::from(decimation.ratio);
    (((sum << decimation.fraction_bits) + ratio / 2) / ratio) as u16
}
