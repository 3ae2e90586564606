//! What the inputs of a rig read by its circuit: the values of `boards/parts.toml`, and the converter of each board.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;

use massline_boards::Part;
use massline_boards::part::in_si;
use massline_shared::signal::{AdcProperties, Calibration};
use massline_shared::units::Volts;
use serde::Deserialize;

/// Leakage of a converter's input, assumed on the high side, A.
const LEAKAGE: f64 = 1e-7;
/// Voltage of a diode that protects an output, assumed, V.
const DIODE: f64 = 0.6;
/// Largest output of a hammer's conditioner, V.
const CONDITIONER_END: f64 = 5.0;
/// Pull-up of a flash chip's select pin, assumed, Ω.
const SELECT_PULL_UP: f64 = 10e3;
/// Capacitor on a breakout as it is sold, F.
const BREAKOUT: f64 = 100e-9;

/// A board with a chip.
#[derive(Clone, Copy, Debug)]
pub struct RealBoard {
    pub name: &'static str,
    pub adc: AdcProperties,
    /// Supply of the sensors, which is the converter's reference, V. The codes of an STM32 are corrected to 3.0 V.
    pub supply: f64,
}

/// All of them.
pub fn boards() -> [RealBoard; 3] {
    let board = |name, adc, supply| RealBoard { name, adc, supply };
    let at_three_volts = Volts(3.0);
    [
        board("blackpill-f411", massline_blackpill_f411::plan::properties(at_three_volts), 3.3),
        board("nucleo-g474re", massline_nucleo_g474re::plan::properties(at_three_volts), 3.3),
        board("pico2", massline_pico2::plan::PROPERTIES, 3.0),
    ]
}

#[derive(Deserialize)]
struct PartsFile {
    part: Vec<Part>,
}

/// The circuit around a board.
#[derive(Debug)]
pub struct Circuit {
    pub board: RealBoard,
    /// Values in Ω and F by designator.
    values: BTreeMap<String, f64>,
    /// Current of a sensor with its followers, A.
    sensor_current: f64,
}

impl Circuit {
    pub fn around(board: RealBoard) -> Self {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../boards/parts.toml");
        let text = fs::read_to_string(path).expect("the parts are there");
        let PartsFile { part: parts } = toml::from_str(&text).expect("the parts are well-formed");
        let named = |name: &str| {
            parts.iter().find(move |part| part.designators(3).iter().any(|other| other == name))
        };
        let microamps: u32 =
            ["A1", "U1"].iter().filter_map(|name| Some(named(name)?.microamps)).sum();
        let values = parts.iter().filter_map(|part| Some((part, in_si(&part.value)?)));
        let values = values.flat_map(|(part, value)| {
            part.designators(3).into_iter().map(move |name| (name, value))
        });
        Self { board, values: values.collect(), sensor_current: f64::from(microamps) * 1e-6 }
    }

    /// The value of a part, Ω or F.
    fn value(&self, name: &str) -> f64 {
        *self.values.get(name).unwrap_or_else(|| panic!("{name} has no value"))
    }

    /// What a sensor's channel reads at this voltage at its input, V: sensors and converter share a supply.
    fn read(&self, volts: f64) -> f64 {
        volts * f64::from(self.board.adc.reference.0) / self.board.supply
    }

    /// The reading of an input at the supply.
    pub fn at_supply(&self) -> f64 {
        self.read(self.board.supply)
    }

    /// The reading of a sensor's input to which nothing is connected: its leakage in the pull-down.
    pub fn open_input(&self) -> f64 {
        self.read(LEAKAGE * self.value("R41"))
    }

    /// The reading of the hammer's input with a conditioner at this voltage, or with nothing plugged in.
    fn hammer(&self, conditioner: Option<f64>) -> f64 {
        let [series, up, down] = ["R1", "R2", "R3"].map(|name| self.value(name).recip());
        let plugged = conditioner.map_or([0.0; 2], |volts| [volts * series, series]);
        (plugged[0] + self.board.supply * up) / (plugged[1] + up + down)
    }

    /// With nothing plugged in.
    pub fn hammer_open(&self) -> f64 {
        self.hammer(None)
    }

    /// With a conditioner at the end of its range.
    pub fn hammer_at_end(&self) -> f64 {
        self.hammer(Some(CONDITIONER_END))
    }

    /// The reading of x of a sensor whose cable is the wrong way round: contact 5 feeds the output of x, and from there
    /// through its resistor and a diode the sensor, whose supply is at the input of x.
    pub fn fed_through_x(&self) -> f64 {
        self.read(self.board.supply - self.sensor_current * self.value("R11") - DIODE)
    }

    /// The reading of an input with the select pin of a flash chip, which drives more than a follower without supply.
    pub fn flash_select(&self) -> f64 {
        let down = self.value("R44");
        self.read(self.board.supply * down / (down + SELECT_PULL_UP))
    }

    /// Cutoff of a channel whose breakout has its own capacitor, Hz.
    pub fn breakout_cutoff(&self) -> f64 {
        (TAU * Calibration::ADXL326_OUTPUT_OHM * (self.value("C11") + BREAKOUT)).recip()
    }

    /// Ripple of the supply that a sensor in the middle of it reads as this, V: the converter follows at once, the
    /// sensor through its low-pass.
    pub fn ripple(&self, read_v: f64, hertz: f64) -> f64 {
        let x = TAU * hertz * Calibration::ADXL326_OUTPUT_OHM * self.value("C11");
        let middle = Calibration::ADXL326_ZERO.0 / self.board.supply;
        read_v / (middle * x / x.hypot(1.0))
    }

    /// How far the supply sags by a current, V: 0.5 Ω as in `boards/POWER.md`.
    pub fn droop(&self, ampere: f64) -> f64 {
        0.5 * ampere
    }

    /// Current of the buzzer while its pin is high, A.
    pub fn buzzer(&self) -> f64 {
        self.board.supply / self.value("R5")
    }
}

/// By hand.
#[test]
fn the_levels_are_those_of_a_calculation_by_hand() {
    let [blackpill, _, pico] = boards().map(Circuit::around);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4, "{a} {b}");
    // 3.3 V · 82/1082, and 3.0 V.
    close(blackpill.hammer_open(), 0.25009);
    close(pico.hammer_open(), 0.22736);
    // (5/56 + 3.3/1000) / (1/56 + 1/1000 + 1/82), in kΩ.
    close(blackpill.hammer_at_end(), 2.98163);
    // 100 nA · 100 kΩ · 3.0/3.3.
    close(blackpill.open_input(), 0.00909);
    // (3.3 V - 0.75 mA · 100 Ω - 0.6 V) · 3.0/3.3.
    close(blackpill.fed_through_x(), 2.38636);
    close(pico.fed_through_x(), 2.325);
    // 3.0 V · 100/110.
    close(blackpill.flash_select(), 2.72727);
    // 1/(2π · 32 kΩ · 110 nF).
    close(blackpill.breakout_cutoff(), 45.2145);
    // A tenth: x = 0.21112, x/√(1 + x²) = 0.20657, and 1.5/3.3 of that.
    close(0.1 * blackpill.ripple(1.0, 105.0), 1.06501);
    // 3.3 V in 1 kΩ.
    close(blackpill.droop(blackpill.buzzer()), 0.00165);
}
