//! Access to the emulated machine for the programs of this package.
//!
//! ```text
//! cargo image run -p massline-on-target --bin golden --target thumbv7em-none-eabihf
//! cargo image run -p massline-on-target --bin counts --target thumbv7em-none-eabihf
//! ```
//! The runner in `.cargo/config.toml` starts QEMU with semihosting, through which the programs print and
//! exit. One instruction takes 64 ns of the machine's time, so a time counter counts instructions, and
//! the number is the same in every run.
#![no_std]

#[cfg(target_os = "none")]
mod machine;

#[cfg(target_os = "none")]
pub use machine::{Cost, StepCosts, end, measure, measure_steps, print};
