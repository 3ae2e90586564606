//! Mistakes in simulated tests: healthy ones are measured, and then something is written, wired, glued or hit otherwise
//! than the layout says, by an amount drawn at random.
//!
//! | module | the mistake is made |
//! | --- | --- |
//! | [`written`] | in the layout, the cables or the readings of a test that was measured without it |
//! | [`set_up`] | on the bench, before the test is measured |
//! | [`small`] | on the bench as well, so small that it may pass for an error of the budget |

pub mod set_up;
pub mod small;
pub mod written;

use massline::support::bench_test::nominal_calibration;
use massline_analysis::identification::{Identification, Selection, identify, solve_learned};
use massline_analysis::judgement::{Concern, Evidence, Judgement};
use massline_analysis::monte_carlo::measurement::{SimulatedTest, TestLayout};
use massline_analysis::monte_carlo::{MonteCarlo, apply_bench_budget};
use massline_analysis::score_tests::{ScoreTests, SmallFault};
use massline_analysis::single_fault::{Examination, Mistake, examine};
use massline_analysis::suspension::{MassLineAnswers, compare, reciprocity_of_mass_lines};
use massline_physics::Bench;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::Code;
use massline_shared::identify::maximum_likelihood::Start;
use massline_shared::identify::{DofMassLines, Estimate, IdentifySettings, Observations};
use massline_shared::layout::HostLayout;

use crate::campaign::layout_file;

/// A test that was measured, and what is written of it.
#[derive(Clone)]
pub struct MeasuredTest {
    /// The layout as it is written.
    pub layout: TestLayout,
    /// Numbers and positions of the nodes as they are written, body frame, m.
    pub nodes: Vec<(u16, [f64; 3])>,
    /// What was measured.
    pub test: SimulatedTest,
}

impl MeasuredTest {
    /// Looks for single mistakes, as the program does.
    pub fn examine(&self) -> Examination {
        examine(&self.host_layout(), &self.nodes, &self.lines())
    }

    fn lines(&self) -> Vec<DofMassLines<f64, Unbounded>> {
        let sensors = self.layout.sensors.len();
        let dofs = self.test.dofs.iter();
        dofs.map(|(index, lines)| (*index, lines.resized(sensors))).collect()
    }

    /// The answers of all methods to the mass lines, and the verdict on the best one, as the program comes to it; no
    /// verdict without an answer.
    pub fn judge(&self) -> (Identification, Option<Judgement>) {
        let layout = self.host_layout();
        let lines = self.lines();
        let observed = Observations::of_mass_lines(&layout, &lines);
        let settings = IdentifySettings::default();
        let mut identification = identify(&observed, Selection::All, &settings);
        let score_tests = ScoreTests::of(&layout, &lines, &identification.estimates);
        let mut seen_by_rig = self.test.diagnostics.clone();
        score_tests.in_proportion(&mut seen_by_rig);
        identification.each_diagnostics(|diagnostics| score_tests.in_proportion(diagnostics));
        let judgement = identification.estimates.first().map(|answer| {
            let examination = examine(&layout, &self.nodes, &lines);
            let estimates = &identification.estimates;
            let settings = settings.inertia_restraint;
            let answers = MassLineAnswers::new(estimates, &lines, layout.clone(), settings);
            let comparison = compare(&answers, |_, _| ());
            let reciprocity = reciprocity_of_mass_lines(&layout, &lines).to_vec();
            let evidence = Evidence {
                examination: Some(&examination),
                score_tests: Some(&score_tests),
                comparison: Some(&comparison),
                refusals: identification.refusals(),
                diagnostics: [identification.priors.as_slice(), &reciprocity, &seen_by_rig]
                    .concat(),
                ..Evidence::of(answer)
            };
            evidence.judge()
        });
        (identification, judgement)
    }

    /// The answer of maximum likelihood, and its tests for small faults, as the program makes them; `None` without an
    /// answer.
    pub fn score_tests(&self) -> Option<(Estimate<f64>, ScoreTests)> {
        let (layout, lines) = (self.host_layout(), self.lines());
        let answer = solve_learned(&layout, &lines, Start::InertiaRestraint).ok()?.estimate;
        let tests = ScoreTests::of(&layout, &lines, std::slice::from_ref(&answer));
        Some((answer, tests))
    }

    /// How significant a small fault is to somebody who knows how large the errors on the bench are, as
    /// [`ScoreTest::significance`](massline_analysis::score_tests::ScoreTest::significance). `None` where the test cannot
    /// show it.
    pub fn seen_with_true_budget(&self, fault: SmallFault, bench: &Bench) -> Option<f64> {
        let mut layout = self.layout.clone();
        apply_bench_budget(&mut layout, bench);
        let layout: HostLayout = layout.cast()?;
        let lines = self.lines();
        let estimate = solve_learned(&layout, &lines, Start::InertiaRestraint).ok()?.estimate;
        let tests = ScoreTests::of(&layout, &lines, &[estimate]).tests;
        let own = tests.into_iter().find(|test| test.fault == fault)?;
        Some(own.significance())
    }

    /// The layout in the capacity of the program.
    pub fn host_layout(&self) -> HostLayout {
        self.layout.cast().expect("fits the host")
    }
}

/// `runs` tests on a bench, from ADC codes to mass lines, with the layout of this text; without those in which no hit
/// passes.
pub fn measured_tests(bench: &Bench, text: &str, runs: u64, seed: u64) -> Vec<MeasuredTest> {
    let calibration = nominal_calibration(bench);
    let file = layout_file(text);
    let layout: TestLayout = file.layout.cast().expect("fits the rig");
    let nodes: Vec<_> = file.nodes.iter().map(|node| (node.id, node.position)).collect();
    let study =
        MonteCarlo { bench, layout: &layout, calibration: &calibration, seed, runs, threads: None };
    let runs = study.runs(&|| false, |_| ()).expect("the bench takes the layout");
    let with = |test| MeasuredTest { layout: layout.clone(), nodes: nodes.clone(), test };
    runs.into_iter().flatten().map(with).collect()
}

/// What names a mistake.
pub enum Culprit {
    /// A suspect for which this is true.
    Suspect(Box<dyn Fn(&Mistake) -> bool>),
    /// Errors of the stated kinds that are larger than stated.
    LargerErrors,
    /// A finding with this code.
    Code(Code),
    /// Nothing: the mistake is on no list of the program.
    OnNoList,
}

impl Culprit {
    /// True when one of the concerns names it.
    pub fn is_named_in(&self, judgement: &Judgement) -> bool {
        judgement.concerns.iter().any(|concern| match (self, concern) {
            (Self::Suspect(is), Concern::SingleMistake { suspects, .. }) => {
                suspects.iter().any(|suspect| is(&suspect.mistake))
            }
            (Self::LargerErrors, Concern::LargerErrors(_)) => true,
            (Self::Code(code), concern) => concern.code() == *code,
            _ => false,
        })
    }
}
