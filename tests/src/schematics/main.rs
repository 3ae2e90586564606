//! Draws the schematic of each board from `boards/parts.toml` and `boards/<name>/board.toml`.
//!
//! ```text
//! cargo run -p massline-tests --bin massline-schematics
//! ```
//! writes `boards/<name>/schematic.svg`. The tests compare the pictures with their sources, and the
//! sources with the firmware and the guides.

mod pen;
mod sheet;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::source::Drawn;

fn main() -> anyhow::Result<()> {
    for board in source::boards(&root())? {
        let path = folder(&board).join("schematic.svg");
        fs::write(&path, draw(&board)?).with_context(|| path.display().to_string())?;
        println!("{}", path.display());
    }
    Ok(())
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn folder(board: &Drawn) -> PathBuf {
    root().join("boards").join(&board.name)
}

fn draw(board: &Drawn) -> anyhow::Result<String> {
    Ok(sheet::draw(&source::parts(&root())?, board))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn boards() -> Vec<Drawn> {
        let boards = source::boards(&root()).unwrap();
        // The three boards that have a guide.
        assert!(boards.len() >= 3, "{boards:?}");
        boards
    }

    fn file(board: &Drawn, name: &str) -> String {
        fs::read_to_string(folder(board).join(name)).unwrap()
    }

    #[test]
    fn the_committed_schematics_are_those_of_their_sources() {
        for board in &boards() {
            assert!(
                draw(board).unwrap() == file(board, "schematic.svg"),
                "{}: run cargo run -p massline-tests --bin massline-schematics, and look at it",
                board.name
            );
        }
    }

    #[test]
    fn the_wiring_is_that_of_the_firmware() {
        for board in &boards() {
            let (Drawn { name: board, wiring, .. }, code) = (board, file(board, "src/chip/mod.rs"));
            let used: BTreeSet<_> = pins(&code).collect();
            let wired: BTreeSet<_> = wiring.firmware_pins().map(str::to_owned).collect();
            assert_eq!(used, wired, "{board}");
            let order = |from: &str, to: char| {
                let (_, list) = code.split_once(from).unwrap();
                pins(list.split_once(to).unwrap().0).collect::<Vec<_>>()
            };
            let (buttons, screen) = (&wiring.buttons, &wiring.screen);
            match &wiring.adc {
                None => assert_eq!(order("channels: (", ')'), wiring.channels, "{board}"),
                Some(adc) => {
                    // The firmware's names of the converter's pins.
                    let names = [
                        ("SDO", "data_out: "),
                        ("SDI", "data_in: "),
                        ("SCLK", "clock: "),
                        ("CS", "select: "),
                    ];
                    for ([pin, other], (name, field)) in adc.wires.iter().zip(names) {
                        assert_eq!((pin.as_str(), order(field, ',')), (name, vec![other.clone()]));
                    }
                }
            }
            assert_eq!(order("buttons: [", ']'), [&*buttons.ok, &*buttons.back, &*buttons.next]);
            assert_eq!(order("bus: ", '\n'), [&*screen.scl, &*screen.sda]);
            assert_eq!(order("tone: ", ')'), [&*wiring.buzzer]);
            assert_eq!(order("light: ", ','), [&*wiring.light]);
        }
    }

    #[test]
    fn the_guides_name_every_pin() {
        for board in &boards() {
            let guide = file(board, "README.md");
            for pin in board.wiring.firmware_pins() {
                assert!(guide.contains(pin), "{}: {pin}", board.name);
            }
        }
    }

    /// The chip's pins that the firmware uses: `p.PA0`, or `p.PIN_16`, which the board labels GP16.
    fn pins(code: &str) -> impl Iterator<Item = String> {
        let words = code.split(|c: char| !c.is_ascii_alphanumeric() && c != '.' && c != '_');
        let number = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_digit());
        words.filter_map(|word| word.strip_prefix("p.P")).filter_map(move |pin| {
            match pin.strip_prefix("IN_") {
                Some(pin) => number(pin).then(|| format!("GP{pin}")),
                None => pin.get(1..).is_some_and(number).then(|| format!("P{pin}")),
            }
        })
    }
}
