//! Arranges the schematic of a rig: sensors and hammer on the left, the board in the middle, panel and
//! plugs on the right, the supplies below.

use massline_boards::Wiring;
use massline_boards::wiring::{Adc, Plug};

use crate::pen::{Align, Pen};
use crate::source::{Drawn, Parts};

const SIZE: (i32, i32) = (1300, 1090);
/// Width of a converter between buffers and board.
const ADC: i32 = 270;
/// Height of a channel.
const ROW: i32 = 66;
/// Height of the hammer's wire, and of the first sensor's.
const HAMMER: i32 = 150;
const SENSORS: i32 = 290;
/// Left edge of the buffers.
const BUFFERS: i32 = 430;
/// Left and right edge of the board.
const LEFT: i32 = 690;
const RIGHT: i32 = 890;

/// Pin numbers of plus, minus and output of the four amplifiers in a package.
const AMPLIFIERS: [(&str, [u8; 3]); 4] =
    [("A", [3, 2, 1]), ("B", [5, 6, 7]), ("C", [10, 9, 8]), ("D", [12, 13, 14])];

/// The sheet as SVG.
pub fn draw(parts: &Parts, board: &Drawn) -> String {
    let wiring = &board.wiring;
    let beside = if wiring.adc.is_some() { ADC } else { 0 };
    let mut pen = Pen::new(SIZE.0 + beside, SIZE.1);
    let mut sheet = Sheet { pen: &mut pen, parts, board, wiring };
    sheet.title();
    sheet.hammer();
    for sensor in 0..parts.sensor.count {
        sheet.sensor(sensor);
    }
    if let Some(adc) = &wiring.adc {
        sheet.adc(adc);
    }
    sheet.pen.shift(beside);
    sheet.board();
    sheet.panel();
    for (row, plug) in (0..).zip(&wiring.plug) {
        sheet.plug(HAMMER + 545 + 75 * row, plug);
    }
    sheet.pen.unshift();
    sheet.supplies();
    pen.finish()
}

struct Sheet<'a> {
    pen: &'a mut Pen,
    parts: &'a Parts,
    board: &'a Drawn,
    wiring: &'a Wiring,
}

