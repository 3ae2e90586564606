//! The rig on a Nucleo board: clocks, pins, and the tasks that the application runs beside.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!(
        "This is firmware. Build it with\n    cargo build -p massline-nucleo-g474re \
         --target thumbv7em-none-eabihf --profile firmware\nand flash it as the board's README says."
    );
    std::process::exit(2);
}
