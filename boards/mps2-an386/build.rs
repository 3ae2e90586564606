//! Sets the constants of the firmware, its linking, and the commit that it is built from.

use std::path::PathBuf;
use std::{env, fs};

use massline_boards::build::{self, Program};

fn main() {
    build::board(&[Program::Firmware], &["link.x"]);
    if build::bare_metal() {
        // A device crate would supply this file with weak handlers; this board's vector table names its own.
        let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
        fs::write(out.join("device.x"), "").expect("OUT_DIR is writable");
    }
    massline_boards::commit(&["..", "../../firmware", "../../shared", "../../Cargo.lock"]);
}
