//! The range of each channel while the rig waits for a hit, which the panel shows as level bars.

use massline_shared::signal::{CHANNELS, Scan};

/// Collects the range of the codes of every channel over a window of scans.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Levels {
    low: [u16; CHANNELS],
    high: [u16; CHANNELS],
    missing: u16,
    window: u16,
}

impl Levels {
    /// Levels over `window` scans each.
    pub fn new(window: u16) -> Self {
        let window = window.max(1);
        Self { low: [u16::MAX; CHANNELS], high: [0; CHANNELS], missing: window, window }
    }

    /// Adds a scan. At the end of a window, returns the level of each channel and starts the next window.
    /// A level is the number of bits of the channel's range; 0 means that the code did not change.
    pub fn feed(&mut self, scan: &Scan) -> Option<[u8; CHANNELS]> {
        for ((low, high), &code) in self.low.iter_mut().zip(&mut self.high).zip(scan) {
            *low = code.min(*low);
            *high = code.max(*high);
        }
        self.missing -= 1;
        if self.missing > 0 {
            return None;
        }
        let bits = |k: usize| (u16::BITS - (self.high[k] - self.low[k]).leading_zeros()) as u8;
        let levels = core::array::from_fn(bits);
        *self = Self::new(self.window);
        Some(levels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_level_is_the_bits_of_the_range_of_its_own_while() {
        let mut levels = Levels::new(3);
        let mut scan = [2000; CHANNELS];
        assert_eq!(levels.feed(&scan), None);
        scan[0] = 0;
        scan[1] = 2001;
        scan[2] = u16::MAX;
        assert_eq!(levels.feed(&scan), None);
        // 2000 has 11 bits, 1 has 1, 63535 has 16.
        let mut expected = [0; CHANNELS];
        expected[..3].copy_from_slice(&[11, 1, 16]);
        assert_eq!(levels.feed(&scan), Some(expected));
        // Scans of the window before do not count.
        assert!((0..2).all(|_| levels.feed(&scan).is_none()));
        assert_eq!(levels.feed(&scan), Some([0; CHANNELS]));
    }
}
