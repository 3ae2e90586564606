//! Solves the mass lines of an archive again, or its lines about the suspension modes.

use std::path::Path;

use massline_shared::identify::{Method, Observable};
use massline_shared::layout::{HostLayout, TestProfile};

use crate::output::Output;
use crate::rig_lines::{RigLines, StoredTest};
use crate::rig_solution::solve_test;
use crate::support::files;
use crate::support::show::{self, NextStep};
use crate::{Error, Result};
use massline_analysis::identification::Selection;
use massline_analysis::single_fault::NominalTest;
use massline_files::archive::Archive;
use massline_report::words::Extent;

/// Prints what this program finds from the mass lines of an archive, or from its lines about the suspension modes, with
/// the archive's layout or the one of a file.
///
/// # Errors
/// When a file is bad, the layout is that of another test, or the data cannot determine the answer.
pub(super) fn solve(
    path: &Path,
    layout: Option<&Path>,
    selection: Selection,
    extent: Extent,
    output: &mut Output,
) -> Result<()> {
    let archive = Archive::read(path)?;
    let nominal = match layout {
        None => NominalTest::of_archive(&archive.layout),
        Some(layout) => with_layout(layout, path, &archive, output)?,
    };
    if let Selection::Only(method) = selection {
        suits(method, path, archive.result.profile())?;
    }
    let lines = RigLines::of_archive(&archive);
    let test = StoredTest { result: &archive.result, lines: &lines };
    let solution = solve_test(test, &nominal, selection);
    // A page shows the answer by all methods with the archive's own layout.
    let next = match (layout, selection) {
        (None, Selection::All) => NextStep::Page(path),
        _ => NextStep::Details,
    };
    output.conclude(solution.verdict());
    show::print(&solution, &solution.result(), (extent, &next), output)
}

/// The test with the layout of a file; settings with which the archive was measured stay.
///
/// # Errors
/// When the file is bad, or its sensors or hits are those of another test.
pub(in super::super) fn with_layout(
    layout: &Path,
    path: &Path,
    archive: &Archive,
    output: &mut Output,
) -> Result<NominalTest> {
    let file = files::layout(layout, output)?;
    if !is_same_test(&file.layout, &archive.layout.resolved) {
        let message = format!(
            "{}: its sensors or hits are not those of the test in {}; only positions, axes and settings may differ",
            layout.display(),
            path.display()
        );
        return Err(Error::input("another_layout", message));
    }
    let (stated, measured) = (&file.layout.test, &archive.layout.resolved.test);
    let mut nominal = NominalTest::of_file(&file);
    let without_effect = match archive.result.profile() {
        TestProfile::MassLine => {
            let differ = (stated.band_hz, stated.terms) != (measured.band_hz, measured.terms);
            differ.then_some("band_hz and terms of [test] have no effect: the mass lines")
        }
        TestProfile::Suspension => {
            let test = &mut nominal.layout.test;
            (test.profile, test.exponential_decay) = (measured.profile, measured.exponential_decay);
            if stated.profile != measured.profile {
                test.band_hz = measured.band_hz;
            }
            let differ = (stated.profile, stated.exponential_decay)
                != (measured.profile, measured.exponential_decay);
            let text =
                "profile and exponential_decay_per_s of [test] have no effect: the responses";
            differ.then_some(text)
        }
    };
    if let Some(sentence) = without_effect {
        let layout = layout.display();
        output.warn(format!("{layout}: {sentence} of an archive stay as they were measured"));
    }
    Ok(nominal)
}

/// Checks that a method uses what an archive of this profile holds.
fn suits(method: Method, path: &Path, profile: TestProfile) -> Result<()> {
    let (responses, mass_lines) = ("frequency responses about the suspension modes", "mass lines");
    let uses_mass_lines = method.entry().observes == Observable::MassLines;
    let (needs, has) = match (profile, uses_mass_lines) {
        (TestProfile::MassLine, false) => (responses, mass_lines),
        (TestProfile::Suspension, true) => (mass_lines, responses),
        _ => return Ok(()),
    };
    let (path, method) = (path.display(), method.name());
    let message = format!(
        "{path}: {method} needs {needs}, and this archive has {has}; choose another --method"
    );
    Err(Error::input("usage", message))
}

/// True when the sensors are on the same nodes and the hits at the same DOFs, in the same order.
fn is_same_test(one: &HostLayout, other: &HostLayout) -> bool {
    let nodes = |layout: &HostLayout| layout.sensors.iter().map(|s| s.node).collect::<Vec<_>>();
    let dofs = |layout: &HostLayout| layout.hits.iter().map(|hit| hit.dof).collect::<Vec<_>>();
    nodes(one) == nodes(other) && dofs(one) == dofs(other)
}
