//! QEMU as a child process.

use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use massline_physics::source::ScanSource;
use massline_shared::signal::AdcProperties;
use nix::fcntl::OFlag;

use super::feeder::Feeder;
use super::memory::Psram;
use crate::{Error, Result};
use massline_client::firmware::EMULATOR;

/// QEMU prints the path of its pty within this time after its start.
const START: Duration = Duration::from_secs(20);
/// Number of output lines of QEMU and the firmware that are stored.
const OUTPUT_LINES: usize = 12;

/// The firmware in QEMU. QEMU ends when this is dropped.
#[derive(Debug)]
pub struct EmulatedRig {
    elf: PathBuf,
    psram: Arc<Psram>,
    machine: Machine,
}

impl EmulatedRig {
    /// Starts the firmware `elf` in QEMU; its sampler reports the properties `adc`, which must be those of
    /// the source that will feed it.
    ///
    /// # Errors
    /// When QEMU is missing (`qemu_missing`) or does not start (`qemu_failed`).
    pub fn start(elf: &Path, adc: &AdcProperties) -> Result<Self> {
        let psram = Arc::new(Psram::create(adc)?);
        let machine = Machine::start(elf, psram.path())?;
        Ok(Self { elf: elf.to_owned(), psram, machine })
    }

    /// The pty that is the rig's serial port. It changes with a restart.
    pub fn port_path(&self) -> &str {
        &self.machine.port_path
    }

    /// Feeds the rig with the scans of `source`. There must be only one feeder at a time.
    pub fn feed(&self, source: Box<dyn ScanSource>) -> Feeder {
        Feeder::start(Arc::clone(&self.psram), source)
    }

    /// Power-cycles the rig; the contents of its flash stay. Stop the feeder first.
    ///
    /// # Errors
    /// When QEMU does not start.
    pub fn restart(&mut self) -> Result<()> {
        self.machine.end();
        self.machine = Machine::start(&self.elf, self.psram.path())?;
        Ok(())
    }

    /// Checks that the rig is still running.
    ///
    /// # Errors
    /// `rig_died` with its output when it is not.
    pub fn check(&mut self) -> Result<()> {
        self.machine.check()
    }

    /// The reason why communication with the rig failed: its output when it has crashed, else `error`.
    pub fn explain(&mut self, error: Error) -> Error {
        self.check().err().unwrap_or(error)
    }
}

/// One run of the QEMU process.
#[derive(Debug)]
struct Machine {
    child: Child,
    port_path: String,
    /// Kept open, because QEMU checks only once a second whether a closed pty has been opened again.
    _port: File,
    words: Words,
    listeners: Vec<JoinHandle<()>>,
}

impl Machine {
    fn start(elf: &Path, psram: &Path) -> Result<Self> {
        let mut child = command(elf, psram).spawn().map_err(|error| {
            if error.kind() == std::io::ErrorKind::NotFound {
                Error::device(
                    "qemu_missing",
                    format!("{EMULATOR} is not installed; on Debian or Ubuntu: apt-get install qemu-system-arm"),
                )
            } else {
                Error::device("qemu_failed", format!("cannot start {EMULATOR}: {error}"))
            }
        })?;
        let words = Words::default();
        let (ports, port) = channel();
        let mut listeners = Vec::new();
        if let Some(stdout) = child.stdout.take() {
            listeners.push(listen(stdout, words.clone(), Some(ports)));
        }
        if let Some(stderr) = child.stderr.take() {
            listeners.push(listen(stderr, words.clone(), None));
        }
        match open_port(&port) {
            Some((port_path, port)) => Ok(Self { child, port_path, _port: port, words, listeners }),
            None => {
                let _ = child.kill();
                let status = child.wait().ok();
                for listener in listeners {
                    let _ = listener.join();
                }
                Err(words.died("qemu_failed", "QEMU did not start the rig", status))
            }
        }
    }

    fn check(&mut self) -> Result<()> {
        let Ok(Some(status)) = self.child.try_wait() else { return Ok(()) };
        self.end();
        Err(self.words.died("rig_died", "the emulated rig has died", Some(status)))
    }

    /// Ends QEMU, if it still runs, and waits until its output has been read.
    fn end(&mut self) {
        // This fails only when the process has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
        for listener in self.listeners.drain(..) {
            let _ = listener.join();
        }
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        self.end();
    }
}

