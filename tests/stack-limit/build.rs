//! Links the program for QEMU's machine mps2-an505, in its secure memory.

use std::path::PathBuf;
use std::{env, fs};

const MEMORY: &str = "MEMORY {
    FLASH : ORIGIN = 0x10000000, LENGTH = 1M
    RAM : ORIGIN = 0x38006000, LENGTH = 104K
}
_stack_end = 0x38000000;
_stack_start = 0x38006000;
";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let folder = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::write(folder.join("memory.x"), MEMORY).expect("the folder can be written");
    println!("cargo::rustc-link-search={}", folder.display());
    if env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none") {
        println!("cargo::rustc-link-arg-bins=-Tlink.x");
    }
}
