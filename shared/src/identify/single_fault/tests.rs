use std::vec;
use std::vec::Vec;

use super::*;
use crate::capacity::Rig;
use crate::identify::maximum_likelihood::workspace;
use crate::layout::tests::{bar_body, bar_layout};
use crate::layout::{Dof, Hit};

type Five = Layout<f64, Rig>;
type Lines = MassLines<f64, Rig>;

const END: [f64; 3] = [0.207_850_606_8, -0.199_018_578_2, 0.149_130_815_1];

/// The frame with five hit DOFs.
fn five_hits() -> Five {
    let mut layout: Five = bar_layout().cast().unwrap();
    for (name, position, direction) in
        [("4:+Y", END, [0.0, 1.0, 0.0]), ("1:-Z", [0.0; 3], [0.0, 0.0, -1.0])]
    {
        let dof: Dof = name.parse().unwrap();
        layout.hits.push(Hit::new(dof, position, direction)).unwrap();
    }
    layout
}

fn nodes() -> Vec<(u16, [f64; 3])> {
    vec![(1, [0.0; 3]), (2, [END[0], END[1], 0.0]), (3, [END[0], 0.0, 0.0]), (4, END)]
}

/// Readings of the frame under a layout, with noise of half a percent of a typical accelerance.
fn readings(layout: &Five) -> Vec<(usize, Lines)> {
    let body = bar_body();
    (0..layout.hits.len())
        .map(|hit| {
            let accelerance = layout.accelerance(&body, hit).unwrap();
            let mut lines = Lines::without_scatter(accelerance);
            lines.noise = crate::responses::Responses::repeat(3, 0.005);
            lines.hits = 5;
            (hit, lines)
        })
        .collect()
}

fn chi_squared(fault: &SingleFault<f64>, layout: &Five, dofs: &[(usize, Lines)]) -> f64 {
    let mut room = vec![0.0; workspace(3, 12)];
    let result = fault.test(layout, dofs, &mut room);
    result.map_or(f64::INFINITY, |result| result.chi_squared)
}

#[test]
fn mistakes_with_axes_are_four_mirrors_three_swaps_and_23_turns() {
    let maps: Vec<AxisMap> = AxisMap::mistakes().collect();
    assert_eq!(maps.len(), 30);
    assert_eq!(maps.iter().filter(|map| map.is_turn()).count(), 23);
    for (i, a) in maps.iter().enumerate() {
        assert!(maps[i + 1..].iter().all(|b| a != b));
        let axes = a.of(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f64]]);
        let determinant = nalgebra::Matrix3::from(axes).determinant();
        assert_eq!(determinant, if a.is_turn() { 1.0 } else { -1.0 });
    }
}

#[test]
fn every_single_mistake_is_listed_once() {
    let layout = five_hits();
    let nodes = nodes();
    // Three sensors, their three pairs, each of five hits at three other nodes or reversed, and six pairs of nodes.
    assert_eq!(SingleFault::all(&layout, &nodes).count(), 3 * 30 + 3 + 5 * 4 + 6);
}

#[test]
fn a_mistake_is_explained_by_itself() {
    let (nominal, nodes) = (five_hits(), nodes());
    // Every tenth mistake, so that all kinds are included.
    for fault in SingleFault::all(&nominal, &nodes).step_by(10) {
        let dofs = readings(&fault.applied(&nominal).unwrap());
        // The readings are exact, so only rounding remains.
        let explained = chi_squared(&fault, &nominal, &dofs);
        assert!(explained < 1e-6, "{fault:?}: {explained}");
    }
}

#[test]
fn what_shows_nothing_has_the_chi_squared_of_chance() {
    let nominal = five_hits();
    let dofs = readings(&nominal);
    let mut room = vec![0.0; workspace(3, 12)];
    let mut shows = |fault: SingleFault<f64>| fault.shows(&nominal, &bar_body(), &dofs, &mut room);
    // A node on the line of action, so force and torque are the same.
    let along = SingleFault::HitAtNode { hit: 1, node: 9, position: END };
    let consistency = shows(along).unwrap();
    // The readings are exact, so only rounding is added to the degrees of freedom.
    assert_eq!(consistency.degrees_of_freedom, 35);
    assert!((consistency.chi_squared - 35.0).abs() < 1e-6, "{consistency:?}");
    let beside = SingleFault::HitAtNode { hit: 1, node: 3, position: [END[0], 0.0, 0.0] };
    assert!(shows(beside).is_none_or(|c| c.equivalent_z() > 10.0));
}
