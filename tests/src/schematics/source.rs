//! What a schematic is drawn from.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// `boards/parts.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    pub sensor: Sensor,
    pub filter: Filter,
    pub buffer: Buffer,
    pub hammer: Hammer,
    pub screen: Screen,
    pub buzzer: Buzzer,
    pub decoupling: Decoupling,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    pub part: String,
    pub count: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Filter {
    pub capacitor: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buffer {
    pub part: String,
    pub resistor: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hammer {
    pub series: String,
    pub to_ground: String,
    pub to_supply: String,
    pub clamp: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Screen {
    pub part: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buzzer {
    pub resistor: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Decoupling {
    pub bulk: Bulk,
    pub each: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bulk {
    pub value: String,
    pub at_board: String,
    pub at_sensors: String,
}

/// `boards/<name>/wiring.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wiring {
    pub board: String,
    pub chip: String,
    pub supply: String,
    /// Of the sensors, where it is another.
    pub sensor_supply: Option<String>,
    /// Hammer, then x, y, z of each sensor: pins of the board, or of the converter beside it.
    pub channels: Vec<String>,
    pub screen: ScreenPins,
    pub buttons: Buttons,
    pub buzzer: String,
    pub light: String,
    pub plug: Vec<Plug>,
    /// A converter beside the board.
    pub adc: Option<Adc>,
    /// Where a pin comes out of the board, if that has another name.
    #[serde(default)]
    pub connector: BTreeMap<String, String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScreenPins {
    pub scl: String,
    pub sda: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buttons {
    pub ok: String,
    pub back: String,
    pub next: String,
}

/// A converter beside the board, and the reference that supplies the sensors too.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Adc {
    pub part: String,
    pub note: String,
    /// Its pins and those of the board.
    pub wires: Vec<[String; 2]>,
    /// Pins at the board's supply, at the reference, at ground.
    pub supply: String,
    pub reference: String,
    pub ground: String,
    /// Two pins that are joined.
    pub joined: [String; 2],
    pub reference_part: String,
    /// Value and place.
    pub capacitors: Vec<[String; 2]>,
}

/// Pins that go to a plug.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plug {
    pub name: String,
    pub note: String,
    pub pins: Vec<String>,
}

impl Wiring {
    /// What the sensors run on.
    pub fn sensor_rail(&self) -> &str {
        self.sensor_supply.as_deref().unwrap_or(&self.supply)
    }

    /// The pins that the firmware uses.
    #[cfg(test)]
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

/// Reads a TOML file.
pub fn read<T: DeserializeOwned>(path: &Path) -> anyhow::Result<T> {
    let name = || path.display().to_string();
    let text = fs::read_to_string(path).with_context(name)?;
    toml::from_str(&text).with_context(name)
}
