//! Which pin goes where, and what else of a board is drawn.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The table `wiring` of a board; `boards/parts.toml` says what is at the other end.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wiring {
    /// The pin that supplies what is around the board.
    pub supply: String,
    /// Of the sensors, where it is another.
    pub sensor_supply: Option<String>,
    /// Hammer, then x, y, z of each sensor: pins of the board, or of the converter beside it.
    pub channels: Vec<String>,
    /// The bus of the screen.
    pub screen: ScreenPins,
    /// Each to ground while pressed.
    pub buttons: Buttons,
    /// A passive piezo buzzer.
    pub buzzer: String,
    /// The light on the board.
    pub light: String,
    /// Sockets and headers.
    pub plug: Vec<Plug>,
    /// A converter beside the board.
    pub adc: Option<Adc>,
    /// Where a pin comes out of the board, if that has another name.
    #[serde(default)]
    pub connector: BTreeMap<String, String>,
}

/// The bus of the screen.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScreenPins {
    /// Clock.
    pub scl: String,
    /// Data.
    pub sda: String,
}

/// The three buttons.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buttons {
    /// OK.
    pub ok: String,
    /// Back.
    pub back: String,
    /// Next.
    pub next: String,
}

/// A converter beside the board, and the reference that supplies the sensors too.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adc {
    /// The converter.
    pub part: String,
    /// What is done with the pins that are not used.
    pub note: String,
    /// Its pins and those of the board.
    pub wires: Vec<[String; 2]>,
    /// Pins at the board's supply.
    pub supply: String,
    /// Pins at the reference.
    pub reference: String,
    /// Pins at ground.
    pub ground: String,
    /// Two pins that are joined.
    pub joined: [String; 2],
    /// The reference.
    pub reference_part: String,
    /// Value and place.
    pub capacitors: Vec<[String; 2]>,
}

/// Pins that go to a plug.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plug {
    /// What is printed beside it.
    pub name: String,
    /// A remark.
    pub note: String,
    /// The pins.
    pub pins: Vec<String>,
}

impl Wiring {
    /// What the sensors run on.
    pub fn sensor_rail(&self) -> &str {
        self.sensor_supply.as_deref().unwrap_or(&self.supply)
    }

    /// The pins that the firmware uses.
    pub fn firmware_pins(&self) -> impl Iterator<Item = &str> {
        let ScreenPins { scl, sda } = &self.screen;
        let Buttons { ok, back, next } = &self.buttons;
        let single = [scl, sda, ok, back, next, &self.buzzer, &self.light];
        // SWD is the debugger's.
        let plugs = self.plug.iter().filter(|plug| !plug.name.contains("SWD"));
        let plugs = plugs.flat_map(|plug| &plug.pins);
        let channels = self.channels.iter().filter(|_| self.adc.is_none());
        let wires = self.adc.iter().flat_map(|adc| adc.wires.iter().map(|[_, board]| board));
        let all = channels.chain(wires).chain(single).chain(plugs);
        all.map(String::as_str)
    }
}
