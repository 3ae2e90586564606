//! The wheel, measured by a simulated rig in the suspension profile.

use massline_physics::Bench;

use super::{Args, LAYOUT};
use crate::Result;
use crate::commands::simulate::object::describe;
use crate::output::Output;
use crate::rig::RigKind;
use crate::support::bench_test::{BenchTest, nominal_calibration};
use crate::support::beside_truth::ShownTest;
use massline_analysis::bench_error::bench_error;
use massline_files::layout_file::LayoutFile;

/// Measures the wheel, and prints the result beside the truth.
pub(super) fn run(args: &Args, rig: RigKind, output: &mut Output) -> Result<()> {
    let existing = args.replace.existing();
    args.report.check(existing)?;
    let file = LayoutFile::parse(LAYOUT, "wheel.toml")?;
    let name = if args.tyre { "wheel-with-tyre" } else { "wheel" };
    let bench = Bench::named(name).map_err(bench_error)?;
    let firmware = rig.firmware(args.firmware.as_deref())?;
    let test = BenchTest {
        label: "wheel",
        layout: &file.layout,
        bench: &bench,
        seed: args.seed,
        rig,
        firmware: firmware.as_deref(),
    };
    let description = &describe(&bench, &format!(", bench {name}"));
    let shown = ShownTest { test, file: &file, report: &args.report, existing, description };
    let measured = shown.measure(&nominal_calibration(&bench).into(), output, |source| source)?;
    shown.print(measured, None, args.details.extent(), output)
}
