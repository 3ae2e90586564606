//! `massline demo`: the paper's four tests on a simulated rig, and the wheel.

mod wheel;

use std::num::NonZeroU8;

use massline_result::{FilePath, TestResult};

use crate::Result;
use crate::output::{Output, Tone};
use crate::rig_lines::{RigLines, StoredTest};
use crate::rig_solution::solve_test;
use crate::support::bench_test::{BenchArgs, BenchTest, nominal_calibration};
use crate::support::compare::{Comparison, side_by_side};
use crate::support::files::ReplaceArgs;
use crate::support::show::{self, DetailsArgs, NextStep};
use crate::support::simulated::{ReportArgs, RigArgs, results_of};
use massline_analysis::identification::Selection;
use massline_analysis::single_fault::NominalTest;
use massline_files::layout_file::LayoutFile;
use massline_report::document::Demo;
use massline_report::words::{Extent, INERTIA_CONVENTION, heading_text, limits_text, result_text};

/// The paper's four tests: sensors 1, 2, 3 or 1, 2, 4; hits 1Y, 2Z, 4X or 1X, 2Z, 2Y.
pub const LAYOUTS: [(&str, &str); 4] = [
    ("three-bar-test-1", include_str!("../../examples/three-bar-test-1.toml")),
    ("three-bar-test-2", include_str!("../../examples/three-bar-test-2.toml")),
    ("three-bar-test-3", include_str!("../../examples/three-bar-test-3.toml")),
    ("three-bar-test-4", include_str!("../../examples/three-bar-test-4.toml")),
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
    other: Option<OtherDemo>,
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
    #[command(flatten)]
    details: DetailsArgs,
}

/// Other demonstrations.
#[derive(Debug, clap::Subcommand)]
enum OtherDemo {
    /// The methods that use the suspension modes, on a wheel that has no mass line.
    Wheel(wheel::Args),
}

/// Runs the command.
///
/// # Errors
/// When the bench is bad, or the rig does not start, gets stuck or has no answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    if let Some(OtherDemo::Wheel(args)) = &args.other {
        return wheel::run(args, output);
    }
    let existing = args.replace.existing();
    args.report.check(existing)?;
    let bench = args.bench.open()?;
    let firmware = args.rig.image()?;
    let (mut comparisons, mut archives) = (Vec::new(), Vec::new());
    let extent = args.details.extent();
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
                test.archived(&file, &nominal_calibration(&bench).into(), output, |source| source)?;
            let result = archive.result.clone();
            archives.push((name.to_owned(), archive));
            result
        } else {
            test.run(output, |source| source)?.result
        };
        let (lines, nominal) = (RigLines::default(), NominalTest::of_file(&file));
        let stored = StoredTest { result: &result, lines: &lines };
        let solution = solve_test(stored, &nominal, Selection::All);
        let result = TestResult { details: None, ..solution.result() };
        if solution.no_answer.is_some() {
            return show::print(&solution, &result, (extent, &NextStep::Details), output);
        }
        let length = layout.characteristic_length();
        let seed = args.bench.seed;
        comparisons.push(Comparison::new(name, seed, test.truth(), length, result));
    }
    let report = args.report.write(|| results_of(archives), existing);
    let written = report.as_ref().ok().and_then(|path| path.as_ref()).map(FilePath::from);
    let table = side_by_side(&comparisons)?;
    let tests = comparisons.iter().map(Comparison::document).collect::<Result<_>>()?;
    let verdicts = comparisons.iter().filter_map(|comparison| comparison.result.verdict);
    output.conclude(verdicts.max());
    output.answer(&Demo { tests, report: written }, |output| {
        let mut text = String::new();
        for (number, comparison) in (1..).zip(&comparisons) {
            let name = output.toned(&format!("test {number}"), Tone::Strong);
            text += &match extent {
                Extent::Brief => {
                    let result = &comparison.result;
                    format!("{name}: {}{}", heading_text(result), limits_text(result))
                }
                Extent::Details => format!("{name}: {}", result_text(&comparison.result, extent)),
            };
        }
        format!(
            "{text}{table}\n± 95 %; {INERTIA_CONVENTION}; J_1, J_2, J_3: principal moments\n%: of m, L and m L²; L = \
             rms distance of the sensors of a test from their centroid\n{}",
            NextStep::Details.text(extent)
        )
        .trim_end()
        .to_owned()
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
