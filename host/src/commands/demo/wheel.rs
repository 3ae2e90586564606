//! `massline demo wheel`: the methods that use the suspension modes, on the frequency responses of a simulated wheel,
//! or on those that a simulated rig measures.

mod on_rig;
mod study;

use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use massline_result::FilePath;
use massline_shared::identify::Method;
use massline_shared::layout::TestSettings;

use crate::output::{Output, Tone, align_right, counted, table};
use crate::rig::RigKind;
use crate::solve::{Options, responses_of, solve};
use crate::support::compare::Comparison;
use crate::support::files::ReplaceArgs;
use crate::support::number::seed;
use crate::support::show::DetailsArgs;
use crate::support::simulated::ReportArgs;
use crate::{Error, Result};
use massline_analysis::identification::Selection;
use massline_files::file::{self, ExistingFile};
use massline_files::layout_file::LayoutFile;
use massline_files::uff::UffFile;
use massline_report::document::{DemoWheel, DemoWheelFiles};
use massline_report::result_file::ResultFile;
use massline_report::solution::Solution;
use massline_report::words::{Extent, message_in, result_text};
use study::{Row, SET_NAMES, Study, Wheel};

/// Arguments of `massline demo wheel`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A wheel of 17.3 kg hangs on mounts with modes at 2.8 to 7.7 Hz, so that no mass line begins below
23 Hz. Its responses from 0.5 to 12.5 Hz are computed, noise is added, and every method answers
that uses the suspension modes, with all forces and with some of them. Errors are in % of scale.
With --rig a simulated rig measures the wheel instead, from the taps of a mallet on: 5 DOFs of
5 hits, 40 s of ringing after each; the answer is compared with the truth.

Examples:
  massline demo wheel
  massline demo wheel --rig virtual          a whole measurement, some 10 s
  massline demo wheel --rig qemu             on the Cortex-M4F, some minutes
  massline demo wheel --tyre                 9 kg of it on springs of 50 Hz
  massline demo wheel --set all --runs 200   errors over the bound, coverage
  massline demo wheel --write wheel.uff      the responses, for `massline solve`
  massline demo wheel --tyre --write tyre.uff
  massline demo wheel --report wheel.html    all forces, as a page with pictures")]
pub struct Args {
    /// The tyre: 9 of the 17.3 kg sit on springs of 50 Hz.
    #[arg(long)]
    tyre: bool,
    /// Set of forces; may be repeated [default: each of them]
    #[arg(long, value_name = "SET", value_parser = SET_NAMES)]
    set: Vec<String>,
    /// Repeat with other noise.
    #[arg(long, value_name = "N", default_value = "1")]
    runs: NonZeroU32,
    /// Standard deviation of the noise of a line, (m/s²)/N, from 1e-9 to 1.
    #[arg(long, value_name = "SIGMA", default_value_t = 0.002)]
    noise: f64,
    /// Distance of the lines, Hz, from 0.1 to 0.4.
    #[arg(long, value_name = "HZ", default_value_t = 0.125)]
    spacing: f64,
    /// Seed of the noise, or of all random numbers on the rig's bench.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = seed)]
    seed: u64,
    /// Write the responses to all forces to this universal file, and the layout beside it, instead of solving them.
    #[arg(long, value_name = "FILE.uff", conflicts_with_all = ["set", "runs", "report"])]
    write: Option<PathBuf>,
    /// Measure the wheel with this simulated rig.
    #[arg(long, value_enum, value_name = "RIG",
          conflicts_with_all = ["set", "runs", "noise", "spacing", "write"])]
    rig: Option<RigKind>,
    /// Firmware image for `--rig qemu`; default: built from this checkout.
    #[arg(long, value_name = "ELF", requires = "rig")]
    firmware: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    replace: ReplaceArgs,
    #[command(flatten)]
    details: DetailsArgs,
}

/// Fewest runs whose coverage says something.
const FEWEST_RUNS: u64 = 20;

/// The layout of the demonstration.
const LAYOUT: &str = include_str!("../../../examples/wheel.toml");

