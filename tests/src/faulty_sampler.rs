//! A virtual rig whose converter fails when a test says so, and what a test may go by.

use massline_firmware::Memory;
use massline_firmware::board::{Board, SampleError, Sampler};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::ScanIndex;
use massline_virtual::rig::{StartError, VirtualRig, VirtualRigOptions};

/// Starts a rig whose converter loses those blocks that `fault` names an error for, having seen them.
///
/// # Errors
/// When the rig does not start.
pub fn rig_that_loses(
    options: VirtualRigOptions,
    fault: impl FnMut(&[Scan]) -> Option<SampleError> + Send + 'static,
) -> Result<VirtualRig, StartError> {
    VirtualRig::start_application(options, async move |board| {
        let Board { info, sampler, link, flash, panel } = board;
        let sampler = Faulty { sampler, fault };
        let board = Board { info, sampler, link, flash, panel };
        let mut memory = Box::new(Memory::new());
        massline_firmware::run(board, &mut memory).await
    })
}

/// The strikes of the hammer, as the converter sees them.
pub struct Strikes {
    threshold: u16,
    count: u32,
    since: Option<u32>,
}

impl Strikes {
    /// Blocks in a record: what the hammer does within is one strike.
    const RECORD_BLOCKS: u32 = 103;

    /// The hammer, whose code rests at some hundred of 4096 and strikes with thousands, strikes where it
    /// changes by more than `threshold` within a block.
    pub fn above(threshold: u16) -> Self {
        Self { threshold, count: 0, since: None }
    }

    /// Takes in the next block; gives the number of the strike whose record it is in, from 1, and the blocks
    /// since that strike.
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

    /// Takes the record of the last strike for ended.
    pub fn forget(&mut self) {
        self.since = None;
    }
}

struct Faulty<S, F> {
    sampler: S,
    fault: F,
}

impl<S: Sampler, F: FnMut(&[Scan]) -> Option<SampleError>> Sampler for Faulty<S, F> {
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
