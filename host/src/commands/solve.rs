//! `massline solve`: computes the ten properties offline, from the frequency responses in a universal file or from an
//! archive.

pub(super) mod archive;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::ValueEnum;
use massline_shared::layout::Dof;
use massline_shared::modes::{LINES_OF_A_SIDE, LinesPerSide};

use crate::output::Output;
use crate::solve::{Options, Problem, ReferencePoint, solve_problem};
use crate::support::method;
use crate::support::responses::{PERTURBATIONS, ResponseArgs};
use crate::support::show::{self, DetailsArgs, NextStep};
use crate::{Error, Result};
use massline_analysis::identification::Selection;
use massline_analysis::suspension::ModeChoice;
use massline_files::archive::{EXTENSION, MAX_BYTES, is_archive};
use massline_files::embedded;

/// Arguments of `massline solve`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Reads UFF dataset 58, ASCII and binary: frequency responses of every hit DOF at every sensor of
the layout. Units are those of the labels, else those of dataset 164, else SI; what was understood is
printed first, and a label that is not understood is refused. Mass lines: equal weights, band and
terms of [test], else 10 to 120 Hz and A, B/s², C s². Suspension modes: those between 0.5 and
12.5 Hz, for objects whose mass line is hidden by them or by elastic modes. All methods that apply answer and are compared. [prior] is used by ml,
global-fit and toivola-nuutila. Placement errors are averaged over test.hits_per_dof hits.

From an archive of `massline measure` or `massline results get` the mass lines in it are solved
again, with the layout in it or with one that was corrected: positions, axes, uncertainty and prior.
Of the options above only --method applies.

Examples:
  massline solve frame.toml frame.uff
  massline solve frame.massline
  massline solve corrected.toml frame.massline
  massline solve frame.toml frame.uff --method ml
  massline solve wheel.toml wheel.uff
  massline solve wheel.toml wheel.uff --method dppim --lines-per-side 2
  massline solve wheel.toml wheel.uff --hits 101:+X,102:+Z,104:+Y --shapes best
  massline solve frame.toml frame.uff --method irm --reference-point origin
  massline solve frame.toml frame.unv --quantity receptance
  massline solve frame.toml frame.uff --decay 10")]
pub struct Args {
    /// The layout file; or an archive, alone.
    #[arg(value_name = "LAYOUT|ARCHIVE")]
    layout: PathBuf,
    /// The universal file with the frequency responses; or an archive, to be solved with this layout.
    #[arg(value_name = "FRFS|ARCHIVE")]
    frfs: Option<PathBuf>,
    /// Point about which the equations are set up [default: centroid].
    #[arg(long, value_enum, value_name = "POINT")]
    reference_point: Option<Point>,
    #[command(flatten)]
    responses: ResponseArgs,
    /// Forces that a mode shape comes from [default: all].
    #[arg(long, value_enum, value_name = "FORCES")]
    shapes: Option<Shapes>,
    /// Lines of the direct method on each side of a mode: those within its width (auto), or a number from 1 to 4
    /// [default: auto].
    #[arg(long, value_name = "N")]
    lines_per_side: Option<LinesPerSideArg>,
    /// Hits to use, such as `1:+Y,4:+X`; default: all of the layout.
    #[arg(long, value_name = "DOFS", value_delimiter = ',')]
    hits: Vec<Dof>,
    #[arg(
        long,
        value_name = "METHOD",
        value_parser = method::one_or_all(),
        default_value = method::ALL,
        help = "One method alone, or all that apply"
    )]
    method: Selection,
    #[command(flatten)]
    details: DetailsArgs,
}

/// The forces that a shape comes from, as an argument.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Shapes {
    /// All forces, by least squares.
    #[default]
    All,
    /// The force that shows the mode best, as in the literature.
    Best,
}

/// Lines on each side of a mode as an argument.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LinesPerSideArg(LinesPerSide);

impl Default for LinesPerSideArg {
    fn default() -> Self {
        Self(LinesPerSide::Width)
    }
}

impl FromStr for LinesPerSideArg {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "auto" {
            return Ok(Self::default());
        }
        let count = text.parse::<usize>().ok();
        let count = count.filter(|count| (1..=LINES_OF_A_SIDE).contains(count));
        let fixed = count.map(|count| Self(LinesPerSide::Fixed(count)));
        fixed.ok_or_else(|| format!("give auto, or a number from 1 to {LINES_OF_A_SIDE}"))
    }
}

