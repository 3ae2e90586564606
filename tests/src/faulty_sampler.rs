//! A virtual rig whose converter fails when a test asks for it, and a count of the hammer's strikes for
//! such tests.

use massline_firmware::Memory;
use massline_firmware::board::{Board, SampleError, Sampler};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::ScanIndex;
use massline_virtual::rig::{StartError, VirtualRig, VirtualRigOptions};

/// Starts a rig whose converter loses every block for which `fault` returns an error.
///
/// # Errors
/// When the rig does not start.
pub fn rig_that_loses(
    options: VirtualRigOptions,
    fault: impl FnMut(&[Scan]) -> Option<SampleError> + Send + 'static,
) -> Result<VirtualRig, StartError> {
    VirtualRig::start_application(options, async move |board| {
        let Board { info, sampler, link, flash, panel, feed_watchdog } = board;
        let sampler = FaultySampler { sampler, fault };
        let board = Board { info, sampler, link, flash, panel, feed_watchdog };
        let mut memory = Box::new(Memory::new());
        massline_firmware::run(board, &mut memory).await
    })
}

/// Counts the strikes of the hammer in the converter's scans.
pub struct Strikes {
    threshold: u16,
    count: u32,
    since: Option<u32>,
}

impl Strikes {
    /// Blocks of a record: whatever the hammer does within a record is one strike.
    const RECORD_BLOCKS: u32 = 103;

    /// The hammer's code is some hundred of 4096 at rest and thousands in a strike. A strike is a change
    /// by more than `threshold` within a block.
    pub fn above(threshold: u16) -> Self {
        Self { threshold, count: 0, since: None }
    }

    /// Processes the next block; returns the number, from 1, of the strike whose record it belongs to,
    /// and the number of blocks since that strike.
    pub fn see(&mut self, block: &[Scan]) -> Option<(u32, u32)> {
        let struck = block.iter().any(|scan| scan[0].abs_diff(block[0][0]) > self.threshold);
        self.since = match self.since {
            None if struck => Some(0),
            Some(Self::RECORD_BLOCKS) => None,
            other => other.map(|blocks| blocks + 1),
        };
        self.count += u32::from(self.since == Some(0));
        self.since.map(|blocks| (self.count, blocks))
    }

    /// Assumes that the record of the last strike has ended.
    pub fn forget(&mut self) {
        self.since = None;
    }
}

struct FaultySampler<S, F> {
    sampler: S,
    fault: F,
}

impl<S: Sampler, F: FnMut(&[Scan]) -> Option<SampleError>> Sampler for FaultySampler<S, F> {
    fn adc(&self) -> AdcProperties {
        self.sampler.adc()
    }

    async fn start(&mut self) -> Result<(), SampleError> {
        self.sampler.start().await
    }

    async fn read(&mut self, block: &mut [Scan]) -> Result<ScanIndex, SampleError> {
        let first = self.sampler.read(block).await?;
        (self.fault)(block).map_or(Ok(first), Err)
    }

    fn stop(&mut self) {
        self.sampler.stop();
    }
}
