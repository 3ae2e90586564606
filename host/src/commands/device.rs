//! `massline device`: finds rigs, shows their identity and counters, tests them at rest, aborts campaigns, raises the
//! level at which a chip resets itself, erases the store of a rig in safe mode.

pub mod brown_out;
mod check;
mod erase;
mod stats;

use std::fmt::Write;

use massline_protocol::BootReason;
use massline_protocol::message::{Identity, Status};
use massline_shared::measurement::campaign;

use crate::Result;
use crate::output::{Output, counted};
use crate::support::connect::PortArgs;
use crate::support::rest::has_campaign;
use massline_client::campaign::phase_name;
use massline_client::{Client, PortFacts, list_ports};
use massline_report::document::{DeviceAbort, DeviceIdentity, DeviceList, Port};
use massline_report::words::hash_text;
use stats::Report;

/// Arguments of `massline device`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  massline device list
  massline device identify --port /dev/ttyACM0
  massline device stats --json
  massline device abort")]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List the USB serial ports of this computer.
    #[command(after_help = "Examples:\n  massline device list\n  massline device list --json")]
    List,
    /// Show the rig's identity and what it is doing.
    #[command(after_help = "\
Examples:
  massline device identify
  massline device identify --port /dev/ttyACM0 --json")]
    Identify(PortArgs),
    /// Show the rig's counters since power-on: lost scans, broken frames, flash erases, stack; and which of
    /// them need attention.
    #[command(after_help = "\
A counter that is not zero and means something is explained below the counters, with what to do
about it; in the JSON that is `findings`.

Examples:
  massline device stats
  massline device stats --port /dev/ttyACM0 --json")]
    Stats(PortArgs),
    /// Abort the campaign that is running or interrupted on the rig; its hits are discarded, results stay.
    #[command(after_help = "\
Examples:
  massline device abort
  massline device abort --port /dev/ttyACM0 --json")]
    Abort(PortArgs),
    /// Test the rig at rest: level, noise and hum of every channel, and what they say about wiring and parts.
    Check(check::Args),
    /// Have the rig's chip reset itself before its supply is too low to work.
    BrownOut(brown_out::Args),
    /// Erase results, layouts and calibration of a rig in safe mode.
    Erase(erase::Args),
}

/// Runs the command.
///
/// # Errors
/// When the rig cannot be reached.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    match &args.command {
        Command::List => {
            let ports = list_ports()?;
            output.answer(&ports_json(&ports), |_| ports_text(&ports))
        }
        Command::Identify(port) => {
            let (mut client, identity) = port.connect(output)?;
            let doing = RigActivity::of(&mut client, &identity)?;
            let value = identity_json(client.port(), &identity, doing);
            output.answer(&value, |_| identity_text(client.port(), &identity, doing))
        }
        Command::Stats(port) => {
            let (mut client, identity) = port.connect(output)?;
            let (stats, hardware) = (client.stats()?, client.hardware()?.unwrap_or_default());
            let battery = client.battery()?;
            let report = Report { identity: &identity, stats, hardware, battery };
            output.answer(&report.json(), |_| report.text())
        }
        Command::Abort(port) => {
            let (mut client, _) = port.connect(output)?;
            abort(&mut client, output)
        }
        Command::Check(args) => check::run(args, output),
        Command::BrownOut(args) => brown_out::run(args, output),
        Command::Erase(args) => erase::run(args, output),
    }
}

/// What a rig is doing.
#[derive(Clone, Copy, Debug)]
struct RigActivity {
    phase: &'static str,
    /// 0 without one, and in safe mode, where the store is not read.
    layout_hash: u32,
    result: u32,
}

impl RigActivity {
    /// Asks the rig; in safe mode it does not answer that.
    fn of(client: &mut Client, identity: &Identity) -> Result<Self> {
        if is_in_safe_mode(identity) {
            return Ok(Self { phase: "safe_mode", layout_hash: 0, result: 0 });
        }
        let Status { phase, layout_hash, result, .. } = client.status()?;
        Ok(Self { phase: phase_name(phase), layout_hash, result })
    }
}

/// True when the rig runs nothing but link and panel.
fn is_in_safe_mode(identity: &Identity) -> bool {
    BootReason::from(identity.boot_reason) == BootReason::SafeMode
}

const SAFE_MODE: &str = "
Its last three starts ended in a panic or a hang, so it runs nothing but its link and its panel. Press its reset
button or switch it off and on: it starts as usual. If it comes back to this, what it stores may be the cause:
`massline device erase` erases that. If that does not help either, flash the newest firmware and report what is
said here.";

