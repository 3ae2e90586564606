//! One test on the bench by the rig's own pure functions, in double precision: hits are triggered,
//! recorded, graded and averaged as the firmware does, only without its executor, link and flash.

use massline_shared::measurement::averaging::{
    DofSpectra, HitInHand, HitMemory, Method, band_of, fit_responses, join,
};
use massline_shared::measurement::campaign::{Campaign, Step};
use massline_shared::diagnosis::Code;
use massline_shared::identify::{MassLines, ScatterAccumulator};
use massline_shared::layout::{Layout, RIG_HITS, RIG_SENSORS, TestSettings, Verdict};
use massline_shared::mass_line::{BasisRow, MassLineError};
use massline_shared::signal::{
    AdcProperties, Calibration, Capture, CaptureState, FftError, RECORD_SCANS, RESPONSES, Record,
    SPECTRUM_LINES, Standing, Trigger, grade,
};
use massline_shared::units::{Newtons, ScanIndex};
use massline_virtual::source::ScanSource;
use nalgebra::Complex;

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

/// The rig without its firmware.
struct Tester<'a> {
    source: &'a mut dyn ScanSource,
    adc: AdcProperties,
    calibration: &'a Calibration,
    test: TestSettings<f64>,
    record: Box<Record>,
    spectra: Box<DofSpectra<f64>>,
    siblings: ScatterAccumulator<f64, RESPONSES>,
    scratch: Box<[f64; RECORD_SCANS]>,
    force: Box<[Complex<f64>; SPECTRUM_LINES]>,
    basis: Box<[BasisRow<f64>; SPECTRUM_LINES]>,
}

impl<'a> Tester<'a> {
    fn new(
        source: &'a mut dyn ScanSource,
        layout: &TestLayout,
        calibration: &'a Calibration,
    ) -> Self {
        Self {
            adc: source.adc(),
            source,
            calibration,
            test: layout.test,
            record: Box::new(Record::new()),
            spectra: Box::new(DofSpectra::<f64>::new()),
            siblings: ScatterAccumulator::new(),
            scratch: Box::new([0.0; RECORD_SCANS]),
            force: Box::new([Complex::new(0.0, 0.0); SPECTRUM_LINES]),
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
        self.siblings = ScatterAccumulator::new();
    }

    /// Averages the record in hand, unless it does not agree with its siblings and the policy wants
    /// only those that do.
    fn average_hit(&mut self) -> Result<Standing<f64>, Unmeasured> {
        let Self { adc, calibration, test, record, spectra, .. } = self;
        let responses = adc.responses();
        let method = Method { adc, calibration, test };
        let memory = HitMemory {
            scratch: &mut *self.scratch,
            force: &mut *self.force,
            basis: &mut *self.basis,
        };
        let mut hit = HitInHand::begin(method, &**record, memory, spectra)?;
        for response in 0..responses {
            hit.add_response(response, &**record, spectra)?;
        }
        let Some(single) = hit.mass_lines(calibration) else { return Ok(Standing::Agrees) };
        let verdict = test.policy.verdict(Code::HitInconsistent);
        let standing = join(&mut self.siblings, &single, verdict);
        if verdict != Verdict::Reject {
            return Ok(Standing::Agrees);
        }
        if let Standing::Astray(_) = standing {
            hit.remove_force(spectra);
            for response in 0..responses {
                hit.remove_response(response, &**record, spectra)?;
            }
        }
        Ok(standing)
    }

    fn close_dof(&mut self) -> Result<TestMassLines, Unmeasured> {
        let Self { adc, calibration, test, spectra, .. } = self;
        let method = Method { adc, calibration, test };
        let squares = &mut self.scratch[..SPECTRUM_LINES];
        let band = band_of(method, spectra, squares).unwrap_or_else(TestSettings::usual_band);
        let fits = fit_responses(method, spectra, band, &mut *self.basis)?;
        let (mut accelerance, noise) = (fits.accelerance, fits.noise);
        // The noise of a channel is changed by the square of its cross-axis sensitivities only.
        self.calibration.undo_cross_axis(accelerance.as_mut_slice());
        Ok(MassLines { noise, ..self.siblings.mass_lines_at(accelerance) })
    }
}
