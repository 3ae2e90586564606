//! The files from which a schematic is drawn.

use std::fs;
use std::path::Path;

use anyhow::Context;
use massline_boards::{Board, Wiring};
use serde::Deserialize;

/// Contents of `boards/parts.toml`.
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

/// A board that has a schematic.
#[derive(Debug)]
pub struct Drawn {
    /// Its folder under `boards/`.
    pub name: String,
    pub title: String,
    pub chip: String,
    pub wiring: Wiring,
}

/// Every board with a chip.
pub fn boards(root: &Path) -> anyhow::Result<Vec<Drawn>> {
    let drawn = |board: Board| {
        let Board { name, title, chip, wiring, .. } = board;
        Some(Drawn { name, title, chip: chip?.name, wiring: wiring? })
    };
    Ok(massline_boards::boards(root)?.into_iter().filter_map(drawn).collect())
}

/// Reads `boards/parts.toml`.
pub fn parts(root: &Path) -> anyhow::Result<Parts> {
    let path = root.join("boards/parts.toml");
    let name = || path.display().to_string();
    let text = fs::read_to_string(&path).with_context(name)?;
    toml::from_str(&text).with_context(name)
}
