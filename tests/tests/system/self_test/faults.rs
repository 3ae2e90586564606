//! Faults of wiring and parts, each with what it does to the inputs of a rig and the codes that must name it.

use std::sync::Arc;

use massline_firmware::board::{Clock, Supply};
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};
use massline_shared::units::Hertz;

use super::circuit::Circuit;
use super::{Rig, Wires, bench};

/// A rig with a fault.
pub struct Case {
    pub name: &'static str,
    pub rig: Rig,
    /// The codes that must be found, each with its subject in words, and no others.
    pub named: Vec<String>,
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

/// What stands at the inputs of a sensor, V.
fn all_axes(sensor: usize, volts: f64) -> impl Fn(&mut Wires, f64) + Send + Sync {
    move |wires, time| {
        for axis in 0..3 {
            wires[1 + 3 * sensor + axis] = volts + 1e-3 * noise(time, axis as u32);
        }
    }
}

/// The supply of a sensor arrives through its output x; y and z are exchanged and at half of what is left of it.
fn fed_through_x(
    circuit: &Circuit,
    sensor: usize,
) -> impl Fn(&mut Wires, f64) + Send + Sync + use<> {
    let (left, whole) = (circuit.fed_through_x(), circuit.at_supply());
    move |wires, time| {
        let [x, y, z] = [0, 1, 2].map(|axis| 1 + 3 * sensor + axis);
        let [of_y, of_z] = [wires[y], wires[z]].map(|volts| volts * left / whole);
        wires[x] = left + 1e-3 * noise(time, 5);
        (wires[y], wires[z]) = (of_z, of_y);
    }
}

fn wire(channel: usize, volts: f64) -> impl Fn(&mut Wires, f64) + Send + Sync {
    move |wires, time| wires[channel] = volts + 1e-3 * noise(time, 7)
}

/// A tone in some channels, V and Hz.
fn hum(
    channels: std::ops::Range<usize>,
    volts: f64,
    hertz: f64,
) -> impl Fn(&mut Wires, f64) + Send + Sync {
    move |wires, time| {
        wires[channels.clone()].iter_mut().for_each(|wire| *wire += volts * tone(time, hertz));
    }
}

/// Cases of rigs around one board.
struct Cases<'a> {
    circuit: &'a Circuit,
    list: Vec<Case>,
}

impl Cases<'_> {
    /// Adds a fault that changes the rig.
    fn change(&mut self, name: &'static str, named: &[&str], change: impl FnOnce(&mut Rig)) {
        let mut bench = bench(self.circuit.board);
        // The nominal calibration is right for sensors without errors of zero.
        bench.sensor.zero_sigma_v = 0.0;
        let mut rig = Rig::on(bench);
        change(&mut rig);
        let named = named.iter().map(ToString::to_string).collect();
        self.list.push(Case { name, rig, named });
    }

    /// Adds a fault that changes what stands at the inputs.
    fn add(
        &mut self,
        name: &'static str,
        named: &[&str],
        effect: impl Fn(&mut Wires, f64) + Send + Sync + 'static,
    ) {
        self.change(name, named, |rig| rig.effect = Arc::new(effect));
    }

    /// Adds a ripple of the supply that a sensor reads as 10 mg.
    fn ripple(&mut self, name: &'static str, hertz: f64) {
        let volts = self.circuit.ripple(570e-6, hertz);
        self.change(name, &["screen_in_all_sensors"], |rig| {
            (rig.bench.supply.ripple_v, rig.bench.supply.ripple_hz) = (volts, hertz);
        });
    }

    /// Adds a supply that sags by this, V, at random instants.
    fn droops(&mut self, name: &'static str, volts: f64) {
        self.change(name, &["supply_unsteady"], |rig| {
            let supply = &mut rig.bench.supply;
            (supply.droop_v, supply.droop_s, supply.droop_rate_per_s) = (volts, 2e-3, 10.0);
        });
    }

    /// Adds mains in all channels.
    fn mains(&mut self, name: &'static str, hertz: f64) {
        self.change(name, &["mains_in_all_channels"], |rig| {
            (rig.bench.mains.amplitude_v, rig.bench.mains.frequency_hz) = (1e-3, hertz);
        });
    }
}

