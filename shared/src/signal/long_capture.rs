//! Captures a long record: the force at the full rate, the responses decimated.

use super::{
    CHANNELS, CaptureState, DECIMATION, Decimator, HAMMER, PRE_TRIGGER_SCANS, RECORD_SCANS, Record,
    SETTLING_ROWS, Scan, Trigger,
};
use crate::signal::AdcProperties;
use crate::units::ScanIndex;

/// Quiet scans before the trigger: the filter settles, and the rows before the hit are complete.
const QUIET_SCANS: usize = (SETTLING_ROWS + PRE_TRIGGER_SCANS + 1) * DECIMATION;

/// Lowest and highest code of each channel at the full rate, as the converter gave it: of the responses since the
/// trigger, of the hammer since its part of the record is full. A decimated response does not show that it was clipped
/// for a moment, and the record has no force after its first half second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FullRateExtremes(pub [[u16; 2]; CHANNELS]);

impl FullRateExtremes {
    /// Of no scans.
    pub const NONE: Self = Self([[u16::MAX, 0]; CHANNELS]);

    fn add(&mut self, channels: core::ops::Range<usize>, scan: &Scan) {
        for channel in channels {
            let [low, high] = &mut self.0[channel];
            (*low, *high) = ((*low).min(scan[channel]), (*high).max(scan[channel]));
        }
    }
}

/// Captures the long record of one hit.
///
/// The trigger is that of [`Capture`](super::Capture), after 1.8 s without a disturbance. In the record, the force
/// begins [`PRE_TRIGGER_SCANS`] scans before the trigger and the responses as many rows before that of the trigger,
/// which are those of the scans whose index is a multiple of [`DECIMATION`].
#[derive(Clone, Copy, Debug)]
pub struct LongCapture {
    trigger: Trigger,
    decimator: Decimator,
    /// Rows in which the filter still settles.
    settling: u8,
    /// Factor on the hammer's codes.
    factor: u16,
    bits: u8,
    state: CaptureState,
    /// Expected index of the next scan.
    expected: Option<u64>,
    trigger_scan: ScanIndex,
    /// Codes of the hammer that are still missing.
    missing: u16,
    extremes: FullRateExtremes,
}

impl LongCapture {
    /// An armed capture for a converter; the record must be [waiting](Record::begin_wait).
    pub fn new(trigger: Trigger, adc: &AdcProperties) -> Self {
        Self {
            trigger: trigger.settling(QUIET_SCANS),
            decimator: Decimator::new(adc.bits),
            settling: SETTLING_ROWS as u8,
            factor: adc.to_row_code(),
            bits: adc.bits,
            state: CaptureState::Waiting,
            expected: None,
            trigger_scan: ScanIndex(0),
            missing: 0,
            extremes: FullRateExtremes::NONE,
        }
    }

    /// Extremes of the complete record.
    pub fn extremes(&self) -> &FullRateExtremes {
        &self.extremes
    }

    /// Takes the next scan into the record.
    ///
    /// A gap in `index` before the trigger restarts the wait; a gap after it makes the record
    /// [`CaptureState::Broken`].
    pub fn feed(&mut self, record: &mut Record, scan: &Scan, index: ScanIndex) -> CaptureState {
        let gap = self.expected.is_some_and(|expected| expected != index.0);
        self.expected = Some(index.0.wrapping_add(1));
        match self.state {
            CaptureState::Waiting if gap => self.restart(record),
            CaptureState::Filling if gap => self.state = CaptureState::Broken,
            _ => {}
        }
        match self.state {
            CaptureState::Waiting => self.wait(record, scan, index),
            CaptureState::Filling => self.fill(record, scan, index),
            CaptureState::Complete { .. } | CaptureState::Broken => {}
        }
        self.state
    }

    fn restart(&mut self, record: &mut Record) {
        record.begin_wait();
        self.trigger.arm();
        self.decimator = Decimator::new(self.bits);
        self.settling = SETTLING_ROWS as u8;
    }

    fn wait(&mut self, record: &mut Record, scan: &Scan, index: ScanIndex) {
        if self.trigger.feed(scan) {
            record.end_wait();
            self.trigger_scan = index;
            self.missing = (RECORD_SCANS - PRE_TRIGGER_SCANS) as u16;
            self.state = CaptureState::Filling;
            self.fill(record, scan, index);
            return;
        }
        record.push_force(scan[HAMMER].saturating_mul(self.factor));
        if let Some(row) = self.decimator.feed(scan, index) {
            match self.settling.checked_sub(1) {
                Some(left) => self.settling = left,
                None => record.push_row(&row),
            }
        }
    }

