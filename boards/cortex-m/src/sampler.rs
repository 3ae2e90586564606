//! The sampler for a converter whose codes are written by a circular transfer: common to all chips.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU16, Ordering, compiler_fence};

use critical_section::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, with_timeout};
use massline_firmware::board::{SampleError, Sampler};
use massline_firmware::scan_ring::{
    Decimation, Fault, Half, HalfFlags, Halves, RingSettings, ScanRing,
};
use massline_shared::signal::{AdcProperties, HAMMER, Scan};
use massline_shared::units::{ScanIndex, Seconds};

use crate::supply::{FactoryReading, Supply};

/// A converter without scans for this time has stopped: it is many times the time of half a buffer.
const PATIENCE: Duration = Duration::from_millis(20);
/// A sensor has a code of the reference at about -5 to -9 g: for a few milliseconds of a hit, never for this long.
const LONGEST_LEVEL: Seconds = Seconds(0.1);

/// The circular transfer and the converter that feeds it.
pub trait Converter {
    /// Starts the transfer, at the start of its buffer, and the converter.
    fn start(&mut self);
    /// Stops transfer and converter; no further interrupts occur.
    fn stop(&mut self);
    /// True when the converter has overwritten a code before the transfer fetched it; it has stopped then.
    fn overrun(&self) -> bool;
}

/// Access to the transfer for its interrupt handler.
pub trait Transfer {
    /// Number of values of the buffer.
    const LENGTH: usize;
    /// Raw scans per half of the buffer.
    const HALF_SCANS: usize;

    /// Flags of the completed halves.
    fn flags(&self) -> HalfFlags;
    /// Clears these flags.
    fn clear(&self, flags: HalfFlags);
    /// Values still to be written before the transfer wraps to the start.
    fn remaining(&self) -> u16;
}

/// The buffer of the transfer, which writes it at any time.
#[repr(transparent)]
pub struct RawBuffer<const LENGTH: usize>([AtomicU16; LENGTH]);

impl<const LENGTH: usize> RawBuffer<LENGTH> {
    /// A buffer of zeros.
    pub const fn new() -> Self {
        const { assert!(LENGTH.is_multiple_of(2) && LENGTH <= u16::MAX as usize) };
        Self([const { AtomicU16::new(0) }; LENGTH])
    }

    /// Address of the buffer, for the transfer.
    pub fn address(&self) -> u32 {
        self.0.as_ptr() as u32
    }

    /// Copies a raw scan of `VALUES` values out of a half. Each value is read whole; the caller detects afterwards
    /// when the transfer has overtaken it.
    pub fn raw_scan<const VALUES: usize>(&self, half: Half, index: usize) -> [u16; VALUES] {
        let start = if half == Half::First { 0 } else { LENGTH / 2 } + VALUES * index;
        let values = &self.0[start..start + VALUES];
        let scan = core::array::from_fn(|rank| values[rank].load(Ordering::Relaxed));
        // The caller looks for an overtaking transfer after these loads, not before them.
        compiler_fence(Ordering::SeqCst);
        scan
    }
}

impl<const LENGTH: usize> Default for RawBuffer<LENGTH> {
    fn default() -> Self {
        Self::new()
    }
}

/// State shared by the interrupt handler and the task.
pub struct SharedPipeline<const RANKS: usize, const SCANS: usize> {
    pipeline: Mutex<RefCell<Pipeline<RANKS, SCANS>>>,
    news: Signal<CriticalSectionRawMutex, ()>,
}

struct Pipeline<const RANKS: usize, const SCANS: usize> {
    ring: ScanRing<RANKS, SCANS>,
    halves: Halves,
    supply: Option<Supply>,
    /// Number of scans that the task waits for.
    wanted: usize,
}

impl<const RANKS: usize, const SCANS: usize> Default for SharedPipeline<RANKS, SCANS> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const RANKS: usize, const SCANS: usize> SharedPipeline<RANKS, SCANS> {
    /// State of a stopped sampler: all zeros, so that it lies in `.bss`.
    pub const fn new() -> Self {
        let (ring, halves) = (ScanRing::new(), Halves::new());
        let pipeline = Pipeline { ring, halves, supply: None, wanted: 0 };
        Self { pipeline: Mutex::new(RefCell::new(pipeline)), news: Signal::new() }
    }

    fn with<R>(&self, work: impl FnOnce(&mut Pipeline<RANKS, SCANS>) -> R) -> R {
        critical_section::with(|cs| work(&mut self.pipeline.borrow_ref_mut(cs)))
    }

    /// Handles the transfer's interrupt; `raw_scan` copies a raw scan out of a half.
    ///
    /// Deadline: the time that the transfer takes for half the buffer. Missing it causes an overrun.
    pub fn on_interrupt(
        &self,
        transfer: &impl Transfer,
        raw_scan: impl Fn(Half, usize) -> [u16; RANKS],
    ) {
        let enough = self.with(|pipeline| {
            pipeline.take(transfer, raw_scan);
            pipeline.ring.fault().is_some() || pipeline.ring.unread() >= pipeline.wanted as u64
        });
        if enough {
            self.news.signal(());
        }
    }
}

