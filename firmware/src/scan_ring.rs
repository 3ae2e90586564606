//! Turns the codes of a circular transfer into scans: the chip-independent part of a board's sampler.
//!
//! ```text
//!  ADC ═ DMA ═▶ [ first half | second half ]      a small circular buffer
//!                    │ interrupt: [`Halves`] determines which half is complete and not yet overwritten
//!                    ▼
//!               ScanRing::feed   alignment, mean of `ratio` raw scans, rails
//!                    ▼
//!               [ scan | scan | … ]  ── ScanRing::read ──▶ Sampler::read
//! ```
//!
//! * *Raw scan*: one pass of the converter through its sequence of `RANKS` inputs: the channels of
//!   a scan first, and among the rest the sentinel.
//! * *Sentinel*: an input whose code is known within narrow bounds, such as the chip's own voltage
//!   reference. A code outside these bounds shows that the buffer and the sequence are out of step, so that
//!   every channel would be mistaken for another one. A channel at rest may have a code within these bounds: a
//!   sequence that has slipped by one rank is found by the channel before the sentinel as well, which then has
//!   a code of the sentinel for longer than any hit lasts. Until then, a tenth of a second, scans of wrong channels are
//!   read; the fault ends the record that they are in, unless it has ended before.
//! * *Overrun*: the writer has overwritten scans that were not read yet.
//!
//! Indices of scans count from power-on and do not wrap: 2⁶⁴ scans outlast the rig.

mod decimation;
mod halves;
#[cfg(test)]
mod tests;

use core::ops::RangeInclusive;

use massline_shared::signal::{CHANNELS, Scan};
use massline_shared::units::ScanIndex;

use crate::board::SampleError;
use decimation::Sums;
pub use decimation::{DecimatedScan, Decimation};
pub use halves::{Half, HalfFlags, Halves, Overrun};

/// A converter counts as stopped after this many faults without a block read between them.
pub const FAULTS_TO_STOP: u8 = 3;

/// After so many slips in a run that only the rank before the sentinel shows, it is that channel which rests at the
/// code of the sentinel, as a dead sensor may: a restart of the converter puts a sequence in step, and does not change
/// that.
const SLIPS_TO_BELIEVE: u8 = 3;

/// How raw scans are checked and averaged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RingSettings {
    /// Resolution and averaging.
    pub decimation: Decimation,
    /// The rank of the sentinel, after the channels.
    pub sentinel: usize,
    /// Valid raw codes of the sentinel.
    pub sentinel_codes: RangeInclusive<u16>,
    /// The rank converted before the sentinel by the same converter, where the sentinel's code would be after
    /// a slip, and for how many raw scans in a row it may have such a code. `None` where a slip cannot occur
    /// or shows otherwise.
    pub before_sentinel: Option<(usize, u16)>,
    /// Raw scans discarded at the start: the first may not have been triggered by the timer.
    pub skip: u16,
}

impl RingSettings {
    /// Zeros, which are not usable.
    const NONE: Self = Self {
        decimation: Decimation { raw_bits: 0, raw_full: 0, ratio: 0, fraction_bits: 0 },
        sentinel: 0,
        sentinel_codes: 0..=0,
        before_sentinel: None,
        skip: 0,
    };
}

/// Why the converter must be restarted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Fault {
    /// The sentinel's code is out of bounds, or another rank has it. Starts at 1, so that `None` is all zeros.
    Misaligned = 1,
    /// The converter reports that it has overwritten a code before it was fetched.
    ConverterOverrun = 2,
}

/// Buffers the last `N` scans between the interrupt that makes them and the task that reads them.
///
/// All zeros when new, so that it lies in `.bss`.
#[derive(Debug)]
pub struct ScanRing<const RANKS: usize, const N: usize> {
    settings: RingSettings,
    running: bool,
    fault: Option<Fault>,
    /// Faults since the last block was read.
    faults: u8,
    skip: u16,
    /// Raw scans in a row in which the rank before the sentinel has had a code of the sentinel.
    doubtful: u16,
    /// Slips found by that rank in this run.
    slips: u8,
    sums: Sums<RANKS>,
    scans: [Scan; N],
    /// Index of the next scan to be made.
    written: u64,
    /// Index of the next scan to be read.
    read: u64,
    /// Lost scans that were not reported yet.
    lost: u32,
    /// Raw scans received since power-on.
    came: u64,
    /// Value of `came` when the reader last found it changed, and the time of that.
    seen: (u64, u64),
}

impl<const RANKS: usize, const N: usize> Default for ScanRing<RANKS, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const RANKS: usize, const N: usize> ScanRing<RANKS, N> {
    const CHANNELS: usize = if RANKS < CHANNELS { RANKS } else { CHANNELS };

    /// A ring that ignores raw scans until [`Self::start`].
    pub const fn new() -> Self {
        const { assert!(RANKS > 0 && N > 0, "RANKS and N must be nonzero") };
        Self {
            settings: RingSettings::NONE,
            running: false,
            fault: None,
            faults: 0,
            skip: 0,
            doubtful: 0,
            slips: 0,
            sums: Sums::ZERO,
            scans: [[0; CHANNELS]; N],
            written: 0,
            read: 0,
            lost: 0,
            came: 0,
            seen: (0, 0),
        }
    }

