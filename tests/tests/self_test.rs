//! The self-test of a rig against faults of wiring and parts, and against rigs without any.

use std::sync::Arc;

use massline::self_test::Check;
use massline_firmware::board::{Clock, Supply};
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::Hertz;
use massline_tests::campaign::{connect, steady_hand, three_bar};
use massline_virtual::bench::{Bench, BenchSource};
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};
use massline_virtual::source::ScanSource;

/// Outputs of the ten channels at the rig's inputs, V, and the time, s.
type Wires = [f64; 10];
/// What a fault does to them.
type Effect = Arc<dyn Fn(&mut Wires, f64) + Send + Sync>;

/// A bench whose wires pass a fault on their way to the converter.
struct Faulty {
    bench: BenchSource,
    effect: Effect,
    scans: u32,
}

impl ScanSource for Faulty {
    fn adc(&self) -> AdcProperties {
        self.bench.adc()
    }

    fn started(&mut self) {
        self.bench.started();
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.bench.armed(arming, dof);
    }

    fn next_scan(&mut self) -> Option<Scan> {
        let scan = self.bench.next_scan()?;
        let adc = self.adc();
        let code = f64::from(adc.volts_per_code());
        let mut wires = scan.map(|of| f64::from(of) * code);
        (self.effect)(&mut wires, f64::from(self.scans) / f64::from(adc.rate.0));
        self.scans += 1;
        Some(wires.map(|volts| (volts / code).round().clamp(0.0, adc.full_scale().into()) as u16))
    }
}

/// White noise between -1 and 1 that depends on the time and on a number.
fn noise(time: f64, number: u32) -> f64 {
    let mut mixed = ((time * 4000.0).round() as u32).wrapping_mul(2_654_435_761)
        ^ number.wrapping_mul(0x9E37_79B9);
    mixed = (mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519);
    mixed = (mixed ^ (mixed >> 13)).wrapping_mul(3_266_489_917);
    f64::from((mixed ^ (mixed >> 16)) >> 8) / f64::from(1_u32 << 23) - 1.0
}

fn tone(time: f64, hertz: f64) -> f64 {
    (std::f64::consts::TAU * hertz * time + 0.7).sin()
}

/// A rig with a fault.
struct Case {
    name: &'static str,
    effect: Effect,
    board: &'static str,
    clock: Clock,
    supply: Supply,
    calibration: CalibrationRecord,
    /// The codes that must be found, each with its subject in words, and no others.
    named: Vec<&'static str>,
}

