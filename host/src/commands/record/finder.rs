//! Finds and grades the hits in consecutive scans, as the rig would under either profile.

use massline_shared::layout::{TestProfile, TestSettings};
use massline_shared::signal::{
    AdcProperties, Calibration, Capture, CaptureState, DECIMATION, FullRateExtremes, HitReport,
    LongCapture, PRE_TRIGGER_SCANS, Record, SETTLING_ROWS, Scan, Trigger, grade, grade_long,
};
use massline_shared::units::{Newtons, ScanIndex};

/// What a scan has shown.
pub(super) enum ScanOutcome {
    /// Nothing new.
    Nothing,
    /// The object rings after a hit, for as long as a record of the suspension profile lasts.
    Ringing,
    /// The record of a hit is complete.
    Hit {
        /// Index of the first scan of its segment: quiet enough scans before the hit for the trigger of a replay.
        start: u64,
        report: Box<HitReport>,
    },
}

/// Finds hits in consecutive scans.
pub(super) struct HitFinder<'r> {
    settings: Settings<'r>,
    capture: HitCapture,
    record: Box<Record>,
    ringing: bool,
    /// Fingerprint of the record graded last.
    last_record: Option<u32>,
}

/// What decides which scans are a hit, and a good one.
#[derive(Clone, Copy)]
pub(super) struct Settings<'r> {
    pub adc: &'r AdcProperties,
    pub calibration: &'r Calibration,
    pub test: &'r TestSettings<f32>,
}

/// The capture of a hit under either profile.
enum HitCapture {
    MassLine(Capture),
    Long(Box<LongCapture>),
}

impl<'r> HitFinder<'r> {
    pub fn new(settings: Settings<'r>) -> Self {
        let mut record = Box::new(Record::new());
        let capture = HitCapture::new(settings, &mut record);
        Self { settings, capture, record, ringing: false, last_record: None }
    }

    /// Processes the next scan.
    pub fn feed(&mut self, scan: &Scan, index: u64) -> ScanOutcome {
        let (record, index) = (&mut *self.record, ScanIndex(index));
        let (state, extremes) = match &mut self.capture {
            HitCapture::MassLine(capture) => (capture.feed(record, scan, index), None),
            HitCapture::Long(capture) => {
                let state = capture.feed(record, scan, index);
                (state, Some(*capture.extremes()))
            }
        };
        match state {
            CaptureState::Complete { trigger_scan } => {
                let report = self.grade(trigger_scan, extremes.as_ref());
                self.last_record = Some(report.fingerprint);
                self.ringing = false;
                self.capture = HitCapture::new(self.settings, &mut self.record);
                let start = trigger_scan.0.saturating_sub(self.scans_before());
                ScanOutcome::Hit { start, report: Box::new(report) }
            }
            CaptureState::Filling if extremes.is_some() && !self.ringing => {
                self.ringing = true;
                ScanOutcome::Ringing
            }
            _ => ScanOutcome::Nothing,
        }
    }

    fn grade(&self, trigger: ScanIndex, extremes: Option<&FullRateExtremes>) -> HitReport {
        let (Settings { adc, calibration, test }, last) = (self.settings, self.last_record);
        match extremes {
            None => grade(&self.record, adc, calibration, test, last),
            Some(extremes) => {
                grade_long(&self.record, (trigger, extremes), adc, calibration, test, last)
            }
        }
    }

    /// Scans of a segment before the trigger: more than the trigger of a replay needs to settle.
    fn scans_before(&self) -> u64 {
        let scans = match self.settings.test.profile {
            TestProfile::MassLine => 2 * PRE_TRIGGER_SCANS,
            TestProfile::Suspension => (SETTLING_ROWS + PRE_TRIGGER_SCANS + 2) * DECIMATION,
        };
        scans as u64
    }
}

impl HitCapture {
    fn new(Settings { adc, calibration, test }: Settings<'_>, record: &mut Record) -> Self {
        let trigger = Trigger::new(adc, calibration, Newtons(test.trigger_n));
        record.begin_wait();
        match test.profile {
            TestProfile::MassLine => Self::MassLine(Capture::new(trigger)),
            TestProfile::Suspension => Self::Long(Box::new(LongCapture::new(trigger, adc))),
        }
    }
}

#[cfg(test)]
mod tests {
    use massline_physics::source::ScanSource;
    use massline_physics::{Bench, BenchSource};

    use super::*;
    use crate::support::bench_test::nominal_calibration;
    use massline_files::layout_file::LayoutFile;

    #[test]
    fn a_hit_of_forty_seconds_is_found_in_the_stream_and_again_in_its_segment() {
        let text = include_str!("../../../examples/wheel.toml");
        let file = LayoutFile::parse(text, "wheel.toml").unwrap();
        let test = file.rig_layout().unwrap().test;
        let bench = Bench::named("wheel").unwrap();
        let mut source = BenchSource::new(&bench, &file.layout, 1).unwrap();
        let (adc, calibration) = (source.adc(), nominal_calibration(&bench));
        let settings = Settings { adc: &adc, calibration: &calibration, test: &test };
        source.armed(1, 0);
        let scans: Vec<Scan> = (0..50 * 4000).map(|_| source.next_scan().unwrap()).collect();
        // When it begins to ring, and what is found then.
        let find = |scans: &[Scan]| {
            let (mut finder, mut rings) = (HitFinder::new(settings), None);
            let hit = (0..).zip(scans).find_map(|(index, scan)| match finder.feed(scan, index) {
                ScanOutcome::Nothing => None,
                ScanOutcome::Ringing => {
                    assert_eq!(rings.replace(index), None, "said once");
                    None
                }
                ScanOutcome::Hit { start, report } => Some((start, *report)),
            });
            let (start, report) = hit.expect("a hit");
            (start, rings.expect("it rings"), report)
        };
        let (start, rings, report) = find(&scans);
        assert!(report.good() && report.swing.is_some(), "{report:?}");
        assert_eq!(rings - start, (SETTLING_ROWS + PRE_TRIGGER_SCANS + 2) as u64 * 80);
        let (_, again, replayed) = find(&scans[start as usize..]);
        assert_eq!(again, rings - start);
        let [first, second] = [report, replayed].map(|report| report.swing.unwrap());
        // What the filter carries over from before the segment has died away, not vanished.
        assert!((first.impulse / second.impulse - 1.0).abs() < 1e-6, "{first:?} {second:?}");
        assert!((first.remainder - second.remainder).abs() < 1e-5, "{first:?} {second:?}");
    }
}
