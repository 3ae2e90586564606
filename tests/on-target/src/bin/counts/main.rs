//! Counts the instructions and the stack of the rig's computations on the Cortex-M4F, in single precision
//! and with the functions that the firmware calls. Prints lines with a name and a number.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod outcome;
#[cfg(target_os = "none")]
mod work;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This runs in QEMU; see the documentation of massline-on-target.");
    std::process::exit(2);
}
