//! Circuit symbols. The position of a symbol is the point where it meets its wire.

use crate::pen::{Align, Pen};
use crate::trace::Point;

impl Pen {
    /// A ground symbol at the end of a wire.
    pub fn ground(&mut self, (x, y): Point) {
        let net = self.ground_net.clone();
        self.net((x, y), &net);
        for (down, half) in [(0, 9), (4, 6), (8, 3)] {
            self.line(&[(x - half, y + down), (x + half, y + down)]);
        }
    }

    /// A supply symbol at the end of a wire.
    pub fn supply(&mut self, (x, y): Point, name: &str) {
        self.net((x, y), name);
        self.line(&[(x - 9, y), (x + 9, y)]);
        self.text((x, y - 4), 11, Align::Middle, name);
    }

    /// The name of a net at the end of a wire, on the side to which the wire points.
    pub fn flag(&mut self, (x, y): Point, side: Align, name: &str) {
        self.net((x, y), name);
        let (tip, text) = match side {
            Align::Left => (x - 6, x - 10),
            Align::Middle | Align::Right => (x + 6, x + 10),
        };
        self.line(&[(x, y - 5), (tip, y), (x, y + 5), (x, y - 5)]);
        let align = if tip < x { Align::Right } else { Align::Left };
        self.text((text, y + 4), 11, align, name);
    }

    /// A capacitor from a wire down to ground.
    pub fn capacitor(&mut self, (x, y): Point, name: &str, value: &str) {
        self.joint((x, y));
        self.wire(&[(x, y), (x, y + 12)]);
        self.pin((x, y + 12), name, "1");
        self.line(&[(x - 9, y + 12), (x + 9, y + 12)]);
        self.line(&[(x - 9, y + 17), (x + 9, y + 17)]);
        self.pin((x, y + 17), name, "2");
        self.wire(&[(x, y + 17), (x, y + 28)]);
        self.ground((x, y + 28));
        self.label((x + 13, y + 13), &[name, value]);
    }

    /// A resistor in a wire that goes right; its length is 50.
    pub fn resistor(&mut self, (x, y): Point, name: &str, value: &str) {
        self.wire(&[(x, y), (x + 8, y)]);
        self.pin((x + 8, y), name, "1");
        self.part((x + 8, y - 6), (34, 12));
        self.pin((x + 42, y), name, "2");
        self.wire(&[(x + 42, y), (x + 50, y)]);
        self.text((x + 25, y - 10), 11, Align::Middle, name);
        self.text((x + 25, y + 18), 11, Align::Middle, value);
    }

    /// A resistor from a wire up to the supply (-1) or down to ground (1); its length is 56. Pin 1 is on top.
    pub fn resistor_to_rail(
        &mut self,
        (x, y): Point,
        way: i32,
        rail: &str,
        name: &str,
        value: &str,
    ) {
        self.joint((x, y));
        self.wire(&[(x, y), (x, y + 12 * way)]);
        let pins = if way < 0 { ["2", "1"] } else { ["1", "2"] };
        self.pin((x, y + 12 * way), name, pins[0]);
        self.part((x - 6, (y + 12 * way).min(y + 46 * way)), (12, 34));
        self.pin((x, y + 46 * way), name, pins[1]);
        self.wire(&[(x, y + 46 * way), (x, y + 56 * way)]);
        if way < 0 {
            self.supply((x, y - 56), rail);
        } else {
            self.ground((x, y + 56));
        }
        self.label((x + 12, y + 29 * way), &[name, value]);
    }

    /// Two diodes that clamp a wire between ground and the supply.
    pub fn clamp(&mut self, (x, y): Point, rail: &str, name: &str, value: &str) {
        self.joint((x, y));
        self.pin((x, y), name, "3");
        for top in [y - 38, y + 22] {
            // The cathodes are on top: current flows from ground to the wire, and from the wire to the
            // supply.
            self.line(&[(x - 9, top), (x + 9, top)]);
            self.line(&[(x, top), (x - 9, top + 15), (x + 9, top + 15), (x, top)]);
        }
        self.pin((x, y - 38), name, "2");
        self.wire(&[(x, y - 56), (x, y - 38)]);
        self.line(&[(x, y - 23), (x, y + 22)]);
        self.pin((x, y + 37), name, "1");
        self.wire(&[(x, y + 37), (x, y + 56)]);
        self.supply((x, y - 56), rail);
        self.ground((x, y + 56));
        self.label((x + 14, y - 36), &[name, value]);
    }