/// Runs the command.
///
/// # Errors
/// When an option is out of range, on Ctrl-C, or when the rig does not start, gets stuck or has no answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    if let Some(rig) = args.rig {
        return on_rig::run(args, rig, output);
    }
    let out_of_range = |text: &str| Err(Error::input("number_out_of_range", text));
    if !(1e-9..=1.0).contains(&args.noise) {
        return out_of_range("--noise must lie between 1e-9 and 1 (m/s²)/N");
    }
    if !(0.1..=0.4).contains(&args.spacing) {
        return out_of_range("--spacing must lie between 0.1 and 0.4 Hz");
    }
    let existing = args.replace.existing();
    args.report.check(existing)?;
    let layout = LayoutFile::parse(LAYOUT, "wheel.toml")?.layout;
    let wheel = Wheel::new(&layout, args.noise, args.spacing, args.tyre)?;
    if let Some(path) = &args.write {
        return write_files(&wheel, args.seed, path, existing, output);
    }
    let all_sets = || SET_NAMES.map(str::to_owned).to_vec();
    let sets = if args.set.is_empty() { all_sets() } else { args.set.clone() };
    let runs = u64::from(args.runs.get());
    let mut studies = Vec::new();
    for set in &sets {
        let bar = output.bar(runs, &format!("forces of set {set}"));
        let interrupt = output.interrupt().clone();
        let study = wheel.study(set, args.seed, runs, &interrupt, |done| bar.set_position(done))?;
        bar.finish_and_clear();
        studies.push(study);
    }
    let mass_lines = mass_lines(args)?;
    let (file, uff) = first_run(&wheel, args)?;
    let solution = solve(&file, &uff, &Options::default(), |_, _| ())?;
    let answer =
        Comparison::new("all forces", args.seed, wheel.truth(), wheel.length(), solution.result());
    let page = || {
        let name = file.title.clone();
        let mut source = ResultFile::of_result(answer.result.clone(), Some(&file), name)?;
        source.add_responses(|layout| responses_of(layout, &uff, None))?;
        Ok(vec![source])
    };
    let report = args.report.write(page, existing);
    let written = report.as_ref().ok().and_then(|path| path.as_ref()).map(FilePath::from);
    let value = DemoWheel {
        noise_m_per_s2_per_n: args.noise,
        spacing_hz: args.spacing,
        tyre: args.tyre,
        seed: args.seed,
        answer: answer.document()?,
        sets: studies.iter().map(Study::to_json).collect(),
        mass_lines: mass_lines.clone(),
        report: written,
    };
    output.conclude(answer.result.verdict);
    output.answer(&value, |output| {
        let extent = args.details.extent();
        let mut text = result_text(&answer.result, extent) + &methods_text(&studies);
        if extent == Extent::Details {
            text += &details_text(&studies, output);
            text += &format!("mass lines of responses up to 120 Hz: {mass_lines}\n");
        }
        text
    })?;
    // The answer does not need the report.
    args.report.offer(report?, output);
    Ok(())
}

/// The layout, and the responses of the first run to all forces, as `--write` writes them.
fn first_run(wheel: &Wheel, args: &Args) -> Result<(LayoutFile, UffFile)> {
    let mut file = LayoutFile::parse(LAYOUT, "wheel.toml")?;
    let name = if args.tyre { "simulated wheel with a tyre" } else { "simulated wheel" };
    file.title = name.into();
    Ok((file, UffFile::parse(&wheel.universal_file(args.seed))?))
}

/// A band between the suspension modes and the modes of the tyre, Hz, where there is no mass line.
const BELOW_TYRE: [f64; 2] = [24.0, 45.0];

/// What the methods of mass lines say to the responses of an analyser. With a tyre, their band is clear of all modes.
fn mass_lines(args: &Args) -> Result<String> {
    let mut file = LayoutFile::parse(LAYOUT, "wheel.toml")?;
    let band = if args.tyre { BELOW_TYRE } else { TestSettings::<f64>::default_band() };
    file.layout.test = TestSettings { band_hz: Some(band), ..TestSettings::default() };
    let wide = Wheel::wide(&file.layout, args.noise, args.tyre)?;
    let uff = UffFile::parse(&wide.universal_file(args.seed))?;
    let selection = Selection::Only(Method::InertiaRestraint);
    let options = Options { selection, ..Options::default() };
    Ok(match solve(&file, &uff, &options, |_, _| ()) {
        Ok(answer) => warnings_of(&answer, &file),
        Err(error) => error.to_string(),
    })
}

