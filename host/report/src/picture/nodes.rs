//! The nodes of a test that carry no sensor.

use std::collections::BTreeMap;

use crate::result_file::ResultFile;

/// Of more nodes without a sensor, none is named.
const MOST_NAMED: usize = 24;

/// A node and its position, m. It has no name where a hit names it, and where there are too many for names.
pub type NamedNode = (String, [f64; 3]);

/// The nodes of a test that carry no sensor: those of its layout file, and those that were hit.
pub fn nodes_without_sensor(source: &ResultFile) -> Vec<NamedNode> {
    let Some(layout) = source.layout() else { return Vec::new() };
    let of_file = source.layout_file().into_iter().flat_map(|file| &file.nodes);
    let of_file = of_file.map(|node| (node.id, node.position));
    let of_hits = layout.hits.iter().map(|hit| (hit.dof.node, hit.position));
    let mut nodes: BTreeMap<u16, [f64; 3]> = of_hits.chain(of_file).collect();
    layout.sensors.iter().for_each(|sensor| {
        nodes.remove(&sensor.node);
    });
    let is_named = nodes.len() <= MOST_NAMED;
    let is_hit = |node: u16| layout.hits.iter().any(|hit| hit.dof.node == node);
    let name = |node: u16| if is_named && !is_hit(node) { node.to_string() } else { String::new() };
    nodes.into_iter().map(|(node, position)| (name(node), position)).collect()
}
