//! Arranges the first sheet of a rig: sensors and hammer on the left, the board in the middle, panel and plugs on
//! the right, the supplies below.

mod converter;
mod panel;
mod sensors;
mod supplies;

use massline_boards::Wiring;
use massline_boards::wiring::Adc;

use crate::pen::{Align, Pen, Sheet};
use crate::source::{DrawnBoard, Parts};
use crate::title::{self, title};

const SIZE: (i32, i32) = (1410, 1656);
/// Width of a converter between sensors and board.
const ADC: i32 = 270;
/// Height of a channel, and of a sensor with its fourth amplifier.
const ROW: i32 = 74;
const SENSOR: i32 = 4 * ROW + 52;
/// Height of the hammer's wire, of the free amplifier, and of the first sensor's wire.
const HAMMER: i32 = 150;
const FREE: i32 = 240;
const SENSORS: i32 = 362;
/// Left edges of the followers of the sensors and of the hammer.
const FOLLOWERS: i32 = 252;
const HAMMER_FOLLOWER: i32 = 430;
/// Left edges of the ends of a sensor's cable; both are this wide.
const CABLE: [i32; 2] = [446, 546];
const END: i32 = 34;
/// Where the resistor and the capacitor at an input are.
const PULL_DOWN: i32 = 624;
const INPUT: i32 = 702;
/// Left and right edge of the board.
const LEFT: i32 = 786;
const RIGHT: i32 = 986;

/// Pin numbers of plus, minus and output of the four amplifiers in a package.
const AMPLIFIERS: [(&str, [u8; 3]); 4] =
    [("A", [3, 2, 1]), ("B", [5, 6, 7]), ("C", [10, 9, 8]), ("D", [12, 13, 14])];

/// Draws the sheet.
pub fn draw(parts: &Parts, board: &DrawnBoard) -> Sheet {
    let wiring = &board.wiring;
    let beside = if wiring.adc.is_some() { ADC } else { 0 };
    let size = (SIZE.0 + beside, SIZE.1);
    let mut pen = Pen::new(size.0, size.1);
    let mut sheet = Layout { pen: &mut pen, parts, board, wiring };
    title(sheet.pen, parts, board, size, title::FIRST);
    sheet.hammer();
    sheet.free_amplifier();
    for sensor in 1..=parts.sensor.count {
        sheet.sensor(sensor);
    }
    if let Some(adc) = &wiring.adc {
        sheet.adc(adc);
    }
    sheet.pen.shift(beside);
    sheet.board();
    sheet.grounded();
    sheet.panel();
    sheet.plugs();
    sheet.pen.unshift();
    sheet.supplies();
    pen.finish()
}

struct Layout<'a> {
    pen: &'a mut Pen,
    parts: &'a Parts,
    board: &'a DrawnBoard,
    wiring: &'a Wiring,
}

impl Layout<'_> {
    fn value(&self, name: &str) -> String {
        self.parts.value(self.board, name)
    }

    fn board(&mut self) {
        self.block(RIGHT - LEFT, &self.board.title, &self.board.chip);
        match &self.wiring.adc {
            Some(adc) => {
                for (y, [_, pin]) in adc_wires(adc) {
                    self.pen.text((LEFT + 8, y + 4), 12, Align::Left, pin);
                    self.pen.pin((LEFT, y), "M1", pin);
                }
            }
            None => self.inputs("M1"),
        }
    }

    /// The box in which all channels end.
    fn block(&mut self, width: i32, name: &str, note: &str) {
        self.pen.part((LEFT, 90), (width, SENSORS + 3 * SENSOR - 160));
        self.pen.text((LEFT + width / 2, 114), 15, Align::Middle, name);
        self.pen.text((LEFT + width / 2, 132), 12, Align::Middle, note);
    }

    /// The channels' pins.
    fn inputs(&mut self, part: &str) {
        let rows = (0..).map(|row| SENSORS + row / 3 * SENSOR + row % 3 * ROW);
        for (y, pin) in [HAMMER].into_iter().chain(rows).zip(&self.wiring.channels) {
            self.pen.pin((LEFT, y + 13), part, pin);
            let pin = self.pin(pin);
            self.pen.text((LEFT + 8, y + 17), 12, Align::Left, &pin);
        }
    }

    /// Inputs of the board that are connected to ground.
    fn grounded(&mut self) {
        for (row, pin) in (0..).zip(&self.wiring.grounded) {
            let y = FREE + 30 * row;
            self.pen.pin((LEFT, y), "M1", pin);
            let pin = self.pin(pin);
            self.pen.wire(&[(LEFT, y), (LEFT - 30, y), (LEFT - 30, y + 8)]);
            self.pen.ground((LEFT - 30, y + 8));
            self.pen.text((LEFT + 8, y + 4), 12, Align::Left, &pin);
        }
    }

    /// The name of a pin, with the connector position where it is accessible.
    fn pin(&self, pin: &str) -> String {
        match self.wiring.connector.get(pin) {
            Some(connector) => format!("{pin} · {connector}"),
            None => pin.to_owned(),
        }
    }

    /// The end of a channel: its wire from `x` to the converter, with the capacitor at the input, and a sensor's with
    /// the resistor that brings it to 0 V when nothing is plugged in.
    fn input(&mut self, number: usize, x: i32, y: i32, name: &str) {
        self.pen.wire(&[(x, y), (LEFT, y)]);
        if number > 0 {
            let resistor = format!("R4{number}");
            let value = self.value(&resistor);
            self.pen.resistor_to_rail((PULL_DOWN, y), 1, "GND", &resistor, &value);
        }
        let capacitor = format!("C4{number}");
        self.pen.capacitor((INPUT, y), &capacitor, &self.value(&capacitor));
        self.pen.text((LEFT - 6, y - 6), 12, Align::Right, name);
    }
}

/// The wires between converter and board, from top to bottom.
fn adc_wires(adc: &Adc) -> impl Iterator<Item = (i32, &[String; 2])> {
    (0..).map(|row| 430 + 40 * row).zip(&adc.wires)
}
