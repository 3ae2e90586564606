//! `massline export`: writes a result as a file of another program.

use std::path::{Path, PathBuf};

use massline_protocol::LayoutHash;
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;
use serde_json::json;

use super::connect::PortArgs;
use super::files::{self, ReplaceArgs};
use super::method;
use crate::error::Result;
use crate::export::{Exported, Format, Frame, UnitSystem, of_value, read_subject};
use crate::file;
use crate::host_solution::HostSolution;
use crate::identification::Selection;
use crate::output::Output;
use crate::report;

/// Arguments of `massline export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
RESULT is the output of solve, measure, results get, simulate or replay with --json (- reads standard
input), or the number of a result on the rig; a file whose name is a number is ./3. Of the answers
in it the best is exported, or that of --method. Where the host has solved a rig's result again,
the host's answer is exported.

Every file states its units, its frame and the convention of its inertia: about the centre of mass,
products of inertia as elements of the tensor, Jxy = -(integral of x y dm). CONM2 takes the opposite
sign, and gets it. Standard deviations, intervals and the covariance go with frame and units. A
frame at the centre of mass or along the principal axes is fixed where the estimate puts it; what
is zero there keeps its standard deviation.

A result that no physical body can have is refused with exit 3. --unphysical writes it all the
same; --force is only for files that exist.

Examples:
  massline export result.json --format urdf -o frame.urdf
  massline export result.json --format conm2 --units t-mm --frame com
  massline export result.json --format mjcf --frame 4 --layout frame.toml
  massline export 3 --format yaml --port /dev/ttyACM0
  massline export result.json --format npz --method irm -o frame.npz
  massline solve frame.toml frame.uff --json | massline export - --format sdf")]
pub struct Args {
    /// A file with the JSON output of a command, - for standard input, or the number of a result on the rig.
    result: String,
    /// Format of the file.
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Format,
    /// Units of the file; urdf, sdf, mjcf and uff are SI by definition.
    #[arg(long, value_enum, value_name = "UNITS", default_value_t)]
    units: UnitSystem,
    /// Frame of the file: body, com (centre of mass), principal, or the number of a node.
    #[arg(long, value_name = "FRAME", default_value_t)]
    frame: Frame,
    /// Layout file of the test: the title, and the nodes for --frame.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    #[arg(
        long,
        value_name = "METHOD",
        value_parser = method::one_of(Method::ALL),
        help = "The answer of this method; default: the best"
    )]
    method: Option<Method>,
    /// Write to this file instead of standard output.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
    /// Write a result that no physical body can have.
    #[arg(long)]
    unphysical: bool,
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the result cannot be read, is unphysical or lacks what the format needs, the format does not go with the units
/// or the frame, or the file cannot be written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    args.format.check(args.units, args.frame)?;
    match &args.output {
        Some(path) => file::check(path, args.replace.existing())?,
        None => output.check_unframed(args.format.is_binary())?,
    }
    let layout = args.layout.as_deref().map(|path| files::layout(path, output)).transpose()?;
    let mut exported = match args.result.parse::<u32>() {
        Ok(number) if number > 0 => on_rig(number, args, output)?,
        _ => read_subject(Path::new(&args.result), args.method)?,
    };
    if let Some(layout) = &layout {
        exported = exported.with_layout(layout);
    }
    if !args.format.holds_responses() {
        exported.check(args.unphysical)?;
        exported = exported.in_frame(args.frame)?.in_units(args.units);
        exported.check(args.unphysical)?;
    }
    let bytes = args.format.write(&exported)?;
    for note in &exported.notes {
        output.note(format!("note: {note}"));
    }
    if let (true, Some(condition)) = (args.unphysical, exported.violated_condition()) {
        output.warn(format!("this is not a physical body: {condition}"));
    }
    let Some(path) = &args.output else {
        return output.unframed(&bytes, args.format.is_binary());
    };
    file::write(path, &bytes, args.replace.existing())?;
    let value = json!({
        "written": path,
        "format": args.format.name(),
        "method": exported.method,
        "units": args.units.name(),
        "frame": args.frame.to_string(),
        "physically_consistent": exported.violated_condition().is_none(),
        "notes": exported.notes,
    });
    output.answer(&value, |_| format!("{}: the answer by {}", path.display(), exported.method))
}

/// A result that is stored on the rig, solved again here where the rig still has its layout.
fn on_rig(number: u32, args: &Args, output: &mut Output) -> Result<Exported> {
    let (mut client, _) = args.port.connect(output)?;
    let result = client.result(number)?;
    super::show::require_answer(&result)?;
    let layout = client.layout().ok().filter(|kept| kept.hash() == result.head.layout_hash);
    let layout: Option<HostLayout> = layout.and_then(|kept| kept.cast());
    let mut value = report::measurement_json(&result);
    if let Some(layout) = &layout {
        HostSolution::new(&result, layout, Selection::All).add_to(&mut value);
    }
    value["schema_version"] = json!(crate::output::SCHEMA_VERSION);
    let exported = of_value(&value, &format!("result {number} of the rig"), args.method)?;
    Ok(match layout {
        Some(layout) => exported.with_rig_layout(layout),
        None => exported,
    })
}