fn case(
    name: &'static str,
    named: &[&'static str],
    effect: impl Fn(&mut Wires, f64) + Send + Sync + 'static,
) -> Case {
    Case {
        name,
        effect: Arc::new(effect),
        board: "virtual",
        clock: Clock::Crystal,
        supply: Supply::STEADY,
        calibration: CalibrationRecord::default(),
        named: named.to_vec(),
    }
}

/// Puts all axes of a sensor to a level, with a little noise.
fn all_axes(sensor: usize, volts: f64) -> impl Fn(&mut Wires, f64) + Send + Sync {
    move |wires, time| {
        for axis in 0..3 {
            wires[1 + 3 * sensor + axis] = volts + 1e-3 * noise(time, axis as u32);
        }
    }
}

/// The supply of a sensor arrives through its output x, less a diode; y and z are exchanged and at half of it.
fn fed_through_x(sensor: usize) -> impl Fn(&mut Wires, f64) + Send + Sync {
    move |wires, time| {
        let [x, y, z] = [0, 1, 2].map(|axis| 1 + 3 * sensor + axis);
        let supply = 2.45;
        let [of_y, of_z] = [wires[y], wires[z]].map(|volts| volts * supply / 3.0);
        wires[x] = supply + 1e-3 * noise(time, 5);
        (wires[y], wires[z]) = (of_z, of_y);
    }
}

fn wire(channel: usize, volts: f64) -> impl Fn(&mut Wires, f64) + Send + Sync {
    move |wires, time| wires[channel] = volts + 1e-3 * noise(time, 7)
}

/// A calibration by a tumble test of sensors without errors.
fn tumbled() -> CalibrationRecord {
    CalibrationRecord { method: CalibrationMethod::Tumble, ..CalibrationRecord::default() }
}

fn cases() -> Vec<Case> {
    let mut breakout = case(
        "100 nF left on the breakout of sensor 2, by the block test",
        &["capacitor_left: sensor 2 y"],
        |_, _| {},
    );
    breakout.calibration.calibration.channels[5].cutoff = Hertz(50.0);
    let other_type = |wires: &mut Wires, _: f64| {
        for wire in &mut wires[7..10] {
            *wire = 1.5 + 1.3 * (*wire - 1.5);
        }
    };
    let mut cases = vec![
        case("sensor 1 not plugged in", &["sensor_silent: sensor 1"], all_axes(0, 0.002)),
        case("sensor 2 not plugged in", &["sensor_silent: sensor 2"], all_axes(1, 0.002)),
        case("supply of sensor 3 broken", &["sensor_silent: sensor 3"], all_axes(2, 0.03)),
        case("supply of sensor 1 swapped", &["sensor_reversed: sensor 1"], all_axes(0, 0.35)),
        case("supply of sensor 2 swapped", &["sensor_reversed: sensor 2"], all_axes(1, 0.42)),
        case("supply of sensor 3 swapped", &["sensor_reversed: sensor 3"], all_axes(2, 0.2)),
        case("ground of sensor 1 broken", &["sensor_ground_open: sensor 1"], all_axes(0, 2.95)),
        case("ground of sensor 2 broken", &["sensor_ground_open: sensor 2"], all_axes(1, 2.99)),
        case("ground of sensor 3 broken", &["sensor_ground_open: sensor 3"], all_axes(2, 2.9)),
        case("wire x of sensor 1 broken", &["axis_silent: sensor 1 x"], wire(1, 0.001)),
        case("wire y of sensor 2 broken", &["axis_silent: sensor 2 y"], wire(5, 0.004)),
        case("wire z of sensor 3 shorted to ground", &["axis_silent: sensor 3 z"], wire(9, 0.0)),
        case(
            "wire y of sensor 1 shorted to the supply",
            &["axis_at_supply: sensor 1 y"],
            wire(2, 3.0),
        ),
        case(
            "buffer of z of sensor 2 dead at 2.2 V",
            &["rest_level_out_of_range: sensor 2 z"],
            wire(6, 2.2),
        ),
        case(
            "buffer of x of sensor 3 dead at 1.0 V",
            &["rest_level_out_of_range: sensor 3 x"],
            wire(7, 1.0),
        ),
        case(
            "an input that reads the middle of the supply, not a sensor",
            &["channel_stuck: sensor 1 z"],
            |wires, _| wires[3] = 1.5,
        ),
        case(
            "solder bridge between y and z of sensor 3",
            &["channels_alike: sensor 3 z"],
            |wires, _| wires[9] = wires[8],
        ),
        case(
            "solder bridge between x of sensor 1 and 2",
            &["channels_alike: sensor 2 x"],
            |wires, _| wires[4] = wires[1],
        ),
        case("loose contact at y of sensor 3", &["channel_noisy: sensor 3 y"], |wires, time| {
            wires[8] += 0.01 * noise(time, 1)
        }),
        case("loose contact of the hammer", &["channel_noisy: the hammer"], |wires, time| {
            wires[0] += 0.01 * noise(time, 2)
        }),
        case("1 mV of 50 Hz in x of sensor 1", &["pick_up_50_hz: sensor 1 x"], |wires, time| {
            wires[1] += 1e-3 * tone(time, 50.2)
        }),
        case("1 mV of 60 Hz in z of sensor 2", &["pick_up_60_hz: sensor 2 z"], |wires, time| {
            wires[6] += 1e-3 * tone(time, 59.9)
        }),
        case(
            "a rectifier's 100 Hz in y of sensor 2",
            &["pick_up_50_hz: sensor 2 y"],
            |wires, time| wires[5] += 2e-3 * tone(time, 100.1),
        ),
        case("50 Hz in the hammer", &["pick_up_50_hz: the hammer"], |wires, time| {
            wires[0] += 2e-3 * tone(time, 49.8)
        }),
        case(
            "a ground loop of 60 Hz in sensor 1",
            &[
                "pick_up_60_hz: sensor 1 x",
                "pick_up_60_hz: sensor 1 y",
                "pick_up_60_hz: sensor 1 z",
            ],
            |wires, time| wires[1..4].iter_mut().for_each(|wire| *wire += 5e-3 * tone(time, 60.1)),
        ),
        case(
            "ripple of the screen in sensor 2",
            &[
                "screen_ripple: sensor 2 x",
                "screen_ripple: sensor 2 y",
                "screen_ripple: sensor 2 z",
            ],
            |wires, time| wires[4..7].iter_mut().for_each(|wire| *wire += 1e-3 * tone(time, 106.0)),
        ),
        case("no hammer", &["hammer_absent"], wire(0, 0.25)),
        Case {
            board: "pico2",
            ..case("no hammer, on a supply of 3.0 V", &["hammer_absent"], wire(0, 0.227))
        },
        case(
            "cable of sensor 1 the wrong way round",
            &["cable_reversed: sensor 1"],
            fed_through_x(0),
        ),
        Case {
            board: "blackpill-f411",
            ..case(
                "cable of sensor 2 the wrong way round",
                &["cable_reversed: sensor 2"],
                fed_through_x(1),
            )
        },
        case("hammer shorted, or KEY pressed", &["hammer_at_ground"], |wires, _| wires[0] = 0.0),
        case("hammer's conditioner at its end", &["hammer_at_supply"], wire(0, 2.97)),
        case("sensor 2 swings", &["not_at_rest: sensor 2"], |wires, time| {
            for (wire, share) in wires[4..7].iter_mut().zip([1.0, 0.5, 0.2]) {
                *wire += 3e-3 * share * tone(time, 1.4);
            }
        }),
        Case {
            calibration: tumbled(),
            ..case("sensor 3 is of another type", &["not_one_gravity: sensor 3"], other_type)
        },
        Case {
            board: "blackpill-f411",
            ..case("flash chip on PA4 to PA7", &["flash_on_inputs"], wire(4, 2.6))
        },
        Case { clock: Clock::Internal, ..case("dead crystal", &["crystal_dead"], |_, _| {}) },
        Case {
            supply: Supply { is_low: || true, brown_out: None, battery: None },
            ..case("supply too low", &["supply_too_low"], |_, _| {})
        },
    ];
    cases.push(breakout);
    cases
}

/// What the self-test of a virtual rig finds: the code and the subject of each finding.
fn examine(bench: &Bench, seed: u64, case: &Case) -> Vec<String> {
    let bench = BenchSource::new(bench, &three_bar().layout, seed).expect("the bench is sound");
    let source = Faulty { bench, effect: case.effect.clone(), scans: 0 };
    let (clock, supply) = (case.clock, case.supply);
    let options = VirtualRigOptions { clock, supply, ..VirtualRigOptions::new(Box::new(source)) };
    let rig = VirtualRig::start(options).expect("the rig starts");
    let mut client = connect(&rig);
    let adc = client.identify().unwrap().adc;
    client.rest_statistics().unwrap();
    let record = client.rest_record().unwrap().expect("the rig gives its record");
    let hardware = client.hardware().unwrap().unwrap();
    let check = Check::of(&record, &adc, case.board, &case.calibration, hardware);
    check.findings.iter().map(massline::self_test::name).collect()
}

/// Sensors without errors of zero, so that their nominal calibration is right.
fn bench() -> Bench {
    let mut bench = steady_hand("default");
    bench.sensor.zero_sigma_v = 0.0;
    bench
}

#[test]
fn every_fault_is_named_and_nothing_else_is() {
    let cases = cases();
    assert!(cases.len() >= 30, "{}", cases.len());
    let wrong: Vec<String> = cases
        .iter()
        .map(|case| (case, examine(&bench(), 1, case)))
        .filter(|(case, found)| *found != case.named)
        .map(|(case, found)| format!("{}: {found:?} instead of {:?}", case.name, case.named))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Sensors and hammers as they come, with as much hum, screen's ripple and slow motion as a sound rig may have.
#[test]
fn two_hundred_sound_rigs_pass() {
    let healthy = case("sound", &[], |wires, time| {
        for wire in &mut wires[1..] {
            // 2 mg of mains and 1 mg of the screen: the limit is 5 mg. 3 mg of swinging, of 20 mg.
            *wire +=
                114e-6 * tone(time, 50.0) + 57e-6 * tone(time, 105.0) + 171e-6 * tone(time, 1.1);
        }
    });
    let failed: Vec<_> = (1..=200)
        .map(|seed| (seed, examine(&steady_hand("default"), seed, &healthy)))
        .filter(|(_, found)| !found.is_empty())
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}
