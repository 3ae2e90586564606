//! A virtual rig whose converter fails when a test says so.

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
