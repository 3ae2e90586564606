//! The firmware that the emulated rig runs: built from the checkout that this program came from.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::error::{Error, Result};

/// The target of the emulated rig.
pub const TARGET: &str = "thumbv7em-none-eabihf";
const PACKAGE: &str = "massline-mps2-an386";

/// Builds the firmware of the emulated rig from the checkout; gives the ELF file.
///
/// # Errors
/// `no_checkout` when the sources are gone, `target_missing` when the compiler lacks the target,
/// `firmware_build_failed` with what cargo said.
pub fn build_firmware() -> Result<PathBuf> {
    let checkout = checkout()?;
    need_target(checkout)?;
    let output = Command::new("cargo")
        .current_dir(checkout)
        .args(["build", "-p", PACKAGE, "--target", TARGET, "--profile", "firmware"])
        .arg("--message-format=json-render-diagnostics")
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| {
            Error::device("firmware_build_failed", format!("cannot start cargo: {error}"))
        })?;
    if !output.status.success() {
        return Err(Error::device(
            "firmware_build_failed",
            format!(
                "cargo could not build {PACKAGE} ({}); --firmware ELF takes a built one",
                output.status
            ),
        ));
    }
    executable_in(&String::from_utf8_lossy(&output.stdout)).ok_or_else(|| {
        Error::internal(
            "firmware_build_failed",
            format!("cargo built {PACKAGE} but named no executable"),
        )
    })
}

/// The checkout that this program was built from.
///
/// # Errors
/// `no_checkout` when it is not there any more.
pub fn checkout() -> Result<&'static Path> {
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).parent();
    checkout.filter(|path| path.join("boards/mps2-an386/Cargo.toml").is_file()).ok_or_else(|| {
        Error::input(
            "no_checkout",
            "the sources of the firmware are not where this program was built; give the built firmware with --firmware ELF",
        )
    })
}

/// The compiler's part for the target has to be installed.
fn need_target(checkout: &Path) -> Result<()> {
    let output = Command::new("rustc")
        .current_dir(checkout)
        .args(["--print", "target-libdir", "--target", TARGET])
        .output()
        .map_err(|error| {
            Error::device("target_missing", format!("cannot ask rustc for its targets: {error}"))
        })?;
    let directory = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if output.status.success() && Path::new(&directory).is_dir() {
        return Ok(());
    }
    Err(Error::device(
        "target_missing",
        format!("the Rust target of the emulated rig is not installed: rustup target add {TARGET}"),
    ))
}

/// The executable of the package in cargo's JSON messages.
fn executable_in(messages: &str) -> Option<PathBuf> {
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok())
        .filter_map(|message| message["executable"].as_str().map(PathBuf::from))
        .find(|path| path.file_stem().is_some_and(|name| name == PACKAGE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_executable_is_found_among_the_messages() {
        let messages = r#"
            {"reason":"compiler-artifact","executable":null}
            {"reason":"compiler-artifact","executable":"/x/firmware/massline-mps2-an386"}
            {"reason":"build-finished","success":true}"#;
        let elf = executable_in(messages);
        assert_eq!(elf.as_deref(), Some(Path::new("/x/firmware/massline-mps2-an386")));
        assert_eq!(executable_in("no json\n{}"), None);
    }

    #[test]
    fn the_checkout_of_this_build_is_found() {
        assert!(checkout().unwrap().join("Cargo.toml").is_file());
    }
}
