//! A test on a simulated rig, shown beside the truth of its bench.

use std::path::PathBuf;

use massline_shared::calibration::CalibrationRecord;
use massline_shared::layout::TestProfile;
use massline_virtual::source::ScanSource;

use super::bench_test::BenchTest;
use super::compare::{Comparison, SIGMA_NOTE};
use super::simulated::{ReportArgs, Simulated, results_of};
use crate::archive::Archive;
use crate::document::{FilePath, Simulation};
use crate::error::Result;
use crate::file::Existing;
use crate::host_solution::HostSolution;
use crate::identification::Selection;
use crate::layout_file::LayoutFile;
use crate::output::{Output, Tone};
use crate::report::{message_of_result, sentences};
use crate::rig_lines::RigLines;
use crate::single_fault::NominalTest;

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
    pub existing: Existing,
    /// What is simulated, in a line.
    pub description: &'a str,
}

/// What a test has measured, with its archive if the report needs it.
type Measured = (Simulated, Option<Archive>);

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
    ) -> Result<Measured> {
        if !self.report.is_wanted() {
            return Ok((self.test.run_with(calibration, output, wrap)?, None));
        }
        let archive = self.test.archived(self.file, calibration, output, wrap)?;
        let measured =
            Simulated { result: archive.result.clone(), lines: RigLines::of_archive(&archive) };
        Ok((measured, Some(archive)))
    }

    /// Prints the result beside the truth, and writes the report; `tape` is the tape that was written.
    ///
    /// # Errors
    /// When there is no answer, or the report or stdout cannot be written.
    pub fn print(
        &self,
        (measured, archive): Measured,
        tape: Option<PathBuf>,
        output: &mut Output,
    ) -> Result<()> {
        let nominal = NominalTest::of_file(self.file);
        let again = HostSolution::new(measured.test(), &nominal, Selection::All).without_details();
        let answer = again.best();
        if let Some(error) = again.error().filter(|_| answer.is_none()) {
            return Err(error);
        }
        let name = self.test.label.to_owned();
        let comparison = Comparison {
            name: name.clone(),
            seed: self.test.seed,
            truth: self.test.truth(),
            length: self.file.layout.characteristic_length(),
            result: measured.result.clone(),
            answer,
        };
        let report = self.report.write(|| results_of(archive.map(|of| (name, of))), self.existing);
        let value = Simulation {
            simulated: self.description.to_owned(),
            test: comparison.to_json(|measurement| again.add_to(measurement))?,
            report: report.as_ref().ok().and_then(|path| path.as_ref()).map(FilePath::from),
            tape: tape.map(FilePath::from),
        };
        let (symbol, worst) = comparison.worst()?;
        let table = comparison.table()?;
        let remark = match measured.test().profile() {
            TestProfile::MassLine => format!("{SIGMA_NOTE}\n"),
            TestProfile::Suspension => comparison.of_methods(&again.answers()),
        };
        let verdict = again.verdict();
        output.conclude(verdict.as_ref().map(|(verdict, _)| *verdict));
        output.answer(&value, |output| {
            let heading = output.toned(&self.file.title, Tone::Strong);
            let first = verdict.map(|(verdict, line)| output.verdict_line(verdict, &line) + "\n");
            let result = &comparison.result;
            let findings =
                sentences(&again.findings_of_rig(), |d| message_of_result(d, result));
            format!(
                "{}{heading}\n{}\n{}{table}{}{findings}worst: {worst:+.3} % of scale at {symbol}\n{remark}\n{}",
                first.unwrap_or_default(),
                self.description,
                again.which_to_use(),
                again.hammer_text(),
                again.to_text().trim_end()
            )
        })?;
        // The answer does not need the report.
        self.report.offer(report?, output);
        Ok(())
    }
}
