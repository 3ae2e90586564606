//! What is on the right of the board: supply, screen, buttons, buzzer, plugs.

use massline_boards::wiring::Plug;

use super::{HAMMER, Layout, RIGHT};
use crate::circuit::pull_down;
use crate::pen::Align;

impl Layout<'_> {
    /// A pin on the right side of the board.
    pub(super) fn right(&mut self, y: i32, name: &str, to: i32) {
        self.pen.pin((RIGHT, y), "M1", name);
        let name = self.pin(name);
        self.pen.text((RIGHT - 8, y + 4), 12, Align::Right, &name);
        self.pen.wire(&[(RIGHT, y), (to, y)]);
    }

    pub(super) fn panel(&mut self) {
        let (wiring, y) = (self.wiring, HAMMER);
        self.right(y, &wiring.supply, 976);
        self.pen.wire(&[(976, y), (976, y - 12)]);
        self.pen.supply((976, y - 12), &wiring.supply);
        self.right(y + 40, "GND", 976);
        self.pen.wire(&[(976, y + 40), (976, y + 48)]);
        self.pen.ground((976, y + 48));
        self.screen(y + 110);
        let buttons = &wiring.buttons;
        let names = [(&buttons.ok, "OK"), (&buttons.back, "Back"), (&buttons.next, "Next")];
        for (row, (pin, name)) in (0..).zip(names) {
            let y = y + 290 + 52 * row;
            self.right(y, pin, 976);
            self.pen.button((979, y), &format!("S{}", row + 1), name);
        }
        let y = y + 455;
        self.right(y, &wiring.buzzer, 956);
        self.pen.resistor((956, y), "R5", &self.value("R5"));
        self.pen.wire(&[(1006, y), (1026, y)]);
        self.pen.buzzer((1036, y), "BZ1", &self.value("BZ1"));
        self.right(y + 75, &wiring.light, 956);
        self.pen.text((964, y + 79), 12, Align::Left, "the board's own light");
        for (row, pin) in wiring.pulled_down.iter().enumerate() {
            let (y, name) = (y + 125 + 50 * row as i32, pull_down(row));
            self.right(y, pin, 956);
            self.pen.resistor((956, y), &name, &self.value(&name));
            self.pen.wire(&[(1006, y), (1026, y), (1026, y + 8)]);
            self.pen.ground((1026, y + 8));
        }
    }

    pub(super) fn screen(&mut self, y: i32) {
        self.pen.part((1026, y - 20), (150, 112));
        let name = format!("DS1 {}", self.value("DS1"));
        self.pen.text((1101, y + 66), 12, Align::Middle, &name);
        self.pen.text((1101, y + 82), 11, Align::Middle, "128 × 64, I²C 0x3C");
        let pins = [(&self.wiring.screen.scl, "SCL"), (&self.wiring.screen.sda, "SDA")];
        for (row, (pin, name)) in (0..).zip(pins) {
            let y = y + 40 * row;
            self.right(y, pin, 1026);
            self.pen.pin((1026, y), "DS1", name);
            self.pen.joint((976, y));
            self.pen.wire(&[(976, y), (976, y - 14), (984, y - 14)]);
            self.pen.flag((984, y - 14), Align::Right, name);
            self.pen.text((1034, y + 4), 11, Align::Left, name);
        }
        self.pen.text((1168, y + 4), 11, Align::Right, "VCC");
        self.pen.pin((1176, y), "DS1", "VCC");
        self.pen.wire(&[(1176, y), (1206, y), (1236, y)]);
        self.pen.wire(&[(1206, y), (1206, y - 10)]);
        self.pen.joint((1206, y));
        self.pen.supply((1206, y - 10), "3V3P");
        self.pen.capacitor((1236, y), "C7", &self.value("C7"));
        self.pen.text((1168, y + 44), 11, Align::Right, "GND");
        self.pen.pin((1176, y + 40), "DS1", "GND");
        self.pen.wire(&[(1176, y + 40), (1196, y + 40), (1196, y + 48)]);
        self.pen.ground((1196, y + 48));
    }

    pub(super) fn plugs(&mut self) {
        let mut y = HAMMER + 660;
        for what in &self.wiring.plug {
            y = self.plug(y, what) + 36;
        }
    }

    /// Returns where it ends.
    pub(super) fn plug(&mut self, y: i32, what: &Plug) -> i32 {
        self.pen.part((1026, y - 16), (210, 32 + 30));
        for (row, pin) in (0..).zip(&what.pins) {
            self.right(y + 30 * row, pin, 1026);
        }
        self.pen.text((1131, y + 12), 12, Align::Middle, &what.name);
        self.pen.text((1131, y + 29), 11, Align::Middle, &what.note);
        y + 62
    }
}
