//! `massline doctor`: what is plugged in, what may be opened, what is missing on this computer, and what to do about
//! it.

use std::process::{Command, Stdio};

use massline_boards::BootLoader;

use crate::Result;
use crate::output::{Output, Tone};
use crate::support::version::VERSION;
use massline_client::firmware::EMULATOR;
use massline_client::flash::board::{BOARDS, Board};
use massline_client::flash::drive::{self, Kind};
use massline_client::flash::usb;
use massline_client::udev;
use massline_client::{self, Client, ClientError, PortFacts, Timing, list_ports};
use massline_report::document::{Doctor, DoctorFinding};

/// Arguments of `massline doctor`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Opens every USB serial port and asks what is there, looks for boards in their boot loaders, and
checks what the emulated rig needs. Nothing is changed. The exit code is 0 also when something is
missing: read what it says.

Examples:
  massline doctor
  massline doctor --json | jq '.findings[] | select(.state != \"good\")'")]
pub struct Args {}

/// How something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// It is there and works.
    Good,
    /// It is not there, and only some commands need it.
    Absent,
    /// It does not work.
    Bad,
}

impl State {
    fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Absent => "absent",
            Self::Bad => "bad",
        }
    }

    fn tone(self) -> Tone {
        match self {
            Self::Good => Tone::Good,
            Self::Absent => Tone::Warning,
            Self::Bad => Tone::Bad,
        }
    }
}

/// Something that was looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Finding {
    subject: String,
    state: State,
    observation: String,
    /// What to do.
    advice: Option<String>,
}

impl Finding {
    fn new(subject: impl Into<String>, state: State, observation: impl Into<String>) -> Self {
        Self { subject: subject.into(), state, observation: observation.into(), advice: None }
    }

    fn advising(self, advice: impl Into<String>) -> Self {
        Self { advice: Some(advice.into()), ..self }
    }

    fn to_json(&self) -> DoctorFinding {
        DoctorFinding {
            subject: self.subject.clone(),
            state: self.state.name().into(),
            found: self.observation.clone(),
            advice: self.advice.clone(),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// None: what is wrong is what it prints.
pub fn run(_: &Args, output: &mut Output) -> Result<()> {
    let mut findings = vec![Finding::new("massline", State::Good, about_program())];
    findings.extend(ports());
    findings.extend(BOARDS.iter().filter_map(in_boot_loader));
    findings.push(probes());
    findings.push(emulator());
    let value = Doctor { findings: findings.iter().map(Finding::to_json).collect() };
    output.answer(&value, |output| {
        let line = |finding: &Finding| {
            let state = output.toned(finding.state.name(), finding.state.tone());
            let advice = finding.advice.iter().flat_map(|text| text.lines());
            let advice: String = advice.map(|line| format!("\n    {line}")).collect();
            format!("{state}  {}: {}{advice}", finding.subject, finding.observation)
        };
        findings.iter().map(line).collect::<Vec<_>>().join("\n")
    })
}

fn about_program() -> String {
    format!(
        "{VERSION} for {} on {}, protocol {}.{}",
        std::env::consts::OS,
        std::env::consts::ARCH,
        massline_protocol::PROTOCOL_MAJOR,
        massline_protocol::PROTOCOL_MINOR
    )
}

/// What is behind every USB serial port.
fn ports() -> Vec<Finding> {
    match list_ports() {
        Err(error) => vec![Finding::new("ports", State::Bad, error.to_string())],
        Ok(ports) if ports.is_empty() => {
            let none = Finding::new("ports", State::Absent, "no USB serial port");
            vec![none.advising(
                "connect the rig with a cable that carries data, or try `massline virtual` without one",
            )]
        }
        Ok(ports) => ports.iter().map(behind).collect(),
    }
}

/// What answers at a port.
fn behind(port: &PortFacts) -> Finding {
    let subject = format!("{} ({})", port.path, port.description);
    let asked = massline_client::open(&port.path)
        .map(|transport| {
            Client::with_timing(transport, Timing { attempts: 2, ..Timing::default() })
        })
        .and_then(|mut client| Ok(client.identify()?));
    match asked {
        Ok(rig) => {
            let dirty = if rig.git_dirty { ", changed" } else { "" };
            let observation = format!(
                "a rig: {}, firmware {} (commit {}{dirty})",
                rig.board, rig.firmware, rig.git_hash
            );
            Finding::new(subject, State::Good, observation)
        }
        Err(error) if error.code() == ClientError::DENIED => {
            Finding::new(subject, State::Bad, error.to_string())
                .advising(udev::advice("tty", "ATTRS", port.usb))
        }
        Err(error) => Finding::new(subject, State::Bad, error.to_string()),
    }
}

/// A board that waits for firmware; `None` when there is none of this kind.
fn in_boot_loader(board: &Board) -> Option<Finding> {
    let subject = format!("{} in its boot loader", board.name);
    let advice = format!("massline flash --board {}", board.name);
    let finding = match board.boot_loader.as_ref()? {
        BootLoader::Dfu(loader) => usb::is_connected(loader).map(|is_connected| {
            is_connected.then(|| Finding::new(&subject, State::Good, "it may be opened"))
        }),
        BootLoader::Uf2(_) | BootLoader::StLink(_) => {
            let drive = drive::find(Kind::of(board)?, None).ok();
            Ok(drive.map(|at| Finding::new(&subject, State::Good, at.display().to_string())))
        }
    };
    match finding {
        Ok(finding) => finding.map(|finding| finding.advising(advice)),
        Err(error) if error.code() == usb::UNLISTED => Some(
            Finding::new("USB", State::Absent, error.to_string())
                .advising("only flashing through a chip's USB boot loader needs it"),
        ),
        Err(error) => Some(Finding::new(subject, State::Bad, error.to_string())),
    }
}

/// Whether this program can use a debug probe.
fn probes() -> Finding {
    if cfg!(feature = "probe") {
        return Finding::new(
            "debug probes",
            State::Good,
            "`massline flash --via probe` is built in",
        );
    }
    Finding::new("debug probes", State::Absent, "this program is built without them")
        .advising("boards with USB need none; else: cargo install --path host --features probe")
}

/// Whether the emulated rig can run.
fn emulator() -> Finding {
    let asked = Command::new(EMULATOR).arg("--version").stderr(Stdio::null()).output();
    let first = |bytes: Vec<u8>| {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        text.lines().next().unwrap_or_default().to_owned()
    };
    match asked {
        Ok(output) if output.status.success() => {
            Finding::new("emulated rig", State::Good, first(output.stdout))
        }
        _ => Finding::new("emulated rig", State::Absent, format!("{EMULATOR} is not installed"))
            .advising(
                "only `--rig qemu` needs it; on Debian or Ubuntu: apt-get install qemu-system-arm",
            ),
    }
}
