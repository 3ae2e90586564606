//! The files from which a schematic is drawn.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::Context;
use massline_boards::{Board, Part, Wiring};
use serde::Deserialize;

/// What is connected to what: part, pin, net.
pub type Netlist = BTreeMap<String, BTreeMap<String, String>>;

/// Contents of `boards/parts.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    pub revision: Revision,
    pub cell: Cell,
    pub netlist: Netlist,
    pub sensor: Sensor,
    pub cable: Vec<Cable>,
    pub part: Vec<Part>,
}

/// The revision of the circuit.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Revision {
    pub name: String,
    pub date: String,
    pub licence: String,
    pub state: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cell {
    pub milliamp_hours: u32,
    pub usable_percent: u32,
    pub millivolts: u32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensor {
    pub count: usize,
    pub netlist: Netlist,
}

/// A cable or plug: its ends, and at each contact its name, what it carries, and the other end's name if it differs.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cable {
    pub name: String,
    pub what: String,
    pub ends: Vec<String>,
    pub wires: Vec<Vec<String>>,
}

/// A board that has a schematic.
#[derive(Debug)]
pub struct DrawnBoard {
    /// Its folder under `boards/`.
    pub name: String,
    pub title: String,
    pub chip: String,
    pub wiring: Wiring,
}

/// Every board with a chip.
pub fn boards(root: &Path) -> anyhow::Result<Vec<DrawnBoard>> {
    let drawn = |board: Board| {
        let Board { name, title, chip, wiring, .. } = board;
        Some(DrawnBoard { name, title, chip: chip?.name, wiring: wiring? })
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

impl Parts {
    /// The parts of a rig with this board: line by line of the bill of materials.
    pub fn bill<'a>(&'a self, board: &'a DrawnBoard) -> impl Iterator<Item = &'a Part> {
        board.wiring.part.iter().chain(&self.part)
    }

    /// The value of a part by its designator.
    pub fn value(&self, board: &DrawnBoard, name: &str) -> String {
        let mut bill = self.bill(board);
        let part =
            bill.find(|p| p.designators(self.sensor.count).iter().any(|other| other == name));
        part.map(|part| part.value.clone()).unwrap_or_default()
    }
}
