//! Prints the program of the PIO, its plan, its pins and the converter's commands as JSON, for `tests/pio/run`.

use std::path::Path;

use massline_boards::Board;
use massline_boards::wiring::Adc;
use massline_pico2::ads7953::{COMMANDS, FRAMES_TO_START};
use massline_pico2::{frames, plan};
use massline_shared::signal::CHANNELS;
use serde_json::json;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = frames::program();
    let board = Board::read(Path::new(env!("CARGO_MANIFEST_DIR")))?;
    let adc = board.wiring.and_then(|wiring| wiring.adc).ok_or("the board has no converter")?;
    let description = json!({
        "program": {
            "words": program.code.as_slice(),
            "wrap": { "target": program.wrap.target, "source": program.wrap.source },
            "side_set_bits": program.side_set.bits(),
        },
        "plan": {
            "core_hz": plan::CORE_HZ,
            "divider": plan::DIVIDER,
            "rate_hz": plan::RATE_HZ,
            "ratio": plan::RATIO,
            "channels": CHANNELS,
            "frame_bits": plan::FRAME_BITS,
            "low": plan::LOW,
            "high": plan::HIGH,
            "hold": plan::HOLD,
            "gap": plan::GAP,
        },
        "pins": {
            "sdo": pin(&adc, "SDO")?,
            "sdi": pin(&adc, "SDI")?,
            "sclk": pin(&adc, "SCLK")?,
            "cs": pin(&adc, "CS")?,
        },
        "commands": COMMANDS,
        "frames_to_start": FRAMES_TO_START,
    });
    println!("{description:#}");
    Ok(())
}

/// Number of the GPIO to which a pin of the converter is wired. A test compares the wiring with the firmware.
fn pin(adc: &Adc, name: &str) -> Result<u8, String> {
    let wire = adc.wires.iter().find(|[of_adc, _]| of_adc == name);
    let number = wire.and_then(|[_, of_board]| of_board.strip_prefix("GP")?.parse().ok());
    number.ok_or_else(|| format!("{name} is not wired to a GPIO"))
}
