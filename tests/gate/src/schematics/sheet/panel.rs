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
        self.right(y, &wiring.supply, RIGHT + 70);
        self.pen.wire(&[(RIGHT + 70, y), (RIGHT + 70, y - 12)]);
        self.pen.supply((RIGHT + 70, y - 12), &wiring.supply);
        self.right(y + 40, "GND", RIGHT + 70);
        self.pen.wire(&[(RIGHT + 70, y + 40), (RIGHT + 70, y + 48)]);
        self.pen.ground((RIGHT + 70, y + 48));
        self.screen(y + 110);
        let buttons = &wiring.buttons;
        let names = [(&buttons.ok, "OK"), (&buttons.back, "Back"), (&buttons.next, "Next")];
        for (row, (pin, name)) in (0..).zip(names) {
            let y = y + 290 + 52 * row;
            self.right(y, pin, RIGHT + 70);
            self.pen.button((RIGHT + 73, y), &format!("S{}", row + 1), name);
        }
        let y = y + 455;
        self.right(y, &wiring.buzzer, RIGHT + 50);
        self.pen.resistor((RIGHT + 50, y), "R5", &self.value("R5"));
        self.pen.wire(&[(RIGHT + 100, y), (RIGHT + 120, y)]);
        self.pen.buzzer((RIGHT + 130, y), "BZ1", &self.value("BZ1"));
        self.right(y + 75, &wiring.light, RIGHT + 50);
        self.pen.text((RIGHT + 58, y + 79), 12, Align::Left, "the board's own light");
        for (row, pin) in wiring.pulled_down.iter().enumerate() {
            let (y, name) = (y + 125 + 50 * row as i32, pull_down(row));
            self.right(y, pin, RIGHT + 50);
            self.pen.resistor((RIGHT + 50, y), &name, &self.value(&name));
            self.pen.wire(&[(RIGHT + 100, y), (RIGHT + 120, y), (RIGHT + 120, y + 8)]);
            self.pen.ground((RIGHT + 120, y + 8));
        }
    }

    pub(super) fn screen(&mut self, y: i32) {
        self.pen.part((RIGHT + 120, y - 20), (150, 112));
        let name = format!("DS1 {}", self.value("DS1"));
        self.pen.text((RIGHT + 195, y + 66), 12, Align::Middle, &name);
        self.pen.text((RIGHT + 195, y + 82), 11, Align::Middle, "128 × 64, I²C");
        let pins = [(&self.wiring.screen.scl, "SCL"), (&self.wiring.screen.sda, "SDA")];
        for (row, (pin, name)) in (0..).zip(pins) {
            let y = y + 40 * row;
            self.right(y, pin, RIGHT + 120);
            self.pen.pin((RIGHT + 120, y), "DS1", name);
            self.pen.joint((RIGHT + 70, y));
            self.pen.wire(&[(RIGHT + 70, y), (RIGHT + 70, y - 14), (RIGHT + 78, y - 14)]);
            self.pen.flag((RIGHT + 78, y - 14), Align::Right, name);
            self.pen.text((RIGHT + 128, y + 4), 11, Align::Left, name);
        }
        self.pen.text((RIGHT + 262, y + 4), 11, Align::Right, "VCC");
        self.pen.pin((RIGHT + 270, y), "DS1", "VCC");
        self.pen.wire(&[(RIGHT + 270, y), (RIGHT + 300, y), (RIGHT + 330, y)]);
        self.pen.wire(&[(RIGHT + 300, y), (RIGHT + 300, y - 10)]);
        self.pen.joint((RIGHT + 300, y));
        self.pen.supply((RIGHT + 300, y - 10), "3V3P");
        self.pen.capacitor((RIGHT + 330, y), "C7", &self.value("C7"));
        self.pen.text((RIGHT + 262, y + 44), 11, Align::Right, "GND");
        self.pen.pin((RIGHT + 270, y + 40), "DS1", "GND");
        self.pen.wire(&[(RIGHT + 270, y + 40), (RIGHT + 290, y + 40), (RIGHT + 290, y + 48)]);
        self.pen.ground((RIGHT + 290, y + 48));
    }

    pub(super) fn plugs(&mut self) {
        let mut y = HAMMER + 660;
        for plug in &self.wiring.plug {
            y = self.plug(y, plug) + 36;
        }
    }

    /// Returns where it ends.
    pub(super) fn plug(&mut self, y: i32, plug: &Plug) -> i32 {
        self.pen.part((RIGHT + 120, y - 16), (210, 32 + 30));
        for (row, pin) in (0..).zip(&plug.pins) {
            self.right(y + 30 * row, pin, RIGHT + 120);
        }
        self.pen.text((RIGHT + 225, y + 12), 12, Align::Middle, &plug.name);
        self.pen.text((RIGHT + 225, y + 29), 11, Align::Middle, &plug.note);
        y + 62
    }
}
