//! Use of the pins, and the other parts of a board in its schematic.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::part::Part;

/// The table `wiring` of a board; `boards/parts.toml` describes what the pins are connected to.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wiring {
    /// The pin that supplies the parts around the board.
    pub supply: String,
    /// The sensors' supply, if it is another one.
    pub sensor_supply: Option<String>,
    /// Inputs of the hammer, then x, y, z of each sensor: pins of the board or of its external converter.
    pub channels: Vec<String>,
    /// The bus of the screen.
    pub screen: ScreenPins,
    /// Pins of the buttons, connected to ground while pressed.
    pub buttons: Buttons,
    /// Pin of a passive piezo buzzer.
    pub buzzer: String,
    /// Pin of the light on the board.
    pub light: String,
    /// The input to which some of these boards connect the select pin of a flash chip.
    pub flash_select: Option<String>,
    /// How a battery supplies the board.
    pub power: Power,
    /// Inputs of the converter at ground, which the firmware converts.
    #[serde(default)]
    pub grounded: Vec<String>,
    /// Pins that the firmware uses and that are connected on the board itself.
    #[serde(default)]
    pub on_board: Vec<String>,
    /// Pins with a resistor to ground, which the firmware does not use.
    #[serde(default)]
    pub pulled_down: Vec<String>,
    /// Sockets and headers.
    pub plug: Vec<Plug>,
    /// Parts of this board's rig alone, the board among them.
    pub part: Vec<Part>,
    /// External converter.
    pub adc: Option<Adc>,
    /// Label of a pin on the board's header, where it differs from the pin's name.
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

/// How a battery supplies the board.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Power {
    /// The pin that takes the voltage of the cell.
    pub battery: String,
    /// The pin with what the board's regulator gets, from USB or battery, if it is another one.
    pub raw: Option<String>,
    /// The board's regulator of 3.3 V.
    pub regulator: String,
    /// Efficiency of the regulator in percent; a linear one passes on the current as it is.
    pub efficiency_percent: Option<u32>,
    /// Lines about settings of the board and about what happens when USB is connected too.
    pub notes: Vec<String>,
}

/// An external converter, and its reference, which also supplies the sensors.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adc {
    /// How the unused pins are connected.
    pub note: String,
    /// Pairs of a pin of the converter and a pin of the board.
    pub wires: Vec<[String; 2]>,
    /// Pins at the board's supply.
    pub supply: String,
    /// Pins at the reference.
    pub reference: String,
    /// Pins at ground.
    pub ground: String,
    /// Two pins that are connected to each other.
    pub joined: [String; 2],
    /// Its capacitors: designator and the pin beside which it is.
    pub capacitors: Vec<[String; 2]>,
}

/// Pins that go to a plug.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plug {
    /// Label printed beside it.
    pub name: String,
    /// A remark.
    pub note: String,
    /// The pins.
    pub pins: Vec<String>,
}

impl Wiring {
    /// The channel of [`Self::flash_select`].
    pub fn flash_select_channel(&self) -> Option<u8> {
        let select = self.flash_select.as_ref()?;
        let channel = self.channels.iter().position(|channel| channel == select)?;
        u8::try_from(channel).ok()
    }

    /// The sensors' supply.
    pub fn sensor_rail(&self) -> &str {
        self.sensor_supply.as_deref().unwrap_or(&self.supply)
    }

    /// The pins that the firmware uses.
    pub fn firmware_pins(&self) -> impl Iterator<Item = &str> {
        let ScreenPins { scl, sda } = &self.screen;
        let Buttons { ok, back, next } = &self.buttons;
        let single = [scl, sda, ok, back, next, &self.buzzer, &self.light];
        // The SWD pins are used by the debugger.
        let plugs = self.plug.iter().filter(|plug| !plug.name.contains("SWD"));
        let plugs = plugs.flat_map(|plug| &plug.pins);
        let channels = self.channels.iter().filter(|_| self.adc.is_none());
        let wires = self.adc.iter().flat_map(|adc| adc.wires.iter().map(|[_, board]| board));
        let pins = channels
            .chain(wires)
            .chain(single)
            .chain(plugs)
            .chain(&self.grounded)
            .chain(&self.on_board);
        pins.map(String::as_str)
    }
}
