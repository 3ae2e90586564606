//! Sets the constants of the firmware and its linking.

use massline_boards::build::{self, Program};

fn main() {
    build::board(&[Program::Firmware, Program::HardwareTest], &["link.x"]);
}
