//! The output of a command.
//!
//! The answer goes to stdout: text, or one JSON object with `--json`. Everything else (progress, warnings,
//! what to do next) goes to stderr, so that a pipe receives only the answer. Colour and progress bars appear
//! only on a terminal; `NO_COLOR` is respected. Text and tables are wrapped to the width of the terminal, as `--help`
//! is; without a terminal, text is wrapped to [`WIDTH`] columns and tables are as wide as they need to be.
//!
//! # JSON documents
//! A document is one object in one line. Its first key is `schema_version`, a number: a
//! program that reads documents checks it and ignores unknown keys. A command that fails after it has printed
//! its answer prints the error as a second document; each document has the version. `massline layout schema`
//! prints a JSON schema with and without `--json`; that schema has no `schema_version`.

mod color;
mod notes;
mod shell;

use std::borrow::Cow;
use std::io::{self, IsTerminal, Write};

use indicatif::ProgressBar;
use serde::Serialize;
use serde_json::{Value, json};

use crate::{Error, ErrorKind, Result};
pub use color::ColorChoice;
use massline_client::interrupt::Interrupt;
use massline_report::document::Failure;
pub use massline_report::document::versioned;
use massline_report::table::terminal_width;
pub use massline_report::table::{Table, align_right, table};
use massline_report::tone::plain;
pub use massline_report::tone::{Tone, harmless};
pub use massline_report::words::counted;
use massline_report::wrap::wrapped;
pub use massline_report::wrap::{KEPT, WIDTH};
use massline_result::Verdict;
pub use notes::Notes;
pub use shell::{shell_path, shell_word, this_command_with};

/// The output streams of a command, and whether the user has pressed Ctrl-C.
pub struct Output {
    out: Box<dyn Write + Send>,
    notes: Notes,
    json: bool,
    color: bool,
    /// Whether stderr alone shows colours.
    notes_color: bool,
    /// Whether stdout is a terminal.
    out_terminal: bool,
    keyboard: bool,
    interrupt: Interrupt,
    /// Further keys for the JSON object of the next error.
    details: Option<Value>,
    /// Whether the command has stated an answer that is not to be used.
    is_unusable: bool,
}

impl Output {
    /// The process's own stdout, stderr and keyboard.
    pub fn of_process(json: bool, color: ColorChoice, interrupt: Interrupt) -> Self {
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
        let dumb = std::env::var_os("TERM").is_some_and(|name| name == "dumb");
        let (out_terminal, err_terminal) = (io::stdout().is_terminal(), io::stderr().is_terminal());
        let shows = |terminal| match color {
            ColorChoice::Auto => terminal && !no_color && !dumb,
            ColorChoice::Always => true,
            ColorChoice::Never => false,
        };
        Self {
            out: Box::new(io::stdout()),
            notes: match err_terminal {
                true => Notes::to(io::stderr()).on_terminal(!dumb),
                false => Notes::to(io::stderr()),
            },
            json,
            color: shows(out_terminal && err_terminal),
            notes_color: shows(err_terminal),
            out_terminal,
            keyboard: io::stdin().is_terminal() && err_terminal,
            interrupt,
            details: None,
            is_unusable: false,
        }
    }

    /// Writes to `out` and `err`, without colour, progress bars and keyboard; for tests and other programs.
    pub fn to(
        json: bool,
        out: impl Write + Send + 'static,
        err: impl Write + Send + 'static,
    ) -> Self {
        Self {
            out: Box::new(out),
            notes: Notes::to(err),
            json,
            color: false,
            notes_color: false,
            out_terminal: false,
            keyboard: false,
            interrupt: Interrupt::new(),
            details: None,
            is_unusable: false,
        }
    }

    /// True when the answer is to be printed as one JSON object.
    pub fn json(&self) -> bool {
        self.json
    }

    /// True when the command can ask a person at the keyboard.
    pub fn has_keyboard(&self) -> bool {
        self.keyboard
    }

    /// True when there are a keyboard and a terminal on which a full screen can be drawn.
    pub fn has_screen(&self) -> bool {
        self.keyboard && self.notes.moves()
    }

    /// Whether the full screen, which is drawn beside the answer, has colours.
    pub fn screen_in_color(&self) -> bool {
        self.notes_color
    }

    /// Lets a command whose answer has this verdict end with [`exit_code`](Self::exit_code).
    pub fn conclude(&mut self, verdict: Option<Verdict>) {
        self.is_unusable |= verdict == Some(Verdict::DoNotUse);
    }

    /// The exit code of a command without an error: 3 after an answer that is not to be used, as without an answer.
    pub fn exit_code(&self) -> u8 {
        if self.is_unusable { Error::undetermined("", "").exit_code() } else { 0 }
    }

    /// The first line of a result in the colour of its verdict.
    pub fn verdict_line(&self, verdict: Verdict, line: &str) -> String {
        self.toned(line, verdict.into())
    }