/// Aborts the campaign on the rig, if there is one.
fn abort(client: &mut Client, output: &mut Output) -> Result<()> {
    let status = client.status()?;
    let is_running = has_campaign(&status)?;
    let hits: u32 = status.accepted.iter().map(|&hits| u32::from(hits)).sum();
    if is_running {
        client.command(campaign::Command::Abort)?;
    }
    let value =
        DeviceAbort { aborted: is_running, discarded_hits: if is_running { hits } else { 0 } };
    output.answer(&value, |_| match is_running {
        true => {
            format!("aborted, stored results stay; discarded: {}", counted(hits, "accepted hit"))
        }
        false => "there was no campaign to abort".into(),
    })
}

fn ports_json(ports: &[PortFacts]) -> DeviceList {
    let port = |port: &PortFacts| Port {
        path: port.path.clone(),
        vendor: port.usb.map(|usb| usb.0),
        product: port.usb.map(|usb| usb.1),
        description: port.description.clone(),
    };
    DeviceList { ports: ports.iter().map(port).collect() }
}

fn ports_text(ports: &[PortFacts]) -> String {
    if ports.is_empty() {
        return "no USB serial port; a simulated rig: `massline virtual`".into();
    }
    let lines: Vec<_> = ports.iter().map(|p| format!("{}  {}", p.path, p.description)).collect();
    lines.join("\n")
}

fn identity_json(port: &str, identity: &Identity, doing: RigActivity) -> DeviceIdentity {
    DeviceIdentity {
        port: port.to_owned(),
        protocol: format!("{}.{}", identity.protocol_major, identity.protocol_minor),
        firmware: identity.firmware.as_str().to_owned(),
        git_hash: identity.git_hash.as_str().to_owned(),
        git_dirty: identity.git_dirty,
        board: identity.board.as_str().to_owned(),
        scan_rate_hz: identity.adc.rate.0.into(),
        channels: identity.adc.channels,
        adc_bits: identity.adc.bits,
        adc_reference_v: identity.adc.reference.0.into(),
        channel_delay_s: identity.adc.channel_delay.0.into(),
        record_scans: identity.record_scans,
        pre_trigger_scans: identity.pre_trigger_scans,
        max_sensors: identity.max_sensors,
        max_hits: identity.max_hits,
        streams: identity.streams,
        boot_reason: BootReason::from(identity.boot_reason).name().into(),
        last_panic: identity.last_panic.as_str().to_owned(),
        phase: doing.phase.into(),
        layout_hash: hash_text(doing.layout_hash),
        result: (doing.result != 0).then_some(doing.result),
    }
}

fn identity_text(port: &str, identity: &Identity, doing: RigActivity) -> String {
    let dirty = if identity.git_dirty { ", changed" } else { "" };
    let none = if is_in_safe_mode(identity) { "not read" } else { "none" };
    let mut text = format!(
        "{port}\n  board      {}\n  firmware   {} ({}{dirty}), protocol {}.{}\n  sampling   {} scans/s, \
         {} channels, {} bits, {:.1} V, {:.1} µs between channels\n  record     {} scans, {} before \
         the trigger\n  capacity   {} sensors, {} hit DOFs\n  stream     {}\n  started    {}\n  \
         phase      {}\n  layout     {}\n  result     {}",
        identity.board,
        identity.firmware,
        identity.git_hash,
        identity.protocol_major,
        identity.protocol_minor,
        identity.adc.rate.0,
        identity.adc.channels,
        identity.adc.bits,
        identity.adc.reference.0,
        identity.adc.channel_delay.0 * 1e6,
        identity.record_scans,
        identity.pre_trigger_scans,
        identity.max_sensors,
        identity.max_hits,
        if identity.streams { "yes" } else { "no, the link is too slow" },
        BootReason::from(identity.boot_reason).name(),
        doing.phase,
        hash_text(doing.layout_hash).unwrap_or_else(|| none.into()),
        if doing.result == 0 { none.into() } else { doing.result.to_string() },
    );
    if identity.last_panic.is_empty() && is_in_safe_mode(identity) {
        text.push_str("\n  last failure  it hung");
    }
    if !identity.last_panic.is_empty() {
        // Writing to a String cannot fail.
        let _ = write!(text, "\n  last panic {}", identity.last_panic);
    }
    if is_in_safe_mode(identity) {
        text.push_str(SAFE_MODE);
    }
    text
}
