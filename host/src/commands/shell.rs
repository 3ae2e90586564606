//! `massline completions` and `massline man`: what shells and `man` know about the program.

use std::path::{Path, PathBuf};

use clap::Command;
use clap_complete::Shell;

use crate::output::Output;
use crate::support::files::ReplaceArgs;
use crate::{Error, Result};
use massline_files::file;
use massline_report::document::{Completions, ManualPage, WrittenPages};
use massline_result::FilePath;

/// Arguments of `massline completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline completions bash >> ~/.bash_completion
  massline completions zsh > ~/.zfunc/_massline
  massline completions fish > ~/.config/fish/completions/massline.fish
  massline completions powershell >> $PROFILE")]
pub struct CompletionsArgs {
    /// The shell.
    #[arg(value_enum)]
    shell: Shell,
}

/// Arguments of `massline man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline man | man -l -
  massline man --output ~/.local/share/man/man1")]
pub struct ManArgs {
    /// Write a page for each command into this folder instead of printing that of the program.
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
}

/// Prints the completions of a shell.
///
/// # Errors
/// When stdout cannot be written.
pub fn completions(
    args: &CompletionsArgs,
    mut command: Command,
    output: &mut Output,
) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "massline", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    if output.json() {
        return output.value(&Completions { shell: args.shell.to_string(), completions: script });
    }
    output.verbatim(script.trim_end())
}

/// Prints the manual page of the program, or writes those of all its commands.
///
/// # Errors
/// When a file exists or cannot be written.
pub fn man(args: &ManArgs, mut command: Command, output: &mut Output) -> Result<()> {
    command.build();
    let Some(folder) = &args.output else {
        let page = String::from_utf8_lossy(&page(&command)?).into_owned();
        return match output.json() {
            true => output.value(&ManualPage { page }),
            false => output.verbatim(page.trim_end()),
        };
    };
    std::fs::create_dir_all(folder).map_err(|e| file::cannot(folder, e))?;
    let mut written = Vec::new();
    write_pages(&command, folder, args.replace, &mut written)?;
    let count = written.len();
    output.answer(&WrittenPages { written }, |_| {
        format!("{count} manual pages in {}", folder.display())
    })
}

/// Writes the page of a command and those of its subcommands.
fn write_pages(
    command: &Command,
    folder: &Path,
    replace: ReplaceArgs,
    written: &mut Vec<FilePath>,
) -> Result<()> {
    let name = command.get_display_name().unwrap_or_else(|| command.get_name());
    let path = folder.join(format!("{name}.1"));
    file::write(&path, &page(command)?, replace.existing())?;
    written.push(path.into());
    let documented = command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help");
    documented
        .into_iter()
        .try_for_each(|subcommand| write_pages(subcommand, folder, replace, written))
}

fn page(command: &Command) -> Result<Vec<u8>> {
    let mut page = Vec::new();
    let rendered = clap_mangen::Man::new(command.clone()).render(&mut page);
    rendered.map_err(|e| Error::internal("man_page", format!("the manual page: {e}")))?;
    Ok(page)
}
