//! `massline demo`: the paper's four tests on a simulated rig, and the wheel.

mod wheel;

use std::num::NonZeroU8;

use super::bench_test::{BenchArgs, BenchTest, nominal_calibration};
use super::compare::{Comparison, SIGMA_NOTE, summary};
use super::files::ReplaceArgs;
use super::simulated::{ReportArgs, RigArgs, results_of};
use crate::document::{Demo, FilePath};
use crate::error::Result;
use crate::host_solution::HostSolution;
use crate::identification::Selection;
use crate::layout_file::LayoutFile;
use crate::output::{Output, Tone};
use crate::rig_lines::{RigLines, StoredTest};
use crate::single_fault::NominalTest;

/// The paper's four tests: sensors 1, 2, 3 or 1, 2, 4; hits 1Y, 2Z, 4X or 1X, 2Z, 2Y.
pub const LAYOUTS: [(&str, &str); 4] = [
    ("three-bar-test-1", include_str!("../../../examples/three-bar-test-1.toml")),
    ("three-bar-test-2", include_str!("../../../examples/three-bar-test-2.toml")),
    ("three-bar-test-3", include_str!("../../../examples/three-bar-test-3.toml")),
    ("three-bar-test-4", include_str!("../../../examples/three-bar-test-4.toml")),
];

/// Arguments of `massline demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A three-bar steel frame hangs on soft cords with three simulated accelerometers. The real firmware
application is configured over its link, a simulated person taps, the rig triggers, computes, solves
and stores, and the result is read back over the same protocol that USB carries.

Examples:
  massline demo
  massline demo --report demo.html            the tests as a page with pictures
  massline demo --bench ideal --seed 7
  massline demo --rig qemu   the same with the Cortex-M4F firmware in QEMU
  massline demo --json | jq '.tests[0].results[0].mass_kg'
  massline demo wheel                         an object without a mass line")]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    other: Option<Other>,
    #[command(flatten)]
    bench: BenchArgs,
    #[command(flatten)]
    rig: RigArgs,
    /// Hits per DOF; default: the number in the layouts.
    #[arg(long, value_name = "N")]
    hits: Option<NonZeroU8>,
    #[command(flatten)]
    report: ReportArgs,
    #[command(flatten)]
    replace: ReplaceArgs,
}

/// Other demonstrations.
#[derive(Debug, clap::Subcommand)]
enum Other {
    /// The methods that use the suspension modes, on a wheel that has no mass line.
    Wheel(wheel::Args),
}

/// Runs the command.
///
/// # Errors
/// When the bench is bad, or the rig does not start, gets stuck or has no answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    if let Some(Other::Wheel(args)) = &args.other {
        return wheel::run(args, output);
    }
    let existing = args.replace.existing();
    args.report.check(existing)?;
    let bench = args.bench.open()?;
    let firmware = args.rig.image()?;
    let (mut comparisons, mut tests, mut archives) = (Vec::new(), Vec::new(), Vec::new());
    for (name, text) in LAYOUTS {
        let file = layout_file(name, text, args.hits)?;
        let layout = &file.layout;
        let heading = output.toned(&format!("{name}: {}", layout.title), Tone::Strong);
        output.note(&heading);
        let test = BenchTest {
            label: name,
            layout,
            bench: &bench,
            seed: args.bench.seed,
            rig: args.rig.rig,
            firmware: firmware.as_deref(),
        };
        let result = if args.report.is_wanted() {
            let archive =
                test.archived(&file, &nominal_calibration(&bench).into(), output, |of| of)?;
            let result = archive.result.clone();
            archives.push((name.to_owned(), archive));
            result
        } else {
            test.run(output, |source| source)?.result
        };
        let (lines, nominal) = (RigLines::default(), NominalTest::of_file(&file));
        let stored = StoredTest { result: &result, lines: &lines };
        let again = HostSolution::new(stored, &nominal, Selection::All).without_details();
        let comparison = Comparison {
            name: name.into(),
            seed: args.bench.seed,
            truth: test.truth(),
            length: layout.characteristic_length(),
            answer: again.best(),
            result: result.clone(),
        };
        if output.json() {
            tests.push(comparison.to_json(|document| again.add_to(document))?);
        } else {
            let verdict = again.verdict();
            let verdict = verdict.map(|(verdict, line)| output.verdict_line(verdict, &line) + "\n");
            let (verdict, missing) = (verdict.unwrap_or_default(), again.missing_text());
            output.text(format!("{heading}\n{verdict}{}{missing}", comparison.table()?))?;
        }
        comparisons.push(comparison);
    }
    let report = args.report.write(|| results_of(archives), existing);
    let written = report.as_ref().ok().and_then(|path| path.as_ref()).map(FilePath::from);
    let summary = summary(&comparisons)?;
    output.answer(&Demo { tests, report: written }, |output| {
        let heading = output.toned("summary", Tone::Strong);
        format!(
            "{heading}\n{summary}\nscale: m, L, L, L, m L² × 6, L = rms distance of the sensors from their \
             centroid\n{SIGMA_NOTE}"
        )
    })?;
    // The answer does not need the report.
    args.report.offer(report?, output);
    Ok(())
}

fn layout_file(name: &str, text: &str, hits: Option<NonZeroU8>) -> Result<LayoutFile> {
    let mut file = LayoutFile::parse(text, name)?;
    if let Some(hits) = hits {
        file.layout.test.hits_per_dof = hits.get();
    }
    Ok(file)
}
