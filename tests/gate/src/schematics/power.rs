//! Arranges the second sheet of a rig: cell, charger, power path and screen supply above, cables below.

use massline_boards::Wiring;

use crate::circuit::raw;
use crate::pen::{Align, Pen, Sheet};
use crate::source::{Cable, DrawnBoard, Parts};
use crate::title::{self, title};

const SIZE: (i32, i32) = (1330, 900);
/// Height of the cell's plus, and of its minus.
const PLUS: i32 = 150;
const MINUS: i32 = 210;
/// Top of the gauge, of the screen's regulator, and of the tables.
const GAUGE: i32 = 300;
const SCREEN: i32 = 330;
const NOTES: i32 = 510;
const TABLES: i32 = 630;
const LINE: i32 = 22;

/// Draws the sheet.
pub fn draw(parts: &Parts, board: &DrawnBoard) -> Sheet {
    let mut pen = Pen::new(SIZE.0, SIZE.1);
    title(&mut pen, parts, board, SIZE, title::SECOND);
    let mut sheet = Layout { pen: &mut pen, parts, board };
    sheet.cell();
    sheet.path();
    sheet.board();
    sheet.gauge();
    sheet.screen();
    sheet.notes();
    sheet.tables();
    pen.finish()
}

struct Layout<'a> {
    pen: &'a mut Pen,
    parts: &'a Parts,
    board: &'a DrawnBoard,
}

