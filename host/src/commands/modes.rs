//! `massline modes`: the suspension modes of an object, from the frequency responses in a universal file.

use std::path::{Path, PathBuf};

use massline_result::Modes;
use massline_shared::layout::{Dof, HostLayout};

use super::solve::{archive::with_layout, swapped};
use crate::Result;
use crate::output::Output;
use crate::solve::{FoundModes, Problem, modes_of_archive, modes_of_problem};
use crate::support::responses::{PERTURBATIONS, ResponseArgs};
use massline_files::archive::{Archive, is_archive};
use massline_report::words::{
    assurance_text, findings, message_in, modes_text, orders_text, sentences, shapes_text,
    shows_flexible_mode, suspension_modes,
};

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
    let source = Source::read(args, output)?;
    if let Source::Files(problem) = &source
        && let Some(understood) = problem.understood(&options).filter(|_| !output.json())
    {
        output.note(understood);
    }
    let bar = output.bar(PERTURBATIONS, "uncertainty");
    let progress = |done: u32, total: u32| {
        bar.set_length(total.into());
        bar.set_position(done.into());
    };
    let modes = match source {
        Source::Archive { archive, path, layout } => {
            modes_of_archive((&archive, path), *layout, &args.hits, &options, progress)
        }
        Source::Files(problem) => modes_of_problem(&problem, &options, progress),
    };
    bar.finish_and_clear();
    let FoundModes { modes, layout, band_hz: band } = modes?;
    let findings = findings(&modes.diagnostics, |d| message_in(d, &layout));
    let modes = suspension_modes(&modes, band, &layout);
    let document = Modes { diagnostics: Some(findings.clone()), ..modes };
    output.answer(&document, |_| {
        let Modes { modes, modal_assurance, orders, .. } = &document;
        [
            modes_text(&document, shows_flexible_mode(&findings)),
            shapes_text(modes),
            assurance_text(modal_assurance),
            orders_text(orders),
            sentences(&findings),
        ]
        .concat()
        .trim_end()
        .to_owned()
    })
}

/// Where the responses are.
enum Source<'a> {
    /// In an archive, for its layout or another one.
    Archive { archive: Box<Archive>, path: &'a Path, layout: Box<HostLayout> },
    /// In a universal file.
    Files(Box<Problem>),
}

impl<'a> Source<'a> {
    fn read(args: &'a Args, output: &mut Output) -> Result<Self> {
        let (path, layout) = match &args.frfs {
            None => (&args.layout, None),
            Some(_) if is_archive(&args.layout) => return Err(swapped("modes", &args.layout)),
            Some(path) if is_archive(path) => (path, Some(args.layout.as_path())),
            Some(path) => {
                let problem = Problem::read(&args.layout, path, &args.hits)?;
                return Ok(Self::Files(Box::new(problem)));
            }
        };
        let archive = Box::new(Archive::read(path)?);
        let layout = match layout {
            Some(layout) => with_layout(layout, path, &archive, output)?.layout,
            None => archive.layout.resolved.clone(),
        };
        Ok(Self::Archive { archive, path, layout: Box::new(layout) })
    }
}
