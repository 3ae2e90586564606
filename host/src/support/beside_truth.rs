//! A test on a simulated rig, shown beside the truth of its bench.

use std::path::PathBuf;

use massline_physics::source::ScanSource;
use massline_result::{FilePath, TestResult};
use massline_shared::calibration::CalibrationRecord;

use super::bench_test::BenchTest;
use super::compare::Comparison;
use super::show::{self, NextStep};
use super::simulated::{ReportArgs, SimulatedMeasurement, results_of};
use crate::Result;
use crate::output::Output;
use crate::rig_lines::RigLines;
use crate::rig_solution::solve_test;
use massline_analysis::identification::Selection;
use massline_analysis::single_fault::NominalTest;
use massline_files::archive::Archive;
use massline_files::file::ExistingFile;
use massline_files::layout_file::LayoutFile;
use massline_report::document::Simulation;
use massline_report::words::{Extent, result_text};

/// A test on a simulated rig that is shown beside the truth.
#[derive(Clone, Copy, Debug)]
pub struct ShownTest<'a> {
    /// The test; its label is the name of the result.
    pub test: BenchTest<'a>,
    /// What its layout was read from.
    pub file: &'a LayoutFile,
    /// Whether there is a report.
    pub report: &'a ReportArgs,
    /// What becomes of a report that is there already.
    pub existing: ExistingFile,
    /// What is simulated, in a line.
    pub description: &'a str,
}

/// What a test has measured, with its archive if the report needs it.
type ArchivedMeasurement = (SimulatedMeasurement, Option<Archive>);

impl ShownTest<'_> {
    /// Measures; `wrap` may insert something between bench and rig.
    ///
    /// # Errors
    /// As [`BenchTest::run`].
    pub fn measure(
        &self,
        calibration: &CalibrationRecord,
        output: &mut Output,
        wrap: impl FnOnce(Box<dyn ScanSource>) -> Box<dyn ScanSource>,
    ) -> Result<ArchivedMeasurement> {
        if !self.report.is_wanted() {
            return Ok((self.test.run_with(calibration, output, wrap)?, None));
        }
        let archive = self.test.archived(self.file, calibration, output, wrap)?;
        let measured = SimulatedMeasurement {
            result: archive.result.clone(),
            lines: RigLines::of_archive(&archive),
        };
        Ok((measured, Some(archive)))
    }

    /// Prints the result beside the truth, and writes the report; `tape` is the tape that was written.
    ///
    /// # Errors
    /// When there is no answer, or the report or stdout cannot be written.
    pub fn print(
        &self,
        (measured, archive): ArchivedMeasurement,
        tape: Option<PathBuf>,
        extent: Extent,
        output: &mut Output,
    ) -> Result<()> {
        let nominal = NominalTest::of_file(self.file);
        let solution = solve_test(measured.test(), &nominal, Selection::All);
        let result = solution.result();
        if solution.no_answer.is_some() {
            return show::print(&solution, &result, (extent, &NextStep::Details), output);
        }
        let name = self.test.label.to_owned();
        let length = self.file.layout.characteristic_length();
        // The errors of a bench are known, and need no estimates.
        let result = TestResult { details: None, ..result };
        let comparison = Comparison::new(&name, self.test.seed, self.test.truth(), length, result);
        let report =
            self.report.write(|| results_of(archive.map(|archive| (name, archive))), self.existing);
        let value = Simulation {
            simulated: self.description.to_owned(),
            test: comparison.document()?,
            report: report.as_ref().ok().and_then(|path| path.as_ref()).map(FilePath::from),
            tape: tape.map(FilePath::from),
        };
        let (symbol, worst) = comparison.worst()?;
        output.conclude(comparison.result.verdict);
        output.answer(&value, |_| {
            let methods = match extent {
                Extent::Details => comparison.of_methods(),
                Extent::Brief => String::new(),
            };
            format!(
                "{}{}\nworst: {worst:+.3} % of scale at {symbol}\n{methods}",
                result_text(&comparison.result, extent),
                self.description,
            )
            .trim_end()
            .to_owned()
        })?;
        // The answer does not need the report.
        self.report.offer(report?, output);
        Ok(())
    }
}
