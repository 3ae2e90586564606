//! `massline flash`: writes the firmware to a board.

use std::path::PathBuf;

use clap::builder::PossibleValuesParser;
use indicatif::ProgressBar;
use massline_boards::BootLoader;

use crate::commands::device::brown_out::{self, LevelOutcome};
use crate::output::Output;
use crate::{Error, Result};
use massline_client::firmware;
use massline_client::flash::board::{BOARDS, Board, FlashMethod};
use massline_client::flash::drive::{self, DriveOutcome, Kind};
use massline_client::flash::image::Image;
use massline_client::flash::plan::Plan;
use massline_client::flash::usb::DfuDevice;
use massline_client::flash::{ProgressObserver, Step, dfuse};
use massline_client::interrupt::Interrupt;
use massline_report::document::{AddressRange, Flashing};

/// Arguments of `massline flash`.
#[derive(Debug, clap::Args)]
#[command(after_help = after_help())]
pub struct Args {
    /// Name of the board.
    #[arg(long, value_parser = PossibleValuesParser::new(BOARDS.iter().map(|b| b.name.as_str())))]
    board: String,
    /// Firmware image from cargo (ELF); default: built from this checkout.
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// How to write the board's flash; default: the way that needs only a cable.
    #[arg(long, value_enum)]
    via: Option<FlashMethod>,
    /// Mount point of the board's drive, if it is not found automatically.
    #[arg(long, value_name = "FOLDER")]
    drive: Option<PathBuf>,
    /// Check the image and show what would be erased and written, without touching a board.
    #[arg(long)]
    dry_run: bool,
    /// With --dry-run and without --image: build the firmware first.
    #[arg(long, requires = "dry_run", conflicts_with = "image")]
    build: bool,
}

fn nothing_built() -> Error {
    Error::input(
        "no_image",
        "--dry-run builds nothing unless it is told to: give --image ELF, or --build to build the firmware first",
    )
}

/// Runs the command.
///
/// # Errors
/// When the image is not for the board, the board is not found, or it does not hold what was written.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let board = Board::named(&args.board)
        .ok_or_else(|| Error::internal("unknown_board", args.board.clone()))?;
    let way = way(args, board)?;
    let path = match &args.image {
        Some(path) => path.clone(),
        None if args.dry_run && !args.build => return Err(nothing_built()),
        None => {
            if !args.dry_run {
                // Building takes minutes.
                look_for(board, way, args)?;
            }
            firmware::build(&board.package, &board.target, "--image")?
        }
    };
    let plan = Plan::new(board, Image::read(&path, board)?)
        .map_err(|error| error.within(path.display()))?;
    let done = if args.dry_run { None } else { Some(flash(way, args, &plan, output)?) };
    let level = match done {
        Some(_) if board.brown_out => Some(brown_out::raise_after_start(&board.name, output)),
        _ => None,
    };
    let facts = Facts { way, plan: &plan, path: path.display().to_string(), done, level };
    output.answer(&facts.json(), |_| facts.text())
}

/// The help text with the ways to flash every board, and examples.
fn after_help() -> String {
    let ways: String = BOARDS.iter().map(way_line).collect();
    format!(
        "\
Ways:
{ways}
Without --image the firmware is built from the sources that this program was built from. What the
rig has stored is not written: layouts, calibration, results stay. An ST-LINK drive may erase more
than it writes: download your results first, or use --via probe.

Examples:
  massline flash --board blackpill-f411
  massline flash --board blackpill-f411 --dry-run --build
  massline flash --board nucleo-g474re --image massline-nucleo-g474re
  massline flash --board pico2 --drive /media/me/RP2350 --json"
    )
}

/// `  pico2          drive: hold BOOTSEL while you plug it in; or probe`
fn way_line(board: &Board) -> String {
    let Board { name, boot_loader, .. } = board;
    match boot_loader {
        Some(loader) => {
            format!("  {name:<14} {}: {}; or probe\n", board.ways()[0].name(), loader.steps())
        }
        None => format!("  {name:<14} probe\n"),
    }
}