    /// Starts a run at `now` and discards unread scans of an earlier run. To be called before the
    /// converter is started. With unusable settings, [`Self::read`] returns [`SampleError::Stopped`].
    pub fn start(&mut self, settings: RingSettings, now: u64) {
        self.faults = 0;
        self.slips = 0;
        self.lost = 0;
        self.read = self.written;
        self.begin(settings, now);
    }

    /// Resumes at `now` after a fault, with the converter restarted.
    pub fn restart(&mut self, now: u64) {
        if self.running {
            self.begin(self.settings.clone(), now);
        }
    }

    /// Ends the run.
    pub fn stop(&mut self) {
        self.running = false;
        self.fault = None;
    }

    fn begin(&mut self, settings: RingSettings, now: u64) {
        self.running = settings.decimation.is_usable() && settings.sentinel < RANKS;
        self.skip = settings.skip;
        self.doubtful = 0;
        self.settings = settings;
        self.fault = None;
        self.sums = Sums::ZERO;
        self.seen = (self.came, now);
    }

    /// Why the converter must be restarted, if it must. Raw scans are ignored until [`Self::restart`].
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Number of scans made and not yet read, including lost ones.
    pub fn unread(&self) -> u64 {
        self.written - self.read
    }

    /// Adds whole raw scans in the order in which they were made. `finish` may correct each scan by the
    /// code of its sentinel, which has the same resolution as the scan's codes.
    pub fn feed(&mut self, raw: &[u16], mut finish: impl FnMut(&mut Scan, u16)) {
        for raw_scan in raw.as_chunks::<RANKS>().0 {
            self.came += 1;
            if !self.running || self.fault.is_some() {
                return;
            }
            if self.skip > 0 {
                self.skip -= 1;
                continue;
            }
            if self.is_misaligned(raw_scan) {
                return self.fail(Fault::Misaligned);
            }
            let settings = &self.settings;
            let Some(codes) = self.sums.add(raw_scan, &settings.decimation) else { continue };
            let sentinel = codes[settings.sentinel];
            let mut scan = [0; CHANNELS];
            scan[..Self::CHANNELS].copy_from_slice(&codes[..Self::CHANNELS]);
            finish(&mut scan, sentinel);
            self.push(scan);
        }
    }

    fn is_misaligned(&mut self, raw_scan: &[u16; RANKS]) -> bool {
        let RingSettings { sentinel, sentinel_codes, before_sentinel, .. } = &self.settings;
        if !sentinel_codes.contains(&raw_scan[*sentinel]) {
            return true;
        }
        let Some((before, longest)) = *before_sentinel else { return false };
        let has_it = raw_scan.get(before).is_some_and(|code| sentinel_codes.contains(code));
        self.doubtful = if has_it { self.doubtful.saturating_add(1) } else { 0 };
        let has_slipped = self.doubtful > longest && self.slips < SLIPS_TO_BELIEVE;
        self.slips += u8::from(has_slipped);
        has_slipped
    }

    fn push(&mut self, scan: Scan) {
        self.scans[(self.written % N as u64) as usize] = scan;
        self.written += 1;
    }

    /// Records a fault of the converter; unread scans are lost.
    pub fn fail(&mut self, fault: Fault) {
        if !self.running || self.fault.is_some() {
            return;
        }
        self.fault = Some(fault);
        self.faults = self.faults.saturating_add(1);
        // At least the scan that was being made.
        self.lose(1);
    }

    /// Records that at least this many raw scans were overwritten before [`Self::feed`] could take them.
    pub fn overrun(&mut self, raw_scans: u32) {
        if !self.running {
            return;
        }
        let scans = raw_scans.div_ceil(u32::from(self.settings.decimation.ratio)).max(1);
        self.sums = Sums::ZERO;
        self.lose(scans);
    }

    fn lose(&mut self, scans: u32) {
        self.written += u64::from(scans);
        self.lost = self.lost.saturating_add(scans);
    }

    /// Fills `block` and returns the index of its first scan, or `None` if not enough scans are available
    /// yet.
    ///
    /// `now` and `patience` are in any one unit of time.
    ///
    /// # Errors
    /// [`SampleError::Overrun`] once for each gap: scans from before the gap are discarded, and reading
    /// continues after it. After a [`Self::fault`] the converter must be restarted first.
    /// [`SampleError::Stopped`] when no raw scan has arrived for longer than `patience`, after
    /// [`FAULTS_TO_STOP`] faults in a row, before [`Self::start`], and for a block longer than `N`.
    pub fn read(
        &mut self,
        block: &mut [Scan],
        now: u64,
        patience: u64,
    ) -> Result<Option<ScanIndex>, SampleError> {
        if !self.running || block.len() > N || self.faults >= FAULTS_TO_STOP {
            return Err(SampleError::Stopped);
        }
        let held = self.unread();
        if self.lost > 0 || held > N as u64 {
            self.read = self.written;
            self.lost = 0;
            return Err(SampleError::Overrun { lost: u32::try_from(held).unwrap_or(u32::MAX) });
        }
        if self.came != self.seen.0 {
            self.seen = (self.came, now);
        }
        if held < block.len() as u64 {
            let silent = now.saturating_sub(self.seen.1);
            return if silent > patience { Err(SampleError::Stopped) } else { Ok(None) };
        }
        let first = self.read;
        for (scan, index) in block.iter_mut().zip(first..) {
            *scan = self.scans[(index % N as u64) as usize];
        }
        self.read += block.len() as u64;
        self.faults = 0;
        Ok(Some(ScanIndex(first)))
    }
}
