//! Answers to the wheel's responses with noise, against the truth.

use massline_physics::Bench;
use massline_physics::responses::{ObjectExtras, SprungPart, add_noise, frequency_responses};
use massline_shared::FrequencyResponses;
use massline_shared::body::{RigidBody, scale};
use massline_shared::identify::global_fit::{GlobalFitSettings, GlobalFitSolution};
use massline_shared::identify::{HALF_WIDTH_95, METHODS, Method};
use massline_shared::layout::{HostLayout, TestProfile};
use massline_shared::modes::Reduction;
use nalgebra::{Complex, SVector};

use crate::Result;
use crate::solve::SUSPENSION_BAND_HZ;
use massline_analysis::bench_error::bench_error;
use massline_analysis::parallel::pieces;
use massline_analysis::suspension::{
    GlobalAnswer, HostFit, ModalAnswers, ModeChoice, Survey, SurveyedAnswer, Variant, answered,
};
use massline_client::interrupt::Interrupt;
use massline_files::uff::{Encoding, functions_of, write};
use massline_report::document::{ComparedMethod, ForceSet};

/// Names of the sets of forces.
pub(super) const SET_NAMES: [&str; 5] = ["all", "A", "B", "C", "D"];
/// The forces of each set, as places in the layout.
const SETS: [&[usize]; 5] = [&[0, 1, 2, 3, 4], &[0, 1, 3], &[1, 2, 3], &[1, 3, 4], &[0, 1, 2, 3]];
/// Band of an analyser that mass lines would be taken from, Hz, and the distance of its lines.
const WIDE_BAND: [f64; 2] = [0.5, 120.0];
const WIDE_SPACING: f64 = 0.25;
/// 9 of 17.3 kg.
const TYRE: SprungPart =
    SprungPart { share: 9.0 / 17.295, frequency_hz: 50.0, damping_ratio: 0.03 };

/// What is compared: every method of the list with all modes, and the ways of the literature to choose them.
fn variants() -> Vec<Variant> {
    let method = Method::ToivolaNuutila;
    let chosen = [ModeChoice::Five, ModeChoice::BestForce];
    (Method::of_modes().map(|method| Variant { method, choice: ModeChoice::All }))
        .chain(chosen.map(|choice| Variant { method, choice }))
        .collect()
}

/// The wheel and its exact responses.
pub(super) struct Wheel {
    layout: HostLayout,
    truth: RigidBody<f64>,
    frequencies: Vec<f64>,
    exact: Vec<Complex<f64>>,
    noise: f64,
}

/// One line of the comparison.
pub(super) struct Row {
    pub(super) name: String,
    /// Root mean square error of the ten properties, % of scale.
    pub(super) error: Option<f64>,
    /// Error over the Cramér-Rao bound.
    pub(super) ratio: Option<f64>,
    /// Share of the 95 % intervals that hold the truth.
    pub(super) coverage: Option<f64>,
    /// Runs without an answer.
    pub(super) unanswered: u64,
}

/// The comparison for a set of forces.
pub(super) struct Study {
    pub(super) set: String,
    /// Hit DOFs.
    pub(super) forces: Vec<String>,
    pub(super) runs: u64,
    pub(super) rows: Vec<Row>,
    /// Runs in which the global fit found a flexible mode above the band.
    pub(super) flexible: u64,
}

/// Errors of one run: for each row the squared error over scale, summed over the ten, and the number of intervals that
/// hold.
type Errors = Vec<Option<(f64, Option<u32>)>>;

/// What one run gives.
struct Run {
    errors: Errors,
    /// Squared Cramér-Rao bound in the same measure.
    bound: Option<f64>,
    /// The global fit found a flexible mode above the band.
    flexible: bool,
}

impl Wheel {
    /// The wheel's responses in the band of its suspension modes.
    pub(super) fn new(layout: &HostLayout, noise: f64, spacing: f64, tyre: bool) -> Result<Self> {
        Self::in_band(layout, noise, spacing, tyre, SUSPENSION_BAND_HZ)
    }

    /// The wheel's responses in the band that an analyser measures.
    pub(super) fn wide(layout: &HostLayout, noise: f64, tyre: bool) -> Result<Self> {
        Self::in_band(layout, noise, WIDE_SPACING, tyre, WIDE_BAND)
    }

