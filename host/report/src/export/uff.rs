//! Universal file: units, local axes, nodes, and the frequency responses of the test.

use massline_shared::layout::HostLayout;

use super::heading::{PROGRAM, ascii};
use super::number::shortest;
use super::subject::ExportedResult;
use super::test_data::{Node, Responses, TestData};
use massline_files::uff::{
    BODY_AXES, Encoding, Frf, ModelNode, write_described, write_nodes, write_units,
};
use massline_result::Verdict;
use massline_result::{Error, Result};

/// Largest difference of two unit vectors that are the same: the rounding of a rig's numbers.
const SAME_DIRECTION: f64 = 1e-6;

/// The file of a result.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    universal_file(&exported.test, Some(exported.verdict))
}

/// Datasets 164 (units), 2420 (local axes, if there are any but the body's), 15 (nodes) and 58 (responses along the
/// local axes of their nodes, with the verdict on the answer). A test without an answer may have them, too.
///
/// # Errors
/// Exit 2 without responses, and when they cannot be along the axes of the nodes.
pub fn universal_file(test: &TestData, verdict: Option<Verdict>) -> Result<Vec<u8>> {
    let measured = test.responses.as_ref().filter(|responses| !responses.frfs.is_empty());
    let Some(responses) = measured else {
        return Err(Error::input(
            "no_responses",
            format!(
                "{} does not hold frequency responses, of which a universal file is made: archives that \
                 `massline measure --output` writes do",
                test.source
            ),
        ));
    };
    let nodes = nodes(test);
    let frfs = along_nodes(responses, &nodes)?;
    let title = ascii(&test.title);
    let window = match responses.decay_per_s {
        0.0 => "no exponential window".into(),
        decay => {
            format!("exponential window on force and response: decay {} 1/s", shortest(decay))
        }
    };
    let mut bytes = write_units();
    bytes.extend(write_nodes(&title, &nodes));
    let about = format!("{PROGRAM}: {title}");
    // Of what the responses lead to; the responses themselves are as they were measured.
    let window = match verdict {
        Some(verdict) => format!("{window}; answer: {}", verdict.words()),
        None => window,
    };
    bytes.extend(write_described(&frfs, Encoding::Ascii, [&about, &window]));
    Ok(bytes)
}

/// The nodes, with the axes of the body where those of a node are not known.
fn nodes(test: &TestData) -> Vec<ModelNode> {
    let node = |node: &Node| {
        let axes = node.axes.unwrap_or(BODY_AXES);
        ModelNode { id: node.id, position: node.position, axes }
    };
    test.nodes.iter().map(node).collect()
}

/// The responses along the local axes of their nodes: a sensor may be glued along other axes.
///
/// # Errors
/// Exit 2 when a node is not known, or a hit pushes in another direction than its DOF says.
fn along_nodes(responses: &Responses, nodes: &[ModelNode]) -> Result<Vec<Frf>> {
    let layout = &responses.layout;
    hits_are_along_nodes(layout, nodes)?;
    let mut frfs = responses.frfs.clone();
    for (triple, sensor) in frfs.chunks_exact_mut(3).zip(layout.sensors.iter().cycle()) {
        let axes = axes_of(sensor.node, nodes)?;
        if axes.iter().zip(&sensor.axes).all(|(axis, of_sensor)| are_same(axis, of_sensor)) {
            continue;
        }
        let turn = axes.map(|axis| sensor.axes.map(|of_sensor| dot(&axis, &of_sensor)));
        let measured = [0, 1, 2].map(|k| triple[k].accelerance.clone());
        for (frf, row) in triple.iter_mut().zip(turn) {
            for (bin, value) in frf.accelerance.iter_mut().enumerate() {
                *value = row
                    .iter()
                    .zip(&measured)
                    .map(|(part, accelerance)| accelerance[bin] * *part)
                    .sum();
            }
        }
    }
    Ok(frfs)
}

fn hits_are_along_nodes(layout: &HostLayout, nodes: &[ModelNode]) -> Result<()> {
    for hit in &layout.hits {
        let axis = axes_of(hit.dof.node, nodes)?[hit.dof.axis.index()];
        if !are_same(&axis.map(|x| x * hit.dof.sign.factor()), &hit.direction) {
            let [x, y, z] = hit.direction.map(shortest);
            return Err(Error::input(
                "hit_not_along_node",
                format!(
                    "the hit {} pushes along [{x} {y} {z}], which is no local axis of node {} as far as this file \
                     can say; give the layout with --layout, or give the hit a node of its own with these axes",
                    hit.dof, hit.dof.node
                ),
            ));
        }
    }
    Ok(())
}

fn axes_of(number: u16, nodes: &[ModelNode]) -> Result<[[f64; 3]; 3]> {
    let node = nodes.iter().find(|node| node.id == number).map(|node| node.axes);
    node.ok_or_else(|| {
        let message = format!(
            "there are responses at node {number}, which the layout does not have; give that of the test with --layout"
        );
        Error::input("unknown_node", message)
    })
}

fn are_same(a: &[f64; 3], b: &[f64; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < SAME_DIRECTION)
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::super::tests::exported;
    use super::*;

    #[test]
    fn a_sensor_along_its_own_axes_is_turned_into_those_of_its_node() {
        let test = exported().test;
        let responses = test.responses.as_ref().unwrap();
        let turned = along_nodes(responses, &nodes(&test)).unwrap();
        assert_eq!(turned[..3], responses.frfs[..3]);
        // Its x is the y of the node, its y is −x.
        let accelerance = |k: usize| &responses.frfs[3 + k].accelerance;
        let minus: Vec<_> = accelerance(1).iter().map(|value| -value).collect();
        assert_eq!(turned[3].accelerance, minus);
        assert_eq!(
            (&turned[4].accelerance, &turned[5].accelerance),
            (accelerance(0), accelerance(2))
        );
        assert_eq!(turned[4].response, responses.frfs[4].response);
    }

    #[test]
    fn a_hit_along_other_axes_than_those_of_its_node_is_refused() {
        let mut test = exported().test;
        test.nodes[3].axes = None;
        let error = universal_file(&test, None).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("hit_not_along_node", 2));
        assert!(error.to_string().contains("the hit 4:-X pushes along [-0.6 -0.8 0.0]"), "{error}");
        test.nodes.truncate(3);
        assert_eq!(universal_file(&test, None).unwrap_err().code(), "unknown_node");
    }
}
