//! Tests on the simulated bench, beside the truth.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use massline_result::FilePath;
use massline_result::{Refusal, TestResult};

/// A simulated test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Simulation {
    /// What was simulated, in a line.
    pub simulated: String,
    /// The test.
    #[serde(flatten)]
    pub test: ComparedTest,
    /// The tape that was written.
    pub tape: Option<FilePath>,
    /// The report that was written.
    pub report: Option<FilePath>,
}

/// The tests of `massline demo`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Demo {
    /// The tests.
    pub tests: Vec<ComparedTest>,
    /// The report that was written.
    pub report: Option<FilePath>,
}

/// A test whose truth is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComparedTest {
    /// Its result.
    #[serde(flatten)]
    pub result: TestResult,
    /// Name of the test.
    pub name: String,
    /// Errors of the answer, in % of m, L, L, L and m L² (six times).
    pub error_percent_of_scale: [f64; 10],
}

/// Many simulated tests of a layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SimulatedRuns {
    /// Number of runs that were done.
    pub runs: u64,
    /// Number of runs that were asked for.
    pub runs_wanted: u64,
    /// Number of runs without mass lines.
    pub runs_without_mass_lines: u64,
    /// Hits of all runs that were rejected and repeated.
    pub rejected_hits: u64,
    /// Runs with a warning, an error or a rejected hit.
    pub runs_with_warnings: u64,
    /// Other runs in which the best method is wrong by more than three standard deviations.
    pub runs_silently_wrong: u64,
    /// How the runs came to the target of the layout, where it has one.
    pub target: Option<RunsToTarget>,
    /// The methods.
    pub methods: Vec<MethodOverRuns>,
    /// The methods without an answer in any run, and why.
    pub not_applicable: Vec<Refusal>,
    /// Notes on the numbers.
    pub notes: Vec<String>,
    /// Seed of the bench.
    pub seed: u64,
    /// Title of the bench.
    pub bench: String,
    /// The error budget that the methods assume: `layout` or `bench`.
    pub budget: String,
    /// What says how large the errors of the bench are: `layout` or `bench`.
    pub errors: String,
    /// Whether the hammer was taken as calibrated.
    pub calibrated_hammer: bool,
}

/// How runs came to the target of their layout.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RunsToTarget {
    /// Runs that reached it.
    pub runs_at_target: u64,
    /// Hits of a whole campaign.
    pub hits_of_a_campaign: u64,
    /// Hits that a run saved on average.
    pub mean_hits_saved: f64,
    /// Share of the 95 % intervals that hold the truth, each run at its end.
    pub coverage95: Option<f64>,
    /// The same of the runs that reached the target.
    pub coverage95_at_target: Option<f64>,
}

/// A method over many runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MethodOverRuns {
    /// Its name.
    pub method: String,
    /// Runs with an answer.
    pub answers: usize,
    /// Runs without an answer.
    pub unanswered: usize,
    /// The codes of the reasons, each with the number of these runs in which it is the first.
    pub reasons: BTreeMap<String, usize>,
    /// Geometric mean of `ratio` over the ten properties.
    pub geometric_mean_ratio: Option<f64>,
    /// The largest `ratio`.
    pub worst_ratio: Option<f64>,
    /// Geometric mean of `width_ratio` over the ten properties.
    pub geometric_mean_width: Option<f64>,
    /// Share of the 95 % intervals of all properties that hold the truth.
    pub pooled_coverage95: Option<f64>,
    /// The ten properties; empty without an answer.
    pub properties: Vec<PropertyOverRuns>,
}

/// A property over many runs, in its SI unit. What a single run or one without uncertainty does not have is `null`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PropertyOverRuns {
    /// Its name.
    pub name: String,
    /// The true value.
    pub truth: f64,
    /// Mean error.
    pub bias: f64,
    /// Root mean square error.
    pub rms: Option<f64>,
    /// Cramér-Rao bound of the standard deviation.
    pub bound: Option<f64>,
    /// Root mean square error over the bound.
    pub ratio: Option<f64>,
    /// Share of the 95 % intervals that hold the truth.
    pub coverage95: Option<f64>,
    /// Mean half width of the 95 % intervals.
    pub half_width95: Option<f64>,
    /// The same over what the bound permits.
    pub width_ratio: Option<f64>,
}

/// The methods of suspension modes on the wheel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DemoWheel {
    /// Standard deviation of the noise of a reading, of a complex number.
    pub noise_m_per_s2_per_n: f64,
    /// Distance of the lines.
    pub spacing_hz: f64,
    /// Whether the wheel has a tyre, a part on a spring.
    pub tyre: bool,
    /// Seed of the noise.
    pub seed: u64,
    /// The answer of the first run to all forces.
    pub answer: ComparedTest,
    /// The sets of forces.
    pub sets: Vec<ForceSet>,
    /// What the methods of mass lines say, as text.
    pub mass_lines: String,
    /// The report that was written.
    pub report: Option<FilePath>,
}

/// A set of forces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForceSet {
    /// Its name.
    pub set: String,
    /// The DOFs that are hit.
    pub forces: Vec<String>,
    /// Number of runs.
    pub runs: u64,
    /// Runs in which the global fit finds a flexible mode above the band.
    pub runs_with_flexible_mode: u64,
    /// The methods.
    pub methods: Vec<ComparedMethod>,
}

/// A method against the truth; `null` where no run has an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComparedMethod {
    /// Its name, with the choice of modes.
    pub name: String,
    /// Root mean square error of the ten properties, in % of m, L, L, L and m L² (six times).
    pub error_percent: Option<f64>,
    /// The same over the Cramér-Rao bound.
    pub over_bound: Option<f64>,
    /// Share of the 95 % intervals that hold the truth.
    pub coverage: Option<f64>,
    /// Runs without an answer.
    pub unanswered: u64,
}

/// The wheel's responses as files.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DemoWheelFiles {
    /// The universal file.
    pub universal_file: FilePath,
    /// The layout.
    pub layout: FilePath,
}
