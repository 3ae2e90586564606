//! Results that a rig has measured: from the rig itself, or from an archive. They are solved again here.

use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;
use serde_json::{Value, json};

use super::document::of_value;
use super::subject::Exported;
use super::test_data::{Node, Responses, TestData};
use crate::archive::{Archive, ArchivedNode};
use crate::document::Measurement;
use crate::error::Result;
use crate::host_solution::HostSolution;
use crate::identification::Selection;
use crate::judgement::state_verdict_of_rig;
use crate::output::SCHEMA_VERSION;
use crate::report;
use crate::rig_lines::{RigLines, StoredTest};
use crate::single_fault::NominalTest;

/// A result of a rig, solved again where its layout is known; `source` is its name in errors and in the file.
///
/// # Errors
/// Exit 2 when there is no answer by `method`, exit 3 without any answer.
pub fn of_measurement(
    test: StoredTest<'_>,
    layout: Option<&HostLayout>,
    source: &str,
    method: Option<Method>,
) -> Result<Exported> {
    of_value(&document_of(test, layout), source, method)
}

/// The document of a result, solved again where its layout is known.
fn document_of(test: StoredTest<'_>, layout: Option<&HostLayout>) -> Value {
    let mut document = report::measurement_json(test.result);
    state_verdict_of_rig(&mut document, test.result);
    if let Some(layout) = layout {
        let nominal = NominalTest::of_layout(layout.clone());
        HostSolution::new(test, &nominal, Selection::All).add_to(&mut document);
    }
    with_version(&document)
}

/// The document of an archive's result, solved again and searched for a single mistake, with what the test cannot see.
pub fn document_of_archive(archive: &Archive) -> Value {
    let mut document = report::measurement_json(&archive.result);
    let lines = RigLines::of_archive(archive);
    let test = StoredTest { result: &archive.result, lines: &lines };
    let again = HostSolution::new(test, &archive.layout.nominal(), Selection::All);
    again.add_to(&mut document);
    document.cannot_see = Some(again.cannot_see());
    with_version(&document)
}

fn with_version(document: &Measurement) -> Value {
    let mut value = json!(document);
    value["schema_version"] = json!(SCHEMA_VERSION);
    value
}

/// The result of an archive, with nodes and frequency responses.
///
/// # Errors
/// As [`of_measurement`], and as [`test_of_archive`].
pub fn of_archive(archive: &Archive, source: &str, method: Option<Method>) -> Result<Exported> {
    let exported = of_value(&document_of_archive(archive), source, method)?;
    let test = test_of_archive(archive, source)?;
    Ok(exported.with_test(|of_document| TestData { notes: of_document.notes, ..test }))
}

/// What an archive holds besides answers: there is also one of a test without an answer.
///
/// # Errors
/// Exit 2 when no rig can use the calibration in the archive.
pub fn test_of_archive(archive: &Archive, source: &str) -> Result<TestData> {
    let layout = &archive.layout;
    let node = |&ArchivedNode { id, position_m, axes }: &ArchivedNode| Node {
        id,
        position: position_m,
        axes,
    };
    let responses = match archive.decay_per_s() {
        Some(decay_per_s) => {
            Some(Responses { frfs: archive.frfs()?, layout: layout.resolved.clone(), decay_per_s })
        }
        None => None,
    };
    let test = TestData {
        nodes: layout.nodes.iter().map(node).collect(),
        responses,
        layout_hash: Some(archive.result.head.layout_hash),
        ..TestData::of_source(source)
    };
    Ok(test.titled(&layout.title))
}
