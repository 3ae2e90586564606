//! Hammer and sensors, up to the inputs of the converter.

use super::{
    AMPLIFIERS, CABLE, END, FOLLOWERS, FREE, HAMMER, HAMMER_FOLLOWER, Layout, ROW, SENSOR, SENSORS,
};
use crate::pen::Align;

impl Layout<'_> {
    pub(super) fn hammer(&mut self) {
        let (y, rail) = (HAMMER, self.wiring.sensor_rail());
        self.pen.part((70, y - 30), (100, 76));
        self.pen.text((120, y - 10), 13, Align::Middle, "hammer");
        self.pen.text((120, y + 8), 11, Align::Middle, "0 to 5 V");
        let name = format!("J1 {}", self.value("J1"));
        self.pen.text((120, y + 34), 11, Align::Middle, &name);
        self.pen.pin((170, y), "J1", "hot");
        self.pen.pin((70, y + 30), "J1", "shell");
        self.pen.wire(&[(70, y + 30), (46, y + 30), (46, y + 38)]);
        self.pen.ground((46, y + 38));
        self.pen.resistor((170, y), "R1", &self.value("R1"));
        self.pen.wire(&[(220, y), (HAMMER_FOLLOWER, y)]);
        self.pen.resistor_to_rail((245, y), -1, rail, "R2", &self.value("R2"));
        self.pen.resistor_to_rail((245, y), 1, rail, "R3", &self.value("R3"));
        self.pen.clamp((315, y), &self.wiring.supply, "D1", &self.value("D1"));
        self.pen.capacitor((375, y), "C1", &self.value("C1"));
        let (unit, pins) = AMPLIFIERS[0];
        let out = self.pen.follower((HAMMER_FOLLOWER, y), "U4", unit, pins);
        self.pen.net(out, "U4A");
        self.pen.resistor(out, "R4", &self.value("R4"));
        self.input(0, out.0 + 50, out.1, "hammer");
    }

    /// The amplifier beside the hammer's.
    pub(super) fn free_amplifier(&mut self) {
        let (unit, pins) = AMPLIFIERS[1];
        self.pen.follower((HAMMER_FOLLOWER, FREE), "U4", unit, pins);
        self.pen.wire(&[(HAMMER_FOLLOWER, FREE), (HAMMER_FOLLOWER - 10, FREE)]);
        self.pen.flag((HAMMER_FOLLOWER - 10, FREE), Align::Left, "U4A");
        self.pen.text(
            (HAMMER_FOLLOWER - 16, FREE + 20),
            11,
            Align::Right,
            "free, or for a piezo disc",
        );
    }

    /// A sensor's board with its cable and its three channels.
    pub(super) fn sensor(&mut self, number: usize) {
        let top = SENSORS + (number as i32 - 1) * SENSOR;
        let name = format!("board at sensor {number}");
        let ground = format!("GND{number}");
        self.pen.frame((22, top - 34), (CABLE[0] + END - 12, SENSOR - 18), &name);
        self.on_ground(&ground, |sheet| sheet.accelerometer(number, top));
        for (axis, (unit, pins)) in AMPLIFIERS.into_iter().take(3).enumerate() {
            let (y, channel) = (top + axis as i32 * ROW, 3 * number - 2 + axis);
            self.pen.wire(&[(160, y), (FOLLOWERS, y)]);
            let capacitor = format!("C{number}{}", axis + 1);
            let value = self.value(&capacitor);
            self.on_ground(&ground, |sheet| sheet.pen.capacitor((190, y), &capacitor, &value));
            let package = format!("U{number}");
            let out = self.pen.follower((FOLLOWERS, y), &package, unit, pins);
            if axis == 2 {
                self.pen.net(out, &format!("U{number}C"));
            }
            let resistor = format!("R{number}{}", axis + 1);
            self.pen.resistor(out, &resistor, &self.value(&resistor));
            self.pen.wire(&[(out.0 + 50, out.1), (CABLE[0], out.1)]);
            let axis = ["x", "y", "z"][axis];
            self.input(channel, CABLE[1] + END, out.1, &format!("{number}{axis}"));
        }
        self.on_ground(&ground, |sheet| sheet.fourth(number, top + 3 * ROW + 14));
        self.cable(number, top);
    }

    pub(super) fn accelerometer(&mut self, number: usize, top: i32) {
        let (name, rail) = (format!("A{number}"), format!("VS{number}"));
        let pins = [
            (Align::Left, 24, "VS"),
            (Align::Left, 24 + ROW, "ST"),
            (Align::Left, 24 + 2 * ROW, "COM"),
            (Align::Right, 24, "X"),
            (Align::Right, 24 + ROW, "Y"),
            (Align::Right, 24 + 2 * ROW, "Z"),
        ];
        self.pen.chip((70, top - 24), (90, 2 * ROW + 40), &name, &pins);
        self.pen.text((115, top + ROW / 2 - 4), 13, Align::Middle, &name);
        self.pen.text((115, top + ROW / 2 + 14), 12, Align::Middle, &self.value(&name));
        self.pen.wire(&[(70, top), (46, top), (46, top - 6)]);
        self.pen.supply((46, top - 6), &rail);
        for y in [top + ROW, top + 2 * ROW] {
            self.pen.wire(&[(70, y), (46, y), (46, y + 8)]);
            self.pen.ground((46, y + 8));
        }
    }

    /// The fourth amplifier, which follows the third, and the supply of the board.
    pub(super) fn fourth(&mut self, number: usize, y: i32) {
        let (package, (unit, pins)) = (format!("U{number}"), AMPLIFIERS[3]);
        self.pen.follower((FOLLOWERS + 20, y), &package, unit, pins);
        self.pen.wire(&[(FOLLOWERS + 20, y), (FOLLOWERS + 14, y)]);
        self.pen.flag((FOLLOWERS + 14, y), Align::Left, &format!("U{number}C"));
        let y = y - 10;
        self.pen.wire(&[(46, y), (60, y), (124, y), (206, y)]);
        self.pen.wire(&[(46, y), (46, y - 4)]);
        self.pen.supply((46, y - 4), &format!("VS{number}"));
        for (x, at) in [(60, 4), (124, 5)] {
            let name = format!("C{number}{at}");
            self.pen.capacitor((x, y), &name, &self.value(&name));
        }
        self.pen.supply_pins((206, y), &package, ["4", "11"]);
    }

    /// The cable of a sensor: six wires from its board to the socket.
    pub(super) fn cable(&mut self, number: usize, top: i32) {
        let (here, socket) = (format!("P{number}"), format!("J{}", number + 1));
        let heights =
            [(1, -20), (2, 13), (3, 13 + ROW), (4, 13 + 2 * ROW), (5, 3 * ROW), (6, 3 * ROW + 34)];
        for (x, part) in CABLE.into_iter().zip([&here, &socket]) {
            self.pen.part((x, top - 58), (END, SENSOR - 18));
            self.pen.text((x + END / 2, top - 42), 11, Align::Middle, part);
        }
        for (pin, down) in heights {
            let (y, name) = (top + down, pin.to_string());
            self.pen.wire(&[(CABLE[0] + END, y), (CABLE[1], y)]);
            for (x, part) in CABLE.into_iter().zip([&here, &socket]) {
                self.pen.text((x + END / 2, y + 4), 11, Align::Middle, &name);
                // The contact is the same on both sides of its box.
                let side = if part == &here { [x, x + END] } else { [x + END, x] };
                self.pen.pin((side[0], y), part, &name);
                self.pen.net((side[0], y), &format!("{part} contact {name}"));
                self.pen.net((side[1], y), &format!("{part} contact {name}"));
            }
        }
        let middle = (CABLE[0] + END + CABLE[1]) / 2;
        // Between the wires of the ground and of x.
        self.pen.text((middle, top), 11, Align::Middle, &format!("W{}", number + 1));
        let (own, rail) = (format!("VS{number}"), self.wiring.sensor_rail());
        let sides = [
            (CABLE[0], -14, own.as_str(), format!("GND{number}")),
            (CABLE[1] + END, 14, rail, "GND".into()),
        ];
        for (x, out, rail, ground) in sides {
            let y = top + 3 * ROW;
            self.pen.wire(&[(x, y), (x + out, y), (x + out, y - 6)]);
            self.pen.supply((x + out, y - 6), rail);
            for y in [top - 20, top + 3 * ROW + 34] {
                self.pen.wire(&[(x, y), (x + out, y), (x + out, y + 6)]);
                self.on_ground(&ground, |sheet| sheet.pen.ground((x + out, y + 6)));
            }
        }
    }

    /// Draws with the ground of a small board.
    pub(super) fn on_ground(&mut self, net: &str, draw: impl FnOnce(&mut Self)) {
        net.clone_into(&mut self.pen.ground_net);
        draw(self);
        "GND".clone_into(&mut self.pen.ground_net);
    }
}