/// The mass of an answer and the first of its warnings.
fn warnings_of(answer: &Solution, file: &LayoutFile) -> String {
    let mass = answer.answer().map_or(f64::NAN, |estimate| estimate.body.mass);
    let [low, high] = BELOW_TYRE;
    let mut text = format!(
        "from {low:.0} to {high:.0} Hz, beside the modes of the tyre, they give a mass of {mass:.1} kg and not that of \
         the wheel"
    );
    let messages = answer.diagnostics.iter().map(|d| message_in(d, &file.layout));
    if let Some(first) = messages.clone().next() {
        text += &format!(", with {} warnings: {first}", messages.count());
    }
    text
}

/// Writes responses and layout.
fn write_files(
    wheel: &Wheel,
    seed: u64,
    path: &Path,
    existing: ExistingFile,
    output: &mut Output,
) -> Result<()> {
    let layout = path.with_extension("toml");
    if layout == path {
        let text =
            format!("{} is the name of the layout; give one that ends in .uff", path.display());
        return Err(Error::input("cannot_write", text));
    }
    let files = [(path, wheel.universal_file(seed)), (&layout, LAYOUT.into())];
    for (file, _) in &files {
        file::check(file, existing)?;
    }
    for (file, bytes) in files {
        file::write(file, &bytes, existing)?;
    }
    let value = DemoWheelFiles { universal_file: path.into(), layout: (&layout).into() };
    output
        .answer(&value, |_| format!("try: massline solve {} {}", layout.display(), path.display()))
}

/// The error of each method under each set of forces, in one table.
fn methods_text(studies: &[Study]) -> String {
    let Some(first) = studies.first() else { return String::new() };
    let mut table = table();
    let sets = studies.iter().map(|study| match study.set.as_str() {
        "all" => "all forces".to_owned(),
        set => format!("set {set}"),
    });
    table.set_header(std::iter::once("rms error, %".to_owned()).chain(sets));
    align_right(&mut table, 1..=studies.len());
    for (k, row) in first.rows.iter().enumerate() {
        let cells = studies.iter().map(|study| {
            let error = study.rows.get(k).and_then(|row| row.error);
            error.map_or("-".into(), |error| format!("{error:.4}"))
        });
        table.add_row(std::iter::once(row.name.clone()).chain(cells));
    }
    let flexible = studies.iter().any(|study| study.flexible > 0);
    let warning = if flexible {
        "a flexible mode above the band shows: only the global fit allows for it\n"
    } else {
        ""
    };
    let of_sets = match studies.iter().any(|study| study.set != "all") {
        true => {
            "sets A to D: three or four of the five forces, as Almeida, Maia and Urgueira combined them\n"
        }
        false => "",
    };
    format!("{table}\n{of_sets}{warning}")
}

/// What one set of forces after the other says.
fn details_text(studies: &[Study], output: &Output) -> String {
    let mut text = String::new();
    for study in studies {
        let runs = counted(study.runs, "run");
        let heading = format!("set {}: {}; {runs}", study.set, study.forces.join(", "));
        text += &format!("\n{}\n{}", output.toned(&heading, Tone::Strong), table_of(study));
        if study.flexible > 0 {
            text +=
                &format!("a flexible mode above the band shows in {} of {runs}\n", study.flexible);
        }
    }
    text + "\nerror: root mean square of the ten properties, relative to m, L, L, L and m L² (six times); over the \
            bound: of Cramér and Rao; coverage: part of the 95 % intervals that contain the truth\n"
}

fn table_of(study: &Study) -> String {
    let mut table = table();
    table.set_header(["method", "error, %", "over bound", "coverage", "unanswered"]);
    align_right(&mut table, 1..5);
    for row in &study.rows {
        let Row { name, error, ratio, coverage, unanswered } = row;
        let figure = |value: &Option<f64>, digits: usize, unit: &str| {
            value.map_or("-".into(), |v| format!("{v:.digits$}{unit}"))
        };
        table.add_row([
            name.clone(),
            figure(error, 4, ""),
            figure(ratio, 2, ""),
            figure(&coverage.filter(|_| study.runs >= FEWEST_RUNS).map(|c| 100.0 * c), 1, " %"),
            unanswered.to_string(),
        ]);
    }
    format!("{table}\n")
}
