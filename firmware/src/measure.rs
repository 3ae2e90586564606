//! The measuring loop: carries out what the measurement requests, from sampling to the stored result.
//!
//! Measuring never waits for the link or the panel. It waits for flash only between two hits, while the
//! sampler is stopped. The sampler runs only while the measurement requests scans.

use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use massline_shared::measurement::NextAction;
use massline_shared::signal::{CHANNELS, Scan};
use massline_shared::units::ScanIndex;

use crate::board::{SampleError, Sampler};
use crate::checkpoint::{Checkpoint, CheckpointBuffer};
use crate::deadline::Deadline;
use crate::levels::Levels;
use crate::outcome::StoredResult;
use crate::pulse::Part;
use crate::rig::{Rig, mass_of};
use crate::store::Store;

/// Scans fetched at a time: 5 ms at 4 kS/s.
const BLOCK: usize = 20;

/// Window of the panel's level bars.
const LEVEL_WINDOW_S: f32 = 0.1;

/// The measuring loop and what it works on.
pub(crate) struct MeasuringLoop<'a, 'm, S: Sampler, F: NorFlash> {
    pub sampler: S,
    pub rig: &'a Rig<'m>,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub checkpoint: Checkpoint,
    pub room: &'a mut CheckpointBuffer,
}

impl<S: Sampler, F: NorFlash> MeasuringLoop<'_, '_, S, F> {
    /// Runs the measuring loop; never returns.
    pub async fn run(mut self) -> ! {
        loop {
            self.rig.pulse.works(Part::Measuring);
            self.checkpoint.update(self.rig, self.store, self.room).await;
            self.rig.wake.reset();
            let action = self.rig.measurement.borrow().next_action();
            match action {
                NextAction::Wait => {
                    self.rig.pulse.waits(Part::Measuring);
                    self.rig.wake.wait().await;
                }
                NextAction::Sample => self.sample().await,
                NextAction::Compute => {
                    self.work();
                    // Lets the link and the watchdog run between two steps of a computation.
                    yield_now().await;
                }
                NextAction::StoreLines { dof } => {
                    self.checkpoint.store_lines(self.rig, self.store, self.room, dof).await;
                }
                NextAction::Store => self.keep_result().await,
            }
            self.rig.changed();
        }
    }

    /// Deadline: [`crate::deadline::DEADLINE`].
    fn work(&self) {
        let _deadline = Deadline::begin(&self.rig.stats);
        self.rig.measurement.borrow_mut().work();
    }

    /// Samples until the measurement requests no more scans or a command arrives.
    async fn sample(&mut self) {
        let rig = self.rig;
        let ended = select(self.feed(), rig.wake.wait()).await;
        self.sampler.stop();
        let mut measurement = rig.measurement.borrow_mut();
        match ended {
            Either::First(Err(SampleError::Overrun { lost })) => measurement.lost(lost),
            Either::First(Err(SampleError::Stopped)) => measurement.stopped(),
            Either::First(Ok(())) | Either::Second(()) => {}
        }
    }

    /// Feeds the measurement with scans until it requests no more. A stream continues after lost scans.
    ///
    /// Deadline: [`crate::deadline::DEADLINE`] between two reads.
    async fn feed(&mut self) -> Result<(), SampleError> {
        let rig = self.rig;
        self.sampler.start().await?;
        let rate = {
            let mut measurement = rig.measurement.borrow_mut();
            measurement.sampling_started();
            measurement.adc().rate.0
        };
        rig.changed();
        let mut levels = Levels::new((rate * LEVEL_WINDOW_S) as u16);
        let mut block: [Scan; BLOCK] = [[0; CHANNELS]; BLOCK];
        loop {
            rig.pulse.works(Part::Measuring);
            match self.sampler.read(&mut block).await {
                Ok(first) => self.take(first, &block, &mut levels),
                Err(SampleError::Overrun { lost }) => {
                    let mut measurement = rig.measurement.borrow_mut();
                    if measurement.streamed().is_none() {
                        return Err(SampleError::Overrun { lost });
                    }
                    measurement.lost(lost);
                }
                Err(stopped) => return Err(stopped),
            }
            if rig.measurement.borrow().next_action() != NextAction::Sample {
                return Ok(());
            }
        }
    }

    /// Passes a block to the measurement, and signals the session and the panel when something has changed.
    fn take(&self, first: ScanIndex, block: &[Scan], levels: &mut Levels) {
        let rig = self.rig;
        let _deadline = Deadline::begin(&rig.stats);
        for levels in block.iter().filter_map(|scan| levels.feed(scan)) {
            rig.levels.set(levels);
            rig.show.signal(());
        }
        let mut measurement = rig.measurement.borrow_mut();
        let before = measurement.phase();
        measurement.feed(first, block);
        if measurement.streamed().is_some() {
            rig.news.signal(());
        }
        if measurement.phase() != before {
            rig.changed();
        }
    }

    /// Stores the result. The campaign pauses when that fails.
    async fn keep_result(&mut self) {
        let rig = self.rig;
        let mut store = self.store.lock().await;
        let mass = rig.measurement.borrow().result().estimates.first().map(mass_of);
        let result = StoredResult::new(rig, store.next_number());
        let put = store.put_result(&result, rig.layout_hash.get(), mass).await;
        let mut measurement = rig.measurement.borrow_mut();
        match put {
            Ok(number) => {
                rig.last_mass.set(mass);
                measurement.stored(number);
            }
            Err(_) => measurement.not_stored(),
        }
    }
}
