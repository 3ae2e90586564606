//! The disturbances, each with what has to be true of its runs.

use massline_physics::Bench;
use massline_physics::suspension::Suspension;
use massline_shared::layout::{AttachedBody, Sensor};
use nalgebra::{Rotation3, Vector3};

/// A disturbance, and what has to be true of its runs.
pub struct Disturbance {
    pub name: &'static str,
    pub change: fn(&mut Bench),
    /// Mass of each sensor's board that the layout declares, kg.
    pub declared_kg: f64,
    /// Least and largest share of the runs that warn.
    pub warned: [f64; 2],
    /// Code that at least these shares of the runs of the two tests carry.
    pub named: Option<(&'static str, [f64; 2])>,
    /// Largest shift of the answer, rms in standard deviations of the undisturbed test.
    pub shift: f64,
    /// Good taps that are rejected, at most, per run.
    pub rejected_wrongly: f64,
    /// Bad taps that are accepted, at most, per run.
    pub accepted_wrongly: f64,
    /// Whether each test has an answer.
    pub answers: bool,
}

/// Any share.
const ANY: [f64; 2] = [0.0, 1.0];
const NEARLY_ALL: [f64; 2] = [0.95, 1.0];
const UNLIMITED: f64 = f64::INFINITY;

/// Nothing is asked of the warnings or of the answer; good taps are rejected in at most one run of twenty.
const ALONE: Disturbance = Disturbance {
    name: "none",
    change: |_| (),
    declared_kg: 0.0,
    warned: ANY,
    named: None,
    shift: UNLIMITED,
    rejected_wrongly: 0.05,
    accepted_wrongly: 0.0,
    answers: true,
};

/// A disturbance of which nearly all runs warn, and which most runs of either test name.
const fn named(
    name: &'static str,
    code: &'static str,
    shift: f64,
    change: fn(&mut Bench),
) -> Disturbance {
    let named = Some((code, [0.9; 2]));
    Disturbance { name, change, warned: NEARLY_ALL, named, shift, ..ALONE }
}

/// A disturbance that no test can tell from another object.
const fn unseen(name: &'static str, change: fn(&mut Bench)) -> Disturbance {
    Disturbance { name, change, ..ALONE }
}

/// A disturbance that moves the answer by no more than `shift` and warns in at most `warned` of the runs.
const fn harmless(
    name: &'static str,
    warned: f64,
    shift: f64,
    change: fn(&mut Bench),
) -> Disturbance {
    Disturbance { name, change, warned: [0.0, warned], shift, ..ALONE }
}

pub const ALL: &[Disturbance] = &[
    harmless("none", 0.01, 0.0, |_| ()),
    // The hits that are rejected exceed the range of a sensor.
    Disturbance {
        rejected_wrongly: 0.4,
        ..harmless("forces of 12 to 40 N", 1.0, 0.3, |b| b.tap.force_n = [12.0, 40.0])
    },
    // In test 4 the channel that is flat is a weak one for most DOFs.
    Disturbance {
        accepted_wrongly: 3.0,
        ..named("2 of 5 hits flat at 75 %", "hit:overload", UNLIMITED, |b| {
            b.operator.flat_rate = 0.4;
        })
    },
    // Only test 1 excites this channel enough.
    Disturbance {
        name: "one channel compressing (1z)",
        change: |b| fault(b, "compress:1z"),
        named: Some(("channel_not_linear", [0.95, 0.0])),
        ..ALONE
    },
    unseen("free moment 4 mm × F, lateral 3 %", |b| {
        (b.tap.free_moment_m, b.tap.lateral) = (0.004, 0.03);
    }),
    unseen("all hits of a DOF 5 mm beside", |b| b.tap.offset_m = 0.005),
    unseen("hammer 3 % low, stated as exact", |b| b.hammer.gain_error = -0.03),
    unseen("sensor boards of 5 g", |b| b.sensor.board_mass_kg = 0.005),
    Disturbance {
        declared_kg: 0.005,
        ..harmless("sensor boards of 5 g, declared", 0.02, 0.5, |b| b.sensor.board_mass_kg = 0.005)
    },
    unseen("INL 3 LSB", |b| b.adc.inl_lsb = 3.0),
    unseen("bow 8 LSB", |b| b.adc.bow_lsb = 8.0),
    named("mains 50 Hz, 5 mV", "hum_of_50_hz", 0.3, |b| hum(b, 50.0)),
    named("mains 49.8 Hz, 5 mV", "hum_of_50_hz", 0.3, |b| hum(b, 49.8)),
    named("mains 50.2 Hz, 5 mV", "hum_of_50_hz", 0.3, |b| hum(b, 50.2)),
    named("mains 60 Hz, 5 mV", "hum_of_60_hz", 0.3, |b| hum(b, 60.0)),
    named("ripple 100 Hz, 5 mV", "hum_of_50_hz", 0.3, |b| hum(b, 100.2)),
    // Hum bends the level of a flat response.
    Disturbance {
        accepted_wrongly: 3.5,
        ..named("2 of 5 hits flat at 75 %, mains 50 Hz, 5 mV", "hit:overload", UNLIMITED, |b| {
            b.operator.flat_rate = 0.4;
            hum(b, 50.0);
        })
    },
    // It cannot be taken out, so that the hits are rejected and half of the tests get none that pass.
    Disturbance {
        rejected_wrongly: UNLIMITED,
        answers: false,
        ..named("mains 50 Hz, 10 mV ± 20 % at 1 Hz", "hit:hum_unsteady", UNLIMITED, |b| {
            (b.mains.amplitude_v, b.mains.modulation, b.mains.modulation_hz) = (0.01, 0.2, 1.0);
        })
    },
    Disturbance {
        warned: [0.97, 1.0],
        named: Some(("multiplexer_keeps_voltage", [0.75; 2])),
        ..named("multiplexer memory 1 %", "", UNLIMITED, |b| b.adc.memory = 0.01)
    },
    named("elastic mode at 180 Hz", "no_plateau", UNLIMITED, |b| {
        (b.elastic[0].frequency_hz, b.elastic[0].damping_ratio) = (180.0, 0.01);
    }),
    // Beside the ripple of a rectifier, for which it is not taken.
    named("elastic mode at 104 Hz", "no_plateau", UNLIMITED, |b| {
        (b.elastic[0].frequency_hz, b.elastic[0].damping_ratio) = (104.0, 0.002);
    }),
    named("suspension at 6 to 9 Hz", "suspension_in_band", UNLIMITED, |b| {
        hang_at(b, [6.0, 6.6, 7.2, 7.8, 8.4, 9.0]);
    }),
    named("suspension at 12 to 15 Hz", "suspension_in_band", UNLIMITED, |b| {
        hang_at(b, [12.0, 12.6, 13.2, 13.8, 14.4, 15.0]);
    }),
    named("cable 400 N/m", "suspension_in_band", UNLIMITED, |b| fault(b, "cable:2:400")),
    harmless("RC within 15 % (3 σ)", 0.03, 0.3, |b| {
        (b.sensor.rc_tolerance, b.hammer.rc_tolerance) = (0.05, 0.05);
    }),
    harmless("RC evenly within 15 %", 0.03, 0.3, |b| {
        (b.sensor.rc_tolerance, b.hammer.rc_tolerance) = (0.0, 0.0);
        (b.sensor.rc_within, b.hammer.rc_within) = (0.15, 0.15);
    }),
    harmless("hammer's RC 20 % high", 1.0, 0.5, |b| b.hammer.rc_error = 0.2),
    named("no capacitors", "no_plateau", UNLIMITED, |b| {
        b.sensor.bandwidth_hz = Some([1600.0, 1600.0, 550.0]);
    }),
    harmless("drift 10 mV/s, clock 100 ppm, jitter 5 µs", 0.02, 0.5, |b| {
        b.sensor.drift_v_per_s = 0.01;
        (b.adc.clock_error, b.adc.jitter_s) = (1e-4, 5e-6);
    }),
    harmless("1 scan of 1000 lost", 1.0, 0.5, |b| b.adc.lost_rate = 0.001),
    harmless("hung with a tilt of 3°", 0.02, 0.3, |b| tilt(b, 3.0)),
    harmless("hung with a tilt of 20°", 1.0, 0.5, |b| tilt(b, 20.0)),
    // A second contact that is too weak to be seen changes nothing.
    Disturbance {
        accepted_wrongly: UNLIMITED,
        ..harmless("2 of 5 hits bounce, 2 to 6 % of the force", 1.0, 0.5, |b| {
            (b.operator.double_rate, b.operator.double_share) = (0.4, [0.02, 0.06]);
        })
    },
    harmless("hard tip: contacts of 1 to 2 ms", 1.0, 0.7, |b| b.tap.duration_s = [0.001, 0.002]),
];

/// What no test can tell from another object, each with the source of its line under "what this test cannot see".
pub const CANNOT_BE_SEEN: [(&str, &str); 6] = [
    ("free moment 4 mm × F, lateral 3 %", "lateral_force_or_free_moment"),
    ("all hits of a DOF 5 mm beside", "same_side_miss"),
    ("hammer 3 % low, stated as exact", "hammer_gain"),
    ("sensor boards of 5 g", "sensor_mass"),
    ("INL 3 LSB", "nonlinearity"),
    ("bow 8 LSB", "nonlinearity"),
];

fn fault(bench: &mut Bench, text: &str) {
    bench.faults.push(text.parse().expect("is a fault"));
}

fn hum(bench: &mut Bench, frequency_hz: f64) {
    (bench.mains.amplitude_v, bench.mains.frequency_hz) = (0.005, frequency_hz);
}

fn hang_at(bench: &mut Bench, hz: [f64; 6]) {
    bench.suspension = Suspension::Frequencies { hz, damping_ratio: 0.02 };
}

/// The object hangs turned about the x axis; the cords stay vertical.
fn tilt(bench: &mut Bench, degrees: f64) {
    let turn = Rotation3::from_axis_angle(&Vector3::x_axis(), degrees.to_radians());
    bench.gravity = turn * bench.gravity;
    if let Suspension::Cords { cords, .. } = &mut bench.suspension {
        for cord in cords {
            cord.direction = (turn * Vector3::from(cord.direction)).into();
        }
    }
}

/// Boards of this mass, weighed to 2 %, as one attached body.
pub fn boards(sensors: &[Sensor<f64>], mass_kg: f64) -> AttachedBody<f64> {
    const WEIGHED: f64 = 0.02;
    let mut attached = AttachedBody { phi: [0.0; 10], relative_sigma: WEIGHED };
    for sensor in sensors {
        let one = AttachedBody::point(mass_kg, WEIGHED, sensor.position);
        attached.phi.iter_mut().zip(one.phi).for_each(|(sum, term)| *sum += term);
    }
    attached
}