    /// The record of whether the user has pressed Ctrl-C.
    pub fn interrupt(&self) -> &Interrupt {
        &self.interrupt
    }

    /// Writes the answer as text, with a line end; lines that are too long for the terminal, or for [`WIDTH`] without
    /// one, are broken between words.
    ///
    /// # Errors
    /// When stdout cannot be written. A closed pipe is not an error.
    pub fn text(&mut self, text: impl AsRef<str>) -> Result<()> {
        self.verbatim(wrapped(text.as_ref(), width(self.out_terminal)))
    }

    /// Writes the answer like [`Output::text`] but never breaks lines; for text that other programs read.
    ///
    /// # Errors
    /// As [`Output::text`].
    pub fn verbatim(&mut self, text: impl AsRef<str>) -> Result<()> {
        let text = harmless(text.as_ref());
        let text = if self.color { text } else { plain(&text).into() };
        let written = writeln!(self.out, "{text}").and_then(|()| self.out.flush());
        check(written)
    }

    /// Checks that stdout can hold a file as it is, before the work whose result it is.
    ///
    /// # Errors
    /// Exit 2 with `--json`, and for a file that is no text when stdout is a terminal.
    pub fn check_unframed(&self, is_binary: bool) -> Result<()> {
        if self.json {
            let message = "with --json standard output holds one JSON object, not a file; name the file with -o";
            return Err(Error::input("output_needed", message));
        }
        if is_binary && self.out_terminal {
            let message =
                "this format is no text for a terminal; name the file with -o, or use a pipe";
            return Err(Error::input("output_needed", message));
        }
        Ok(())
    }

    /// Writes a file to stdout: as it is, but text without the control characters that a terminal would obey.
    ///
    /// # Errors
    /// As [`Output::text`] and [`Output::check_unframed`].
    pub fn unframed(&mut self, bytes: &[u8], is_binary: bool) -> Result<()> {
        self.check_unframed(is_binary)?;
        match std::str::from_utf8(bytes) {
            Ok(text) if !is_binary => self.verbatim(text.trim_end_matches('\n')),
            _ => check(self.out.write_all(bytes).and_then(|()| self.out.flush())),
        }
    }

    /// Writes the answer, a JSON object, in one line with its `schema_version`.
    ///
    /// # Errors
    /// As [`Output::text`], and when `value` is not an object.
    pub fn value(&mut self, value: &impl Serialize) -> Result<()> {
        let line = versioned(value)?;
        let written = writeln!(self.out, "{}", escaped(&line)).and_then(|()| self.out.flush());
        check(written)
    }

    /// Writes `value` with `--json`, else the text that `text` returns.
    ///
    /// # Errors
    /// As [`Output::text`].
    pub fn answer(
        &mut self,
        value: &impl Serialize,
        text: impl FnOnce(&Self) -> String,
    ) -> Result<()> {
        if self.json {
            self.value(value)
        } else {
            let text = text(self);
            self.text(text)
        }
    }

    /// As [`Output::answer`], for a [`Table`]: its lines are never broken, because it fits the terminal by itself.
    ///
    /// # Errors
    /// As [`Output::text`].
    pub fn answer_table(&mut self, value: &impl Serialize, table: &Table) -> Result<()> {
        if self.json { self.value(value) } else { self.verbatim(table.to_string()) }
    }

    /// Writes a note on stderr, beside the answer.
    pub fn note(&mut self, text: impl AsRef<str>) {
        self.notes.note(text.as_ref());
    }

    /// The stream of the notes, for a part that works on its own, such as a client that waits for its rig.
    pub fn notes(&self) -> Notes {
        self.notes.clone()
    }

    /// Makes sure, before anything is done, that a question can be asked, or that `yes` has answered it. `doing` is
    /// what the command does, such as `deleting`.
    ///
    /// # Errors
    /// When nobody could confirm.
    pub fn can_confirm(&self, yes: bool, doing: &str) -> Result<()> {
        if yes || self.keyboard {
            return Ok(());
        }
        let text = format!("{doing} asks for a confirmation, and there is no keyboard; add --yes");
        Err(Error::input("not_confirmed", text))
    }

    /// Asks a question at the keyboard; anything but y or yes is a no.
    ///
    /// # Errors
    /// When the keyboard cannot be read.
    pub fn confirm(&mut self, question: &str) -> Result<bool> {
        self.note(format!("{question} [y/N]"));
        let mut line = String::new();
        io::stdin().read_line(&mut line).map_err(|e| {
            Error::internal("no_keyboard", format!("the keyboard cannot be read: {e}"))
        })?;
        Ok(matches!(line.trim().to_lowercase().as_str(), "y" | "yes"))
    }

    /// Writes a warning on stderr.
    pub fn warn(&mut self, text: impl AsRef<str>) {
        let head = self.toned("warning:", Tone::Warning);
        self.note(format!("{head} {}", text.as_ref()));
    }

