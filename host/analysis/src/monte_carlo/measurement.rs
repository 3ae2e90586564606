//! One test on the bench with the measurement code of a rig, in double precision: hits are triggered,
//! recorded, graded, averaged and identified as on a rig, but without its link and flash.

use massline_physics::source::ScanSource;
use massline_result::Doubt;
use massline_shared::capacity::Rig;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::agreement::Agreement;
use massline_shared::identify::{DofMassLines, Estimate, Method};
use massline_shared::measurement::campaign::{Campaign, Command, Outcome, Phase, Start};
use massline_shared::measurement::{self, GradedHit, Measurement, Memory, NextAction, StartError};
use massline_shared::signal::{Calibration, SPECTRUM_BINS, ringing_s};
use massline_shared::units::ScanIndex;

use crate::score_tests::ScoreTests;
use crate::suspension::{DofLines, TestLines};

/// A layout in the rig's capacity and in double precision.
pub type TestLayout = measurement::TestLayout<f64>;

/// A test is abandoned after this many rejected hits at one DOF.
pub const MOST_REJECTED: u16 = 200;
/// An arming is abandoned after this many scans without a hit: a minute and a half at 4 kS/s.
const MOST_SCANS: u64 = 360_000;

/// The result of one test.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedTest {
    /// Index in the layout and mass lines of every hit DOF.
    pub dofs: Vec<DofMassLines<f64, Rig>>,
    /// Or, in the suspension profile, the lines of every hit DOF.
    pub lines: Vec<DofLines>,
    /// What all methods of the suspension profile say together.
    pub combined: Option<Agreement<f64>>,
    /// Why they are not combined, as far as there is a reason besides theirs.
    pub doubt: Option<Doubt>,
    /// What the global fit was tested for.
    pub score_tests: ScoreTests,
    /// The answers, the best method first.
    pub estimates: Vec<Estimate<f64>>,
    /// The methods without an answer, and the reasons.
    pub refusals: Vec<(Method, Diagnostics)>,
    /// Number of rejected hits.
    pub rejected: u16,
    /// Number of hits that were left out because the target had been reached.
    pub hits_saved: usize,
    /// True when the target was reached, at the last DOF or before.
    pub reached: bool,
    /// Every hit, with the number of its arming; a hit that was withdrawn afterwards appears again.
    pub hits: Vec<(u32, GradedHit)>,
    /// Diagnostics of the campaign.
    pub diagnostics: Vec<Diagnostic>,
}

impl SimulatedTest {
    /// True when the result carries a warning or an error, or a hit was rejected.
    pub fn warns(&self) -> bool {
        let of_answer = self.estimates.iter().take(1).flat_map(|estimate| &estimate.diagnostics);
        let mut diagnostics = self.diagnostics.iter().chain(of_answer);
        self.rejected > 0 || diagnostics.any(|diagnostic| diagnostic.severity >= Severity::Warning)
    }
}

/// Why a test yields no mass lines.
#[derive(Clone, Debug, PartialEq)]
pub enum MeasureError {
    /// No hit reaches the trigger level.
    NeverTriggered(usize),
    /// Too many hits were rejected.
    AlwaysRejected {
        /// Index of the DOF in the layout.
        dof: usize,
        /// Rejected hits of the whole test.
        rejected: u16,
    },
    /// A rig cannot measure with this layout, for these reasons.
    Refused(StartError, Vec<Diagnostic>),
    /// The mass line fit of a DOF failed.
    MassLine(Diagnostic),
}

impl MeasureError {
    /// Number of rejected hits.
    pub fn rejected(&self) -> u16 {
        match self {
            Self::AlwaysRejected { rejected, .. } => *rejected,
            Self::NeverTriggered(_) | Self::Refused(..) | Self::MassLine(_) => 0,
        }
    }
}