    /// An operational amplifier as a voltage follower of the input at `(x, y)`; returns the point of its
    /// output. `unit` is its letter in the package, `pins` the numbers of plus, minus and output.
    pub fn follower(&mut self, (x, y): Point, package: &str, unit: &str, pins: [u8; 3]) -> Point {
        let (left, tip, out) = (x + 26, x + 88, y + 13);
        let pins = pins.map(|pin| pin.to_string());
        self.wire(&[(x, y), (left, y)]);
        self.line(&[(left, y - 14), (tip, out), (left, y + 40), (left, y - 14)]);
        self.wire(&[(tip, out), (tip + 10, out)]);
        self.joint((tip + 10, out));
        let below = y + 48;
        self.wire(&[
            (tip + 10, out),
            (tip + 10, below),
            (x + 8, below),
            (x + 8, y + 26),
            (left, y + 26),
        ]);
        for (pin, at) in pins.iter().zip([(left, y), (left, y + 26), (tip, out)]) {
            self.pin(at, package, pin);
        }
        self.text((left + 5, y + 4), 11, Align::Left, "+");
        self.text((left + 5, y + 30), 11, Align::Left, "−");
        self.text((left + 15, y + 17), 11, Align::Left, &format!("{package}{unit}"));
        self.text((left - 3, y - 3), 9, Align::Right, &pins[0]);
        self.text((left - 3, y + 23), 9, Align::Right, &pins[1]);
        self.text((tip + 4, out - 7), 9, Align::Right, &pins[2]);
        (tip + 10, out)
    }

    /// The supply pins of a package, from a wire down to ground.
    pub fn supply_pins(&mut self, (x, y): Point, name: &str, [plus, minus]: [&str; 2]) {
        self.joint((x, y));
        self.wire(&[(x, y), (x, y + 10)]);
        self.pin((x, y + 10), name, plus);
        self.part((x - 16, y + 10), (32, 18));
        self.pin((x, y + 28), name, minus);
        self.wire(&[(x, y + 28), (x, y + 44)]);
        self.ground((x, y + 44));
        self.text((x, y + 23), 11, Align::Middle, name);
        self.text((x + 5, y + 8), 9, Align::Left, plus);
        self.text((x + 5, y + 38), 9, Align::Left, minus);
    }

    /// A push-button from a wire to ground.
    pub fn button(&mut self, (x, y): Point, part: &str, name: &str) {
        self.wire(&[(x - 3, y), (x + 4, y)]);
        self.pin((x + 4, y), part, "1");
        self.line(&[(x + 4, y - 9), (x + 40, y - 9)]);
        self.line(&[(x + 22, y - 9), (x + 22, y - 17)]);
        self.pin((x + 40, y), part, "2");
        self.wire(&[(x + 40, y), (x + 70, y), (x + 70, y + 8)]);
        for end in [x + 4, x + 40] {
            self.circle((end, y), 3, "#ffffff");
        }
        self.ground((x + 70, y + 8));
        self.text((x + 90, y + 4), 12, Align::Left, &format!("{part} {name}"));
    }

    /// A slide switch in a wire that goes right; its length is 50.
    pub fn switch(&mut self, (x, y): Point, name: &str) {
        self.wire(&[(x, y), (x + 8, y)]);
        self.pin((x + 8, y), name, "1");
        self.line(&[(x + 8, y), (x + 38, y - 12)]);
        self.pin((x + 42, y), name, "2");
        self.wire(&[(x + 42, y), (x + 50, y)]);
        for end in [x + 8, x + 42] {
            self.circle((end, y), 3, "#ffffff");
        }
        self.text((x + 25, y + 18), 11, Align::Middle, name);
    }

    /// A buzzer from a wire to ground.
    pub fn buzzer(&mut self, (x, y): Point, part: &str, name: &str) {
        self.add(format_args!(
            "<path d=\"M{x},{0} a14,14 0 0 1 0,28 z\" fill=\"#f4f1e8\"/>",
            y - 6
        ));
        self.wire(&[(x - 10, y), (x, y)]);
        self.pin((x, y), part, "1");
        self.pin((x, y + 16), part, "2");
        self.wire(&[(x, y + 16), (x - 10, y + 16), (x - 10, y + 26)]);
        self.ground((x - 10, y + 26));
        self.text((x + 24, y + 12), 12, Align::Left, &format!("{part} {name}"));
    }

    /// A box with pins on its sides: `(side, height below its top, name)`. Its pins lie on its edge.
    pub fn chip(
        &mut self,
        (x, y): Point,
        (width, height): (i32, i32),
        part: &str,
        pins: &[(Align, i32, &str)],
    ) {
        self.part((x, y), (width, height));
        for &(side, down, name) in pins {
            let (at, text) = match side {
                Align::Left | Align::Middle => (x, x + 7),
                Align::Right => (x + width, x + width - 7),
            };
            let align = if at == x { Align::Left } else { Align::Right };
            self.pin((at, y + down), part, name);
            self.text((text, y + down + 4), 11, align, name);
        }
    }
}
