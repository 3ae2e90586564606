//! Universal file: units, local axes, nodes, and the frequency responses of the test.

use super::subject::{Exported, Node};
use crate::error::{Error, Result};
use crate::uff::{BODY_AXES, Encoding, ModelNode, write_nodes, write_units};

/// Datasets 164 (units), 2420 (local axes, if there are any but the body's), 15 (nodes) and 58 (responses).
pub(super) fn write(exported: &Exported) -> Result<Vec<u8>> {
    let lacking = match (exported.frfs.is_empty(), exported.nodes.is_empty()) {
        (true, _) => "frequency responses",
        (_, true) => "the positions of its nodes",
        _ => {
            let mut bytes = write_units();
            bytes.extend(write_nodes(&exported.title, &nodes(exported)));
            bytes.extend(crate::uff::write(&exported.frfs, Encoding::Ascii));
            return Ok(bytes);
        }
    };
    Err(Error::input(
        "no_responses",
        format!(
            "{} does not hold {lacking}, of which a universal file is made; the universal file that \
             `massline solve` read has the responses, a JSON document never does",
            exported.source
        ),
    ))
}

/// The nodes, with the axes of the body where those of a node are not known.
fn nodes(exported: &Exported) -> Vec<ModelNode> {
    let node = |node: &Node| {
        let axes = node.axes.unwrap_or(BODY_AXES);
        ModelNode { id: node.id, position: node.position, axes }
    };
    exported.nodes.iter().map(node).collect()
}
