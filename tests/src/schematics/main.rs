//! Draws the schematic of each board from `boards/parts.toml` and `boards/<name>/wiring.toml`.
//!
//! ```text
//! cargo run -p massline-tests --bin massline-schematics
//! ```
//! writes `boards/<name>/schematic.svg`. The tests hold the pictures against their sources, and the sources
//! against the firmware and the guides.

mod pen;
mod sheet;
mod source;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;

use crate::source::{Parts, Wiring};

/// The boards that have a schematic.
const BOARDS: [&str; 3] = ["blackpill-f411", "nucleo-g474re", "pico2"];

fn main() -> anyhow::Result<()> {
    for board in BOARDS {
        let path = folder(board).join("schematic.svg");
        fs::write(&path, draw(board)?).with_context(|| path.display().to_string())?;
        println!("{}", path.display());
    }
    Ok(())
}

fn folder(board: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../boards").join(board)
}

fn draw(board: &str) -> anyhow::Result<String> {
    let parts: Parts = source::read(&folder("parts.toml"))?;
    Ok(sheet::draw(&parts, &wiring(board)?))
}

fn wiring(board: &str) -> anyhow::Result<Wiring> {
    source::read(&folder(board).join("wiring.toml"))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn file(board: &str, name: &str) -> String {
        fs::read_to_string(folder(board).join(name)).unwrap()
    }

    #[test]
    fn the_committed_schematics_are_those_of_their_sources() {
        for board in BOARDS {
            assert!(
                draw(board).unwrap() == file(board, "schematic.svg"),
                "{board}: run cargo run -p massline-tests --bin massline-schematics, and look at it"
            );
        }
    }

    #[test]
    fn the_wiring_is_that_of_the_firmware() {
        for board in BOARDS {
            let (wiring, code) = (wiring(board).unwrap(), file(board, "src/chip/mod.rs"));
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
                    // What the firmware calls the converter's pins.
                    let names = [
                        ("SDO", "data_out: "),
                        ("SDI", "data_in: "),
                        ("SCLK", "clock: "),
                        ("CS", "select: "),
                    ];
                    for ([pin, board], (name, field)) in adc.wires.iter().zip(names) {
                        assert_eq!((pin.as_str(), order(field, ',')), (name, vec![board.clone()]));
                    }
                }
            }
            assert_eq!(order("buttons: [", ']'), [&*buttons.ok, &*buttons.back, &*buttons.next]);
            assert_eq!(order("screen(", ')'), [&*screen.scl, &*screen.sda]);
            assert_eq!(order("tone: ", ')'), [&*wiring.buzzer]);
            assert_eq!(order("light: ", ','), [&*wiring.light]);
        }
    }

    #[test]
    fn the_guides_name_every_pin() {
        for board in BOARDS {
            let guide = file(board, "README.md");
            for pin in wiring(board).unwrap().firmware_pins() {
                assert!(guide.contains(pin), "{board}: {pin}");
            }
        }
    }

    /// The pins that firmware takes from the chip: `p.PA0`, or `p.PIN_16`, which the board calls GP16.
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
