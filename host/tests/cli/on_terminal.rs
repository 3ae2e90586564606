//! The program on a terminal of its own: what it writes, what is then on the screen, keys, another size.

use std::fs::File;
use std::io::{Read, Write};
use std::num::NonZero;
use std::os::fd::AsFd;
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, poll};
use nix::pty::openpty;
use rustix::termios::{Winsize, tcsetwinsize};

/// After this time, what a test waits for does not come, and it fails; a hit takes one to two seconds.
const PATIENCE: Duration = Duration::from_secs(120);

/// Time between two looks at a clock while nothing comes, ms.
const LOOK_MS: u16 = 500;

/// Columns and rows of a terminal.
pub type Size = [u16; 2];

/// The program on a terminal of its own.
pub struct Terminal {
    pub process: Child,
    /// All that it has written.
    pub text: String,
    /// The end of the terminal that a person has.
    screen: File,
    /// The beginning of a character whose other bytes have not come yet.
    cut: Vec<u8>,
    emulator: vt100::Parser,
    started: Instant,
    /// What was on the screen, and when; kept only for a recording.
    seen: Option<Vec<(Duration, vt100::Screen)>>,
}

impl Terminal {
    /// The program on a terminal of this size and type.
    pub fn start(size: Size, name: &str, arguments: &[&str]) -> Self {
        Self::start_in(Path::new("."), size, name, arguments)
    }

    /// The same in this folder.
    pub fn start_in(folder: &Path, size: Size, name: &str, arguments: &[&str]) -> Self {
        let ends = openpty(None, None).unwrap();
        let screen = File::from(ends.master);
        set_size(&screen, size);
        let end = || File::from(ends.slave.try_clone().unwrap());
        // The terminal has to be that of the process: its size is asked for by that way.
        let process = Command::new("setsid")
            .args(["--ctty", env!("CARGO_BIN_EXE_massline")])
            .args(arguments)
            .current_dir(folder)
            .env("TERM", name)
            // Libraries take this for a terminal that shows colours.
            .env("CI", "true")
            .env_remove("NO_COLOR")
            .env_remove("COLUMNS")
            .env_remove("MASSLINE_PORT")
            .stdin(end())
            .stdout(end())
            .stderr(end())
            .spawn()
            .unwrap();
        let [columns, rows] = in_cells(size);
        Self {
            process,
            text: String::new(),
            screen,
            cut: Vec::new(),
            emulator: vt100::Parser::new(rows, columns, 0),
            started: Instant::now(),
            seen: None,
        }
    }

    /// Reads until `condition` holds for all that was written; false at the end of the process.
    pub fn until(&mut self, condition: impl Fn(&str) -> bool) -> bool {
        self.read_until(|terminal| condition(&terminal.text))
    }

    /// Reads until `condition` holds on the screen; false at the end of the process.
    pub fn until_shown(&mut self, condition: impl Fn(&str) -> bool) -> bool {
        self.read_until(|terminal| condition(&terminal.screen_text()))
    }

    /// Reads for at most this time until `condition` holds on the screen; whether it did.
    pub fn shown_within(&mut self, time: Duration, condition: impl Fn(&str) -> bool) -> bool {
        let began = Instant::now();
        while !condition(&self.screen_text()) {
            if began.elapsed() > time || !self.read() {
                return condition(&self.screen_text());
            }
        }
        true
    }

    fn read_until(&mut self, condition: impl Fn(&Self) -> bool) -> bool {
        let began = Instant::now();
        while !condition(self) {
            assert!(began.elapsed() < PATIENCE, "this does not come:\n{}", self.screen_text());
            if !self.read() {
                return false;
            }
        }
        true
    }

    /// Reads what comes next; false at the end of the process.
    fn read(&mut self) -> bool {
        let mut buffer = [0; 4096];
        let mut waited = [PollFd::new(self.screen.as_fd(), PollFlags::POLLIN)];
        // The caller counts the time.
        if matches!(poll(&mut waited, LOOK_MS), Ok(0) | Err(Errno::EINTR)) {
            return true;
        }
        // The last end of the other side closes with an error.
        let read = self.screen.read(&mut buffer).unwrap_or(0);
        let new = &buffer[..read];
        self.emulator.process(new);
        if let Some(seen) = &mut self.seen {
            seen.push((self.started.elapsed(), self.emulator.screen().clone()));
        }
        self.cut.extend(new);
        let whole = match std::str::from_utf8(&self.cut) {
            Err(error) if error.error_len().is_none() && read > 0 => error.valid_up_to(),
            _ => self.cut.len(),
        };
        self.text += &String::from_utf8_lossy(&self.cut[..whole]);
        self.cut.drain(..whole);
        read > 0
    }

    /// What is on the screen now.
    pub fn screen_text(&self) -> String {
        self.emulator.screen().contents()
    }

    /// Types keys.
    pub fn type_keys(&mut self, keys: &str) {
        self.screen.write_all(keys.as_bytes()).unwrap();
    }

    /// Gives the terminal another size.
    pub fn resize(&mut self, size: Size) {
        set_size(&self.screen, size);
        let [columns, rows] = in_cells(size);
        self.emulator.screen_mut().set_size(rows, columns);
    }

    /// Reads to the end: exit code and everything.
    pub fn end(&mut self) -> (i32, String) {
        self.until(|_| false);
        (self.process.wait().unwrap().code().unwrap(), self.text.clone())
    }

    /// Begins a recording, with a line of a shell that has started the program.
    pub fn record(&mut self, command: &str) {
        self.emulator.process(format!("$ {command}\r\n").as_bytes());
        self.seen = Some(vec![(Duration::ZERO, self.emulator.screen().clone())]);
    }

    /// What was on the screen since the recording was begun, and when.
    pub fn seen(&mut self) -> Vec<(Duration, vt100::Screen)> {
        self.seen.take().unwrap_or_default()
    }
}

fn set_size(screen: &File, [columns, rows]: Size) {
    let size = Winsize { ws_row: rows, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 };
    tcsetwinsize(screen, size).unwrap();
}

fn in_cells(size: Size) -> [NonZero<u16>; 2] {
    size.map(|length| length.try_into().unwrap())
}
