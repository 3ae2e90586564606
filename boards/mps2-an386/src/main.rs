//! The rig on QEMU's machine `mps2-an386`: the link is UART0; the ring of scans and the flash are in PSRAM.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!(
        "This is firmware. Build it with\n    cargo image build mps2-an386\nand run it with `massline demo --rig qemu`."
    );
    std::process::exit(2);
}
