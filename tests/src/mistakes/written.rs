//! Mistakes in the layout, the cables or the readings of a test that was measured without them.

use massline_analysis::single_fault::{Mistake, SizedFault};
use massline_shared::identify::single_fault::{AxisMap, SingleFault};
use massline_shared::layout::{Axis, Prior, RIG_SENSORS};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Culprit, MeasuredTest};

/// A kind of mistake.
pub struct Kind {
    /// What is wrong.
    pub name: &'static str,
    /// Makes it in a healthy test, by an amount that is drawn; `None` when the test has no room for it.
    pub make: fn(&mut MeasuredTest, &mut ChaCha8Rng) -> Option<Culprit>,
}

/// The kinds that the search of the program can name.
pub const NAMED: &[Kind] = &[
    Kind { name: "an axis reversed", make: |test, random| reversed(test, random, false) },
    Kind {
        name: "all axes of a sensor reversed",
        make: |test, random| reversed(test, random, true),
    },
    Kind { name: "two wires of a sensor swapped", make: |test, random| axes(test, random, false) },
    Kind { name: "a sensor turned", make: |test, random| axes(test, random, true) },
    Kind { name: "the cables of two sensors swapped", make: cables },
    Kind { name: "two nodes swapped", make: nodes_swapped },
    Kind { name: "a hit at another node", make: hit_elsewhere },
    Kind { name: "a hit from the other side", make: hit_reversed },
    Kind { name: "the gain of a channel", make: channel_gain },
    Kind { name: "a channel that is dead", make: dead_channel },
    Kind { name: "the gain of a sensor", make: sensor_gain },
    Kind { name: "the gain of a hit", make: hit_gain },
    Kind { name: "a coordinate", make: coordinate },
    Kind { name: "the sign of a coordinate", make: sign_of_coordinate },
    Kind { name: "a hit beside its node", make: hit_beside },
    Kind { name: "the gain of everything, mass known", make: common_gain },
];

/// The kinds that are on none of its lists.
pub const ON_NO_LIST: &[Kind] = &[
    Kind { name: "a sensor at another node", make: sensor_at_another_node },
    Kind { name: "a sensor turned by 15 to 75°", make: sensor_askew },
    Kind { name: "an axis of two sensors reversed", make: two_reversed },
    Kind { name: "a hit along another axis", make: hit_along_another_axis },
    Kind { name: "two hits exchanged", make: hits_exchanged },
    Kind { name: "a channel that reads another", make: same_channel_twice },
    Kind { name: "cross-axis sensitivity of 5 to 30 %", make: cross_axis },
    Kind { name: "a single reading", make: single_reading },
    Kind { name: "the force reversed", make: force_reversed },
];

impl MeasuredTest {
    fn place(&self, node: u16) -> [f64; 3] {
        self.nodes.iter().find(|(other, _)| *other == node).expect("a node").1
    }

    fn move_node(&mut self, node: u16, place: [f64; 3]) {
        let on_node = self.layout.sensors.iter_mut().filter(|sensor| sensor.node == node);
        on_node.for_each(|sensor| sensor.position = place);
        let on_node = self.layout.hits.iter_mut().filter(|hit| hit.dof.node == node);
        on_node.for_each(|hit| hit.position = place);
        let on_node = self.nodes.iter_mut().filter(|(other, _)| *other == node);
        on_node.for_each(|(_, position)| *position = place);
    }

    /// Multiplies readings by a factor for each index of the DOF and response.
    fn multiply(&mut self, factor: impl Fn(usize, usize) -> f64) {
        for (hit, own) in &mut self.test.dofs {
            let factor = |response: usize| factor(*hit, response);
            for i in 0..3 * RIG_SENSORS {
                own.accelerance[i] *= factor(i);
                own.noise[i] *= factor(i).abs();
                own.trend.products[i] *= factor(i);
                own.band_shift[i] *= factor(i);
                for k in 0..3 * RIG_SENSORS {
                    own.scatter[(i, k)] *= factor(i) * factor(k);
                }
            }
        }
    }