fn way(args: &Args, board: &Board) -> Result<FlashMethod> {
    let ways = board.ways();
    let way = match args.via {
        Some(way) => way,
        None if args.drive.is_some() => FlashMethod::Drive,
        None => ways[0],
    };
    let names: Vec<_> = ways.iter().map(|way| way.name()).collect();
    if !ways.contains(&way) {
        return Err(Error::input(
            "no_such_way",
            format!("{} is not flashed by {}; use {}", board.name, way.name(), names.join(" or ")),
        ));
    }
    if args.drive.is_some() && way != FlashMethod::Drive {
        return Err(Error::input("usage", "--drive goes with --via drive"));
    }
    Ok(way)
}

/// How certain it is that the board holds the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FlashOutcome {
    ReadBack,
    Started,
    Unverified,
}

/// Looks for the board, as [`flash`] does after the firmware is built.
///
/// # Errors
/// When it is not found.
fn look_for(board: &Board, way: FlashMethod, args: &Args) -> Result<()> {
    match way {
        FlashMethod::Dfu => match &board.boot_loader {
            Some(BootLoader::Dfu(loader)) => DfuDevice::open(loader).map(|_| ()),
            _ => Err(unknown("boot loader that speaks DFU", board)),
        },
        FlashMethod::Drive => {
            let kind = Kind::of(board).ok_or_else(|| unknown("drive", board))?;
            drive::find(kind, args.drive.as_deref()).map(|_| ())
        }
        FlashMethod::Probe => look_for_probe(),
    }
}

fn flash(way: FlashMethod, args: &Args, plan: &Plan, output: &mut Output) -> Result<FlashOutcome> {
    let interrupt = output.interrupt().clone();
    let _guard = interrupt.guard();
    let mut watch = Bar::new(output, plan, interrupt.clone());
    match way {
        FlashMethod::Dfu => {
            let Some(BootLoader::Dfu(loader)) = &plan.board.boot_loader else {
                return Err(unknown("boot loader that speaks DFU", plan.board));
            };
            dfuse::flash(&DfuDevice::open(loader)?, plan, &mut watch)
                .map(|()| FlashOutcome::ReadBack)
        }
        FlashMethod::Drive => {
            let kind = Kind::of(plan.board).ok_or_else(|| unknown("drive", plan.board))?;
            let drive = drive::find(kind, args.drive.as_deref())?;
            drive::flash(kind, &drive, plan, &mut watch).map(|taken| match taken {
                DriveOutcome::Started => FlashOutcome::Started,
                DriveOutcome::Unconfirmed => FlashOutcome::Unverified,
            })
        }
        FlashMethod::Probe => by_probe(plan, &mut watch),
    }
}

/// The error for a way that the board does not have; not reached, because [`way`] rejects it first.
fn unknown(feature: &str, board: &Board) -> Error {
    Error::internal("no_such_way", format!("{} has no {feature}", board.name))
}

#[cfg(feature = "probe")]
fn by_probe(plan: &Plan, watch: &mut dyn ProgressObserver) -> Result<FlashOutcome> {
    massline_client::flash::probe::flash(plan, watch).map(|()| FlashOutcome::ReadBack)
}

#[cfg(feature = "probe")]
fn look_for_probe() -> Result<()> {
    massline_client::flash::probe::find().map(|_| ())
}

#[cfg(not(feature = "probe"))]
fn by_probe(_: &Plan, _: &mut dyn ProgressObserver) -> Result<FlashOutcome> {
    Err(built_without_probe())
}

#[cfg(not(feature = "probe"))]
fn look_for_probe() -> Result<()> {
    Err(built_without_probe())
}

#[cfg(not(feature = "probe"))]
fn built_without_probe() -> Error {
    Error::input(
        "built_without_probe",
        "this massline was built without probes: cargo install --path host --features probe",
    )
}

/// A progress bar on the terminal.
struct Bar {
    bar: ProgressBar,
    step: Option<Step>,
    interrupt: Interrupt,
}

impl Bar {
    fn new(output: &Output, plan: &Plan, interrupt: Interrupt) -> Self {
        Self { bar: output.bar(plan.image.len(), &plan.board.name), step: None, interrupt }
    }
}