/// A reference point as an argument.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Point {
    /// The centroid of the sensors, which gives less scatter.
    #[default]
    Centroid,
    /// The origin of the body frame.
    Origin,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad, or the data cannot determine the answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let (archive, layout) = match &args.frfs {
        None if is_archive(&args.layout) => (&args.layout, None),
        None => return Err(alone(&args.layout)),
        Some(_) if is_archive(&args.layout) => return Err(swapped("solve", &args.layout)),
        Some(path) if is_archive(path) => (path, Some(args.layout.as_path())),
        Some(frfs) => return from_frequency_responses(args, frfs, output),
    };
    refuse_options_of_responses(args, archive)?;
    archive::solve(archive, layout, args.method, args.details.extent(), output)
}

/// Refuses the options that have no effect on the mass lines of an archive.
fn refuse_options_of_responses(args: &Args, archive: &Path) -> Result<()> {
    let given = [
        ("--reference-point", args.reference_point.is_some()),
        ("--shapes", args.shapes.is_some()),
        ("--lines-per-side", args.lines_per_side.is_some()),
        ("--hits", !args.hits.is_empty()),
    ];
    let given = given.into_iter().filter_map(|(name, is_given)| is_given.then_some(name));
    let given: Vec<_> = given.chain(args.responses.given()).collect();
    if given.is_empty() {
        return Ok(());
    }
    let message = format!(
        "{}: {} does not apply to an archive, whose mass lines are solved as they were measured; leave it out",
        archive.display(),
        given.join(", ")
    );
    Err(Error::input("usage", message))
}

/// The error for a file alone that is not an archive.
fn alone(path: &Path) -> Error {
    let name = path.display();
    if embedded::is_page(path) {
        return match embedded::read(path, MAX_BYTES) {
            Err(e) => Error::input("archive_not_readable", format!("{name}: cannot be read: {e}")),
            Ok(_) => Error::input(
                "no_mass_lines",
                format!(
                    "{name}: the page holds the output of a command, not an archive with mass lines to be solved \
                     again; give what it was solved from, the layout and the frequency responses: `massline solve \
                     LAYOUT.toml FRFS.uff`"
                ),
            ),
        };
    }
    if path.is_dir() {
        let message = format!(
            "{name}: this is a folder; give an archive (`massline solve FILE.{EXTENSION}`), or a layout and a file \
             with frequency responses (`massline solve LAYOUT.toml FRFS.uff`)"
        );
        return Error::input("usage", message);
    }
    let message = format!(
        "{name}: only an archive (FILE.{EXTENSION}) is solved alone; after a layout, give the file with the frequency \
         responses or an archive: `massline solve {name} FRFS.uff`"
    );
    Error::input("usage", message)
}

/// The error of a command that was given an archive in the place of the layout.
pub(super) fn swapped(command: &str, path: &Path) -> Error {
    let name = path.display();
    let message = format!(
        "{name}: this is an archive; give the layout first: `massline {command} LAYOUT.toml {name}`"
    );
    Error::input("usage", message)
}

fn from_frequency_responses(args: &Args, frfs: &Path, output: &mut Output) -> Result<()> {
    let options = Options {
        reference_point: match args.reference_point.unwrap_or_default() {
            Point::Centroid => ReferencePoint::Centroid,
            Point::Origin => ReferencePoint::Origin,
        },
        selection: args.method,
        mode_choice: match args.shapes.unwrap_or_default() {
            Shapes::All => ModeChoice::All,
            Shapes::Best => ModeChoice::BestForce,
        },
        lines: args.lines_per_side.unwrap_or_default().0,
        ..args.responses.options()
    };
    let problem = Problem::read(&args.layout, frfs, &args.hits)?;
    if let Some(understood) = problem.understood(&options).filter(|_| !output.json()) {
        output.note(understood);
    }
    let bar = output.bar(PERTURBATIONS, "uncertainty");
    let solution = solve_problem(&problem, &options, |done, total| {
        bar.set_length(total.into());
        bar.set_position(done.into());
    });
    bar.finish_and_clear();
    // With an answer they are among its findings.
    if solution.is_err() {
        for suspicion in problem.layout.suspicions() {
            output.warn(format!("{}: {suspicion}", args.layout.display()));
        }
    }
    let solution = solution?;
    output.conclude(solution.verdict());
    let next = (args.details.extent(), &NextStep::Details);
    show::print(&solution, &solution.result(), next, output)
}