    /// The sensor reads `mixing` times what it should; the correlation of its noise is not followed.
    fn mix(&mut self, sensor: usize, mixing: &Matrix3<f64>) {
        for (_, own) in &mut self.test.dofs {
            let is = Vector3::from_fn(|axis, _| own.accelerance[3 * sensor + axis]);
            let reads = mixing * is;
            for axis in 0..3 {
                own.accelerance[3 * sensor + axis] = reads[axis];
            }
        }
    }

    fn any_sensor(&self, random: &mut ChaCha8Rng) -> usize {
        random.random_range(0..self.layout.sensors.len())
    }

    /// A DOF that was hit.
    fn any_hit(&self, random: &mut ChaCha8Rng) -> usize {
        self.test.dofs[random.random_range(0..self.test.dofs.len())].0
    }

    /// A node that is hit or carries a sensor.
    fn any_node(&self, random: &mut ChaCha8Rng) -> u16 {
        let sensors = self.layout.sensors.iter().map(|sensor| sensor.node);
        let used: Vec<u16> =
            sensors.chain(self.layout.hits.iter().map(|hit| hit.dof.node)).collect();
        used[random.random_range(0..used.len())]
    }

    /// A node other than this one.
    fn other_node(&self, node: u16, random: &mut ChaCha8Rng) -> u16 {
        let others: Vec<u16> =
            self.nodes.iter().map(|(other, _)| *other).filter(|other| *other != node).collect();
        others[random.random_range(0..others.len())]
    }

    fn write(&mut self, fault: SingleFault<f64>) -> Option<Culprit> {
        self.layout = fault.applied(&self.layout)?;
        Some(listed(fault))
    }
}

fn any_axis(random: &mut ChaCha8Rng) -> Axis {
    Axis::ALL[random.random_range(0..3)]
}

fn any_sign(random: &mut ChaCha8Rng) -> f64 {
    if random.random_bool(0.5) { 1.0 } else { -1.0 }
}

/// A gain that is clearly wrong: half of them from a unit or an amplifier, the others anything from 0.05 to 20.
fn any_gain(random: &mut ChaCha8Rng) -> f64 {
    const USUAL: [f64; 8] = [9.806_65, 1.0 / 9.806_65, 1000.0, 0.001, 10.0, 0.1, 2.0, 0.5];
    if random.random_bool(0.5) {
        return USUAL[random.random_range(0..USUAL.len())];
    }
    let log = random.random_range(1.25_f64.ln()..20.0_f64.ln());
    (any_sign(random) * log).exp()
}

fn listed(fault: SingleFault<f64>) -> Culprit {
    Culprit::Suspect(Box::new(move |mistake| *mistake == Mistake::Listed(fault)))
}

fn sized(fault: SizedFault) -> Culprit {
    let is =
        move |mistake: &Mistake| matches!(mistake, Mistake::Sized(sized) if sized.fault == fault);
    Culprit::Suspect(Box::new(is))
}

fn reversed(test: &mut MeasuredTest, random: &mut ChaCha8Rng, all_axes: bool) -> Option<Culprit> {
    let sensor = test.any_sensor(random);
    let reads = if all_axes { AxisMap::REVERSED } else { AxisMap::with_reversed(any_axis(random)) };
    test.write(SingleFault::SensorAxes { sensor, reads })
}

fn axes(test: &mut MeasuredTest, random: &mut ChaCha8Rng, turned: bool) -> Option<Culprit> {
    let is_plain = |map: &AxisMap| map.0.iter().all(|(sign, _)| sign.factor() > 0.0);
    let maps: Vec<_> = AxisMap::mistakes()
        .filter(|map| map.is_turn() == turned && (turned || is_plain(map)))
        .collect();
    let written = maps[random.random_range(0..maps.len())];
    let sensor = test.any_sensor(random);
    let is = test.layout.sensors[sensor].axes;
    test.write(SingleFault::SensorAxes { sensor, reads: written })?;
    // A turn is undone by the opposite one.
    let undoes = |reads: &AxisMap| {
        let fault = SingleFault::SensorAxes { sensor, reads: *reads };
        fault.applied(&test.layout).is_some_and(|layout| layout.sensors[sensor].axes == is)
    };
    let reads = AxisMap::mistakes().find(undoes)?;
    Some(listed(SingleFault::SensorAxes { sensor, reads }))
}