/// Faults of rigs around a board.
pub fn cases(circuit: &Circuit) -> Vec<Case> {
    let mut cases = Cases { circuit, list: Vec::new() };
    sensors(&mut cases);
    wires(&mut cases);
    tones(&mut cases);
    hammer(&mut cases);
    others(&mut cases);
    cases.list
}

fn sensors(cases: &mut Cases<'_>) {
    let (open, supply) = (cases.circuit.open_input(), cases.circuit.at_supply());
    cases.add("sensor 1 not plugged in", &["sensor_silent: sensor 1"], all_axes(0, open));
    cases.add("sensor 2 not plugged in", &["sensor_silent: sensor 2"], all_axes(1, open));
    // What amplifiers do without a supply, with one the wrong way round, or without a ground, has no formula: levels
    // over the range that is possible.
    cases.add("supply of sensor 3 broken", &["sensor_silent: sensor 3"], all_axes(2, 0.03));
    cases.add("supply of sensor 1 swapped", &["sensor_reversed: sensor 1"], all_axes(0, 0.35));
    cases.add("supply of sensor 2 swapped", &["sensor_reversed: sensor 2"], all_axes(1, 0.42));
    cases.add("supply of sensor 3 swapped", &["sensor_reversed: sensor 3"], all_axes(2, 0.2));
    for (sensor, below) in [(0, 0.05), (1, 0.01), (2, 0.1)] {
        let named = format!("sensor_ground_open: sensor {}", sensor + 1);
        cases.add("ground of a sensor broken", &[&named], all_axes(sensor, supply - below));
    }
    for sensor in 0..3 {
        let named = format!("cable_reversed: sensor {}", sensor + 1);
        let effect = fed_through_x(cases.circuit, sensor);
        cases.add("cable of a sensor the wrong way round", &[&named], effect);
    }
    cases.add(
        "an input that reads the middle of the supply, not a sensor",
        &["channel_stuck: sensor 1 z"],
        |wires, _| wires[3] = 1.5,
    );
    cases.add("sensor 2 swings", &["not_at_rest: sensor 2"], |wires, time| {
        for (wire, share) in wires[4..7].iter_mut().zip([1.0, 0.5, 0.2]) {
            *wire += 3e-3 * share * tone(time, 1.4);
        }
    });
    cases.change("sensor 3 is of another type", &["not_one_gravity: sensor 3"], |rig| {
        rig.calibration =
            CalibrationRecord { method: CalibrationMethod::Tumble, ..CalibrationRecord::default() };
        rig.effect = Arc::new(|wires, _| {
            wires[7..10].iter_mut().for_each(|wire| *wire = 1.5 + 1.3 * (*wire - 1.5));
        });
    });
    let cutoff = cases.circuit.breakout_cutoff();
    cases.change(
        "100 nF left on the breakout of sensor 2, by the block test",
        &["capacitor_left: sensor 2 y"],
        |rig| rig.calibration.calibration.channels[5].cutoff = Hertz(cutoff as f32),
    );
}

fn wires(cases: &mut Cases<'_>) {
    let (open, supply) = (cases.circuit.open_input(), cases.circuit.at_supply());
    cases.add("wire x of sensor 1 broken", &["axis_silent: sensor 1 x"], wire(1, open));
    cases.add("wire y of sensor 2 broken", &["axis_silent: sensor 2 y"], wire(5, open));
    cases.add("wire z of sensor 3 shorted to ground", &["axis_silent: sensor 3 z"], wire(9, 0.0));
    cases.add(
        "wire y of sensor 1 shorted to the supply",
        &["axis_at_supply: sensor 1 y"],
        wire(2, supply),
    );
    cases.add(
        "buffer of z of sensor 2 dead at 2.2 V",
        &["rest_level_out_of_range: sensor 2 z"],
        wire(6, 2.2),
    );
    cases.add(
        "buffer of x of sensor 3 dead at 1.0 V",
        &["rest_level_out_of_range: sensor 3 x"],
        wire(7, 1.0),
    );
    cases.add(
        "solder bridge between y and z of sensor 3",
        &["channels_alike: sensor 3 z"],
        |wires, _| wires[9] = wires[8],
    );
    cases.add(
        "solder bridge between x of sensor 1 and 2",
        &["channels_alike: sensor 2 x"],
        |wires, _| wires[4] = wires[1],
    );
    cases.add("loose contact at y of sensor 3", &["channel_noisy: sensor 3 y"], |wires, time| {
        wires[8] += 0.01 * noise(time, 1);
    });
}

