//! What is said beside the answer, and the progress bars under it.

use std::io::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::width;
use crate::terminal::RawMode;
use massline_report::tone::{harmless, plain};
use massline_report::wrap::wrapped;

/// The stream of what is said beside the answer. Clones write to the same stream.
#[derive(Clone)]
pub struct Notes {
    err: Arc<Mutex<Box<dyn Write + Send>>>,
    /// Whether it is a terminal.
    terminal: bool,
    /// The bars, which make room for a note; `None` where there are none.
    bars: Option<MultiProgress>,
    diverted: Arc<Mutex<Option<DivertedNotes>>>,
}

/// Where notes go while a full screen has the terminal.
struct DivertedNotes {
    take: Box<dyn FnMut(&str) + Send>,
    /// All of them, for afterwards.
    taken: Vec<String>,
}

impl Notes {
    /// Notes on a stream that is not a terminal.
    pub(super) fn to(err: impl Write + Send + 'static) -> Self {
        let err: Box<dyn Write + Send> = Box::new(err);
        Self {
            err: Arc::new(Mutex::new(err)),
            terminal: false,
            bars: None,
            diverted: Arc::default(),
        }
    }

    /// Notes on the terminal of stderr; with bars if it can move its cursor.
    pub(super) fn on_terminal(self, moves: bool) -> Self {
        let bars = || MultiProgress::with_draw_target(ProgressDrawTarget::stderr());
        Self { terminal: true, bars: moves.then(bars), ..self }
    }

    /// Writes a note.
    pub fn note(&self, text: &str) {
        if let Some(diverted) = &mut *self.diverted() {
            diverted.taken.push(text.into());
            return (diverted.take)(&plain(&harmless(text)));
        }
        self.verbatim(wrapped(text, width(self.terminal)));
    }

    fn verbatim(&self, text: String) {
        let mut text = harmless(&text).into_owned();
        if self.terminal && RawMode::is_on() {
            text = text.replace('\n', "\r\n") + "\r";
        }
        let mut err = self.err.lock().unwrap_or_else(PoisonError::into_inner);
        let mut write = || writeln!(err, "{text}");
        let written = match &self.bars {
            Some(bars) => bars.suspend(write),
            None => write(),
        };
        // A failure to write to stderr cannot be reported anywhere.
        written.ok();
    }

    /// True for a terminal that can move its cursor.
    pub(super) fn moves(&self) -> bool {
        self.bars.is_some()
    }

    /// From now on, `take` gets the notes, without colours; [`Self::resume`] ends it.
    pub fn divert(&self, take: impl FnMut(&str) + Send + 'static) {
        *self.diverted() = Some(DivertedNotes { take: Box::new(take), taken: Vec::new() });
    }

    /// Writes what was diverted meanwhile, and goes on writing.
    pub fn resume(&self) {
        let diverted = self.diverted().take();
        diverted.into_iter().flat_map(|diverted| diverted.taken).for_each(|text| self.note(&text));
    }

    fn diverted(&self) -> MutexGuard<'_, Option<DivertedNotes>> {
        self.diverted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A progress bar that counts to `length`; invisible where there are none. Notes appear above it.
    pub(super) fn bar(&self, length: u64, label: &str) -> ProgressBar {
        let Some(bars) = &self.bars else { return ProgressBar::hidden() };
        let bar = bars.add(ProgressBar::new(length));
        let style = ProgressStyle::with_template("{prefix:20} {bar:30} {pos}/{len} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        bar.set_prefix(harmless(label).into_owned());
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diverted_notes_are_written_afterwards() {
        let notes = Notes::to(std::io::sink());
        let seen = Arc::new(Mutex::new(Vec::new()));
        let taken = Arc::clone(&seen);
        notes.divert(move |text| taken.lock().unwrap().push(text.to_owned()));
        notes.clone().note("\x1b[33mwarning:\x1b[0m a\x1b[2Jb");
        assert_eq!(*seen.lock().unwrap(), ["warning: a\u{fffd}[2Jb"]);
        notes.resume();
        notes.note("later");
        assert_eq!(seen.lock().unwrap().len(), 1);
    }

    #[test]
    fn a_label_of_a_bar_has_no_control_characters() {
        let notes = Notes::to(std::io::sink()).on_terminal(true);
        assert_eq!(notes.bar(3, "a\x1b[2Jb").prefix(), "a\u{fffd}[2Jb");
    }
}