impl Layout<'_> {
    /// A box with the name and value of a part in its middle.
    fn chip(&mut self, at: (i32, i32), size: (i32, i32), part: &str, pins: &[(Align, i32, &str)]) {
        self.pen.chip(at, size, part, pins);
        let value = self.parts.value(self.board, part);
        let middle = (at.0 + size.0 / 2, at.1 + size.1);
        self.pen.text((middle.0, middle.1 + 16), 12, Align::Middle, &format!("{part} {value}"));
    }

    fn capacitor(&mut self, at: (i32, i32), name: &str) {
        let value = self.parts.value(self.board, name);
        self.pen.capacitor(at, name, &value);
    }

    /// Cell, plug, and the module that charges and protects it.
    fn cell(&mut self) {
        let rows = [(PLUS, ["+", "1", "B+"]), (MINUS, ["−", "2", "B−"])];
        let right = |name| [(Align::Right, 30, name), (Align::Right, 90, "−")];
        self.chip((50, PLUS - 30), (110, 120), "BT1", &right("+"));
        self.pen.part((230, PLUS - 30), (34, 120));
        self.pen.text((247, PLUS + 106), 12, Align::Middle, "J6 JST PH");
        let sides = [
            (Align::Left, 30, "B+"),
            (Align::Left, 90, "B−"),
            (Align::Right, 30, "OUT+"),
            (Align::Right, 90, "OUT−"),
        ];
        self.chip((340, PLUS - 30), (130, 120), "M2", &sides);
        self.pen.text((405, PLUS - 36), 11, Align::Middle, "USB-C, for charging only");
        for (line, text) in (0..).zip(["charger,", "protection"]) {
            self.pen.text((405, PLUS + 28 + 14 * line), 11, Align::Middle, text);
        }
        self.pen.text((96, PLUS + 34), 11, Align::Middle, "3.0 to 4.2 V");
        for (y, [_, contact, _]) in rows {
            self.pen.wire(&[(160, y), (230, y)]);
            self.pen.pin((230, y), "J6", contact);
            for x in [230, 264] {
                self.pen.net((x, y), &format!("J6 contact {contact}"));
            }
            self.pen.text((247, y + 4), 11, Align::Middle, contact);
            self.pen.wire(&[(264, y), (340, y)]);
        }
        self.pen.text((195, PLUS - 8), 11, Align::Middle, "W5");
        self.pen.wire(&[(470, MINUS), (494, MINUS), (494, MINUS + 8)]);
        self.pen.ground((494, MINUS + 8));
    }

    /// From the module over switch and ideal diode to the board.
    fn path(&mut self) {
        self.pen.wire(&[(470, PLUS), (530, PLUS), (580, PLUS)]);
        self.pen.wire(&[(530, PLUS), (530, PLUS - 10)]);
        self.pen.joint((530, PLUS));
        self.pen.supply((530, PLUS - 10), "BAT");
        self.pen.switch((580, PLUS), "S4");
        self.pen.wire(&[(630, PLUS), (660, PLUS), (710, PLUS), (740, PLUS)]);
        self.capacitor((660, PLUS), "C5");
        self.pen.wire(&[(710, PLUS), (710, PLUS + 30), (740, PLUS + 30)]);
        self.pen.joint((710, PLUS));
        let pins = [
            (Align::Left, 30, "VDD"),
            (Align::Left, 60, "EN"),
            (Align::Left, 90, "GND"),
            (Align::Right, 30, "OUT"),
        ];
        self.chip((740, PLUS - 30), (100, 120), "U5", &pins);
        self.pen.wire(&[(740, MINUS), (722, MINUS), (722, MINUS + 8)]);
        self.pen.ground((722, MINUS + 8));
        self.pen.wire(&[(840, PLUS), (870, PLUS), (910, PLUS), (1010, PLUS)]);
        self.pen.wire(&[(870, PLUS), (870, PLUS - 10)]);
        self.pen.joint((870, PLUS));
        self.pen.supply((870, PLUS - 10), "VSYS");
        self.capacitor((910, PLUS), "C6");
    }

    /// The pins of the board through which it is supplied.
    fn board(&mut self) {
        let power = &self.board.wiring.power;
        self.pen.part((1010, PLUS - 50), (200, 130));
        self.pen.text((1110, PLUS - 28), 14, Align::Middle, &self.board.title);
        let name = |pin: &str| match self.board.wiring.connector.get(pin) {
            Some(connector) => format!("{pin} · {connector}"),
            None => pin.to_owned(),
        };
        self.pen.text((1018, PLUS + 4), 12, Align::Left, &name(&power.battery));
        self.pen.pin((1010, PLUS), "M1", &power.battery);
        if let Some(pin) = &power.raw {
            self.pen.text((1202, PLUS + 4), 12, Align::Right, &name(pin));
            self.pen.pin((1210, PLUS), "M1", pin);
            self.pen.wire(&[(1210, PLUS), (1240, PLUS), (1240, PLUS - 10)]);
            self.pen.supply((1240, PLUS - 10), pin);
        }
        let supply = format!("makes {}; other pins: sheet 1", self.board.wiring.supply);
        self.pen.text((1110, PLUS + 40), 11, Align::Middle, &power.regulator);
        self.pen.text((1110, PLUS + 58), 11, Align::Middle, &supply);
    }

    /// The fuel gauge on the bus of the screen.
    fn gauge(&mut self) {
        let pins = [
            (Align::Left, 30, "VDD"),
            (Align::Left, 60, "CELL"),
            (Align::Left, 90, "GND"),
            (Align::Left, 115, "CTG"),
            (Align::Left, 140, "QSTRT"),
            (Align::Right, 30, "SCL"),
            (Align::Right, 60, "SDA"),
        ];
        self.chip((340, GAUGE), (130, 160), "U7", &pins);
        self.pen.text((462, GAUGE + 119), 11, Align::Right, "I²C 0x36");
        self.pen.text((462, GAUGE + 144), 11, Align::Right, "ALRT free");
        let y = GAUGE + 30;
        self.pen.wire(&[(340, y), (310, y), (210, y), (190, y), (190, y - 10)]);
        self.pen.supply((190, y - 10), "BAT");
        self.capacitor((210, y), "C9");
        self.pen.joint((310, y));
        self.pen.wire(&[(310, y), (310, y + 30), (340, y + 30)]);
        for down in [90, 115, 140] {
            self.pen.wire(&[(340, GAUGE + down), (310, GAUGE + down)]);
        }
        self.pen.wire(&[(310, GAUGE + 90), (310, GAUGE + 115)]);
        self.pen.wire(&[(310, GAUGE + 115), (310, GAUGE + 140)]);
        self.pen.wire(&[(310, GAUGE + 140), (310, GAUGE + 150)]);
        for down in [115, 140] {
            self.pen.joint((310, GAUGE + down));
        }
        self.pen.ground((310, GAUGE + 150));
        for (down, name) in [(30, "SCL"), (60, "SDA")] {
            self.pen.wire(&[(470, GAUGE + down), (500, GAUGE + down)]);
            self.pen.flag((500, GAUGE + down), Align::Right, name);
        }
    }

    /// The regulator of the screen.
    fn screen(&mut self) {
        let pins = [(Align::Left, 30, "VIN"), (Align::Left, 60, "GND"), (Align::Right, 30, "VOUT")];
        let y = SCREEN + 30;
        self.chip((740, SCREEN), (110, 90), "U6", &pins);
        self.pen.wire(&[(740, y), (700, y), (700, y - 10)]);
        self.pen.supply((700, y - 10), raw(&self.board.wiring));
        self.pen.wire(&[(740, y + 30), (700, y + 30), (700, y + 38)]);
        self.pen.ground((700, y + 38));
        self.pen.wire(&[(850, y), (890, y), (940, y), (940, y - 10)]);
        self.capacitor((890, y), "C8");
        self.pen.supply((940, y - 10), "3V3P");
        self.pen.text(
            (970, y + 4),
            12,
            Align::Left,
            "supplies the screen DS1, sheet 1, and nothing else",
        );
    }

    fn notes(&mut self) {
        for (line, note) in (0..).zip(&self.board.wiring.power.notes) {
            self.pen.text((50, NOTES + 20 * line), 12, Align::Left, note);
        }
    }

    /// The cables: what is at each contact.
    fn tables(&mut self) {
        let mut x = 50;
        for (cable, width) in self.parts.cable.iter().zip([250, 440, 230, 250]) {
            self.table((x, TABLES), width, cable);
            x += width + 20;
        }
    }

    fn table(&mut self, (x, y): (i32, i32), width: i32, cable: &Cable) {
        let sensors = cable.name.contains("{j}");
        let count = self.parts.sensor.count;
        let name = match sensors {
            true => format!("W2 to W{}", count + 1),
            false => cable.name.clone(),
        };
        let description =
            cable.what.replace("{n}", "1 to 3").replace(" at P1 to 3", " at P1 to P3");
        let (description, rest) = description.split_once("; ").unwrap_or((&description, ""));
        let (kind, description) = description.split_once(": ").unwrap_or(("", description));
        self.pen.text((x, y - 30), 12, Align::Left, &format!("{name}  {kind}"));
        self.pen.text((x, y - 12), 11, Align::Left, description);
        let column = |sensor: usize| x + 120 + 80 * sensor as i32;
        let mut at = y + 16;
        self.pen.line(&[(x, y), (x + width, y)]);
        if sensors {
            for sensor in 1..=count {
                let ends = format!("J{}, P{sensor}", sensor + 1);
                self.pen.text((column(sensor), at), 11, Align::Left, &ends);
            }
            self.pen.line(&[(x, at + 6), (x + width, at + 6)]);
            at += LINE;
        }
        for wire in &cable.wires {
            self.pen.text((x + 4, at), 11, Align::Left, &wire[0]);
            self.pen.text((x + 60, at), 11, Align::Left, &wire[1]);
            for sensor in (1..=count).filter(|_| sensors) {
                let pin = goes_to(&self.board.wiring, &wire[0], sensor);
                self.pen.text((column(sensor), at), 11, Align::Left, &pin);
            }
            self.pen.line(&[(x, at + 6), (x + width, at + 6)]);
            at += LINE;
        }
        self.pen.text((x, at), 11, Align::Left, rest);
    }
}

/// Where a contact of a sensor's cable leads.
pub fn goes_to(wiring: &Wiring, contact: &str, sensor: usize) -> String {
    let axis = ["2", "3", "4"].iter().position(|number| *number == contact);
    match (axis, contact) {
        (Some(axis), _) => wiring.channels[3 * sensor - 2 + axis].clone(),
        (None, "5") => wiring.sensor_rail().to_owned(),
        (None, _) => "GND".to_owned(),
    }
}
