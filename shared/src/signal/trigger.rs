//! The trigger: detects a hit and captures its record.
//!
//! The *pre-trigger* scans are those before the contact. They must be quiet, because the rest value of every
//! channel is computed from them.

use super::chain::HAMMER;
use super::{AdcProperties, Calibration, PRE_TRIGGER_SCANS, RECORD_SCANS, Record, Scan};
use crate::real::Real;
use crate::units::{Newtons, ScanIndex};

/// Finds the rising edge of a hit in a force signal of any unit.
///
/// The rest value is the running mean since arming. The trigger fires at the first sample that is at least
/// `level` above it, after `settle` samples that stayed within `level` of it; a disturbance before that
/// restarts the settling. Each arming fires only once.
///
/// ```
/// # use massline_shared::signal::EdgeTrigger;
/// // A hit is 3 N above rest, after 80 quiet samples.
/// let mut trigger = EdgeTrigger::new(3.0_f32, 80);
/// let force = |n: usize| if n < 100 { 0.4 } else { 20.0 };
/// assert_eq!((0..200).position(|n| trigger.feed(force(n))), Some(100));
/// // Each arming fires only once.
/// assert!(!trigger.feed(20.0));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EdgeTrigger<R> {
    level: R,
    settle: u32,
    rest: R,
    quiet: u32,
    fired: bool,
}

impl<R: Real> EdgeTrigger<R> {
    /// Approximate number of samples in the running mean, short enough to follow a slow drift of the hammer.
    const MEMORY: u32 = 1024;

    /// An armed trigger.
    pub fn new(level: R, settle: usize) -> Self {
        let settle = u32::try_from(settle).unwrap_or(u32::MAX);
        Self { level, settle, rest: R::zero(), quiet: 0, fired: false }
    }

    /// Arms the trigger for the next hit and starts the rest value anew.
    pub fn arm(&mut self) {
        self.quiet = 0;
        self.fired = false;
    }

    /// Takes the next sample; true when it triggers.
    pub fn feed(&mut self, sample: R) -> bool {
        if self.fired {
            return false;
        }
        let rise = sample - self.rest;
        if self.quiet >= self.settle {
            if rise >= self.level {
                self.fired = true;
                return true;
            }
        } else if self.quiet == 0 || rise.abs() >= self.level {
            self.rest = sample;
            self.quiet = 1;
            return false;
        }
        self.quiet = self.quiet.saturating_add(1);
        if let Some(count) = R::from_u32(self.quiet.min(Self::MEMORY)) {
            self.rest += rise / count;
        }
        false
    }
}

/// The trigger of the rig: an [`EdgeTrigger`] on the codes of the hammer.
#[derive(Clone, Copy, Debug)]
pub struct Trigger {
    edge: EdgeTrigger<f32>,
    /// −1 for a hammer whose voltage falls with the force, otherwise 1.
    sign: f32,
}

impl Trigger {
    /// Lowest trigger level, codes; a lower one would respond to the noise of the converter.
    pub const LOWEST_LEVEL: f32 = 4.0;

    /// An armed trigger that fires at `level` above the rest value, after [`PRE_TRIGGER_SCANS`]
    /// quiet scans.
    pub fn new(adc: &AdcProperties, calibration: &Calibration, level: Newtons) -> Self {
        let newtons_per_code = calibration.per_code(adc, HAMMER);
        let level = (level.0 / newtons_per_code.abs()).max(Self::LOWEST_LEVEL);
        Self {
            edge: EdgeTrigger::new(level, PRE_TRIGGER_SCANS),
            sign: if newtons_per_code < 0.0 { -1.0 } else { 1.0 },
        }
    }

    /// The same trigger with another number of quiet scans.
    pub(super) fn settling(mut self, scans: usize) -> Self {
        self.edge.settle = u32::try_from(scans).unwrap_or(u32::MAX);
        self
    }

    /// Arms the trigger for the next hit.
    pub fn arm(&mut self) {
        self.edge.arm();
    }

    /// Takes the next scan; true when it triggers.
    pub fn feed(&mut self, scan: &Scan) -> bool {
        self.edge.feed(self.sign * f32::from(scan[HAMMER]))
    }
}

/// Progress of the capture of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaptureState {
    /// There was no trigger yet.
    Waiting,
    /// The trigger has fired, and the record is being filled.
    Filling,
    /// The record contains the whole hit: [`PRE_TRIGGER_SCANS`] scans, then that of the trigger, then the
    /// rest. It does not change until the next arming.
    Complete {
        /// Index of the scan that triggered.
        trigger_scan: ScanIndex,
    },
    /// Scans were lost after the trigger: the record is useless, and the capture waits for the next arming.
    Broken,
}