/// Measures the hit DOFs of a layout on the scans of `source` until the layout's target is reached, otherwise
/// all of them, and identifies the ten properties.
///
/// # Errors
/// See [`MeasureError`].
pub fn measure(
    source: &mut dyn ScanSource,
    layout: &TestLayout,
    calibration: &Calibration,
) -> Result<SimulatedTest, MeasureError> {
    let mut memory = Box::new(Memory::<f64>::new());
    let mut rig = Measurement::new(source.adc(), &mut memory);
    rig.set_layout(layout.clone());
    rig.set_calibration(*calibration, None);
    rig.start(Start::DEFAULT, true, true).map_err(|error| refused(&rig, error))?;
    let mut rejected_before = (0, 0);
    let (mut hits, mut lines) = (Vec::new(), Vec::new());
    loop {
        match rig.next_action() {
            NextAction::StoreLines { dof } => {
                lines.push(take_lines(&rig, dof));
                rig.lines_stored();
            }
            NextAction::Sample => take_record(&mut rig, source)?,
            NextAction::Compute => rig.work(),
            NextAction::Wait if rig.phase() == Phase::TargetReached => {
                // Cannot fail in this phase.
                let _ = rig.command(Command::Conclude);
            }
            NextAction::Store | NextAction::Wait => break,
        }
        while let Some(hit) = rig.next_hit() {
            hits.push((rig.armings(), hit));
        }
        let Some(campaign) = rig.campaign() else { break };
        let (dof, rejected) = (campaign.dof(), campaign.rejected());
        if dof != rejected_before.0 {
            rejected_before = (dof, rejected);
        } else if rejected - rejected_before.1 >= MOST_REJECTED {
            return Err(MeasureError::AlwaysRejected { dof, rejected });
        }
    }
    let dofs = rig.campaign().map_or(&[][..], Campaign::dofs);
    let unneeded = dofs.iter().filter(|dof| dof.outcome == Outcome::NotNeeded).count();
    let precision = rig.precision().and_then(|known| known.precision);
    let result = rig.result();
    let no_line = |code| matches!(code, Code::BandTooNarrow | Code::DataNotFinite);
    if let Some(diagnostic) = result.diagnostics.iter().find(|d| d.is_error() && no_line(d.code))
        && result.mass_lines.len() + unneeded < layout.hits.len()
    {
        return Err(MeasureError::MassLine(*diagnostic));
    }
    let solved = solve_lines(&rig, &lines);
    Ok(SimulatedTest {
        dofs: result.mass_lines.to_vec(),
        lines,
        combined: solved.combined,
        doubt: solved.doubt,
        score_tests: solved.score_tests,
        estimates: [result.estimates, &solved.estimates].concat(),
        refusals: [result.refusals, &solved.refusals].concat(),
        hits_saved: unneeded * usize::from(layout.test.hits_per_dof),
        reached: precision.is_some_and(|known| known.is_reached()),
        rejected: rig.campaign().map_or(0, |campaign| campaign.rejected()),
        hits,
        diagnostics: result.diagnostics.to_vec(),
    })
}

/// The lines of the DOF that the measurement has closed.
fn take_lines(rig: &Measurement<'_, f64>, dof: usize) -> DofLines {
    let responses = rig.adc_in_use().responses();
    let response_lines = |response| (0..SPECTRUM_BINS).map(move |bin| rig.line(response, bin));
    DofLines { dof, lines: (0..responses).flat_map(response_lines).collect() }
}

/// Answers to lines.
#[derive(Default)]
struct LineAnswers {
    estimates: Vec<Estimate<f64>>,
    refusals: Vec<(Method, Diagnostics)>,
    combined: Option<Agreement<f64>>,
    doubt: Option<Doubt>,
    score_tests: ScoreTests,
}

/// What the methods of the suspension profile say of lines.
fn solve_lines(rig: &Measurement<'_, f64>, lines: &[DofLines]) -> LineAnswers {
    let layout = rig.layout().filter(|_| !lines.is_empty()).and_then(TestLayout::cast);
    let Some(layout) = layout else { return LineAnswers::default() };
    let wanted: Vec<Method> = Method::of_modes().chain([Method::GlobalFit]).collect();
    let measured = TestLines::new(&layout, rig.adc(), lines);
    match measured.solve(ringing_s(rig.adc()), &wanted, |_, _| ()) {
        Ok(solution) => LineAnswers {
            estimates: solution.estimates,
            refusals: solution.not_applicable,
            combined: solution.comparison.agreement,
            doubt: solution.comparison.doubt,
            score_tests: solution.score_tests,
        },
        Err(reasons) => {
            let refusals = wanted.iter().map(|method| (*method, reasons.clone())).collect();
            LineAnswers { refusals, ..LineAnswers::default() }
        }
    }
}

/// Processes the scans of one arming.
fn take_record(
    rig: &mut Measurement<'_, f64>,
    source: &mut dyn ScanSource,
) -> Result<(), MeasureError> {
    rig.sampling_started();
    let dof = rig.campaign().map_or(0, |campaign| campaign.dof());
    source.armed(rig.armings(), dof);
    for index in 0..MOST_SCANS {
        let Some(scan) = source.next_scan() else { break };
        rig.feed(ScanIndex(index), &[scan]);
        if rig.next_action() != NextAction::Sample {
            return Ok(());
        }
    }
    Err(MeasureError::NeverTriggered(dof))
}

fn refused(rig: &Measurement<'_, f64>, error: StartError) -> MeasureError {
    let findings = rig.layout().map(|layout| rig.check(layout));
    let errors = findings.iter().flatten().filter(|finding| finding.is_error()).copied();
    MeasureError::Refused(error, errors.collect())
}