fn cables(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let sensor = test.any_sensor(random);
    let other = (sensor + 1) % test.layout.sensors.len();
    let sensors = [sensor.min(other), sensor.max(other)];
    test.write(SingleFault::CablesSwapped { sensors })
}

fn nodes_swapped(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let node = test.any_node(random);
    let other = test.layout.sensors[test.any_sensor(random)].node;
    if other == node {
        return None;
    }
    let places = [test.place(node), test.place(other)];
    test.move_node(node, places[1]);
    test.move_node(other, places[0]);
    Some(Culprit::Suspect(Box::new(move |mistake| {
        matches!(mistake, Mistake::Listed(SingleFault::NodesSwapped { nodes, .. })
            if nodes.contains(&node) && nodes.contains(&other))
    })))
}

fn hit_elsewhere(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let hit = test.any_hit(random);
    let struck = test.layout.hits[hit].dof.node;
    let written = test.other_node(struck, random);
    test.layout.hits[hit].dof.node = written;
    test.layout.hits[hit].position = test.place(written);
    Some(Culprit::Suspect(Box::new(move |mistake| {
        matches!(mistake, Mistake::Listed(SingleFault::HitAtNode { hit: own, node, .. })
            if *own == hit && *node == struck)
    })))
}

fn hit_reversed(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let hit = test.any_hit(random);
    test.write(SingleFault::HitReversed { hit })
}

fn channel_gain(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let (sensor, axis, gain) = (test.any_sensor(random), any_axis(random), any_gain(random));
    multiply_channel(test, sensor, axis, gain);
    Some(sized(SizedFault::ChannelGain { sensor, axis }))
}

fn dead_channel(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let (sensor, axis) = (test.any_sensor(random), any_axis(random));
    multiply_channel(test, sensor, axis, random.random_range(0.0..0.01));
    Some(sized(SizedFault::ChannelGain { sensor, axis }))
}

fn multiply_channel(test: &mut MeasuredTest, sensor: usize, axis: Axis, gain: f64) {
    let wrong = 3 * sensor + axis.index();
    test.multiply(|_, response| if response == wrong { gain } else { 1.0 });
}

fn sensor_gain(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let (sensor, gain) = (test.any_sensor(random), any_gain(random));
    test.multiply(|_, response| if response / 3 == sensor { gain } else { 1.0 });
    Some(sized(SizedFault::SensorGain { sensor }))
}

fn hit_gain(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let (hit, gain) = (test.any_hit(random), any_gain(random));
    test.multiply(|own, _| if own == hit { gain } else { 1.0 });
    Some(sized(SizedFault::HitGain { hit }))
}

fn coordinate(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let (node, axis) = (test.any_node(random), any_axis(random));
    let mut place = test.place(node);
    place[axis.index()] += any_sign(random) * random.random_range(0.03..0.3);
    test.move_node(node, place);
    Some(sized(SizedFault::NodeCoordinate { node, axis }))
}

fn sign_of_coordinate(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let (node, axis) = (test.any_node(random), any_axis(random));
    let mut place = test.place(node);
    if place[axis.index()].abs() < 0.05 {
        return None;
    }
    place[axis.index()] *= -1.0;
    test.move_node(node, place);
    Some(sized(SizedFault::NodeCoordinate { node, axis }))
}