/// Captures the record of one hit.
///
/// ```
/// # use massline_shared::signal::*;
/// # use massline_shared::units::*;
/// # let adc = AdcProperties { rate: Hertz(4000.0), channels: 10, bits: 12,
/// #     reference: Volts(3.0), channel_delay: Seconds(1e-5) };
/// let trigger = Trigger::new(&adc, &Calibration::default(), Newtons(3.0));
/// let mut record = Box::new(Record::new());
/// record.begin_wait();
/// let mut capture = Capture::new(trigger);
/// let state = (0..4000).find_map(|index| {
///     let mut scan = [2000; CHANNELS];
///     scan[HAMMER] = if index == 1000 { 900 } else { 140 };
///     match capture.feed(&mut record, &scan, ScanIndex(index)) {
///         CaptureState::Complete { trigger_scan } => Some(trigger_scan),
///         _ => None,
///     }
/// });
/// assert_eq!(state, Some(ScanIndex(1000)));
/// // The quiet scans before the hit are in the record.
/// assert_eq!(record.scan(PRE_TRIGGER_SCANS).unwrap()[HAMMER], 900);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Capture {
    trigger: Trigger,
    state: CaptureState,
    /// Expected index of the next scan.
    expected: Option<u64>,
    trigger_scan: ScanIndex,
    missing: usize,
}

impl Capture {
    /// An armed capture; the record must be [waiting](Record::begin_wait).
    pub fn new(trigger: Trigger) -> Self {
        Self {
            trigger,
            state: CaptureState::Waiting,
            expected: None,
            trigger_scan: ScanIndex(0),
            missing: 0,
        }
    }

    /// Arms the capture for the next hit and discards the last one.
    pub fn arm(&mut self, record: &mut Record) {
        record.begin_wait();
        self.trigger.arm();
        *self = Self::new(self.trigger);
    }

    /// Progress of the capture.
    pub fn state(&self) -> CaptureState {
        self.state
    }

    /// Takes the next scan into the record.
    ///
    /// A gap in `index` before the trigger restarts the pre-trigger; a gap after it makes the record
    /// [`CaptureState::Broken`].
    pub fn feed(&mut self, record: &mut Record, scan: &Scan, index: ScanIndex) -> CaptureState {
        let gap = self.expected.is_some_and(|expected| expected != index.0);
        self.expected = Some(index.0.wrapping_add(1));
        self.state = match self.state {
            CaptureState::Waiting => {
                if gap {
                    record.begin_wait();
                    self.trigger.arm();
                }
                self.wait(record, scan, index)
            }
            CaptureState::Filling if gap => CaptureState::Broken,
            CaptureState::Filling => self.fill(record, scan),
            done => done,
        };
        self.state
    }

    fn wait(&mut self, record: &mut Record, scan: &Scan, index: ScanIndex) -> CaptureState {
        if !self.trigger.feed(scan) {
            record.push(scan);
            return CaptureState::Waiting;
        }
        record.end_wait();
        record.push(scan);
        self.trigger_scan = index;
        self.missing = RECORD_SCANS - PRE_TRIGGER_SCANS - 1;
        CaptureState::Filling
    }