fn command(elf: &Path, psram: &Path) -> Command {
    let mut memory =
        std::ffi::OsString::from("memory-backend-file,id=afe,size=16M,share=on,mem-path=");
    memory.push(psram);
    let mut command = Command::new(EMULATOR);
    command
        .args(["-M", "mps2-an386,memory-backend=afe", "-object"])
        .arg(memory)
        .args(["-display", "none", "-monitor", "none", "-no-reboot"])
        .args(["-chardev", "pty,id=link", "-serial", "chardev:link"])
        .args(["-chardev", "stdio,id=words,signal=off", "-serial", "chardev:words"])
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        // In its own process group QEMU does not receive Ctrl-C, which this process handles by stopping the
        // rig.
        .process_group(0);
    command
}

/// Waits for the path of the pty and opens it.
fn open_port(paths: &Receiver<String>) -> Option<(String, File)> {
    let path = paths.recv_timeout(START).ok()?;
    let port = OpenOptions::new()
        .read(true)
        .write(true)
        .custom_flags((OFlag::O_NOCTTY | OFlag::O_NONBLOCK).bits())
        .open(&path)
        .ok()?;
    Some((path, port))
}

/// Collects the lines of QEMU's and the firmware's output; sends on the path of the pty.
fn listen(
    stream: impl Read + Send + 'static,
    words: Words,
    ports: Option<Sender<String>>,
) -> JoinHandle<()> {
    thread::spawn(move || {
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            match (port_in(&line), &ports) {
                (Some(path), Some(ports)) => {
                    // The receiver is gone when the start has been abandoned.
                    let _ = ports.send(path.to_owned());
                }
                _ => words.add(line),
            }
        }
    })
}

/// `char device redirected to /dev/pts/3 (label link)`
fn port_in(line: &str) -> Option<&str> {
    line.strip_prefix("char device redirected to ")?.strip_suffix(" (label link)")
}

/// The first lines of the output; after the cause of a crash only register dumps follow.
#[derive(Clone, Debug, Default)]
struct Words(Arc<Mutex<VecDeque<String>>>);

impl Words {
    fn lines(&self) -> MutexGuard<'_, VecDeque<String>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn add(&self, line: String) {
        let mut lines = self.lines();
        if lines.len() < OUTPUT_LINES && !line.trim().is_empty() && !is_register_dump(&line) {
            lines.push_back(line);
        }
    }

    fn died(&self, code: &'static str, failure: &str, status: Option<ExitStatus>) -> Error {
        let lines: Vec<String> = self.lines().iter().cloned().collect();
        let status = status.map_or(String::new(), |status| format!(" ({status})"));
        let words = if lines.is_empty() { "no output".to_owned() } else { lines.join("\n  ") };
        Error::device(code, format!("{failure}{status}; it said:\n  {words}"))
    }
}

/// `R00=…`, `XPSR=…`, `s00=…`, `FPSCR: …`: the registers that QEMU prints when a core locks up.
fn is_register_dump(line: &str) -> bool {
    let name = line.split(['=', ':']).next().unwrap_or_default();
    name == "XPSR"
        || name == "FPSCR"
        || (name.len() == 3
            && name.starts_with(['R', 's', 'd'])
            && name[1..].bytes().all(|byte| byte.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_port_is_read_from_the_output_of_qemu() {
        let line = "char device redirected to /dev/pts/3 (label link)";
        assert_eq!(port_in(line), Some("/dev/pts/3"));
        assert_eq!(port_in("panicked at src/main.rs"), None);
    }

    #[test]
    fn last_words_leave_the_registers_out() {
        let words = Words::default();
        for line in [
            "panicked at a.rs:1:2:",
            "too much",
            "",
            "R00=200008a4 R01=00000001",
            "XPSR=61000003 -ZC- T handler",
            "s00=0 s01=0 d00=0",
            "FPSCR: 00000000",
        ] {
            words.add(line.to_owned());
        }
        let error = words.died("rig_died", "dead", None);
        assert_eq!(error.to_string(), "dead; it said:\n  panicked at a.rs:1:2:\n  too much");
        assert_eq!(error.exit_code(), 4);
    }
}
