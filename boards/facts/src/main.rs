//! Prints the boards for scripts, one per line: package, target, and the folder's name. Runs cargo for the image of
//! one.
//!
//! ```text
//! cargo image                      every board
//! cargo image --chips              those with a chip
//! cargo image build pico2          builds an image
//! cargo image run pico2            builds it and runs it on the board, through a probe
//! cargo image test pico2 --test hardware
//! ```
//! Where no board is named, cargo gets the arguments as they are.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use massline_boards::{Error, boards, image};

const USAGE: &str = "\
usage: massline-boards [--chips]
       massline-boards build|run|test|clippy BOARD [ARGUMENT OF CARGO]...
       massline-boards build|run|test|clippy [ARGUMENT OF CARGO]...";

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().skip(1).collect();
    let root = &root();
    let done = match arguments.split_first() {
        None => list(root, false),
        Some((option, [])) if option == "--chips" => list(root, true),
        Some((subcommand, rest)) => match subcommand.to_str() {
            Some(subcommand @ ("build" | "run" | "test" | "clippy")) => {
                cargo(root, subcommand, rest)
            }
            _ => {
                eprintln!("{USAGE}");
                return ExitCode::from(2);
            }
        },
    };
    done.unwrap_or_else(|error| {
        eprintln!("{error}");
        ExitCode::FAILURE
    })
}

/// The workspace around the present folder, else the one that this program was built from.
fn root() -> PathBuf {
    let is_root = |folder: &&Path| folder.join("boards/facts/Cargo.toml").is_file();
    let here = std::env::current_dir().unwrap_or_default();
    let built_from = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
    here.ancestors().chain(built_from).find(is_root).unwrap_or(&here).to_owned()
}

fn list(root: &Path, chips_only: bool) -> Result<ExitCode, Error> {
    for board in boards(root)?.iter().filter(|board| !chips_only || board.chip.is_some()) {
        println!("{} {} {}", board.package(), board.target, board.name);
    }
    Ok(ExitCode::SUCCESS)
}

fn cargo(root: &Path, subcommand: &str, arguments: &[OsString]) -> Result<ExitCode, Error> {
    let mut cargo = image::cargo(root, subcommand)?;
    cargo.args(image::arguments(root, arguments)?);
    let status = cargo.status().map_err(|error| Error::NoAnswer {
        command: format!("cargo {subcommand}"),
        why: error.to_string(),
    })?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}