impl Sheet<'_> {
    fn title(&mut self) {
        let title = format!("massline on a {} ({})", self.board.title, self.board.chip);
        self.pen.text((40, 42), 20, Align::Left, &title);
    }

    fn board(&mut self) {
        self.block(RIGHT - LEFT, &self.board.title, &self.board.chip);
        match &self.wiring.adc {
            Some(adc) => {
                for (y, [_, pin]) in adc_wires(adc) {
                    self.pen.text((LEFT + 8, y + 4), 12, Align::Left, pin);
                }
            }
            None => self.inputs(),
        }
    }

    /// The box in which all channels end.
    fn block(&mut self, width: i32, name: &str, note: &str) {
        self.pen.part((LEFT, 90), (width, SENSORS + 9 * ROW - 80));
        self.pen.text((LEFT + width / 2, 114), 15, Align::Middle, name);
        self.pen.text((LEFT + width / 2, 132), 12, Align::Middle, note);
    }

    /// The names of the channels' pins.
    fn inputs(&mut self) {
        let wires = [HAMMER].into_iter().chain((0..).map(|row| SENSORS + row * ROW));
        for (y, pin) in wires.zip(&self.wiring.channels) {
            let pin = self.pin(pin);
            self.pen.text((LEFT + 8, y + 17), 12, Align::Left, &pin);
        }
    }

    /// A converter with its reference.
    fn adc(&mut self, adc: &Adc) {
        let (right, rail, reference) = (LEFT + 170, &self.wiring.supply, self.wiring.sensor_rail());
        self.block(right - LEFT, &adc.part, &adc.note);
        self.inputs();
        for (y, name) in [(175, &adc.supply), (235, &adc.reference)] {
            self.pen.text((right - 8, y + 4), 12, Align::Right, name);
            self.pen.wire(&[(right, y), (right + 24, y), (right + 24, y - 10)]);
        }
        self.pen.supply((right + 24, 165), rail);
        self.pen.supply((right + 24, 225), reference);
        self.pen.text((right - 8, 279), 12, Align::Right, &adc.ground);
        self.pen.wire(&[(right, 275), (right + 24, 275), (right + 24, 283)]);
        self.pen.ground((right + 24, 283));
        for (y, name) in [(335, &adc.joined[0]), (365, &adc.joined[1])] {
            self.pen.text((right - 8, y + 4), 12, Align::Right, name);
        }
        self.pen.wire(&[(right, 335), (right + 24, 335), (right + 24, 365), (right, 365)]);
        for (y, [pin, _]) in adc_wires(adc) {
            self.pen.text((right - 8, y + 4), 12, Align::Right, pin);
            self.pen.wire(&[(right, y), (LEFT + ADC, y)]);
        }
        self.reference(adc);
    }

    /// The voltage reference that supplies the sensors.
    fn reference(&mut self, adc: &Adc) {
        let (x, y) = (LEFT, 44);
        self.pen.part((x, y - 18), (110, 36));
        self.pen.text((x + 55, y + 5), 12, Align::Middle, &adc.reference_part);
        self.pen.wire(&[(x, y), (x - 30, y), (x - 30, y - 8)]);
        self.pen.supply((x - 30, y - 8), &self.wiring.supply);
        self.pen.wire(&[(x + 110, y), (x + 140, y), (x + 140, y - 8)]);
        self.pen.supply((x + 140, y - 8), self.wiring.sensor_rail());
        self.pen.wire(&[(x + 55, y + 18), (x + 55, y + 26)]);
        self.pen.ground((x + 55, y + 26));
    }

    /// The name of a pin, with the connector position where it is accessible.
    fn pin(&self, pin: &str) -> String {
        match self.wiring.connector.get(pin) {
            Some(connector) => format!("{pin} · {connector}"),
            None => pin.to_owned(),
        }
    }

    /// The buffer after a channel's filter, with its wire to the channel's pin.
    fn channel(&mut self, number: usize, y: i32, amplifier: (usize, usize), name: &str) {
        let (package, pins) = AMPLIFIERS[amplifier.1];
        let unit = format!("U{}{package}", amplifier.0 + 1);
        let (x, y) = self.pen.follower((BUFFERS, y), &unit, pins);
        let resistor = format!("R{}", number + 4);
        self.pen.resistor((x, y), &resistor, &self.parts.buffer.resistor);
        self.pen.wire(&[(x + 50, y), (LEFT, y)]);
        self.pen.text((LEFT - 6, y - 6), 12, Align::Right, name);
    }

    fn filter(&mut self, number: usize, x: i32, y: i32) {
        let name = format!("C{}", number + 1);
        self.pen.capacitor((x, y), &[&name, &self.parts.filter.capacitor]);
    }

    fn hammer(&mut self) {
        let (y, hammer, rail) = (HAMMER, &self.parts.hammer, self.wiring.sensor_rail());
        self.pen.part((70, y - 30), (100, 76));
        self.pen.text((120, y - 10), 13, Align::Middle, "hammer");
        self.pen.text((120, y + 8), 11, Align::Middle, "0 to 5 V");
        self.pen.text((120, y + 34), 11, Align::Middle, "BNC, J1");
        self.pen.wire(&[(70, y + 30), (46, y + 30), (46, y + 38)]);
        self.pen.ground((46, y + 38));
        self.pen.resistor((170, y), "R1", &hammer.series);
        self.pen.wire(&[(220, y), (BUFFERS, y)]);
        self.pen.resistor_to_rail((245, y), -1, rail, &["R2", &hammer.to_supply]);
        self.pen.resistor_to_rail((245, y), 1, rail, &["R3", &hammer.to_ground]);
        self.pen.clamp((315, y), &self.wiring.supply, &["D1", &hammer.clamp]);
        self.filter(0, 375, y);
        self.channel(0, y, (0, 3), "hammer");
    }

    fn sensor(&mut self, number: usize) {
        let top = SENSORS + number as i32 * 3 * ROW;
        self.pen.part((70, top - 24), (150, 2 * ROW + 48));
        let title = format!("sensor {}", number + 1);
        self.pen.text((135, top + ROW - 4), 13, Align::Middle, &title);
        self.pen.text((135, top + ROW + 14), 12, Align::Middle, &self.parts.sensor.part);
        self.pen.wire(&[(70, top), (46, top), (46, top - 10)]);
        self.pen.supply((46, top - 10), self.wiring.sensor_rail());
        self.pen.text((76, top + 4), 11, Align::Left, "VS");
        self.pen.wire(&[(70, top + 2 * ROW), (46, top + 2 * ROW), (46, top + 2 * ROW + 8)]);
        self.pen.ground((46, top + 2 * ROW + 8));
        self.pen.text((76, top + 2 * ROW + 4), 11, Align::Left, "GND");
        for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            let (y, channel) = (top + axis as i32 * ROW, 1 + 3 * number + axis);
            self.pen.text((212, y + 4), 11, Align::Right, name);
            self.pen.wire(&[(220, y), (BUFFERS, y)]);
            self.filter(channel, 330, y);
            self.channel(
                channel,
                y,
                (number, axis),
                &format!("{}{}", number + 1, name.to_lowercase()),
            );
        }
    }

    /// A pin on the right side of the board.
    fn right(&mut self, y: i32, name: &str, to: i32) {
        let name = self.pin(name);
        self.pen.text((RIGHT - 8, y + 4), 12, Align::Right, &name);
        self.pen.wire(&[(RIGHT, y), (to, y)]);
    }

    fn panel(&mut self) {
        let (wiring, y) = (self.wiring, HAMMER);
        self.right(y, &wiring.supply, 960);
        self.pen.wire(&[(960, y), (960, y - 12)]);
        self.pen.supply((960, y - 12), &wiring.supply);
        self.right(y + 40, "GND", 960);
        self.pen.wire(&[(960, y + 40), (960, y + 48)]);
        self.pen.ground((960, y + 48));
        self.screen(y + 100);
        let buttons = &wiring.buttons;
        let names = [(&buttons.ok, "OK"), (&buttons.back, "Back"), (&buttons.next, "Next")];
        for (row, (pin, name)) in (0..).zip(names) {
            let y = y + 250 + 52 * row;
            self.right(y, pin, 960);
            self.pen.button((963, y), name);
        }
        let y = y + 415;
        self.right(y, &wiring.buzzer, 940);
        self.pen.resistor((940, y), "R14", &self.parts.buzzer.resistor);
        self.pen.wire(&[(990, y), (1010, y)]);
        self.pen.buzzer((1020, y), "buzzer, passive piezo");
        self.right(y + 75, &wiring.light, 940);
        self.pen.text((948, y + 79), 12, Align::Left, "the board's own light");
    }

    fn screen(&mut self, y: i32) {
        self.pen.part((1010, y - 20), (150, 120));
        self.pen.text((1085, y + 76), 12, Align::Middle, &self.parts.screen.part);
        self.pen.text((1085, y + 92), 11, Align::Middle, "128 × 64, I²C 0x3C");
        let pins = [(&self.wiring.screen.scl, "SCL"), (&self.wiring.screen.sda, "SDA")];
        for (row, (pin, name)) in (0..).zip(pins) {
            self.right(y + 40 * row, pin, 1010);
            self.pen.text((1018, y + 40 * row + 4), 11, Align::Left, name);
        }
        self.pen.text((1152, y + 4), 11, Align::Right, "VCC");
        self.pen.wire(&[(1160, y), (1190, y), (1190, y - 10)]);
        self.pen.supply((1190, y - 10), &self.wiring.supply);
        self.pen.text((1152, y + 44), 11, Align::Right, "GND");
        self.pen.wire(&[(1160, y + 40), (1190, y + 40), (1190, y + 48)]);
        self.pen.ground((1190, y + 48));
    }

    fn plug(&mut self, y: i32, what: &Plug) {
        self.pen.part((1010, y - 16), (150, 32 + 30));
        for (row, pin) in (0..).zip(&what.pins) {
            self.right(y + 30 * row, pin, 1010);
        }
        self.pen.text((1085, y + 12), 12, Align::Middle, &what.name);
        self.pen.text((1085, y + 29), 11, Align::Middle, &what.note);
    }

    /// The capacitors at the supplies, and the supply pins of the buffers.
    fn supplies(&mut self) {
        let y = SENSORS + 9 * ROW + 70;
        let capacitors = capacitors(self.parts, self.wiring);
        let step = if capacitors.len() > 9 { 108 } else { 132 };
        let mut last = "";
        for (number, (rail, value, place)) in capacitors.iter().enumerate() {
            let (x, name) = (70 + step * number as i32, format!("C{}", number + 11));
            if *rail == last {
                self.pen.wire(&[(x - step, y), (x, y)]);
            } else {
                self.pen.wire(&[(x, y), (x - 24, y), (x - 24, y - 10)]);
                self.pen.supply((x - 24, y - 10), rail);
            }
            last = rail;
            self.pen.capacitor((x, y), &[&name, value]);
            self.pen.text((x - 9, y + 54), 10, Align::Left, place);
        }
        self.notes(y + 86);
    }

    fn notes(&mut self, y: i32) {
        let (amplifiers, rail) = (&self.parts.buffer.part, &self.wiring.supply);
        let sensors = self.wiring.sensor_rail();
        let notes = [
            format!(
                "U1 to U3: {amplifiers}; pin 4 to {rail}, pin 11 to GND. U2D and U3D are free: pin 12 to GND, \
                     pin 13 to pin 14; or U2D amplifies a piezo hammer."
            ),
            format!(
                "C1 to C10: C0G or film, beside the buffers. Take off the capacitors that a breakout brings at \
                     X, Y, Z. Sensors run on {sensors}, behind no regulator of their own."
            ),
            "Values and reasons: boards/README.md".to_owned(),
        ];
        for (line, note) in (0..).zip(&notes) {
            self.pen.text((46, y + 19 * line), 12, Align::Left, note);
        }
    }
}