fn tones(cases: &mut Cases<'_>) {
    let [x1, y2, z2] = ["1 x", "2 y", "2 z"];
    let at = |code: &str, axis: &str| format!("{code}: sensor {axis}");
    for hertz in [49.6, 50.2] {
        cases.add(
            "1 mV of 50 Hz in x of sensor 1",
            &[&at("pick_up_50_hz", x1)],
            hum(1..2, 1e-3, hertz),
        );
        cases.add("50 Hz in the hammer", &["pick_up_50_hz: the hammer"], hum(0..1, 1e-3, hertz));
    }
    for hertz in [59.9, 60.4] {
        cases.add(
            "1 mV of 60 Hz in z of sensor 2",
            &[&at("pick_up_60_hz", z2)],
            hum(6..7, 1e-3, hertz),
        );
    }
    for hertz in [99.2, 100.1, 100.8] {
        cases.add("a rectifier's 100 Hz", &[&at("pick_up_50_hz", y2)], hum(5..6, 2e-3, hertz));
    }
    for hertz in [119.2, 120.8] {
        cases.add("a rectifier's 120 Hz", &[&at("pick_up_60_hz", y2)], hum(5..6, 2e-3, hertz));
    }
    let all_of = |code: &str| ["1 x", "1 y", "1 z"].map(|axis| at(code, axis));
    let ground = all_of("pick_up_60_hz");
    let names = ground.each_ref().map(String::as_str);
    cases.add("a ground loop of 60 Hz in sensor 1", &names, hum(1..4, 5e-3, 60.1));
    cases.mains("mains of 49.6 Hz in all channels", 49.6);
    cases.mains("mains of 60.4 Hz in all channels", 60.4);
    let ground = all_of("screen_ripple");
    let names = ground.each_ref().map(String::as_str);
    for hertz in [95.3, 104.0, 106.0, 115.2] {
        cases.add("ground of the screen through sensor 1", &names, hum(1..4, 1e-3, hertz));
    }
    cases.ripple("ripple of the screen, slowest", 94.5);
    cases.ripple("ripple of the screen at 96 Hz", 96.0);
    cases.ripple("ripple of the screen at 105 Hz", 105.0);
    cases.ripple("ripple of the screen at 114 Hz", 114.0);
    cases.ripple("ripple of the screen, fastest", 115.5);
}

fn hammer(cases: &mut Cases<'_>) {
    let (open, end) = (cases.circuit.hammer_open(), cases.circuit.hammer_at_end());
    cases.add("no hammer", &["hammer_absent"], wire(0, open));
    cases.add("hammer shorted, or KEY pressed", &["hammer_at_ground"], |wires, _| wires[0] = 0.0);
    cases.add("hammer's conditioner at its end", &["hammer_at_supply"], wire(0, end));
    cases.add("loose contact of the hammer", &["channel_noisy: the hammer"], |wires, time| {
        wires[0] += 0.01 * noise(time, 2);
    });
}

fn others(cases: &mut Cases<'_>) {
    if cases.circuit.board.name == "blackpill-f411" {
        let (select, open) = (cases.circuit.flash_select(), cases.circuit.open_input());
        cases.add("flash chip on PA4 to PA7", &["flash_on_inputs"], wire(4, select));
        let named = ["flash_on_inputs", "axis_silent: sensor 2 y", "axis_silent: sensor 2 z"];
        cases.add("flash chip, and sensor 2 not plugged in", &named, move |wires, time| {
            all_axes(1, open)(wires, time);
            wire(4, select)(wires, time);
        });
    }
    cases.droops("loose power wire", 0.2);
    cases.droops("loose power wire, worse", 0.4);
    cases.change("dead crystal", &["crystal_dead"], |rig| rig.clock = Clock::Internal);
    cases.change("supply too low", &["supply_too_low"], |rig| {
        rig.supply = Supply { is_low: || true, brown_out: None, battery: None };
    });
}
