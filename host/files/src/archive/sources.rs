//! An archive states its points three times: as `layout.nodes`, in `layout.resolved`, and as the text `layout.toml`.
//! They must agree, because an export reads one and a solution another.

use massline_shared::layout::HostLayout;

use super::{ArchivedLayout, ArchivedNode};
use crate::layout_file::LayoutFile;

/// By how much two statements of a coordinate or direction may differ: a rig rounds to single precision. Relative to
/// the larger of the number and one.
const ROUNDING: f64 = 1e-6;

/// The first two statements that contradict each other, in words.
pub(super) fn check(layout: &ArchivedLayout) -> Result<(), String> {
    let ArchivedLayout { nodes, resolved, toml, .. } = layout;
    points(resolved).try_for_each(|(place, node, position)| {
        let stated = nodes.iter().find(|other| other.id == node);
        let stated = stated.ok_or_else(|| {
            format!("{place} is at node {node}, which layout.nodes does not have")
        })?;
        agree(&place, &position, &format!("layout.nodes (node {node})"), &stated.position_m)
    })?;
    let Some(text) = toml else { return Ok(()) };
    let file = LayoutFile::parse(text, "layout.toml").map_err(|error| error.to_string())?;
    agree_with_file(&file, nodes, resolved)
}

/// Every point of the layout that is solved: its place in the archive, its node and its position.
fn points(layout: &HostLayout) -> impl Iterator<Item = (String, u16, [f64; 3])> {
    let sensors = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position)).enumerate();
    let hits = layout.hits.iter().map(|hit| (hit.dof.node, hit.position)).enumerate();
    let place = |list: &str, index: usize| format!("layout.resolved.{list}[{index}].position");
    let sensors =
        sensors.map(move |(index, (node, position))| (place("sensors", index), node, position));
    sensors.chain(hits.map(move |(index, (node, position))| (place("hits", index), node, position)))
}

fn agree_with_file(
    file: &LayoutFile,
    nodes: &[ArchivedNode],
    resolved: &HostLayout,
) -> Result<(), String> {
    for node in &file.nodes {
        let Some(stated) = nodes.iter().find(|other| other.id == node.id) else {
            return Err(format!("layout.toml has node {}, and layout.nodes does not", node.id));
        };
        let place = format!("layout.nodes (node {})", node.id);
        agree(&place, &stated.position_m, "layout.toml", &node.position)?;
    }
    for (index, (one, other)) in resolved.sensors.iter().zip(&file.layout.sensors).enumerate() {
        let place = format!("layout.resolved.sensors[{index}].axes");
        one.axes
            .iter()
            .zip(&other.axes)
            .try_for_each(|(a, b)| agree(&place, a, "layout.toml", b))?;
    }
    for (index, (one, other)) in resolved.hits.iter().zip(&file.layout.hits).enumerate() {
        let place = format!("layout.resolved.hits[{index}].direction");
        agree(&place, &one.direction, "layout.toml", &other.direction)?;
    }
    Ok(())
}

fn agree(place: &str, one: &[f64; 3], other_place: &str, other: &[f64; 3]) -> Result<(), String> {
    let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * a.abs().max(b.abs()).max(1.0);
    if one.iter().zip(other).all(is_same) {
        return Ok(());
    }
    Err(format!("{place} is {one:?}, and {other_place} says {other:?}"))
}
