//! Builds the firmware of a board from the checkout that this program was built from.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use massline_result::{Error, Result};

/// The program that runs the firmware without a board.
pub const EMULATOR: &str = "qemu-system-arm";

/// Builds `package` for `target` from the checkout; returns the ELF file. `otherwise` names the option that
/// accepts a ready-made image; the errors mention it.
///
/// # Errors
/// `no_checkout` when the sources are missing, `target_missing` when the compiler lacks the target,
/// `firmware_build_failed` with cargo's output.
pub fn build(package: &str, target: &str, otherwise: &str) -> Result<PathBuf> {
    let checkout = checkout()
        .map_err(|e| e.within(format!("{package} must be built or given by {otherwise}")))?;
    need_target(checkout, target)?;
    let output = massline_boards::image::cargo(checkout, "build")
        .map_err(|error| Error::device("firmware_build_failed", error.to_string()))?
        .args(["-p", package, "--target", target, "--message-format=json-render-diagnostics"])
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| {
            Error::device("firmware_build_failed", format!("cannot start cargo: {error}"))
        })?;
    if !output.status.success() {
        return Err(Error::device(
            "firmware_build_failed",
            format!(
                "cargo could not build {package} ({}); to use an existing image, pass {otherwise} ELF",
                output.status
            ),
        ));
    }
    executable_in(&String::from_utf8_lossy(&output.stdout), package).ok_or_else(|| {
        Error::internal(
            "firmware_build_failed",
            format!("cargo built {package} but named no executable"),
        )
    })
}

/// The checkout that this program was built from.
///
/// # Errors
/// `no_checkout` when it does not exist any more.
pub fn checkout() -> Result<&'static Path> {
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2);
    checkout.filter(|path| path.join("boards/mps2-an386/Cargo.toml").is_file()).ok_or_else(|| {
        Error::input(
            "no_checkout",
            "the sources of the firmware are not where this program was built",
        )
    })
}

/// Checks that the compiler's support for the target is installed.
fn need_target(checkout: &Path, target: &str) -> Result<()> {
    let output = Command::new("rustc")
        .current_dir(checkout)
        .args(["--print", "target-libdir", "--target", target])
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
        format!("the Rust target of the firmware is not installed: rustup target add {target}"),
    ))
}

/// The path of the package's executable, from cargo's JSON messages.
fn executable_in(messages: &str, package: &str) -> Option<PathBuf> {
    #[derive(serde::Deserialize)]
    struct Message {
        executable: Option<PathBuf>,
    }
    messages
        .lines()
        .filter_map(|line| serde_json::from_str::<Message>(line).ok()?.executable)
        .find(|path| path.file_stem().is_some_and(|name| name == package))
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
        let elf = executable_in(messages, "massline-mps2-an386");
        assert_eq!(elf.as_deref(), Some(Path::new("/x/firmware/massline-mps2-an386")));
        assert_eq!(executable_in("no json\n{}", "x"), None);
    }

    #[test]
    fn the_checkout_of_this_build_is_found() {
        assert!(checkout().unwrap().join("Cargo.toml").is_file());
    }
}
