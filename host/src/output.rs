//! Where a command writes.
//!
//! Answers go to stdout: text, or with `--json` one object. Everything else (progress, warnings,
//! what to do next) goes to stderr, so that a pipe sees the answer alone. Colour and progress bars
//! appear only on a terminal; `NO_COLOR` is respected. Text for people is as wide as the terminal, at most
//! [`WIDTH`] columns as `--help` is, and so wide where there is no terminal.
//!
//! # JSON documents
//! A document is one object in one line. Its first key is `schema_version`, the number
//! [`SCHEMA_VERSION`]: a program that reads documents checks it and ignores keys that it does not know. A
//! command that fails after its answer prints a second document, the error; each document has the version.
//! `massline layout schema` prints a JSON schema with and without `--json`; it is no document of this kind.

mod wrap;

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use comfy_table::{CellAlignment, LineStyle, Table, presets};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::interrupt::Interrupt;
use wrap::wrapped;

/// The version of the JSON documents: one higher whenever a key is renamed or removed or means something
/// else. A new key alone does not change it.
pub const SCHEMA_VERSION: u32 = 1;

/// Columns of text for people.
pub const WIDTH: usize = 100;

/// Where a command writes, and whether the user has pressed Ctrl-C.
pub struct Output {
    out: Box<dyn Write + Send>,
    err: Box<dyn Write + Send>,
    json: bool,
    color: bool,
    /// Whether stdout is a terminal.
    out_terminal: bool,
    /// Whether stderr is a terminal, where bars can be shown.
    err_terminal: bool,
    keyboard: bool,
    raw: bool,
    interrupt: Interrupt,
    /// What the object of an error says besides the error.
    details: Option<Value>,
}

/// An answer with the version of its keys.
#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    #[serde(flatten)]
    answer: &'a Value,
}

/// How a piece of text is shown on a terminal with colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// A heading.
    Strong,
    /// Good news.
    Good,
    /// A reservation.
    Warning,
    /// Bad news.
    Bad,
}

impl Tone {
    fn escape(self) -> &'static str {
        match self {
            Self::Strong => "\x1b[1m",
            Self::Good => "\x1b[32m",
            Self::Warning => "\x1b[33m",
            Self::Bad => "\x1b[31m",
        }
    }
}

impl Output {
    /// The process's own stdout, stderr and keyboard.
    pub fn of_process(json: bool, interrupt: Interrupt) -> Self {
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        let (out_terminal, err_terminal) = (io::stdout().is_terminal(), io::stderr().is_terminal());
        Self {
            out: Box::new(io::stdout()),
            err: Box::new(io::stderr()),
            json,
            color: out_terminal && err_terminal && !no_color,
            out_terminal,
            err_terminal,
            keyboard: io::stdin().is_terminal() && err_terminal,
            raw: false,
            interrupt,
            details: None,
        }
    }

    /// Writes to `out` and `err`, without colour, bars and keyboard; for tests and other programs.
    pub fn to(
        json: bool,
        out: impl Write + Send + 'static,
        err: impl Write + Send + 'static,
    ) -> Self {
        Self {
            out: Box::new(out),
            err: Box::new(err),
            json,
            color: false,
            out_terminal: false,
            err_terminal: false,
            keyboard: false,
            raw: false,
            interrupt: Interrupt::new(),
            details: None,
        }
    }

    /// True when the answer is wanted as one JSON object.
    pub fn json(&self) -> bool {
        self.json
    }

    /// True when a person sits at the keyboard.
    pub fn has_keyboard(&self) -> bool {
        self.keyboard
    }

    /// While the terminal is in raw mode a line end does not return to the first column by itself.
    pub fn set_raw(&mut self, raw: bool) {
        self.raw = raw;
    }

    /// Says when the user has pressed Ctrl-C.
    pub fn interrupt(&self) -> &Interrupt {
        &self.interrupt
    }

    /// Writes the answer as text, with a line end; lines that are too long for the terminal or for [`WIDTH`]
    /// are broken between words.
    ///
    /// # Errors
    /// When stdout cannot be written. A reader that has gone away is no error.
    pub fn text(&mut self, text: impl AsRef<str>) -> Result<()> {
        self.verbatim(wrapped(text.as_ref(), width(self.out_terminal)))
    }

    /// As [`Output::text`] with the lines as they are: what other programs read.
    ///
    /// # Errors
    /// As [`Output::text`].
    pub fn verbatim(&mut self, text: impl AsRef<str>) -> Result<()> {
        let written = writeln!(self.out, "{}", text.as_ref()).and_then(|()| self.out.flush());
        check(written)
    }

