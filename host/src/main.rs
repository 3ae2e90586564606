//! The command line program.

use std::process::ExitCode;

fn main() -> ExitCode {
    massline::commands::main(std::env::args_os())
}
