//! What acts on the object although nobody declares it: boards and cables.

use nalgebra::{Matrix6, Vector3};

use super::physics::{accelerance_to, mass_lines, motion_of, no_errors, tapped_with};
use super::{layout, test_one};
use crate::bench::Bench;
use crate::loads::loaded_modes;
use crate::settings::Fault;
use crate::suspension::{RigidMode, Suspension};
use crate::taps::Tip;

fn ideal(fault: &str) -> Bench {
    let mut bench = Bench::named("ideal").unwrap();
    bench.elastic.clear();
    bench.faults = vec![fault.parse::<Fault>().unwrap()];
    bench
}

#[test]
fn boards_move_with_the_object_and_are_not_part_of_the_truth() {
    let bench = ideal("boards:0.005");
    assert_eq!(bench.truth(), Bench::named("ideal").unwrap().truth());
    let by_key = {
        let mut bench = Bench { faults: Vec::new(), ..bench.clone() };
        bench.sensor.board_mass_kg = 0.005;
        bench
    };
    let mut layout = layout([1, 2, 4], ["1:+Y", "2:+Z", "4:+X"]);
    // A laser does not load the object.
    layout.sensors[1].senses_gravity = false;
    let mut mass = bench.body.mass_matrix();
    for sensor in layout.sensors.iter().filter(|s| s.senses_gravity) {
        let motion = motion_of(sensor.position);
        mass += motion.transpose() * motion * 0.005;
    }
    for dof in 0..3 {
        let record = tapped_with(&bench, &layout, dof, Tip::default(), 6000);
        let hit = &layout.hits[dof];
        let force = Vector3::from(hit.direction);
        let moment = Vector3::from(hit.position).cross(&force);
        let loaded = accelerance_to(&mass, &layout, force, moment);
        let bare = accelerance_to(&bench.body.mass_matrix(), &layout, force, moment);
        let lines = mass_lines(&bench, &record, &[0, -1, -2, -3, -4]);
        for (line, loaded) in lines.iter().zip(&loaded) {
            // (2.5 Hz/10 Hz)⁵ from the suspension's damping, of accelerances up to 3 (m/s²)/N.
            assert!((line - loaded).abs() < 3e-4, "{line} {loaded}");
        }
        // 10 g at the ends of 1.23 kg: the effect is far above that tolerance.
        let effect = loaded.iter().zip(&bare).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(effect > 0.01, "{effect}");
        assert_eq!(record, tapped_with(&by_key, &layout, dof, Tip::default(), 6000));
    }
}

/// Stiffness of the suspension, from its modes: `M (Σ ω² φ φᵀ) M`.
fn stiffness(bench: &Bench) -> Matrix6<f64> {
    let modes: [RigidMode; 6] =
        loaded_modes(bench, &test_one(), &no_errors(bench)).unwrap().try_into().unwrap();
    let square = |m: &RigidMode| m.shape * m.shape.transpose() * m.omega.powi(2);
    let mass = bench.body.mass_matrix();
    mass * modes.iter().map(square).sum::<Matrix6<f64>>() * mass
}

#[test]
fn a_cable_adds_its_stiffness_at_its_node() {
    let on_cords = ideal("cable:2:400");
    let hz = [1.0, 1.5, 2.0, 1.2, 1.7, 2.5];
    let by_frequencies = Bench {
        suspension: Suspension::Frequencies { hz, damping_ratio: 0.01 },
        ..on_cords.clone()
    };
    for bench in [on_cords, by_frequencies] {
        let free = Bench { faults: Vec::new(), ..bench.clone() };
        let motion = motion_of(bench.node(2).unwrap().position_m);
        let expected = motion.transpose() * motion * 400.0;
        let added = stiffness(&bench) - stiffness(&free);
        // Rounding of a 6 × 6 eigenproblem with values up to 400 N/m.
        assert!((added - expected).norm() < 1e-9 * expected.norm(), "{added} {expected}");
    }
}

#[test]
fn a_cable_may_pull_at_a_node_of_the_layout_alone() {
    let mut bench = ideal("cable:9:400");
    let mut layout = test_one();
    layout.sensors[2].node = 9;
    layout.sensors[2].position = [0.1, 0.0, 0.0];
    let omegas = |bench: &Bench| -> Vec<f64> {
        let modes = loaded_modes(bench, &layout, &no_errors(bench)).unwrap();
        modes.iter().map(|mode| mode.omega).collect()
    };
    let pulled = omegas(&bench);
    bench.faults.clear();
    let free = omegas(&bench);
    // A spring raises every frequency or leaves it; three of them see a translation of the point.
    assert!(pulled.iter().zip(&free).all(|(a, b)| *a > b * (1.0 - 1e-12)), "{pulled:?} {free:?}");
    assert!(pulled[5] > 1.2 * free[5], "{pulled:?} {free:?}");
}