    fn fill(&mut self, record: &mut Record, scan: &Scan) -> CaptureState {
        record.push(scan);
        self.missing = self.missing.saturating_sub(1);
        match self.missing {
            0 => CaptureState::Complete { trigger_scan: self.trigger_scan },
            _ => CaptureState::Filling,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::tests::{ADC, hammer_code};
    use std::boxed::Box;
    use std::vec::Vec;

    const LEVEL: Newtons = Newtons(3.0);

    fn capture() -> (Capture, Box<Record>) {
        let mut record = Box::new(Record::new());
        record.begin_wait();
        (Capture::new(Trigger::new(&ADC, &Calibration::default(), LEVEL)), record)
    }

    fn scan(newtons: f32) -> Scan {
        let mut scan = [2048; crate::signal::CHANNELS];
        scan[HAMMER] = hammer_code(newtons);
        scan
    }

    /// The scans at which records are complete; the trigger is armed again after each.
    fn triggers(force: impl Fn(u64) -> f32, scans: u64) -> Vec<u64> {
        let (mut capture, mut record) = capture();
        let mut trigger_scans = Vec::new();
        for i in 0..scans {
            let state = capture.feed(&mut record, &scan(force(i)), ScanIndex(i));
            if let CaptureState::Complete { trigger_scan } = state {
                trigger_scans.push(trigger_scan.0);
                assert_eq!(record.len(), RECORD_SCANS);
                let at = |i: usize| record.scan(i).unwrap()[HAMMER];
                assert!(at(PRE_TRIGGER_SCANS) >= hammer_code(3.0));
                assert!((0..PRE_TRIGGER_SCANS).all(|i| at(i) < hammer_code(3.0)));
                capture.arm(&mut record);
            }
        }
        trigger_scans
    }

    fn pulse(i: u64, at: u64, peak: f32) -> f32 {
        match i.checked_sub(at) {
            Some(t @ 0..=20) => peak * (core::f32::consts::PI * t as f32 / 20.0).sin(),
            _ => 0.0,
        }
    }

    #[test]
    fn a_hit_is_recorded_from_its_pre_trigger_on() {
        // The pulse starts at 5000; its next sample is the first above 3 N of 30 N.
        assert_eq!(triggers(|i| pulse(i, 5000, 30.0), 10_000), [5001]);
    }

    #[test]
    fn a_second_hit_within_the_record_does_not_fire() {
        let double = |i| pulse(i, 3000, 30.0) + pulse(i, 3150, 20.0);
        assert_eq!(triggers(double, 12_000), [3001]);
    }

    #[test]
    fn the_next_hit_fires_again_after_arming() {
        let two = |i| pulse(i, 3000, 30.0) + pulse(i, 8000, 25.0);
        assert_eq!(triggers(two, 12_000), [3001, 8001]);
    }

    #[test]
    fn nothing_fires_before_the_pre_trigger_has_passed() {
        assert_eq!(triggers(|i| pulse(i, 40, 30.0), 6000), []);
        // The first hit restarts the settling: after 80 quiet scans the trigger is ready.
        assert_eq!(triggers(|i| pulse(i, 40, 30.0) + pulse(i, 200, 30.0), 6000), [201]);
    }

    #[test]
    fn a_weak_touch_does_not_fire() {
        assert_eq!(triggers(|i| pulse(i, 3000, 2.5), 10_000), []);
    }

    #[test]
    fn a_slow_drift_of_the_hammer_does_not_fire() {
        // A drift of 10 N over 40 000 scans; a fixed rest value would trigger at 3 N.
        let drift = |i: u64| i as f32 / 4000.0;
        assert_eq!(triggers(drift, 40_000), []);
        let mut edge = EdgeTrigger::new(3.0, PRE_TRIGGER_SCANS);
        let fired: Vec<u64> =
            (0..40_000).filter(|&i| edge.feed(drift(i) + pulse(i, 35_000, 30.0))).collect();
        // The rest value lags the drift by about 1024 scans, 0.26 N: still below the level.
        assert_eq!(fired, [35_001]);
    }

    #[test]
    fn a_hammer_of_opposite_polarity_fires_on_falling_codes() {
        let mut calibration = Calibration::default();
        calibration.channels[HAMMER].sensitivity *= -1.0;
        let mut trigger = Trigger::new(&ADC, &calibration, LEVEL);
        let falling = |i| {
            let mut scan = scan(0.0);
            scan[HAMMER] = 4000 - (hammer_code(pulse(i, 300, 30.0)) - hammer_code(0.0));
            scan
        };
        let fired: Vec<u64> = (0..1000).filter(|&i| trigger.feed(&falling(i))).collect();
        assert_eq!(fired, [301]);
    }

    #[test]
    fn a_gap_before_the_hit_starts_the_pre_trigger_anew() {
        let (mut capture, mut record) = capture();
        for i in 0..200 {
            capture.feed(&mut record, &scan(0.0), ScanIndex(i));
        }
        // 50 scans after the gap are too few for the pre-trigger, so this hit is not taken.
        for i in 1000..1050 {
            capture.feed(&mut record, &scan(0.0), ScanIndex(i));
        }
        assert_eq!(capture.feed(&mut record, &scan(30.0), ScanIndex(1050)), CaptureState::Waiting);
    }

    #[test]
    fn a_gap_after_the_hit_breaks_the_record_until_it_is_armed() {
        let (mut capture, mut record) = capture();
        for i in 0..200 {
            capture.feed(&mut record, &scan(0.0), ScanIndex(i));
        }
        assert_eq!(capture.feed(&mut record, &scan(30.0), ScanIndex(200)), CaptureState::Filling);
        assert_eq!(capture.feed(&mut record, &scan(0.0), ScanIndex(202)), CaptureState::Broken);
        assert_eq!(capture.feed(&mut record, &scan(0.0), ScanIndex(203)), CaptureState::Broken);
        capture.arm(&mut record);
        assert_eq!(capture.feed(&mut record, &scan(0.0), ScanIndex(204)), CaptureState::Waiting);
    }

    #[test]
    fn a_complete_record_is_not_touched() {
        let (mut capture, mut record) = capture();
        let mut index = 0;
        loop {
            let state = capture.feed(&mut record, &scan(pulse(index, 300, 30.0)), ScanIndex(index));
            index += 1;
            if matches!(state, CaptureState::Complete { .. }) {
                break;
            }
        }
        let before: Vec<u16> = record.channel(HAMMER).collect();
        for i in index..index + 100 {
            let state = capture.feed(&mut record, &scan(40.0), ScanIndex(i));
            assert_eq!(state, CaptureState::Complete { trigger_scan: ScanIndex(301) });
        }
        assert!(record.channel(HAMMER).eq(before));
    }
}