impl<const RANKS: usize, const SCANS: usize> Pipeline<RANKS, SCANS> {
    fn take<T: Transfer>(&mut self, transfer: &T, raw_scan: impl Fn(Half, usize) -> [u16; RANKS]) {
        let (length, raw_scans) = (T::LENGTH as u16, T::HALF_SCANS);
        let flags = transfer.flags();
        transfer.clear(flags);
        let half = match self.halves.finished(flags, transfer.remaining(), length) {
            Ok(Some(half)) => half,
            Ok(None) => return,
            Err(overrun) => return self.ring.overrun(overrun.halves * raw_scans as u32),
        };
        let supply = &mut self.supply;
        for index in 0..raw_scans {
            self.ring.feed(&raw_scan(half, index), |scan, reference| {
                if let Some(supply) = supply {
                    scan[HAMMER] = supply.correct(scan[HAMMER], reference);
                }
            });
        }
        let read = self.halves.was_read(half, transfer.flags(), transfer.remaining(), length);
        if let Err(overrun) = read {
            self.ring.overrun(overrun.halves * raw_scans as u32);
        }
    }
}

/// Kind of the sentinel.
#[derive(Clone, Copy, Debug)]
pub enum Sentinel {
    /// The chip's voltage reference, which also measures the supply, for which the hammer's codes are
    /// corrected.
    Reference {
        /// The manufacturer's reading of it.
        noted: FactoryReading,
        /// The rank that the same converter converts before it.
        before: usize,
    },
    /// A constant code.
    Code(u16),
}

/// Properties of a converter's scans.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Properties of the scans.
    pub adc: AdcProperties,
    /// Resolution and averaging of the raw scans.
    pub decimation: Decimation,
    /// The sentinel and its rank.
    pub sentinel: (Sentinel, usize),
}

/// A [`Sampler`] for a converter, and the state shared with its interrupt handler.
pub struct RingSampler<C, const RANKS: usize, const SCANS: usize> {
    /// The converter, halted.
    converter: C,
    /// State shared with the interrupt handler.
    shared: &'static SharedPipeline<RANKS, SCANS>,
    plan: Plan,
}

impl<C: Converter, const RANKS: usize, const SCANS: usize> RingSampler<C, RANKS, SCANS> {
    /// A sampler for a converter that is halted.
    pub const fn new(
        converter: C,
        shared: &'static SharedPipeline<RANKS, SCANS>,
        plan: Plan,
    ) -> Self {
        Self { converter, shared, plan }
    }

    fn settings(&self) -> RingSettings {
        let Plan { decimation, sentinel: (reads, sentinel), .. } = self.plan;
        let (sentinel_codes, before_sentinel) = match reads {
            Sentinel::Reference { noted, before } => {
                let raw_rate = self.plan.adc.rate.0 * f32::from(decimation.ratio);
                let longest = (raw_rate * LONGEST_LEVEL.0) as u16;
                (noted.codes(decimation.raw_bits), Some((before, longest)))
            }
            Sentinel::Code(code) => (code..=code, None),
        };
        RingSettings { decimation, sentinel, sentinel_codes, before_sentinel, skip: 1 }
    }

    fn supply(&self) -> Option<Supply> {
        match self.plan.sentinel.0 {
            Sentinel::Reference { noted, .. } => {
                Some(Supply::new(noted, self.plan.decimation.bits()))
            }
            Sentinel::Code(_) => None,
        }
    }

    fn start_converter(&mut self) {
        self.converter.stop();
        self.shared.with(|pipeline| pipeline.halves = Halves::new());
        self.converter.start();
    }
}

impl<C: Converter, const RANKS: usize, const SCANS: usize> Sampler
    for RingSampler<C, RANKS, SCANS>
{
    fn adc(&self) -> AdcProperties {
        self.plan.adc
    }

    async fn start(&mut self) -> Result<(), SampleError> {
        self.converter.stop();
        self.shared.with(|pipeline| {
            pipeline.supply = self.supply();
            pipeline.ring.start(self.settings(), Instant::now().as_ticks());
        });
        self.start_converter();
        Ok(())
    }

    async fn read(&mut self, block: &mut [Scan]) -> Result<ScanIndex, SampleError> {
        loop {
            let now = Instant::now().as_ticks();
            let overrun = self.converter.overrun();
            let (read, fault) = self.shared.with(|pipeline| {
                if overrun {
                    pipeline.ring.fail(Fault::ConverterOverrun);
                }
                pipeline.wanted = block.len();
                (pipeline.ring.read(block, now, PATIENCE.as_ticks()), pipeline.ring.fault())
            });
            if fault.is_some() {
                self.shared.with(|pipeline| pipeline.ring.restart(now));
                self.start_converter();
            }
            match read {
                Ok(Some(first)) => return Ok(first),
                Ok(None) => {}
                Err(error) => return Err(error),
            }
            // Whether this timed out or not, the next read determines the outcome.
            let _ = with_timeout(PATIENCE, self.shared.news.wait()).await;
        }
    }

    fn stop(&mut self) {
        self.converter.stop();
        self.shared.with(|pipeline| pipeline.ring.stop());
    }
}