    fn fill(&mut self, record: &mut Record, scan: &Scan, index: ScanIndex) {
        self.extremes.add(HAMMER + 1..CHANNELS, scan);
        match self.missing.checked_sub(1) {
            Some(left) => {
                self.missing = left;
                record.push_force(scan[HAMMER].saturating_mul(self.factor));
            }
            None => self.extremes.add(HAMMER..HAMMER + 1, scan),
        }
        if let Some(row) = self.decimator.feed(scan, index) {
            record.push_row(&row);
            if record.len() == RECORD_SCANS {
                self.state = CaptureState::Complete { trigger_scan: self.trigger_scan };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::Calibration;
    use crate::signal::tests::{ADC, hammer_code};
    use crate::units::Newtons;
    use std::boxed::Box;

    fn armed() -> (LongCapture, Box<Record>) {
        let mut record = Box::new(Record::new());
        record.begin_wait();
        let trigger = Trigger::new(&ADC, &Calibration::default(), Newtons(3.0));
        (LongCapture::new(trigger, &ADC), record)
    }

    /// A push of 50 N for 20 ms at scan `at`; responses that show the number of the row, which is 300 for that of the
    /// push.
    fn scan(n: u64, at: u64) -> Scan {
        let row = |n: u64| n / DECIMATION as u64;
        let mut scan = [(300 + row(n) - row(at)) as u16; CHANNELS];
        scan[HAMMER] = hammer_code(if (at..at + 80).contains(&n) { 50.0 } else { 0.0 });
        scan
    }

    #[test]
    fn force_and_rows_lie_about_the_trigger() {
        for (first, at) in [(0, 8_000), (17, 8_079), (1_000_040, 1_008_000), (79, 20_001)] {
            let (mut capture, mut record) = armed();
            let complete = (first..first + 400_000).find(|&n| {
                matches!(
                    capture.feed(&mut record, &scan(n, at), ScanIndex(n)),
                    CaptureState::Complete { .. }
                )
            });
            let row_of_trigger = at / DECIMATION as u64;
            let rows_after = (RECORD_SCANS - PRE_TRIGGER_SCANS) as u64;
            assert_eq!(complete, Some((row_of_trigger + rows_after) * DECIMATION as u64 - 1));
            assert_eq!(capture.state, CaptureState::Complete { trigger_scan: ScanIndex(at) });
            let force = |place: usize| record.scan(place).unwrap()[HAMMER];
            let rest = hammer_code(0.0) << 4;
            assert_eq!((force(79), force(80)), (rest, hammer_code(50.0) << 4));
            assert_eq!((force(159), force(160)), (hammer_code(50.0) << 4, rest));
            // The filter is symmetric: it delays by half its length of 830 scans, 5.2 rows.
            let row = |place: usize| f64::from(record.scan(place).unwrap()[4]) / 16.0;
            // It is a ramp of steps, whose mean is half a step lower.
            assert!((row(80) - (300.0 - 4.7)).abs() < 0.02, "{}", row(80));
            // Rows follow each other.
            assert!((0..RECORD_SCANS - 1).all(|k| (row(k + 1) - row(k) - 1.0).abs() < 0.1));
        }
    }

    #[test]
    fn a_hit_before_the_filter_has_settled_does_not_trigger() {
        let (mut capture, mut record) = armed();
        let at = QUIET_SCANS as u64 - 10;
        for n in 0..at + 1000 {
            assert_eq!(
                capture.feed(&mut record, &scan(n, at), ScanIndex(n)),
                CaptureState::Waiting
            );
        }
    }

    #[test]
    fn lost_scans_restart_the_wait_and_break_the_record() {
        let (mut capture, mut record) = armed();
        let feed = |capture: &mut LongCapture, record: &mut Record, n: u64| {
            capture.feed(record, &scan(n, 20_000), ScanIndex(n))
        };
        for n in 0..5000 {
            feed(&mut capture, &mut record, n);
        }
        // Five scans are lost; the wait begins anew and is over before the push.
        (5005..20_000).for_each(|n| {
            assert_eq!(feed(&mut capture, &mut record, n), CaptureState::Waiting);
        });
        assert_eq!(feed(&mut capture, &mut record, 20_000), CaptureState::Filling);
        assert_eq!(feed(&mut capture, &mut record, 20_002), CaptureState::Broken);
    }

    #[test]
    fn a_short_clip_and_a_late_push_are_seen() {
        let (mut capture, mut record) = armed();
        for n in 0..200_000 {
            let mut scan = scan(n, 10_000);
            scan[2] = if n == 12_000 { 4095 } else { 2048 };
            if n == 100_000 {
                scan[HAMMER] = hammer_code(20.0);
            }
            capture.feed(&mut record, &scan, ScanIndex(n));
        }
        let FullRateExtremes(extremes) = capture.extremes();
        assert_eq!(extremes[2], [2048, 4095]);
        assert_eq!(extremes[HAMMER], [hammer_code(0.0), hammer_code(20.0)]);
    }
}
