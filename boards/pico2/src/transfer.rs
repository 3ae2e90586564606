//! The interrupt of the transfer: which halves of the buffer are complete, and where it writes.

use massline_cortex_m::sampler::Transfer;
use massline_firmware::scan_ring::HalfFlags;

use crate::plan::{HALF_PASSES, RAW_LENGTH};

/// The channels of the DMA that write the halves.
pub const WRITERS: [usize; 2] = [0, 2];
/// Frames per half of the buffer.
pub const HALF: u32 = RAW_LENGTH as u32 / 2;
/// The interrupt line of the DMA that the sampler uses.
pub const LINE: usize = 1;
/// The register INTR that is read. It has the channels of every line. Only its first address, 0x400, is described by
/// all sources: at 0x410 the register description has INTR1, and the headers of the manufacturer's SDK a reserved word.
const RAISED: usize = 0;
/// Number of polls for a busy channel. One is reset in a few cycles.
const LOOKS: usize = 10_000;

/// Registers of the DMA.
pub trait Registers {
    /// INTR of this number: the channels that have finished since they were cleared.
    fn intr(&self, number: usize) -> u32;
    /// Clears channels, through INTS of a line.
    fn clear(&self, line: usize, channels: u32);
    /// The values that a channel has still to write; `None` when it is not busy.
    fn remaining(&self, channel: usize) -> Option<u32>;
}

/// The transfer; it counts frames.
pub struct Frames<R>(pub R);

impl<R: Registers> Transfer for Frames<R> {
    const LENGTH: usize = RAW_LENGTH;
    const HALF_SCANS: usize = HALF_PASSES;

    fn flags(&self) -> HalfFlags {
        let raised = self.0.intr(RAISED);
        HalfFlags { first: raised & 1 << WRITERS[0] != 0, second: raised & 1 << WRITERS[1] != 0 }
    }

    fn clear(&self, flags: HalfFlags) {
        self.0.clear(LINE, bits(flags));
    }

    /// Between the two halves neither channel is busy for a few cycles while one is reset; then the other
    /// is busy.
    fn remaining(&self) -> u16 {
        let [first, second] = WRITERS;
        let poll = || self.0.remaining(second).or_else(|| Some(HALF + self.0.remaining(first)?));
        (0..LOOKS).find_map(|_| poll()).unwrap_or(0) as u16
    }
}

/// The channels of these flags.
pub fn bits(flags: HalfFlags) -> u32 {
    u32::from(flags.first) << WRITERS[0] | u32::from(flags.second) << WRITERS[1]
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use massline_cortex_m::sampler::SharedPipeline;

    use super::*;
    use crate::plan::{RANKS, RING_SCANS};

    /// The DMA as the headers of the manufacturer's SDK describe it: what is at 0x410 reads 0.
    struct Twin {
        raised: Cell<u32>,
        busy: usize,
    }

    impl Twin {
        /// Whether the core is interrupted.
        fn is_pending(&self) -> bool {
            self.raised.get() & bits(HalfFlags { first: true, second: true }) != 0
        }
    }

    impl Registers for &Twin {
        fn intr(&self, number: usize) -> u32 {
            if number == 0 { self.raised.get() } else { 0 }
        }

        fn clear(&self, line: usize, channels: u32) {
            assert_eq!(line, LINE);
            self.raised.set(self.raised.get() & !channels);
        }

        fn remaining(&self, channel: usize) -> Option<u32> {
            (channel == self.busy).then_some(HALF - 1)
        }
    }

    #[test]
    fn the_interrupt_ends_and_its_half_is_read() {
        let shared: SharedPipeline<RANKS, RING_SCANS> = SharedPipeline::new();
        for half in [0, 1, 0] {
            let twin = Twin { raised: Cell::new(1 << WRITERS[half]), busy: WRITERS[1 - half] };
            let passes = Cell::new(0);
            shared.on_interrupt(&Frames(&twin), |_, _| {
                passes.set(passes.get() + 1);
                [0; RANKS]
            });
            assert!(!twin.is_pending(), "the core never leaves the interrupt");
            assert_eq!(passes.get(), HALF_PASSES);
        }
    }

    #[test]
    fn what_remains_is_counted_to_the_end_of_the_second_half() {
        let remaining = |busy| Frames(&Twin { raised: Cell::new(0), busy }).remaining();
        assert_eq!(u32::from(remaining(WRITERS[0])), 2 * HALF - 1);
        assert_eq!(u32::from(remaining(WRITERS[1])), HALF - 1);
        assert_eq!(remaining(9), 0, "no channel is busy");
    }
}