    fn in_band(
        layout: &HostLayout,
        noise: f64,
        spacing: f64,
        tyre: bool,
        [low, high]: [f64; 2],
    ) -> Result<Self> {
        let bench = Bench::named("wheel").map_err(bench_error)?;
        let count = ((high - low) / spacing).round() as u32;
        let frequencies: Vec<f64> = (0..=count).map(|k| low + spacing * f64::from(k)).collect();
        let besides = ObjectExtras { part: tyre.then_some(TYRE), ..ObjectExtras::default() };
        let exact = frequency_responses(&bench, layout, &frequencies, 0.0, &besides)
            .map_err(bench_error)?;
        let mut layout = layout.clone();
        // The wheel's responses have noise and no other errors.
        layout.set_exact();
        // Nor are they those of a rig, whose converter the budget of the suspension profile contains.
        layout.test.profile = TestProfile::MassLine;
        Ok(Self { layout, truth: bench.truth(), frequencies, exact, noise })
    }

    /// The ten properties, in the order of `theta`, SI.
    pub(super) fn truth(&self) -> [f64; 10] {
        self.truth.theta().into()
    }

    /// The characteristic length of the sensors, m.
    pub(super) fn length(&self) -> f64 {
        self.layout.characteristic_length()
    }

    /// The layout with only these hits.
    fn with_forces(&self, forces: &[usize]) -> HostLayout {
        let mut layout = self.layout.clone();
        layout.hits = forces.iter().map(|force| self.layout.hits[*force]).collect();
        layout
    }

    /// The responses of all forces with the noise of the first run.
    pub(super) fn universal_file(&self, seed: u64) -> Vec<u8> {
        let mut noisy = self.exact.clone();
        add_noise(&mut noisy, self.noise, seed, 0);
        let (channels, hits) = (3 * self.layout.sensors.len(), self.layout.hits.len());
        let readings = FrequencyResponses::new(&self.frequencies, &noisy, channels, hits);
        let frfs = readings.map(|readings| functions_of(&self.layout, &readings));
        write(&frfs.unwrap_or_default(), Encoding::Binary)
    }

    /// Answers to so many draws of noise.
    pub(super) fn study(
        &self,
        set: &str,
        seed: u64,
        runs: u64,
        interrupt: &Interrupt,
        progress: impl FnMut(u64) + Send,
    ) -> Result<Study> {
        let place = SET_NAMES.iter().position(|name| *name == set).unwrap_or(0);
        let forces = SETS[place];
        let memory = || Box::new(Reduction::new());
        let one = |memory: &mut Box<Reduction<f64>>, run: u64| self.run(forces, seed, run, memory);
        let _guard = interrupt.guard();
        let completed_runs = pieces(runs, None, &|| interrupt.pressed(), progress, memory, one);
        let rows = rows(&completed_runs);
        let layout = self.with_forces(forces);
        let forces = layout.hits.iter().map(|hit| hit.dof.to_string()).collect();
        let flexible = completed_runs.iter().filter(|run| run.flexible).count() as u64;
        let runs = completed_runs.len() as u64;
        Ok(Study { set: set.into(), forces, runs, rows, flexible })
    }

    fn run(&self, forces: &[usize], seed: u64, run: u64, memory: &mut Reduction<f64>) -> Run {
        let variants = variants();
        let [of_global, combined] = [variants.len(), variants.len() + 1];
        let unanswered = || vec![None; variants.len() + 2];
        let nothing = || Run { errors: unanswered(), bound: None, flexible: false };
        let mut noisy = self.exact.clone();
        add_noise(&mut noisy, self.noise, seed, run);
        let hit_count = self.layout.hits.len();
        let picked: Vec<Complex<f64>> = noisy
            .chunks_exact(hit_count)
            .flat_map(|of_hits| forces.iter().map(|force| of_hits[*force]))
            .collect();
        let layout = self.with_forces(forces);
        let channels = 3 * layout.sensors.len();
        let readings = FrequencyResponses::new(&self.frequencies, &picked, channels, forces.len());
        let Some(readings) = readings else { return nothing() };
        let Ok(fit) = HostFit::new(&layout, &readings, memory) else { return nothing() };
        let ModalAnswers { answers, .. } = answered(&fit, &variants, false, memory);
        let start = answers.first().map(|(_, answer)| answer.body);
        let global = start.and_then(|start| {
            GlobalAnswer::of(&layout, &readings, &start, &GlobalFitSettings::default()).ok()
        });
        let mut asked: Vec<SurveyedAnswer<'_>> =
            answers.iter().map(|(variant, _)| SurveyedAnswer::Modal(*variant)).collect();
        asked.extend(global.as_ref().map(SurveyedAnswer::Global));
        let survey = Survey::of(&layout, Some(&fit), &asked, |_, _| ());
        let mut errors = unanswered();
        let mut thetas = [None; METHODS];
        for (place, (variant, answer)) in answers.iter().enumerate() {
            let length = layout.characteristic_length();
            let Ok(estimate) = survey.estimate(place, variant, answer, length) else { continue };
            if let Some(row) = variants.iter().position(|other| other == variant) {
                errors[row] = Some(self.error(&estimate.theta(), estimate.sigma()));
            }
            if variant.choice == ModeChoice::All {
                thetas[place] = Some(estimate.theta());
            }
        }
        let flexible = global.as_ref().is_some_and(|global| global.solution.extra_terms > 0);
        if let Some(GlobalAnswer { solution, .. }) = &global {
            let estimate = &solution.estimate;
            errors[of_global] = Some(self.error(&estimate.theta(), estimate.sigma()));
            thetas[answers.len()] = Some(estimate.theta());
            if flexible {
                thetas = [None; METHODS];
                errors[combined] = errors[of_global];
            }
        }
        if let Some(agreement) = survey.agreement(&thetas) {
            let sigma = agreement.covariance.diagonal().map(f64::sqrt);
            errors[combined] = Some(self.error(&agreement.theta, Some(sigma)));
        }
        let bound = global.as_ref().and_then(|global| self.bound(&global.solution));
        Run { errors, bound, flexible }
    }

