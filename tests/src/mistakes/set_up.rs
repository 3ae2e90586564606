//! Mistakes on the bench, made before a test is measured.

use massline_physics::Bench;
use massline_physics::Fault;
use massline_physics::suspension::Suspension;
use massline_shared::diagnosis::Code;
use massline_shared::layout::Axis;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::Culprit;

/// A kind of mistake.
pub struct Kind {
    /// What is wrong.
    pub name: &'static str,
    /// Makes it on a healthy bench, by an amount that is drawn.
    pub make: fn(&mut Bench, &mut ChaCha8Rng) -> Culprit,
}

/// The kinds.
pub const ALL: &[Kind] = &[
    Kind { name: "hits that scatter 4 to 8 times as much", make: rough_hits },
    Kind { name: "sensors glued 4 to 8 times as roughly", make: rough_sensors },
    Kind { name: "a suspension of 6 to 15 Hz", make: stiff_suspension },
    Kind { name: "a cable of 200 to 1000 N/m", make: cable },
    Kind { name: "an elastic mode at 130 to 200 Hz", make: elastic_mode },
    Kind { name: "hum of 3 to 8 mV", make: hum },
    Kind { name: "a sensor channel that saturates", make: rail },
];

fn rough_hits(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    let factor = random.random_range(4.0..8.0);
    bench.tap.point_sigma_m *= factor;
    bench.tap.direction_sigma_rad *= factor;
    Culprit::LargerErrors
}

fn rough_sensors(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    let factor = random.random_range(4.0..8.0);
    bench.sensor.position_sigma_m *= factor;
    bench.sensor.rotation_sigma_rad *= factor;
    bench.sensor.gain_sigma *= factor;
    Culprit::LargerErrors
}

fn stiff_suspension(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    let lowest = random.random_range(6.0..12.0);
    let hz = std::array::from_fn(|mode| lowest * (1.0 + 0.05 * mode as f64));
    bench.suspension = Suspension::Frequencies { hz, damping_ratio: 0.02 };
    Culprit::Code(Code::SuspensionInBand)
}

fn cable(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    let stiffness_n_per_m = random.random_range(200.0..1000.0);
    bench.faults.push(Fault::Cable { node: random.random_range(1..=4), stiffness_n_per_m });
    Culprit::Code(Code::SuspensionInBand)
}

fn elastic_mode(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    bench.elastic[0].frequency_hz = random.random_range(130.0..200.0);
    bench.elastic[0].damping_ratio = 0.01;
    Culprit::Code(Code::NoPlateau)
}

fn hum(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    bench.mains.amplitude_v = random.random_range(0.003..0.008);
    bench.mains.frequency_hz = random.random_range(49.8..50.2);
    Culprit::Code(Code::HumOf50Hz)
}

fn rail(bench: &mut Bench, random: &mut ChaCha8Rng) -> Culprit {
    bench.faults.push(Fault::SensorRail {
        sensor: random.random_range(0..3),
        axis: Axis::ALL[random.random_range(0..3)],
        limit_m_per_s2: random.random_range(5.0..30.0),
    });
    Culprit::OnNoList
}