impl ProgressObserver for Bar {
    fn at(&mut self, step: Step, done: u64, total: u64) -> Result<()> {
        if self.interrupt.pressed() {
            return Err(Error::interrupted(match step {
                Step::Erase if done == 0 => "stopped before anything was erased",
                Step::Erase | Step::Write => {
                    "stopped: the firmware on the board is incomplete; run the same command again"
                }
                Step::Verify => {
                    "stopped: everything is written, but not all of it verified; run the same command \
                     again to be sure"
                }
            }));
        }
        if self.step != Some(step) {
            self.step = Some(step);
            self.bar.set_length(total);
            self.bar.set_message(match step {
                Step::Erase => "bytes erased",
                Step::Write => "bytes written",
                Step::Verify => "bytes read back",
            });
        }
        self.bar.set_position(done);
        Ok(())
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Said when the rig did not answer after it was flashed.
const NOT_RAISED: &str = "the rig has not answered yet, so the level at which its chip resets itself was left as it \
                          is: `massline device brown-out` raises it";

/// The answer of the command.
struct Facts<'p> {
    way: FlashMethod,
    plan: &'p Plan,
    path: String,
    /// `None` after a dry run.
    done: Option<FlashOutcome>,
    /// What became of the level below which the chip resets itself; `None` for a board without one, and after a dry
    /// run.
    level: Option<LevelOutcome>,
}

impl Facts<'_> {
    fn json(&self) -> Flashing {
        let range = |start: u32, end: u64| AddressRange { start, end };
        let Plan { board, image, erase } = self.plan;
        Flashing {
            board: board.name.clone(),
            image: self.path.clone(),
            via: self.way.name(),
            segments: image.segments.iter().map(|s| range(s.address, s.end())).collect(),
            bytes: image.len(),
            sectors: erase.iter().map(|s| range(s.start, s.end.into())).collect(),
            store: range(board.store.start, board.store.end.into()),
            flashed: self.done.is_some(),
            verified: self.done.map(|done| done != FlashOutcome::Unverified),
            brown_out_mv: match &self.level {
                Some(LevelOutcome::Raised(level)) => Some(*level),
                _ => None,
            },
        }
    }

    fn text(&self) -> String {
        let board = self.plan.board;
        let mut lines = vec![format!("{}: {}", board.name, self.path)];
        for segment in &self.plan.image.segments {
            lines.push(format!(
                "  image    0x{:08x} to 0x{:08x}  {:7} bytes",
                segment.address,
                segment.end(),
                segment.bytes.len()
            ));
        }
        lines.push(format!(
            "  erased   {} sectors, {} bytes\n  store    0x{:08x} to 0x{:08x}, {}",
            self.plan.erase.len(),
            self.plan.erased(),
            board.store.start,
            board.store.end,
            self.store_is()
        ));
        lines.push(self.outcome().into());
        match &self.level {
            Some(LevelOutcome::Raised(level)) => lines.push(brown_out::text(*level)),
            Some(LevelOutcome::Refused(why)) => lines.push(format!(
                "the level at which its chip resets itself was left as it is: {why}"
            )),
            Some(LevelOutcome::Silent) => lines.push(NOT_RAISED.into()),
            None => {}
        }
        lines.join("\n")
    }

    /// What happens to the stored data.
    fn store_is(&self) -> &'static str {
        match Kind::of(self.plan.board) {
            Some(Kind::StLink(_)) if self.way == FlashMethod::Drive => {
                "not written; what the ST-LINK erases is up to its firmware: fetch results first"
            }
            _ => "not touched",
        }
    }

    fn outcome(&self) -> &'static str {
        match self.done {
            None => "nothing flashed: this was a dry run",
            Some(FlashOutcome::ReadBack) => {
                "flashed, read back and found the same; the rig starts. Next: massline device identify"
            }
            Some(FlashOutcome::Started) => {
                "the boot loader has taken every block and started the rig. Next: massline device identify"
            }
            Some(FlashOutcome::Unverified) => {
                "the ST-LINK has taken the file without a complaint. Next: massline device identify, which \
                 shows whether the rig runs"
            }
        }
    }
}
