//! An external converter with its reference.

use massline_boards::wiring::Adc;

use super::{ADC, LEFT, Layout, adc_wires};
use crate::pen::Align;

impl Layout<'_> {
    /// A converter with its reference.
    pub(super) fn adc(&mut self, adc: &Adc) {
        let (right, rail, reference) = (LEFT + 170, &self.wiring.supply, self.wiring.sensor_rail());
        let name = format!("U8 {}", self.value("U8"));
        self.block(right - LEFT, &name, &adc.note);
        self.inputs("U8");
        for (y, name, rail) in [(175, &adc.supply, rail.as_str()), (235, &adc.reference, reference)]
        {
            self.pen.text((right - 8, y + 4), 12, Align::Right, name);
            self.pen.pin((right, y), "U8", name);
            self.pen.wire(&[(right, y), (right + 24, y), (right + 24, y - 10)]);
            self.pen.supply((right + 24, y - 10), rail);
        }
        self.pen.text((right - 8, 279), 12, Align::Right, &adc.ground);
        self.pen.pin((right, 275), "U8", &adc.ground);
        self.pen.wire(&[(right, 275), (right + 24, 275), (right + 24, 283)]);
        self.pen.ground((right + 24, 283));
        for (y, name) in [(335, &adc.joined[0]), (365, &adc.joined[1])] {
            self.pen.text((right - 8, y + 4), 12, Align::Right, name);
            self.pen.pin((right, y), "U8", name);
        }
        self.pen.wire(&[(right, 335), (right + 24, 335), (right + 24, 365), (right, 365)]);
        for (y, [pin, _]) in adc_wires(adc) {
            self.pen.text((right - 8, y + 4), 12, Align::Right, pin);
            self.pen.pin((right, y), "U8", pin);
            self.pen.wire(&[(right, y), (LEFT + ADC, y)]);
        }
        self.reference();
    }

    /// The voltage reference that supplies the sensors.
    pub(super) fn reference(&mut self) {
        let (x, y) = (LEFT, 44);
        self.pen.part((x, y - 18), (110, 36));
        let name = format!("U9 {}", self.value("U9"));
        self.pen.text((x + 55, y + 5), 12, Align::Middle, &name);
        for (at, pin) in [((x, y), "IN"), ((x + 110, y), "OUT"), ((x + 55, y + 18), "GND")] {
            self.pen.pin(at, "U9", pin);
        }
        self.pen.wire(&[(x, y), (x - 30, y), (x - 30, y - 8)]);
        self.pen.supply((x - 30, y - 8), &self.wiring.supply);
        self.pen.wire(&[(x + 110, y), (x + 140, y), (x + 140, y - 8)]);
        self.pen.supply((x + 140, y - 8), self.wiring.sensor_rail());
        self.pen.wire(&[(x + 55, y + 18), (x + 55, y + 26)]);
        self.pen.ground((x + 55, y + 26));
    }
}
