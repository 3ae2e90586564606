//! What a universal file holds in the place of a frequency response that it lacks.

use std::collections::BTreeSet;

use super::pair::{Pair, key_of};
use crate::Error;
use massline_files::uff::{Function, NodeDirection, UffFile};

/// Most DOFs that a message lists.
const LISTED: usize = 12;

/// The error of a frequency response that the file lacks, with what it has in its place.
pub(super) fn error(uff: &UffFile, pair: &Pair) -> Error {
    let [response, reference] = pair.key();
    let (name, axis, hit) = (pair.name(), pair.axis.index() + 1, pair.hit);
    let wanted = format!(
        "response node {}, direction ±{axis}, reference node {}, direction ±{}",
        pair.node,
        hit.node,
        hit.axis.index() + 1
    );
    let frfs = || uff.functions.iter().filter(|f| f.is_frequency_response());
    let what_to_do = if let Some(swapped) = frfs().find(|f| key_of(f) == [reference, response]) {
        format!(
            "the file has it with response and reference swapped, in dataset {} (response {}, reference {}): \
             export it with the sensor as the response and the hammer as the reference",
            swapped.dataset,
            dof(swapped.response),
            dof(swapped.reference)
        )
    } else if let Some(scalar) = frfs().find(|f| is_scalar(f, pair)) {
        format!(
            "the file has responses at {} due to {}, such as dataset {}: direction 0 is that of a scalar without an \
             axis; export it with directions 1, 2 and 3 for x, y and z (here: {wanted})",
            dof(scalar.response),
            dof(scalar.reference),
            scalar.dataset
        )
    } else if let Some(empty) = uff.empty.iter().find(|f| key_of(f) == pair.key()) {
        format!("dataset {} is that function and holds no values; export it again", empty.dataset)
    } else {
        format!(
            "{}; export it ({wanted}), or take the sensor or the hit out of the layout",
            what_is_held(frfs())
        )
    };
    Error::input(
        "frf_missing",
        format!("the file has no frequency response of {name}: {what_to_do}"),
    )
}

/// True for a function at the nodes of a pair without a direction of response or reference.
fn is_scalar(function: &Function, pair: &Pair) -> bool {
    let [response, reference] = pair.key();
    let [at, due_to] = key_of(function);
    let fits = |actual: (i64, u64), wanted: (i64, u64)| {
        actual.0 == wanted.0 && (actual.1 == 0 || actual.1 == wanted.1)
    };
    fits(at, response) && fits(due_to, reference) && (at.1 == 0 || due_to.1 == 0)
}

/// The DOFs of the frequency responses of a file.
fn what_is_held<'a>(frfs: impl Iterator<Item = &'a Function> + Clone) -> String {
    let list = |places: &mut dyn Iterator<Item = NodeDirection>| {
        let unique: BTreeSet<(i64, i64)> = places.map(|at| (at.node, at.direction)).collect();
        let names = unique.iter().take(LISTED);
        let names: Vec<_> =
            names.map(|&(node, direction)| dof(NodeDirection { node, direction })).collect();
        let more = if unique.len() > LISTED {
            format!(" and {} others", unique.len() - LISTED)
        } else {
            String::new()
        };
        format!("{}{more}", names.join(", "))
    };
    if frfs.clone().next().is_none() {
        return "the file holds no frequency response at all (function type 4 of dataset 58)"
            .into();
    }
    format!(
        "the file has responses at {} due to forces at {} (node:direction)",
        list(&mut frfs.clone().map(|f| f.response)),
        list(&mut frfs.clone().map(|f| f.reference))
    )
}

/// A DOF in the numbering of the file.
fn dof(place: NodeDirection) -> String {
    format!("{}:{}", place.node, place.direction)
}