    /// The squared Cramér-Rao bound over scale, summed over the ten: the covariance of the global fit under the true
    /// noise.
    fn bound(&self, solution: &GlobalFitSolution<f64>) -> Option<f64> {
        let sigma = solution.estimate.sigma()?;
        let scale = scale(self.truth.mass, self.layout.characteristic_length());
        let true_over_found = self.noise * std::f64::consts::FRAC_1_SQRT_2 / solution.noise;
        Some((sigma * true_over_found).component_div(&scale).norm_squared())
    }

    /// Squared errors over scale, summed, and the number of 95 % intervals that hold.
    fn error(
        &self,
        theta: &SVector<f64, 10>,
        sigma: Option<SVector<f64, 10>>,
    ) -> (f64, Option<u32>) {
        let error = theta - self.truth.theta();
        let scale = scale(self.truth.mass, self.layout.characteristic_length());
        let held = sigma.map(|sigma| {
            let held = (0..10).filter(|k| error[*k].abs() <= HALF_WIDTH_95 * sigma[*k]);
            held.count() as u32
        });
        (error.component_div(&scale).norm_squared(), held)
    }
}

/// The rows over all runs.
fn rows(runs: &[Run]) -> Vec<Row> {
    let bounds: Vec<f64> = runs.iter().filter_map(|run| run.bound).collect();
    let bound = bounds.iter().sum::<f64>() / bounds.len() as f64;
    let others = [Method::GlobalFit.name().into(), "combined".into()];
    let row = |(place, name): (usize, String)| {
        let answered: Vec<_> = runs.iter().filter_map(|run| run.errors[place]).collect();
        let count = answered.len() as f64;
        let mean = |sum: f64, divisor: f64| (divisor > 0.0).then(|| sum / divisor);
        let squares = answered.iter().map(|(squares, _)| squares).sum::<f64>();
        let held: Vec<u32> = answered.iter().filter_map(|(_, held)| *held).collect();
        let intervals = 10.0 * held.len() as f64;
        Row {
            name,
            error: mean(squares, 10.0 * count).map(|mean| 100.0 * mean.sqrt()),
            ratio: mean(squares, count * bound).map(f64::sqrt).filter(|ratio| ratio.is_finite()),
            coverage: mean(f64::from(held.iter().sum::<u32>()), intervals),
            unanswered: (runs.len() - answered.len()) as u64,
        }
    };
    variants().iter().map(name_of).chain(others).enumerate().map(row).collect()
}

/// The name of a row.
fn name_of(variant: &Variant) -> String {
    let name = variant.method.name();
    match variant.choice {
        ModeChoice::All => name.into(),
        ModeChoice::Five => format!("{name}, five modes"),
        ModeChoice::BestForce => format!("{name}, best force"),
    }
}

impl Study {
    pub(super) fn to_json(&self) -> ForceSet {
        let method = |row: &Row| ComparedMethod {
            name: row.name.clone(),
            error_percent: row.error,
            over_bound: row.ratio,
            coverage: row.coverage,
            unanswered: row.unanswered,
        };
        ForceSet {
            set: self.set.clone(),
            forces: self.forces.clone(),
            runs: self.runs,
            runs_with_flexible_mode: self.flexible,
            methods: self.rows.iter().map(method).collect(),
        }
    }
}
