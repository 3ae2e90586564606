//! `massline virtual`: a virtual rig on a pty, or at a TCP address.

use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::time::Duration;

use massline_physics::{Bench, TapHandle};
use massline_protocol::BootReason;
use massline_shared::layout::{Dof, HostLayout};
use massline_virtual::flash::FlashBacking;
use massline_virtual::pipe::HostEnd;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};
use massline_virtual::sampler::Timing;
use massline_virtual::tcp::TcpServer;

use super::demo::LAYOUTS;
use crate::output::Output;
use crate::support::bench_test::{BenchArgs, source_on};
use crate::support::files;
use crate::{Error, Result};
use massline_analysis::bench_error::bench_error;
use massline_files::file;
use massline_files::layout_file::LayoutFile;
use massline_report::document::VirtualPort;

#[cfg_attr(unix, path = "virtual_rig/own_port_unix.rs")]
#[cfg_attr(not(unix), path = "virtual_rig/own_port_elsewhere.rs")]
mod own_port;

/// Polling interval for Ctrl-C and the rig.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Arguments of `massline virtual`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
The port for --port is printed on stdout: the path of a pty, or an address with --tcp and on systems
without ptys (Windows). One program at a time can use it. The layout says where the sensors sit on the bench and
which mark each prompt of the rig means; measure with the same one.

Examples:
  massline virtual                        taps by itself when the rig is armed
  massline virtual --manual               taps when you press Enter
  massline virtual --layout frame.toml --flash rig.bin
  massline measure frame.toml --port /dev/pts/5
  massline virtual --tcp 127.0.0.1:4000   at an address; port 0: any free one
  massline measure frame.toml --port tcp://127.0.0.1:4000")]
pub struct Args {
    #[command(flatten)]
    bench: BenchArgs,
    /// Layout file; default: the first test of the demo.
    #[arg(long, value_name = "FILE")]
    layout: Option<PathBuf>,
    /// Tap only when Enter is pressed.
    #[arg(long)]
    manual: bool,
    /// Store the rig's flash in this file; default: discarded at the end.
    #[arg(long, value_name = "FILE")]
    flash: Option<PathBuf>,
    /// Serve the rig at this address (HOST:PORT) instead of on a pty.
    #[arg(long, value_name = "ADDRESS")]
    tcp: Option<String>,
    /// Run as fast as possible instead of in real time.
    #[arg(long, conflicts_with = "manual")]
    fast: bool,
    /// Start in safe mode, as after three failed starts.
    #[arg(long)]
    safe_mode: bool,
}

/// Serves the rig until Ctrl-C.
///
/// # Errors
/// When a file is bad, the system has no pty left or the address is not free; exit 130 at Ctrl-C.
pub fn run(args: &Args, output: &mut Output) -> Result<()> {
    let bench = args.bench.open()?;
    let layout = layout(args, output)?;
    let mut source = source_on(&bench, &layout, args.bench.seed)?;
    let taps = args.manual.then(|| source.manual());
    let mut options = VirtualRigOptions::new(Box::new(source));
    options.timing = if args.fast { Timing::Simulated } else { Timing::RealTime };
    if args.safe_mode {
        options.boot_reason = BootReason::SafeMode;
        options.last_panic = "nothing has failed: this is --safe-mode";
    }
    if let Some(path) = &args.flash {
        options.flash = FlashBacking::File(path.clone());
    }
    if args.layout.is_none() && Bench::named("default").map_err(bench_error)?.body != bench.body {
        output.warn(
            "without --layout the sensors and marks are those of the demo's frame, which is not the object of this \
             bench: give its layout",
        );
    }
    let rig = VirtualRig::start(options)
        .map_err(|e| Error::input("virtual_rig", format!("the virtual rig does not start: {e}")))?;
    let served = match &args.tcp {
        Some(address) => serve_tcp(rig.link(), address)?,
        None => own_port::serve(rig.link())?,
    };
    let port = &served.port;
    if served.is_open_to_others {
        output.warn(format!(
            "this rig answers anybody who can reach {port}, without a password; 127.0.0.1 keeps it to this computer"
        ));
    }
    output.answer(&VirtualPort { port: port.clone() }, |_| port.clone())?;
    output.note(format!("massline measure LAYOUT --port {port}; Ctrl-C ends the rig"));
    if let Some(taps) = taps {
        output.note(
            "Enter taps where the rig waits, or where you tapped last; a DOF such as 1:+Y and Enter taps there",
        );
        let dofs = layout.hits.iter().map(|hit| hit.dof).collect();
        listen(taps, dofs, &rig);
    }
    let interrupt = output.interrupt().clone();
    let _guard = interrupt.guard();
    while !interrupt.pressed() {
        if let Some(panic) = rig.panicked() {
            return Err(Error::internal("rig_panicked", panic.to_string()));
        }
        std::thread::sleep(LOOK_EVERY);
    }
    Err(Error::interrupted("the virtual rig has ended"))
}

/// A port that serves the rig until this is dropped.
struct ServedPort {
    /// Its name, for `--port`.
    port: String,
    /// Other computers can reach it.
    is_open_to_others: bool,
    _server: Box<dyn std::fmt::Debug>,
}

fn serve_tcp(link: HostEnd, address: &str) -> Result<ServedPort> {
    let server = TcpServer::serve(link, address).map_err(|e| {
        let hint =
            "give HOST:PORT of this computer, such as 127.0.0.1:4000, or port 0 for any free one";
        Error::input("cannot_listen", format!("cannot listen at {address}: {e}; {hint}"))
    })?;
    let address = server.address();
    let is_open_to_others = !address.ip().is_loopback();
    let port = format!("tcp://{address}");
    Ok(ServedPort { port, is_open_to_others, _server: Box::new(server) })
}

fn layout(args: &Args, output: &mut Output) -> Result<HostLayout> {
    let file = match &args.layout {
        Some(path) => {
            let file = files::layout(path, output)?;
            files::for_rig(&file, path)?;
            file
        }
        None => LayoutFile::parse(LAYOUTS[0].1, LAYOUTS[0].0)?,
    };
    Ok(file.layout)
}

/// Longest line that a person types, bytes.
const MOST_LINE_BYTES: usize = 4096;

/// The next line on stdin; `None` when there are no more.
fn typed() -> Option<String> {
    let line = file::line(&mut io::stdin().lock(), MOST_LINE_BYTES);
    line.unwrap_or_else(|error| {
        eprintln!("standard input: {error}; nothing taps any more");
        None
    })
}

/// Taps for each line on stdin: at the DOF that the rig waits for, or at the DOF that the line names.
fn listen(taps: TapHandle, dofs: Vec<Dof>, rig: &VirtualRig) {
    let source = rig.source();
    // The rig's arming numbers count up from zero; those of named DOFs count down from the maximum.
    let mut asides = u32::MAX;
    let prompt = io::stdin().is_terminal();
    // The thread ends with the process, because reading stdin cannot be interrupted.
    std::thread::spawn(move || {
        while let Some(line) = typed() {
            let named = line.parse::<Dof>().ok();
            if let Some(dof) = named.and_then(|dof| dofs.iter().position(|&d| d == dof)) {
                asides -= 1;
                source.armed(asides, dof);
            } else if !line.trim().is_empty() {
                eprintln!("the layout has no DOF {}", line.trim());
                continue;
            }
            taps.tap();
            source.poke();
            if prompt {
                eprint!("tap ");
            }
        }
    });
}
