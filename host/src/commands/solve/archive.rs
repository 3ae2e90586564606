//! Solves the mass lines of an archive again.

use std::path::Path;

use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;

use crate::archive::Archive;
use crate::commands::{files, show};
use crate::error::{Error, Result};
use crate::identification::Selection;
use crate::output::Output;
use crate::rig_lines::{RigLines, StoredTest};
use crate::single_fault::NominalTest;

/// Prints the answer that the archive holds and what this program finds from its mass lines, with the archive's layout or
/// the one of a file.
///
/// # Errors
/// When a file is bad, the layout is that of another test, or the data cannot determine the answer.
pub(super) fn solve(
    path: &Path,
    layout: Option<&Path>,
    selection: Selection,
    output: &mut Output,
) -> Result<()> {
    let archive = Archive::read(path)?;
    let nominal = match layout {
        None => archive.layout.nominal(),
        Some(layout) => {
            let file = files::layout(layout, output)?;
            if !is_same_test(&file.layout, &archive.layout.resolved) {
                let message = format!(
                    "{}: its sensors or hits are not those of the test in {}; only positions, axes and settings may differ",
                    layout.display(),
                    path.display()
                );
                return Err(Error::input("another_layout", message));
            }
            let measured = &archive.layout.resolved.test;
            if (file.layout.test.band_hz, file.layout.test.terms)
                != (measured.band_hz, measured.terms)
            {
                output.warn(format!(
                    "{}: band_hz and terms of [test] have no effect: the mass lines of an archive stay as they were measured",
                    layout.display()
                ));
            }
            NominalTest::of_file(&file)
        }
    };
    if let Selection::Only(method) = selection
        && !Method::of_mass_lines().any(|of| of == method)
    {
        let message = format!(
            "{}: {} needs the lines of frequency responses about the suspension modes, and an archive has mass lines; \
             choose another --method",
            path.display(),
            method.name()
        );
        return Err(Error::input("usage", message));
    }
    let lines = RigLines::of_archive(&archive);
    let test = StoredTest { result: &archive.result, lines: &lines };
    show::solved_again(test, &nominal, selection, output)
}

/// True when the sensors are on the same nodes and the hits at the same DOFs, in the same order.
fn is_same_test(one: &HostLayout, other: &HostLayout) -> bool {
    let nodes = |of: &HostLayout| of.sensors.iter().map(|s| s.node).collect::<Vec<_>>();
    let dofs = |of: &HostLayout| of.hits.iter().map(|hit| hit.dof).collect::<Vec<_>>();
    nodes(one) == nodes(other) && dofs(one) == dofs(other)
}