fn hit_beside(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    /// The number of the mark, a node of its own.
    const MARK: u16 = 90;
    let hit = test.any_hit(random);
    let own = &mut test.layout.hits[hit];
    let turn = random.random_range(0.0..std::f64::consts::TAU);
    let direction = Vector3::from(own.direction);
    let across = direction.yzx() * turn.cos() + direction.zxy() * turn.sin();
    let written = Vector3::from(own.position) - across * random.random_range(0.02..0.15);
    own.position = written.into();
    // The point that was hit is no node.
    let struck = own.dof.node;
    own.dof.node = MARK;
    test.nodes.retain(|(node, _)| *node != struck);
    test.nodes.push((MARK, written.into()));
    // Along an axis it is also a coordinate of that node.
    Some(Culprit::Suspect(Box::new(move |mistake| match mistake {
        Mistake::Sized(sized) => match sized.fault {
            SizedFault::HitDisplaced { hit: own } => own == hit,
            SizedFault::NodeCoordinate { node, .. } => node == MARK,
            _ => false,
        },
        Mistake::Listed(_) => false,
    })))
}

fn common_gain(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    /// What scales say of the three-bar frame, kg.
    const KNOWN: Prior<f64> = Prior { property: 0, value: 1.23, sigma: 0.001 };
    test.layout.priors.push(KNOWN).ok()?;
    let gain = any_gain(random);
    test.multiply(|_, _| gain);
    Some(sized(SizedFault::CommonGain))
}

fn sensor_at_another_node(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let sensor = test.any_sensor(random);
    let written = test.other_node(test.layout.sensors[sensor].node, random);
    test.layout.sensors[sensor].node = written;
    test.layout.sensors[sensor].position = test.place(written);
    Some(Culprit::OnNoList)
}

fn sensor_askew(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let sensor = test.any_sensor(random);
    let about = Unit::new_normalize(Vector3::from_fn(|_, _| random.random_range(-1.0..1.0)));
    let angle = any_sign(random) * random.random_range(15.0_f64..75.0).to_radians();
    test.mix(sensor, Rotation3::from_axis_angle(&about, angle).matrix());
    Some(Culprit::OnNoList)
}

fn two_reversed(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let first = test.any_sensor(random);
    for sensor in [first, (first + 1) % test.layout.sensors.len()] {
        let reads = AxisMap::with_reversed(any_axis(random));
        test.write(SingleFault::SensorAxes { sensor, reads })?;
    }
    Some(Culprit::OnNoList)
}

fn hit_along_another_axis(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let hit = test.any_hit(random);
    let own = &mut test.layout.hits[hit].direction;
    *own =
        if random.random_bool(0.5) { [own[1], own[2], own[0]] } else { [own[2], own[0], own[1]] };
    Some(Culprit::OnNoList)
}

fn hits_exchanged(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let dofs = &mut test.test.dofs;
    let first = random.random_range(0..dofs.len());
    let second = (first + 1) % dofs.len();
    let of_first = dofs[first].1.clone();
    dofs[first].1 = std::mem::replace(&mut dofs[second].1, of_first);
    Some(Culprit::OnNoList)
}

fn same_channel_twice(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let sensor = test.any_sensor(random);
    let (axis, read) = (any_axis(random).index(), any_axis(random).index());
    if axis == read {
        return None;
    }
    let mut mixing = Matrix3::identity();
    mixing[(axis, axis)] = 0.0;
    mixing[(axis, read)] = 1.0;
    test.mix(sensor, &mixing);
    Some(Culprit::OnNoList)
}

fn cross_axis(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let sensor = test.any_sensor(random);
    let mut mixing = Matrix3::identity();
    for (row, column) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
        mixing[(row, column)] = any_sign(random) * random.random_range(0.05..0.3);
    }
    test.mix(sensor, &mixing);
    Some(Culprit::OnNoList)
}

fn single_reading(test: &mut MeasuredTest, random: &mut ChaCha8Rng) -> Option<Culprit> {
    let hit = test.any_hit(random);
    let wrong = 3 * test.any_sensor(random) + any_axis(random).index();
    let gain = any_gain(random);
    test.multiply(|own, response| if (own, response) == (hit, wrong) { gain } else { 1.0 });
    Some(Culprit::OnNoList)
}

fn force_reversed(test: &mut MeasuredTest, _: &mut ChaCha8Rng) -> Option<Culprit> {
    test.multiply(|_, _| -1.0);
    Some(Culprit::OnNoList)
}