/// The wires between converter and board, from top to bottom.
fn adc_wires(adc: &Adc) -> impl Iterator<Item = (i32, &[String; 2])> {
    (0..).map(|row| 430 + 40 * row).zip(&adc.wires)
}

/// Rail, value and location of each capacitor at a supply.
fn capacitors<'a>(parts: &'a Parts, wiring: &'a Wiring) -> Vec<(&'a str, &'a str, String)> {
    let (supply, sensors) = (wiring.supply.as_str(), wiring.sensor_rail());
    let (bulk, each) = (&parts.decoupling.bulk, parts.decoupling.each.as_str());
    let count = parts.sensor.count;
    let mut all = vec![(supply, bulk.value.as_str(), bulk.at_board.clone())];
    all.extend((1..=count).map(|n| (supply, each, format!("at U{n}, pin 4"))));
    all.push((supply, each, "at the OLED".into()));
    for [value, place] in wiring.adc.iter().flat_map(|adc| &adc.capacitors) {
        let rail = if place.contains("REF") { sensors } else { supply };
        all.push((rail, value, place.clone()));
    }
    all.push((sensors, &bulk.value, bulk.at_sensors.clone()));
    all.extend((1..=count).map(|n| (sensors, each, format!("at sensor {n}"))));
    all
}
