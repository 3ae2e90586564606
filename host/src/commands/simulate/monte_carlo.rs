//! `massline simulate --runs`: statistics of a layout over many simulated tests.

use std::num::{NonZeroU64, NonZeroUsize};
use std::path::Path;

use clap::ValueEnum;
use massline_physics::{Bench, ErrorsFrom};
use massline_shared::layout::{CALIBRATED_HAMMER_GAIN, HostLayout};

use crate::output::{Output, Tone};
use crate::support::bench_test::{nominal_calibration, source_on};
use crate::{Error, Result};
use massline_analysis::monte_carlo::measurement::TestLayout;
use massline_analysis::monte_carlo::{MonteCarlo, Study, apply_bench_budget};
use massline_files::layout_file::LayoutFile;
use massline_report::words::monte_carlo::{self as report, StudySettings};

/// Options of a study.
#[derive(Clone, Debug, clap::Args)]
pub struct MonteCarloArgs {
    /// Repeat the test N times, without a rig, and compare with the Cramér-Rao bound.
    #[arg(long, value_name = "N", value_parser = runs, conflicts_with_all = ["rig", "firmware", "report"])]
    pub runs: Option<NonZeroU64>,
    /// Error budget that the methods assume; the bound is always that of the errors of the bench.
    #[arg(long, value_enum, default_value_t, value_name = "BUDGET", requires = "runs")]
    budget: Budget,
    /// Take the hammer as calibrated with a block of known mass: its gain is uncertain by 0.3 %, unless the layout
    /// states it.
    #[arg(long, requires = "runs", conflicts_with = "budget")]
    calibrated_hammer: bool,
    /// Number of threads; default: all cores.
    #[arg(long, value_name = "N", requires = "runs", value_parser = threads)]
    threads: Option<NonZeroUsize>,
}

/// An error budget as an argument.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Budget {
    /// The table `uncertainty` of the layout, which the data may correct, as in a real test.
    #[default]
    Layout,
    /// The standard deviations with which the bench draws its errors, used as they are.
    Bench,
}

impl Budget {
    fn name(self) -> &'static str {
        match self {
            Self::Layout => "layout",
            Self::Bench => "bench",
        }
    }
}

/// Most threads: more than any computer has cores.
const MOST_THREADS: usize = 1024;

/// Parses a number of threads.
fn threads(text: &str) -> std::result::Result<NonZeroUsize, String> {
    let number = text.parse().ok().filter(|number| *number <= MOST_THREADS);
    number
        .and_then(NonZeroUsize::new)
        .ok_or_else(|| format!("give a number from 1 to {MOST_THREADS}"))
}

/// Parses a number of runs.
fn runs(text: &str) -> std::result::Result<NonZeroU64, String> {
    let number = text.parse::<u64>().ok().and_then(NonZeroU64::new);
    number.ok_or_else(|| {
        "give a whole number of runs, at least 1; use 100 or more for reliable statistics".into()
    })
}

/// What is simulated again and again.
#[derive(Clone, Debug)]
pub struct StudyObject<'a> {
    /// The object and the measuring chain.
    pub bench: &'a Bench,
    /// Seed of all random numbers.
    pub seed: u64,
    /// What is simulated, in a line.
    pub description: String,
}

/// Runs after which a study in which none has an answer is not continued.
const FUTILE_RUNS: u64 = 5;

/// Runs the study.
///
/// # Errors
/// When the layout does not fit the rig or the bench, no method has an answer, or on Ctrl-C; the results so
/// far are printed in any case.
pub fn run(
    path: &Path,
    file: &LayoutFile,
    object: StudyObject<'_>,
    args: &MonteCarloArgs,
    runs: NonZeroU64,
    output: &mut Output,
) -> Result<()> {
    let StudyObject { bench, seed, description } = object;
    let mut layout: TestLayout = file.layout.cast().ok_or_else(|| {
        let text = "the layout has more sensors or hits than a rig takes";
        Error::input("layout_too_large", text).within(path.display())
    })?;
    if args.calibrated_hammer && layout.calibrated_hammer {
        // Stated, so that no calibration supplies it.
        (layout.apparatus.hammer_gain, layout.calibrated_hammer) = (CALIBRATED_HAMMER_GAIN, false);
    }
    if args.budget == Budget::Bench {
        apply_bench_budget(&mut layout, bench);
    }
    let calibration = nominal_calibration(bench);
    source_on(bench, &file.layout, seed)?;
    let monte_carlo = MonteCarlo {
        bench,
        layout: &layout,
        calibration: &calibration,
        seed,
        runs: runs.get(),
        threads: args.threads,
    };
    let bar = output.bar(runs.get(), "runs");
    let interrupt = output.interrupt();
    let guard = interrupt.guard();
    let is_interrupted = || interrupt.pressed();
    let mut study = monte_carlo.first_runs(FUTILE_RUNS, &is_interrupted)?;
    if !study.is_futile() {
        study = monte_carlo.run(&is_interrupted, |done| bar.set_position(done))?;
    }
    drop(guard);
    bar.finish_and_clear();
    let settings = StudySettings {
        seed,
        bench: &bench.title,
        budget: args.budget.name(),
        errors: match bench.errors {
            ErrorsFrom::Bench => "bench",
            ErrorsFrom::Layout => "layout",
        },
        calibrated_hammer: args.calibrated_hammer,
    };
    let value = report::to_json(&study, settings);
    let Some(error) = shortcoming(&study, &file.layout) else {
        return output.answer(&value, |output| to_text(&study, file, &description, output));
    };
    // The results so far are printed too; with `--json` in the object of the error.
    if output.json() {
        output.explain(&value);
    } else {
        let text = to_text(&study, file, &description, output);
        output.text(text)?;
    }
    Err(error.within(path.display()))
}

fn to_text(study: &Study, file: &LayoutFile, description: &str, output: &Output) -> String {
    let heading = output.toned(&file.title, Tone::Strong);
    format!("{heading}\n{description}\n{}", report::to_text(study, &file.layout))
}

/// The error for a study that is incomplete or has no answer.
fn shortcoming(study: &Study, layout: &HostLayout) -> Option<Error> {
    if study.runs < study.wanted && !study.is_futile() {
        let done = format!("interrupted after {} of {} runs", study.runs, study.wanted);
        return Some(Error::interrupted(done));
    }
    let unanswered = study.methods.iter().all(|method| method.answers == 0);
    unanswered.then(|| {
        let stopped = match study.runs < study.wanted {
            true => {
                format!("the first {} runs all failed, and the others were left out: ", study.runs)
            }
            false => String::new(),
        };
        let reason = study.unmeasured.as_ref().map_or_else(
            || "no method has an answer in any run; see massline layout check".to_owned(),
            |(_, first)| report::measure_error_text(first, layout),
        );
        Error::undetermined("no_answer", stopped + &reason)
    })
}
