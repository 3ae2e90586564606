//! Prints the boards for scripts, one per line: package, target, and the folder's name.
//!
//! ```text
//! cargo run -p massline-boards            every board
//! cargo run -p massline-boards -- --chips those with a chip
//! ```

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let chips_only = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        [] => false,
        ["--chips"] => true,
        _ => {
            eprintln!("usage: massline-boards [--chips]");
            return ExitCode::from(2);
        }
    };
    match massline_boards::boards(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")) {
        Ok(boards) => {
            for board in boards.iter().filter(|board| !chips_only || board.chip.is_some()) {
                println!("{} {} {}", board.package(), board.target, board.name);
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
