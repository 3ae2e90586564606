//! `massline replay`: runs the whole rig on a tape.

mod tape_player;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use massline_protocol::message::Status;
use massline_shared::measurement::campaign::{Command, Phase};

use crate::output::Output;
use crate::rig::SimulatedRig;
use crate::rig_solution::solve_test;
use crate::support::files;
use crate::support::method::MethodArgs;
use crate::support::progress::Progress;
use crate::support::show::{self, DetailsArgs, NextStep};
use crate::support::simulated::{RigArgs, SimulatedCampaign};
use crate::{Error, Result};
use massline_analysis::single_fault::NominalTest;
use massline_client::Client;
use massline_files::tape::Tape;
use tape_player::{TapeProgress, TapeSource};

/// A rig that is still armed this long after the end of a segment has found no hit in it, and one that still records
/// has not seen the end of the hit.
const GRACE: Duration = Duration::from_secs(1);

/// Arguments of `massline replay`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The tape is a NumPy array of raw ADC codes, little-endian u16, shape (scans, 10): the hammer, then
sensor 1 x, y, z, sensor 2 ...; a sidecar of the same name with .toml says how it was recorded and
which DOF was hit in each segment. A rejected segment is not repeated: the replay warns of a DOF
with too few accepted hits, and ends with exit 3 at a DOF with none.

Examples:
  massline replay frame-tape.npy --layout frame.toml
  massline replay frame-tape.npy --layout frame.toml --method ml
  massline replay frame-tape.npy --layout frame.toml --rig qemu --json
  massline replay frame-tape.npy --layout frame.toml --calibration rig.toml")]
pub struct Args {
    /// The tape; its sidecar has the same name with the extension `.toml`.
    tape: PathBuf,
    /// The layout file.
    #[arg(long, value_name = "FILE")]
    layout: PathBuf,
    /// Calibration file; default: the calibration in the sidecar.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    rig: RigArgs,
    #[command(flatten)]
    method: MethodArgs,
    #[command(flatten)]
    details: DetailsArgs,
}

/// Runs the command.
///
/// # Errors
/// When a file is bad or does not fit the others, the rig does not start or gets stuck, or the tape
/// cannot determine the answer.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let file = files::layout(&args.layout, output)?;
    let layout = files::for_rig(&file, &args.layout)?;
    let tape = Tape::read(&args.tape)?;
    if tape.cut_short {
        output.warn(format!(
            "{}: the recording was cut short; its {} whole scans are played",
            args.tape.display(),
            tape.scans.count()
        ));
    }
    let calibration = files::calibration(args.calibration.as_deref(), &file)?
        .unwrap_or_else(|| tape.sidecar.calibration.into());
    let firmware = args.rig.image()?;
    let (source, warning) =
        TapeSource::new(tape, &layout).map_err(|e| e.within(args.tape.display()))?;
    if let Some(warning) = warning {
        output.warn(warning);
    }
    let progress = source.progress();
    let mut rig = SimulatedRig::start(args.rig.rig, firmware.as_deref(), Box::new(source))?;
    let campaign =
        SimulatedCampaign { label: "replay", layout: &layout, calibration: &calibration };
    let mut player = Player { tape: progress, silent_since: None };
    let result = campaign
        .run(&mut rig, output, &mut |client, status, shown| player.steer(client, status, shown))?;
    let nominal = NominalTest::of_file(&file);
    let solution = solve_test(result.test(), &nominal, args.method.selection());
    output.conclude(solution.verdict());
    let next = (args.details.extent(), &NextStep::Details);
    show::print(&solution, &solution.result(), next, output)
}

/// Finishes a DOF whose segments are used up.
struct Player {
    tape: TapeProgress,
    /// The arming whose segment has ended without a hit so far, and the time of its end.
    silent_since: Option<(u32, Instant)>,
}

impl Player {
    fn steer(
        &mut self,
        client: &mut Client,
        status: &Status,
        shown: &mut Progress,
    ) -> Result<Option<Command>> {
        if let Some(failed) = self.tape.failed() {
            let message = format!("the tape cannot be played on: {failed}");
            return Err(Error::input("tape_not_readable", message));
        }
        let dof = usize::from(status.dof);
        match Phase::try_from(status.phase).ok() {
            Some(Phase::Armed) => {}
            Some(Phase::Busy) if self.tape.played_out() => {
                return if self.is_silent(status) { Err(torn(shown.dof(dof))) } else { Ok(None) };
            }
            _ => {
                self.silent_since = None;
                return Ok(None);
            }
        }
        if self.tape.exhausted() == Some(dof) {
            // The status may be older than the tape's state, so a new one is requested.
            let status = client.status()?;
            client.discard_statuses();
            let armed = Phase::try_from(status.phase).ok() == Some(Phase::Armed);
            if armed && usize::from(status.dof) == dof {
                return end(&status, dof, shown).map(Some);
            }
            return Ok(None);
        }
        if self.tape.played_out() && self.is_silent(status) {
            self.silent_since = None;
            shown.line(&format!("a segment of {} holds no hit", shown.dof(dof)));
            self.tape.play_next();
        }
        Ok(None)
    }

    /// True when the segment of this arming has ended a while ago.
    fn is_silent(&mut self, status: &Status) -> bool {
        let since = match self.silent_since {
            Some((arming, since)) if arming == status.armings => since,
            _ => Instant::now(),
        };
        self.silent_since = Some((status.armings, since));
        since.elapsed() > GRACE
    }
}

/// The error of a tape that ends while the rig records a hit at this DOF.
fn torn(dof: &str) -> Error {
    let text = format!(
        "the tape ends within the record of a hit at {dof}; record {dof} again, or remove its last segment from \
         the sidecar"
    );
    Error::input("tape_ends_in_a_record", text)
}

/// Finishes the DOF with the hits that it has; without any the data cannot determine the answer.
fn end(status: &Status, dof: usize, shown: &mut Progress) -> Result<Command> {
    let name = shown.dof(dof).to_owned();
    let accepted = status.accepted.get(dof).copied().unwrap_or(0);
    if accepted == 0 {
        return Err(Error::undetermined(
            "dof_without_hits",
            format!(
                "the tape has no segment of {name} that the rig accepts; record {name} again, or \
                 leave it out of the layout if three others remain"
            ),
        ));
    }
    let wanted = status.hits_per_dof;
    shown.line(&format!(
        "warning: {name} is finished with {accepted} of {wanted} hits, because the tape has no more"
    ));
    Ok(Command::Finish)
}
