//! Draws the schematic of each board from `boards/parts.toml` and `boards/<name>/board.toml`.
//!
//! ```text
//! cargo run -p massline-gate --bin massline-schematics
//! ```
//! writes `boards/<name>/schematic.svg` and `power.svg`, `boards/PARTS.md`, and the drawings of `boards/BRING-UP.md`.
//! The tests compare the drawings with their sources, the nets that are drawn with those of the facts, and the facts
//! with the firmware and the guides.

mod bill;
mod check;
mod circuit;
mod figures;
mod guide;
mod pen;
mod power;
mod sheet;
mod source;
mod symbols;
mod title;
mod trace;

#[cfg(test)]
mod tests;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::pen::Sheet;
use crate::source::{DrawnBoard, Parts};

fn main() -> anyhow::Result<()> {
    let (parts, boards) = (source::parts(&root())?, source::boards(&root())?);
    let path = root().join("boards/PARTS.md");
    fs::write(&path, bill::page(&parts, &boards)?).with_context(|| path.display().to_string())?;
    for (name, drawing) in guide::FILES.iter().zip(guide::drawings()) {
        let path = root().join("boards/bring-up").join(name);
        fs::write(&path, &drawing.svg).with_context(|| path.display().to_string())?;
        check::legible(&drawing).with_context(|| path.display().to_string())?;
    }
    for board in &boards {
        let sheets = sheets(&parts, board);
        for (name, sheet) in SHEETS.iter().zip(&sheets) {
            let path = folder(board).join(name);
            fs::write(&path, &sheet.svg).with_context(|| path.display().to_string())?;
            println!("{}", path.display());
        }
        check::check(&parts, board, &sheets).with_context(|| board.name.clone())?;
    }
    Ok(())
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn folder(board: &DrawnBoard) -> PathBuf {
    root().join("boards").join(&board.name)
}

/// Files of the sheets of a board.
const SHEETS: [&str; 2] = ["schematic.svg", "power.svg"];

fn sheets(parts: &Parts, board: &DrawnBoard) -> [Sheet; 2] {
    [sheet::draw(parts, board), power::draw(parts, board)]
}
