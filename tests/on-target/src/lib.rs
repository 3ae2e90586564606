//! What the programs of this package need of the emulated machine.
//!
//! ```text
//! cargo run -p massline-on-target --bin golden --target thumbv7em-none-eabihf --profile firmware
//! cargo run -p massline-on-target --bin counts --target thumbv7em-none-eabihf --profile firmware
//! ```
//! The runner in `.cargo/config.toml` starts QEMU with semihosting, through which they print and end
//! with an exit code, and with one instruction every 64 ns of the machine's time, so that a counter of
//! time counts instructions, the same number in every run.
#![no_std]

#[cfg(target_os = "none")]
mod machine;

#[cfg(target_os = "none")]
pub use machine::{Cost, end, measure, print};
