//! `massline modes`: the suspension modes of an object, from the frequency responses in a universal file.

use std::path::PathBuf;

use massline_shared::layout::Dof;

use super::responses::{PERTURBATIONS, ResponseArgs};
use super::solve::{archive::with_layout, swapped};
use crate::archive::{Archive, is_archive};
use crate::document;
use crate::error::Result;
use crate::output::Output;
use crate::report::{
    assurance_text, diagnostics_json, message_in, modes_json, modes_text, orders_text, sentences,
    shapes_text,
};
use crate::solve::{FoundModes, modes_of_archive, modes_of_files};

/// Arguments of `massline modes`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads UFF dataset 58 as `massline solve` does, fits poles and residues to all responses of the
suspension band together, and prints frequency, damping ratio, Norm Indicator and shape of every
mode, how alike the shapes are, and the poles of every order: those that return from order to order
are modes.

Examples:
  massline modes wheel.toml wheel.uff
  massline modes wheel.toml wheel.uff --suspension-band 1:20
  massline modes wheel.toml wheel.uff --hits 101:+X,102:+Z,104:+Y
  massline modes wheel.massline
  massline modes corrected.toml wheel.massline
  massline modes wheel.toml wheel.uff --json | jq '.modes[].frequency_hz'")]
pub struct Args {
    /// The layout file; or an archive alone, whose spectra were kept.
    #[arg(value_name = "LAYOUT|ARCHIVE")]
    layout: PathBuf,
    /// The universal file with the frequency responses; or an archive, whose spectra are read with this layout.
    #[arg(value_name = "FRFS|ARCHIVE")]
    frfs: Option<PathBuf>,
    #[command(flatten)]
    responses: ResponseArgs,
    /// Hits to use, such as `1:+Y,4:+X`; default: all of the layout.
    #[arg(long, value_name = "DOFS", value_delimiter = ',')]
    hits: Vec<Dof>,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, or its responses show no modes.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let options = args.responses.options();
    let (archive, layout) = match &args.frfs {
        None => (Some(&args.layout), None),
        Some(_) if is_archive(&args.layout) => return Err(swapped("modes", &args.layout)),
        Some(path) if is_archive(path) => (Some(path), Some(args.layout.as_path())),
        Some(_) => (None, None),
    };
    let archive = match archive {
        Some(path) => {
            let archive = Archive::read(path)?;
            let layout = match layout {
                Some(layout) => with_layout(layout, path, &archive, output)?.layout,
                None => archive.layout.resolved.clone(),
            };
            Some((archive, path, layout))
        }
        None => None,
    };
    let bar = output.bar(PERTURBATIONS, "uncertainty");
    let progress = |done: u32, all: u32| {
        bar.set_length(all.into());
        bar.set_position(done.into());
    };
    let found = match (&archive, &args.frfs) {
        (Some((archive, path, layout)), _) => {
            modes_of_archive((archive, path), layout.clone(), &args.hits, &options, progress)
        }
        (None, frfs) => {
            let frfs = frfs.as_ref().unwrap_or(&args.layout);
            modes_of_files(&args.layout, frfs, &args.hits, &options, progress)
        }
    };
    bar.finish_and_clear();
    let FoundModes { modes, layout, band_hz: band } = found?;
    let message_of = |d: &massline_shared::diagnosis::Diagnostic| message_in(d, &layout);
    let diagnostics = Some(diagnostics_json(&modes.diagnostics, message_of));
    let document = document::Modes { diagnostics, ..modes_json(&modes, band, &layout) };
    output.answer(&document, |_| {
        [
            modes_text(&modes, band, &layout),
            shapes_text(&modes),
            assurance_text(&modes),
            orders_text(&modes),
            sentences(&modes.diagnostics, message_of),
        ]
        .concat()
        .trim_end()
        .to_owned()
    })
}
