//! `massline export`: writes a result as a file of another program.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;

use crate::output::Output;
use crate::rig_lines::{RigLines, StoredTest};
use crate::support::connect::PortArgs;
use crate::support::files::{self, ReplaceArgs};
use crate::support::measured::{of_archive, of_measurement, result_of_archive, test_of_archive};
use crate::support::method;
use crate::{Error, Result};
use massline_files::archive::{self, Archive};
use massline_files::file;
use massline_report::document::{ExportedAnswer, ExportedFile};
use massline_report::export::{
    ExportedResult, Format, Frame, TestData, UnitSystem, read_subject, universal_file,
};
use massline_result::Verdict;

/// Arguments of `massline export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
RESULT is an archive (FRAME.massline), the output of solve, measure, results get, simulate or replay
with --json (- reads standard input), or the number of a result on the rig; a file whose name is a
number is ./3. Of the answers in it the best is exported, or that of --method. What a rig has
measured is solved again here, and that answer is exported. Frequency responses (uff) are in the
archives of massline measure, which need no answer for them.

Every file states its units, its frame and the convention of its inertia: about the centre of mass,
products of inertia as elements of the tensor, J_xy = -(integral of x y dm). CONM2 takes the opposite
sign, and gets it. Standard deviations, intervals and the covariance go with frame and units. A
frame at the centre of mass or along the principal axes is fixed where the estimate puts it; what
is zero there keeps its standard deviation.

The verdict on the result is in the header of the file. A result that is not to be used, because it is
contradicted or no physical body can have it, is refused with exit 3. --despite-verdict writes it all
the same; --force is only for files that exist.

Examples:
  massline export result.json --format urdf -o frame.urdf
  massline export result.json --format conm2 --units t-mm --frame com
  massline export result.json --format mjcf --frame 4 --layout frame.toml
  massline export frame.massline --format uff -o frame.uff
  massline export 3 --format yaml --port /dev/ttyACM0
  massline export result.json --format npz --method irm -o frame.npz
  massline solve frame.toml frame.uff --json | massline export - --format sdf")]
pub struct Args {
    /// An archive, the JSON output of a command, - for standard input, or the number of a result on the rig.
    result: String,
    /// Format of the file.
    #[arg(long, value_enum, value_name = "FORMAT")]
    format: Option<Format>,
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
    /// Write a result whose verdict is not to use it: contradicted data, or no physical body.
    #[arg(long)]
    despite_verdict: bool,
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the result cannot be read, is unphysical or lacks what the format needs, the format does not go with the units
/// or the frame, or the file cannot be written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let format = args.format()?;
    format.check(args.units, args.frame)?;
    match &args.output {
        Some(path) => file::check(path, args.replace.existing())?,
        None => output.check_unframed(format.is_binary())?,
    }
    let layout = args.layout.as_deref().map(|path| files::layout(path, output)).transpose()?;
    let with_layout = |test: TestData| match &layout {
        Some(layout) => test.with_layout(layout),
        None => test,
    };
    let archive = match args.archive() {
        Some((path, name)) => Some((Archive::read(path)?, name)),
        None => None,
    };
    if let Some((archive, name)) = archive.as_ref().filter(|_| format.holds_responses()) {
        // Also of a test without an answer.
        let test = with_layout(test_of_archive(archive, name));
        let verdict = match archive.answers() {
            Some(result) => result.verdict,
            None => result_of_archive(archive).verdict,
        };
        if verdict == Some(Verdict::DoNotUse) {
            output.warn(
                "verdict: do not use the answer of this test; the responses are written as they were measured",
            );
        }
        return args.deliver(
            &universal_file(&test, verdict)?,
            &test,
            None,
            "the responses",
            output,
        );
    }
    let exported = match (&archive, args.number()) {
        (Some((archive, name)), _) => of_archive(archive, name, args.method)?,
        (None, Some(number)) => on_rig(number, args, output)?,
        (None, None) => read_subject(Path::new(&args.result), args.method)?,
    };
    let mut exported = exported.with_test(with_layout);
    if !format.holds_responses() {
        exported.check(args.despite_verdict)?;
        exported = exported.in_frame(args.frame)?.in_units(args.units);
        exported.check(args.despite_verdict)?;
    }
    let bytes = format.write(&exported)?;
    if let (true, Some(condition)) = (args.despite_verdict, exported.violated_condition()) {
        output.warn(format!("this is not a physical body: {condition}"));
    }
    if exported.verdict != Verdict::Good {
        let mut doubts = exported.doubts.iter();
        let first = doubts.next().map_or_else(String::new, |doubt| format!(": {doubt}"));
        output.warn(format!("verdict: {}{first}", exported.verdict.words()));
        doubts.for_each(|doubt| output.warn(doubt));
    }
    let answer = ExportedAnswer {
        method: exported.method().to_owned(),
        physically_consistent: exported.violated_condition().is_none(),
        verdict: exported.verdict,
        doubts: exported.doubts.clone(),
    };
    let contents = format!("the answer by {}", exported.method());
    args.deliver(&bytes, &exported.test, Some(answer), &contents, output)
}

impl Args {
    /// The format, which has no default.
    fn format(&self) -> Result<Format> {
        self.format.ok_or_else(|| {
            let names: Vec<_> =
                Format::value_variants().iter().map(|format| format.name()).collect();
            let example = Format::Csv.name();
            let message = format!(
                "--format is missing; give one of {}: massline export {} --format {example}",
                names.join(", "),
                self.result
            );
            Error::input("usage", message)
        })
    }

    /// The number of a result on the rig, if that is what is exported.
    fn number(&self) -> Option<u32> {
        self.result.parse().ok().filter(|&number| number > 0)
    }

    /// The path and name of an archive, if that is what is exported.
    fn archive(&self) -> Option<(&Path, String)> {
        let path = Path::new(&self.result);
        let is_one = self.number().is_none() && archive::is_archive(path);
        is_one.then(|| (path, path.file_name().unwrap_or_default().to_string_lossy().into_owned()))
    }

    /// Writes the file, and says what it holds when it is not on standard output.
    fn deliver(
        &self,
        bytes: &[u8],
        test: &TestData,
        answer: Option<ExportedAnswer>,
        contents: &str,
        output: &mut Output,
    ) -> Result<()> {
        for note in &test.notes {
            output.note(format!("note: {note}"));
        }
        let Some(path) = &self.output else {
            return output.unframed(bytes, self.format()?.is_binary());
        };
        file::write(path, bytes, self.replace.existing())?;
        let value = ExportedFile {
            written: path.into(),
            format: self.format()?.name(),
            units: self.units.name(),
            frame: self.frame.to_string(),
            notes: test.notes.clone(),
            answer,
        };
        output.answer(&value, |_| format!("{}: {contents}", path.display()))
    }
}

/// A result that is stored on the rig, solved again here where the rig still has its layout.
fn on_rig(number: u32, args: &Args, output: &mut Output) -> Result<ExportedResult> {
    let (mut client, identity) = args.port.connect(output)?;
    let result = client.result(number)?;
    let lines = RigLines::read(&mut client, identity.adc, &result)?;
    let layout = client.stored_layout(result.head.layout_hash)?;
    let layout: Option<HostLayout> = layout.and_then(|kept| kept.cast());
    if layout.is_none() {
        crate::support::show::require_answer(&result)?;
    }
    let source = format!("result {number} of the rig");
    let test = StoredTest { result: &result, lines: &lines };
    let exported = of_measurement(test, layout.as_ref(), &source, args.method)?;
    Ok(match layout {
        Some(layout) => exported.with_test(|test| test.with_rig_layout(layout)),
        None => exported,
    })
}
