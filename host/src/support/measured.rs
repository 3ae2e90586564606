//! Results that a rig has measured: from the rig itself, or from an archive. They are solved again here.

use massline_result::TestResult;
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;

use crate::Result;
use crate::rig_lines::{RigLines, StoredTest};
use crate::rig_solution::solve_test;
use massline_analysis::identification::Selection;
use massline_analysis::single_fault::NominalTest;
use massline_files::archive::{Archive, ArchivedNode};
use massline_report::export::{ExportedResult, Node, Responses, TestData, of_result};
use massline_report::solution::Solution;
use massline_report::words::result_of_rig;

/// A result of a rig, solved again where its layout is known; `source` is its name in errors and in the file.
///
/// # Errors
/// Exit 2 when there is no answer by `method`, exit 3 without any answer.
pub fn of_measurement(
    test: StoredTest<'_>,
    layout: Option<&HostLayout>,
    source: &str,
    method: Option<Method>,
) -> Result<ExportedResult> {
    let result = match layout {
        Some(layout) => {
            let nominal = NominalTest::of_layout(layout.clone());
            answered(solve_test(test, &nominal, Selection::All), source)?
        }
        None => result_of_rig(test.result),
    };
    of_result(&result, source, method)
}

/// The result of an archive, solved again.
pub fn result_of_archive(archive: &Archive) -> TestResult {
    solution_of_archive(archive).result()
}

fn solution_of_archive(archive: &Archive) -> Solution {
    let lines = RigLines::of_archive(archive);
    let test = StoredTest { result: &archive.result, lines: &lines };
    solve_test(test, &NominalTest::of_archive(&archive.layout), Selection::All)
}

/// The result of a solution that has an answer.
fn answered(solution: Solution, source: &str) -> Result<TestResult> {
    match &solution.no_answer {
        Some(error) => Err(error.clone().within(source)),
        None => Ok(solution.result()),
    }
}

/// The result of an archive, with nodes and frequency responses.
///
/// # Errors
/// As [`of_measurement`].
pub fn of_archive(
    archive: &Archive,
    source: &str,
    method: Option<Method>,
) -> Result<ExportedResult> {
    let result = answered(solution_of_archive(archive), source)?;
    let exported = of_result(&result, source, method)?;
    let test = test_of_archive(archive, source);
    Ok(exported.with_test(|of_document| TestData { notes: of_document.notes, ..test }))
}

/// What an archive holds besides answers: there is also one of a test without an answer.
pub fn test_of_archive(archive: &Archive, source: &str) -> TestData {
    let layout = &archive.layout;
    let node = |&ArchivedNode { id, position_m, axes }: &ArchivedNode| Node {
        id,
        position: position_m,
        axes,
    };
    let responses = archive.decay_per_s().map(|decay_per_s| Responses {
        frfs: archive.frfs(),
        layout: layout.resolved.clone(),
        decay_per_s,
    });
    let test = TestData {
        nodes: layout.nodes.iter().map(node).collect(),
        responses,
        layout_hash: Some(archive.result.head.layout_hash),
        ..TestData::of_source(source)
    };
    test.titled(&layout.title)
}
