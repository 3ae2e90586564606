//! `massline completions`: what shells know about the program.

use clap::Command;
use clap_complete::Shell;

use crate::Result;
use crate::output::Output;
use massline_report::document::Completions;

/// Arguments of `massline completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline completions bash >> ~/.bash_completion
  massline completions zsh > ~/.zfunc/_massline
  massline completions fish > ~/.config/fish/completions/massline.fish
  massline completions powershell >> $PROFILE")]
pub struct Args {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completions of a shell.
///
/// # Errors
/// When stdout cannot be written.
pub fn run(args: &Args, mut command: Command, output: &mut Output) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "massline", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    if output.json() {
        return output.value(&Completions { shell: args.shell.to_string(), completions: script });
    }
    output.verbatim(script.trim_end())
}
