//! One test on the bench by the rig's own pure functions, in double precision: hits are triggered,
//! recorded, graded and averaged as the firmware does, only without its executor, link and flash.

use massline_shared::campaign::{Campaign, Step};
use massline_shared::diagnosis::Code;
use massline_shared::identify::{MassLines, ScatterAccumulator};
use massline_shared::layout::{Layout, RIG_HITS, RIG_SENSORS, TestSettings, Verdict};
use massline_shared::mass_line::{
    BasisRow, Fitting, Line, MassLineBasis, MassLineError, ResponseFits, find_band,
    window_correlation,
};
use massline_shared::signal::{
    AdcProperties, Calibration, Capture, CaptureState, FftError, HitAnalysis, PRE_TRIGGER_SCANS,
    RECORD_SCANS, RESPONSES, Record, SPECTRUM_LINES, Spectra, Standing, Trigger, grade, standing,
};
use massline_shared::units::{Newtons, ScanIndex};
use massline_virtual::source::ScanSource;
use nalgebra::{Complex, SVector};

/// A layout of the rig in double precision.
pub type TestLayout = Layout<f64, RIG_SENSORS, RIG_HITS>;
/// Mass lines of the rig's responses in double precision.
pub type TestMassLines = MassLines<f64, RESPONSES>;

/// Rejected hits at one DOF after which a test is given up.
const MOST_REJECTED: u16 = 200;
/// Scans without a hit after which an arming is given up: a minute and a half at 4 kS/s.
const MOST_SCANS: u64 = 360_000;

/// What one test measures.
#[derive(Clone, Debug, PartialEq)]
pub struct Measurement {
    /// Index in the layout and mass lines of every hit DOF.
    pub dofs: Vec<(usize, TestMassLines)>,
    /// Hits that were not good enough.
    pub rejected: u16,
}

/// Why a test has no mass lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unmeasured {
    /// The hammer does not reach the trigger.
    #[error("no hit at DOF {} reaches test.trigger_n; lower it or hit harder", .0 + 1)]
    NeverTriggered(usize),
    /// No hit is good enough.
    #[error(
        "{MOST_REJECTED} hits at DOF {} were rejected; look at test.weakest_hit_n and at the \
         force of the bench's taps", .0 + 1
    )]
    AlwaysRejected(usize),
    /// A hit cannot be transformed.
    #[error("a hit cannot be analysed: {0}")]
    Transform(#[from] FftError),
    /// A DOF has no mass line.
    #[error("no mass line can be fitted: {0}; look at test.band_hz")]
    MassLine(#[from] MassLineError),
}

/// Measures all hit DOFs of a layout on what `source` gives.
///
/// # Errors
/// See [`Unmeasured`].
pub fn measure(
    source: &mut dyn ScanSource,
    layout: &TestLayout,
    calibration: &Calibration,
) -> Result<Measurement, Unmeasured> {
    let mut tester = Tester::new(source, layout, calibration);
    let mut campaign = Campaign::new();
    // A layout without hits has no DOF to measure.
    let started = campaign.start(layout.hits.len(), layout.test.hits_per_dof, false);
    let mut dofs = Vec::new();
    let mut rejected_before = 0;
    while started.is_ok() {
        match campaign.step() {
            Step::AwaitHit { dof } => {
                campaign.armed();
                tester.take_record(campaign.armings(), dof)?;
                campaign.triggered();
                campaign.graded(tester.is_good());
                if campaign.rejected() - rejected_before >= MOST_REJECTED {
                    return Err(Unmeasured::AlwaysRejected(dof));
                }
            }
            Step::Analyse { .. } => {
                if campaign.accepted() == 0 {
                    tester.open_dof();
                }
                match tester.average_hit()? {
                    Standing::Agrees => campaign.analysed(),
                    Standing::Astray(_) => campaign.withdrawn(),
                    Standing::Contradicts(_) => campaign.contradicted(),
                }
            }
            Step::CloseDof { dof } => {
                dofs.push((dof, tester.close_dof()?));
                campaign.dof_closed();
                rejected_before = campaign.rejected();
            }
            Step::Identify | Step::Rest => break,
        }
    }
    Ok(Measurement { dofs, rejected: campaign.rejected() })
}

type Lines = [Complex<f64>; SPECTRUM_LINES];
const ZERO: Complex<f64> = Complex { re: 0.0, im: 0.0 };

/// The rig without its firmware.
struct Tester<'a> {
    source: &'a mut dyn ScanSource,
    adc: AdcProperties,
    calibration: &'a Calibration,
    test: TestSettings<f64>,
    hit: HitAnalysis<f64>,
    record: Box<Record>,
    spectra: Box<Spectra<f64, RESPONSES, SPECTRUM_LINES>>,
    single_hits: ScatterAccumulator<f64, RESPONSES>,
    scratch: Box<[f64; RECORD_SCANS]>,
    basis: Box<[BasisRow<f64>; SPECTRUM_LINES]>,
}

impl<'a> Tester<'a> {
    fn new(
        source: &'a mut dyn ScanSource,
        layout: &TestLayout,
        calibration: &'a Calibration,
    ) -> Self {
        let adc = source.adc();
        Self {
            source,
            adc,
            calibration,
            test: layout.test,
            hit: HitAnalysis::new(&adc, calibration, &layout.test, PRE_TRIGGER_SCANS),
            record: Box::new(Record::new()),
            spectra: Box::new(Spectra::<f64, RESPONSES, SPECTRUM_LINES>::new()),
            single_hits: ScatterAccumulator::new(),
            scratch: Box::new([0.0; RECORD_SCANS]),
            basis: Box::new([BasisRow::default(); SPECTRUM_LINES]),
        }
    }

