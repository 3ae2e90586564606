//! The emulated rig: the firmware in QEMU's machine `mps2-an386`.
//!
//! ```text
//!  client ◀── pty ──▶ UART0 ┐
//!                           │ qemu-system-arm
//!  source ──▶ feeder ─ ring ┘ in the machine's PSRAM, a file that both map
//! ```
//! The link is a pty that any serial program can open. The scans of a [`ScanSource`] go through the ring; a
//! [`Feeder`] writes them as the rig asks for them, so the emulator's speed does not matter and a run is as
//! repeatable as its source.
//!
//! [`ScanSource`]: massline_physics::source::ScanSource

mod feeder;
mod machine;
mod memory;

pub use feeder::Feeder;
pub use machine::EmulatedRig;

pub use massline_client::firmware::checkout;

/// The target of the emulated rig.
pub use massline_mps2_an386::facts::TARGET;

/// Builds the firmware of the emulated rig from the checkout; returns the ELF file.
///
/// # Errors
/// As [`massline_client::firmware::build`].
pub fn build_firmware() -> crate::Result<std::path::PathBuf> {
    massline_client::firmware::build("massline-mps2-an386", TARGET, "--firmware")
}
