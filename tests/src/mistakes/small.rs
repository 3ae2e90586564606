//! Small faults on the bench, made before a test is measured.

use massline_analysis::score_tests::SmallFault;
use massline_physics::{Bench, Fault};
use massline_shared::layout::{Axis, HostLayout};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A kind of small fault.
pub struct Kind {
    /// What is wrong.
    pub name: &'static str,
    /// Makes it on a healthy bench, of a size that is drawn; returns what names it. `None` when the layout has no room
    /// for it.
    pub make: fn(&mut Bench, &HostLayout, &mut ChaCha8Rng) -> Option<SmallFault>,
    /// Whether the answer is tested for it.
    pub is_tested: bool,
}

/// The kinds.
pub const ALL: &[Kind] = &[
    Kind { name: "a node written 6 to 15 mm wrong", make: node, is_tested: true },
    Kind { name: "a hammer that drifts by 3 to 8 %", make: hammer_drift, is_tested: true },
    Kind { name: "a channel that drifts by 4 to 10 %", make: channel_drift, is_tested: true },
    Kind { name: "chips 2 to 6 mm above their marks", make: height, is_tested: true },
    Kind { name: "a DOF whose hits lean by 60 to 120 mrad", make: lean, is_tested: true },
    Kind { name: "all hits turned by 30 to 80 mrad", make: turn, is_tested: true },
    Kind {
        name: "a hammer whose gain differs by 1 to 3 % from DOF to DOF",
        make: hit_gain,
        is_tested: false,
    },
    Kind { name: "a pad of 5 to 15 g on each mark", make: pad, is_tested: true },
];

fn any_axis(random: &mut ChaCha8Rng) -> Axis {
    Axis::ALL[random.random_range(0..3)]
}

fn any_sign(random: &mut ChaCha8Rng) -> f64 {
    if random.random_bool(0.5) { 1.0 } else { -1.0 }
}

fn node(bench: &mut Bench, layout: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    let is_hit = |node: u16| layout.hits.iter().any(|hit| hit.dof.node == node);
    let both: Vec<u16> =
        layout.sensors.iter().map(|sensor| sensor.node).filter(|node| is_hit(*node)).collect();
    let node = *both.get(random.random_range(0..both.len().max(1)))?;
    let (axis, distance_m) =
        (any_axis(random), any_sign(random) * random.random_range(0.006..0.015));
    bench.faults.push(Fault::NodeMisplaced { node, axis, distance_m });
    Some(SmallFault::NodeMisplaced { node, axis })
}

fn hammer_drift(bench: &mut Bench, _: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    let change = any_sign(random) * random.random_range(0.03..0.08);
    bench.faults.push(Fault::HammerDrift { change });
    Some(SmallFault::HammerDrifts)
}

fn channel_drift(
    bench: &mut Bench,
    layout: &HostLayout,
    random: &mut ChaCha8Rng,
) -> Option<SmallFault> {
    let (sensor, axis) = (random.random_range(0..layout.sensors.len()), any_axis(random));
    let change = any_sign(random) * random.random_range(0.04..0.1);
    bench.faults.push(Fault::ChannelDrift { sensor, axis, change });
    Some(SmallFault::ChannelDrifts { sensor, axis })
}

fn height(bench: &mut Bench, _: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    bench.faults.push(Fault::ChipsAboveMarks { height_m: random.random_range(0.002..0.006) });
    Some(SmallFault::ChipsAboveMarks)
}

fn lean(bench: &mut Bench, layout: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    let hit = random.random_range(0..layout.hits.len());
    bench.faults.push(Fault::HitLeans { hit, angle_rad: random.random_range(0.06..0.12) });
    Some(SmallFault::HitLeans { hit })
}

fn turn(bench: &mut Bench, _: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    bench.faults.push(Fault::HitsTurned { angle_rad: random.random_range(0.03..0.08) });
    Some(SmallFault::HitsTurned)
}

fn hit_gain(bench: &mut Bench, _: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    bench.hammer.hit_gain_sigma = random.random_range(0.01..0.03);
    None
}

fn pad(bench: &mut Bench, _: &HostLayout, random: &mut ChaCha8Rng) -> Option<SmallFault> {
    bench.faults.push(Fault::Pad { mass_kg: random.random_range(0.005..0.015) });
    Some(SmallFault::MarksLoaded)
}