    fn take_record(&mut self, arming: u32, dof: usize) -> Result<(), Unmeasured> {
        self.source.armed(arming, dof);
        self.record.clear();
        let level = Newtons(self.test.trigger_n as f32);
        let mut capture = Capture::new(Trigger::new(&self.adc, self.calibration, level));
        for index in 0..MOST_SCANS {
            let Some(scan) = self.source.next_scan() else { break };
            let state = capture.feed(&mut self.record, &scan, ScanIndex(index));
            if let CaptureState::Complete { .. } = state {
                return Ok(());
            }
        }
        Err(Unmeasured::NeverTriggered(dof))
    }

    fn is_good(&self) -> bool {
        grade(&self.record, &self.adc, self.calibration, &self.test.cast(), None).good()
    }

    fn open_dof(&mut self) {
        self.spectra.clear();
        self.single_hits = ScatterAccumulator::new();
    }

    /// Averages the record in hand, unless it does not agree with its siblings and the policy wants
    /// only those that do.
    fn average_hit(&mut self) -> Result<Standing<f64>, Unmeasured> {
        let (mut force, mut lines): (Lines, Lines) =
            ([ZERO; SPECTRUM_LINES], [ZERO; SPECTRUM_LINES]);
        self.hit.force(&*self.record, &mut *self.scratch, &mut force)?;
        self.spectra.add_force(&force);
        let resolution = self.hit.resolution(RECORD_SCANS);
        let basis = basis(&self.test, resolution, |line| force[line].norm_sqr(), &mut *self.basis)?;
        let mut single = SVector::<f64, RESPONSES>::zeros();
        for response in 0..self.adc.responses() {
            self.hit.response(&*self.record, response, &mut *self.scratch, &mut lines)?;
            self.spectra.add_response(response, &force, &lines);
            HitAnalysis::divide(&mut lines, &force);
            single[response] = basis.fit(lines)?.accelerance();
        }
        self.calibration.undo_cross_axis(single.as_mut_slice());
        let siblings = &self.single_hits;
        let distance = siblings.distance(&single);
        let standing = standing(u32::from(siblings.hits()), siblings.spread(), distance);
        let rejects = self.test.policy.verdict(Code::HitInconsistent) == Verdict::Reject;
        if !rejects || standing == Standing::Agrees {
            self.single_hits.add(&single);
            return Ok(Standing::Agrees);
        }
        if let Standing::Astray(_) = standing {
            self.spectra.remove_force(&force);
            for response in 0..self.adc.responses() {
                self.hit.response(&*self.record, response, &mut *self.scratch, &mut lines)?;
                self.spectra.remove_response(response, &force, &lines);
            }
        }
        Ok(standing)
    }

    fn close_dof(&mut self) -> Result<TestMassLines, Unmeasured> {
        let spectra = &self.spectra;
        let resolution = self.hit.resolution(RECORD_SCANS);
        let record = RECORD_SCANS as f64 / f64::from(self.adc.rate.0);
        let responses = self.adc.responses();
        let fitting = Fitting {
            band: self.band(resolution),
            decay: self.test.exponential_decay,
            terms: self.test.terms,
            correlation: window_correlation(self.test.exponential_decay, record),
        };
        let frf = |response, line| spectra.frf(self.test.frf_estimator, response, line);
        let lines = lines(resolution, |line| spectra.force_auto(line));
        let fits =
            ResponseFits::<f64, RESPONSES>::new(lines, &fitting, responses, frf, &mut *self.basis)?;
        let (mut accelerance, noise) = (fits.accelerance, fits.noise);
        // The noise of a channel is changed by the square of its cross-axis sensitivities only.
        self.calibration.undo_cross_axis(accelerance.as_mut_slice());
        Ok(MassLines { noise, ..self.single_hits.mass_lines_at(accelerance) })
    }

    /// The band of the DOF in hand: as set, else as its averaged spectra show it.
    fn band(&self, resolution: f64) -> [f64; 2] {
        let found = || {
            let mut squares = [0.0; SPECTRUM_LINES];
            self.spectra.add_squares(self.adc.responses(), &mut squares);
            let frequency = |line: usize| line as f64 * resolution;
            find_band(&squares, frequency, self.test.exponential_decay).map(|found| found.ends)
        };
        self.test.band_hz.or_else(found).unwrap_or_else(TestSettings::usual_band)
    }
}

fn basis<'b>(
    test: &TestSettings<f64>,
    resolution: f64,
    weight: impl Fn(usize) -> f64 + Clone,
    workspace: &'b mut [BasisRow<f64>],
) -> Result<MassLineBasis<'b, f64>, MassLineError> {
    let (band, lines) = (test.expected_band(), lines(resolution, weight));
    MassLineBasis::new(lines, band, test.exponential_decay, test.terms, workspace)
}

fn lines(
    resolution: f64,
    weight: impl Fn(usize) -> f64 + Clone,
) -> impl Iterator<Item = Line<f64>> + Clone {
    (0..SPECTRUM_LINES).map(move |i| Line { frequency: i as f64 * resolution, weight: weight(i) })
}
