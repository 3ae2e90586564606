//! The capacitors at the supplies of the main board, and the notes below.

use super::{Layout, SENSOR, SENSORS};
use crate::pen::Align;

impl Layout<'_> {
    /// The capacitors at the supplies of the main board.
    pub(super) fn supplies(&mut self) {
        let y = SENSORS + 3 * SENSOR + 22;
        let (supply, sensors) = (self.wiring.supply.as_str(), self.wiring.sensor_rail());
        let mut capacitors = vec![
            (supply, "C2".to_owned(), format!("at {supply}")),
            (supply, "C3".into(), "at U4".into()),
            (sensors, "C4".into(), "at J2 to J4".into()),
        ];
        if let Some(adc) = &self.wiring.adc {
            let rail = |place: &str| if adc.reference.contains(place) { sensors } else { supply };
            capacitors.extend(
                adc.capacitors
                    .iter()
                    .map(|[name, at]| (rail(at), name.clone(), format!("at {at}"))),
            );
        }
        let mut rails = vec![supply, sensors];
        rails.dedup();
        let mut x = 46;
        for rail in rails {
            let parts: Vec<_> = capacitors.iter().filter(|(other, ..)| *other == rail).collect();
            self.pen.supply((x, y - 10), rail);
            self.pen.wire(&[(x, y - 10), (x, y)]);
            let mut from = (x, y);
            for (number, (_, name, place)) in (0..).zip(parts) {
                let to = (x + 30 + 100 * number, y);
                self.pen.wire(&[from, to]);
                self.pen.capacitor(to, name, &self.value(name));
                self.pen.text((to.0 - 9, y + 54), 11, Align::Left, place);
                from = to;
            }
            if rail == supply {
                let to = (from.0 + 100, y);
                self.pen.wire(&[from, to]);
                self.pen.supply_pins(to, "U4", ["8", "4"]);
                from = to;
            }
            x = from.0 + 90;
        }
        self.notes(y + 92);
    }

    pub(super) fn notes(&mut self, y: i32) {
        let sensors = self.wiring.sensor_rail();
        let notes = [
            format!("U1 to U3, U4: {}, {}. VS1 to VS3 are {sensors} at the end of the \
                 cables.", self.value("U1"), self.value("U4")),
            "C1 and C11 to C33 are C0G: with 32 kΩ they make 497 Hz. C40 to C49 are beside the inputs.".to_owned(),
            format!("Grounds of sensors and hammer meet at one GND pin of the {},", self.board.title),
            "those of screen, buzzer and battery at another one. Cables and plugs: sheet 2.".to_owned(),
        ];
        for (line, note) in (0..).zip(&notes) {
            self.pen.text((46, y + 18 * line), 12, Align::Left, note);
        }
    }
}