    /// Writes the answer, an object, as one line of JSON with its [`SCHEMA_VERSION`].
    ///
    /// # Errors
    /// As [`Output::text`], and when `value` is no object.
    pub fn value(&mut self, value: &Value) -> Result<()> {
        let document = Document { schema_version: SCHEMA_VERSION, answer: value };
        let line = serde_json::to_string(&document).map_err(|e| {
            Error::internal("no_object", format!("the answer is no JSON object: {e}; report this"))
        })?;
        self.verbatim(line)
    }

    /// Writes `value` with `--json`, else what `text` makes.
    ///
    /// # Errors
    /// As [`Output::text`].
    pub fn answer(&mut self, value: &Value, text: impl FnOnce(&Self) -> String) -> Result<()> {
        if self.json {
            self.value(value)
        } else {
            let text = text(self);
            self.text(text)
        }
    }

    /// Says something beside the answer, on stderr.
    pub fn note(&mut self, text: impl AsRef<str>) {
        self.note_verbatim(wrapped(text.as_ref(), width(self.err_terminal)));
    }

    fn note_verbatim(&mut self, mut text: String) {
        if self.raw {
            text = text.replace('\n', "\r\n") + "\r";
        }
        // There is nowhere to report that stderr is gone.
        let _ = writeln!(self.err, "{text}");
    }

    /// Says a reservation, on stderr.
    pub fn warn(&mut self, text: impl AsRef<str>) {
        let head = self.toned("warning:", Tone::Warning);
        self.note(format!("{head} {}", text.as_ref()));
    }

    /// Reports an error: on stderr for people and with `--json` on stdout as an object.
    pub fn error(&mut self, error: &Error) {
        let head = self.toned("error:", Tone::Bad);
        if !self.json {
            return self.note(format!("{head} {error}"));
        }
        // In one line, as in the object.
        self.note_verbatim(format!("{head} {error}"));
        let mut value = error.to_json();
        if let (Some(Value::Object(details)), Some(object)) =
            (self.details.take(), value.as_object_mut())
        {
            object.extend(details);
        }
        // There is nowhere to report that stdout is gone.
        let _ = self.value(&value);
    }

    /// Puts the keys of the object `details` beside the error that is reported next.
    pub fn explain(&mut self, details: Value) {
        self.details = Some(details);
    }

    /// `text` in colour where colours are shown.
    pub fn toned(&self, text: &str, tone: Tone) -> String {
        if self.color { format!("{}{text}\x1b[0m", tone.escape()) } else { text.into() }
    }

    /// A bar on stderr that counts to `length`; invisible where stderr is no terminal.
    pub fn bar(&self, length: u64, label: &str) -> ProgressBar {
        if !self.err_terminal {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr());
        let style = ProgressStyle::with_template("{prefix:20} {bar:30} {pos}/{len} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        bar.set_prefix(label.to_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

/// Columns for text, on a terminal those that it has now.
fn width(on_terminal: bool) -> usize {
    let columns = || crossterm::terminal::size().ok().map(|(columns, _)| usize::from(columns));
    // A terminal that does not know its size says zero.
    let known = on_terminal.then(columns).flatten().filter(|&columns| columns > 0);
    known.map_or(WIDTH, |columns| columns.min(WIDTH))
}

/// An empty table in the style of all tables of this program: lines above, under the header, below.
pub fn table() -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none()));
    table
}

/// Aligns columns of numbers.
pub fn align_right(table: &mut Table, columns: impl IntoIterator<Item = usize>) {
    for column in columns {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
}

fn check(written: io::Result<()>) -> Result<()> {
    match written {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::internal("cannot_write", format!("standard output cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Shared(Arc<Mutex<Vec<u8>>>);

    impl Shared {
        fn text(&self) -> String {
            String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
        }
    }

    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn with_json_an_error_is_one_object_on_stdout_and_a_line_on_stderr() {
        let (out, err) = (Shared::default(), Shared::default());
        Output::to(true, out.clone(), err.clone()).error(&Error::input("wrong", "so it is"));
        let value: Value = serde_json::from_str(&out.text()).unwrap();
        assert_eq!(value["error"]["exit"], 2);
        assert_eq!(value["schema_version"], SCHEMA_VERSION);
        assert_eq!(err.text(), "error: so it is\n");
    }

    #[test]
    fn a_document_is_an_object_in_one_line_that_begins_with_its_version() {
        let out = Shared::default();
        let mut output = Output::to(true, out.clone(), io::sink());
        output.value(&json!({ "a": [1], "z": null })).unwrap();
        assert_eq!(out.text(), "{\"schema_version\":1,\"a\":[1],\"z\":null}\n");
        assert_eq!(output.value(&json!([1])).unwrap_err().code(), "no_object");
    }

    #[test]
    fn without_json_stdout_stays_empty_on_an_error() {
        let out = Shared::default();
        Output::to(false, out.clone(), io::sink()).error(&Error::input("wrong", "so it is"));
        assert_eq!(out.text(), "");
    }
}