    /// Reports an error: as text on stderr, or with `--json` as an object on stdout.
    pub fn error(&mut self, error: &Error) {
        if !self.json {
            let head = match error.kind {
                ErrorKind::Interrupted => self.toned("stopped:", Tone::Warning),
                _ => self.toned("error:", Tone::Bad),
            };
            return self.note(format!("{head} {error}"));
        }
        let mut value = json!(Failure::from(error));
        if let (Some(Value::Object(details)), Some(object)) =
            (self.details.take(), value.as_object_mut())
        {
            object.extend(details);
        }
        // A failure to write to stdout cannot be reported anywhere.
        let _ = self.value(&value);
    }

    /// Adds the keys of the object `details` to the JSON object of the next error.
    pub fn explain(&mut self, details: &impl Serialize) {
        self.details = serde_json::to_value(details).ok();
    }

    /// Whether text is coloured.
    pub fn in_color(&self) -> bool {
        self.color
    }

    /// `text` in the colour of `tone`, if stdout shows colours.
    pub fn toned(&self, text: &str, tone: Tone) -> String {
        if self.color { tone.mark(text) } else { text.into() }
    }

    /// A progress bar on stderr that counts to `length`; invisible when stderr is not a terminal. Notes appear above
    /// it.
    pub fn bar(&self, length: u64, label: &str) -> ProgressBar {
        self.notes.bar(length, label)
    }
}

/// Width of text: that of the terminal, or [`WIDTH`] without a terminal.
fn width(on_terminal: bool) -> usize {
    on_terminal.then(terminal_width).flatten().unwrap_or(WIDTH)
}

/// A JSON text whose strings name their control characters by number; serde_json writes those above 0x7e as they are.
fn escaped(json: &str) -> Cow<'_, str> {
    if !json.contains(char::is_control) {
        return json.into();
    }
    let mut text = String::new();
    for c in json.chars() {
        if c.is_control() {
            text += &format!("\\u{:04x}", u32::from(c));
        } else {
            text.push(c);
        }
    }
    text.into()
}

fn check(written: io::Result<()>) -> Result<()> {
    match written {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::input("cannot_write", format!("standard output cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::*;

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
    fn with_json_an_error_is_one_object_on_stdout_and_nothing_else() {
        let (out, err) = (Shared::default(), Shared::default());
        Output::to(true, out.clone(), err.clone()).error(&Error::input("wrong", "so it is"));
        let value: Value = serde_json::from_str(&out.text()).unwrap();
        assert_eq!(value["error"]["exit"], 2);
        assert_eq!(value["schema_version"], massline_result::SCHEMA_VERSION);
        assert_eq!(err.text(), "");
    }

    #[test]
    fn a_document_is_an_object_in_one_line_that_begins_with_its_version() {
        let out = Shared::default();
        let mut output = Output::to(true, out.clone(), io::sink());
        output.value(&json!({ "a": [1], "z": null })).unwrap();
        assert_eq!(out.text(), "{\"schema_version\":1,\"a\":[1],\"z\":null}\n");
        assert_eq!(output.value(&json!([1])).unwrap_err().code(), "document_not_written");
    }

    #[test]
    fn control_characters_of_others_do_not_reach_the_terminal() {
        let (out, err) = (Shared::default(), Shared::default());
        let mut output = Output::to(false, out.clone(), err.clone());
        output.text("a\x1b]0;title\x07b\x1b[2J\tc\rd\u{9b}e").unwrap();
        assert_eq!(out.text(), "a\u{fffd}]0;title\u{fffd}b\u{fffd}[2J\tc\u{fffd}d\u{fffd}e\n");
        output.note("\x1b[1mbold\x1b[0m \x1b[5m");
        assert_eq!(err.text(), "\x1b[1mbold\x1b[0m \u{fffd}[5m\n");
    }

    #[test]
    fn json_keeps_the_control_characters_of_strings_and_a_terminal_does_not_get_them() {
        let out = Shared::default();
        let strange = "a\u{1b}[2J\u{7f}\u{9b}31m\u{fffd}é";
        Output::to(true, out.clone(), io::sink()).value(&json!({ "a": strange })).unwrap();
        assert!(!out.text().trim_end().contains(char::is_control), "{}", out.text());
        let value: Value = serde_json::from_str(&out.text()).unwrap();
        assert_eq!(value["a"], strange);
    }

    #[test]
    fn who_stops_a_command_has_made_no_error() {
        let err = Shared::default();
        Output::to(false, io::sink(), err.clone()).error(&Error::interrupted("the rig has ended"));
        assert_eq!(err.text(), "stopped: the rig has ended\n");
    }

    #[test]
    fn without_json_stdout_stays_empty_on_an_error() {
        let out = Shared::default();
        Output::to(false, out.clone(), io::sink()).error(&Error::input("wrong", "so it is"));
        assert_eq!(out.text(), "");
    }
}
