//! `massline device check`: the self-test of a rig at rest.

use massline_protocol::message::{Identity, Reason};

use crate::output::{Output, counted};
use crate::support::connect::PortArgs;
use crate::{Error, Result};
use massline_analysis::self_test::RigAtRest;
use massline_client::Client;
use massline_client::flash::board::circuit_of;
use massline_report::self_test::{json, text};

/// Arguments of `massline device check`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Lay the rig and its sensors down, or let the object hang still, and touch nothing for a second. The
check reads every channel: its level, its noise, the mains and the screen's ripple in it. From these
it names broken and swapped wires, a hammer that is not plugged in, a sensor of another type, and
more, with what to do. It exits with 3 when it finds something. A capacitor that was left on a
breakout shows in the block test only: massline calibrate block.

Examples:
  massline device check
  massline device check --port /dev/ttyACM0 --json")]
pub struct Args {
    #[command(flatten)]
    port: PortArgs,
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached or does not sample, and when a fault is found.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let (mut client, identity) = args.port.connect(output)?;
    let check = examine(&mut client, &identity)?;
    let document = json(&check);
    if check.findings.is_empty() {
        return output.answer(&document, |_| text(&check));
    }
    if !output.json() {
        output.text(text(&check))?;
    }
    output.explain(&document);
    let first = check.findings[0].code.to_string();
    let faults = counted(check.findings.len(), "fault");
    Err(Error::undetermined(first, format!("the check has found {faults}: see what to do above")))
}

/// Has the rig read its channels at rest, and examines what it has read.
fn examine(client: &mut Client, identity: &Identity) -> Result<RigAtRest> {
    let calibration = client.calibration()?;
    let read = client.rest_statistics();
    // Asked afterwards, because the converter was started for it.
    let hardware = client.hardware()?.unwrap_or_default();
    match read {
        Err(error) if error.refusal() == Some(Reason::SamplerStopped) => {
            return Ok(RigAtRest::of_stopped(hardware));
        }
        read => read?,
    };
    let record = client.rest_record()?.ok_or_else(|| {
        Error::device("no_record", "the rig gives no record at rest; update its firmware")
    })?;
    Ok(RigAtRest::of(&record, &identity.adc, circuit_of(&identity.board), &calibration, hardware))
}
