//! Rigs without a fault: sensors, hammers and supplies as they come, and what the mains and the screen may do to them.

use massline_physics::errors::TestErrors;
use massline_physics::{Bench, BenchSource};
use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};
use massline_shared::signal::{Calibration, CrossAxis};
use massline_shared::units::Volts;
use massline_tests::campaign::three_bar;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::circuit::Circuit;
use super::{Rig, bench};

/// 1 mg of a sensor, V.
const MILLI_G: f64 = Calibration::ADXL326_VOLT_PER_G * 1e-3;

/// A rig; every other one has been calibrated in a tumble test.
pub fn rig(circuit: &Circuit, seed: u64) -> Rig {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |from: f64, to: f64| from + (to - from) * rng.random::<f64>();
    let mut bench = bench(circuit.board);
    // By the data sheet a zero is within 0.3 V and a sensitivity within 10 %: four and three times this.
    (bench.sensor.zero_sigma_v, bench.sensor.gain_sigma) = (0.075, 0.033);
    bench.sensor.rc_within = 0.15;
    bench.sensor.noise_g_per_sqrt_hz = between(250e-6, 350e-6);
    (bench.hammer.zero_v, bench.hammer.zero_sigma_v) = (0.11, 0.01);
    (bench.adc.inl_lsb, bench.adc.dnl_lsb) = (1.5, 0.5);
    // Up to 2 mg of the mains, of which the computed 0.13 mg rms are a tenth, in all channels.
    let nominal = if between(0.0, 1.0) < 0.5 { 50.0 } else { 60.0 };
    bench.mains.frequency_hz = nominal + between(-0.5, 0.5);
    bench.mains.amplitude_v = between(0.0, 2.0) * MILLI_G;
    bench.mains.harmonics = vec![between(0.0, 0.3), between(0.0, 0.3)];
    // Up to 1 mg of the screen, of which 0.06 mg rms are computed.
    bench.supply.ripple_hz = between(94.5, 115.5);
    let read = between(0.0, 1.0) * MILLI_G;
    bench.supply.ripple_v = circuit.ripple(read, bench.supply.ripple_hz);
    bench.supply.ripple_harmonics = vec![between(0.0, 0.5), between(0.0, 0.3)];
    // Up to three times the buzzer's current, the screen's 10 mA without a regulator of its own.
    bench.supply.droop_v = circuit.droop(between(0.0, 3.0) * circuit.buzzer());
    (bench.supply.droop_s, bench.supply.droop_rate_per_s) = (between(1e-4, 1e-2), 10.0);
    // A draught that moves the frame by some milli-g, of the 20 that are named.
    bench.environment.draught_n = between(0.0, 2e-3);
    let calibration =
        if seed.is_multiple_of(2) { tumbled(&bench, seed) } else { CalibrationRecord::default() };
    Rig { calibration, ..Rig::on(bench) }
}

/// The calibration that an exact tumble test finds.
fn tumbled(bench: &Bench, seed: u64) -> CalibrationRecord {
    let source = BenchSource::new(bench, &three_bar().layout, seed).expect("the bench is sound");
    let TestErrors { zero_v, sensors, .. } = source.errors();
    let mut calibration = Calibration::default();
    for (sensor, errors) in sensors.iter().enumerate() {
        let gains = errors.sensitivity;
        for axis in 0..3 {
            let channel = 1 + 3 * sensor + axis;
            let entry = &mut calibration.channels[channel];
            entry.zero = Volts((bench.sensor.zero_v + zero_v[channel]) as f32);
            let per_g = bench.sensor.sensitivity_v_per_g * gains[(axis, axis)];
            entry.sensitivity = (per_g / STANDARD_GRAVITY) as f32;
        }
        let share = |row, column| (gains[(row, column)] / gains[(row, row)]) as f32;
        calibration.cross_axis[sensor] = CrossAxis {
            xy: share(0, 1),
            xz: share(0, 2),
            yx: share(1, 0),
            yz: share(1, 2),
            zx: share(2, 0),
            zy: share(2, 1),
        };
    }
    CalibrationRecord {
        calibration,
        method: CalibrationMethod::Tumble,
        ..CalibrationRecord::default()
    }
}
