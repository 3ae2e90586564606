//! The constants of the firmware, and how it is linked.

use massline_boards::build::{self, Program};

fn main() {
    build::board(&[Program::Firmware, Program::HardwareTest], &["link.x", "defmt.x"]);
}
