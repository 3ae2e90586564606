//! The full screen of a measurement: what a person with a hammer sees.
//!
//! A [`View`] is what there is to see, without a terminal: [`guide`] is that of a campaign, [`positions`] that of a
//! tumble test. A [`Screen`] shows one on the terminal. How a part looks is in [`draw`].

mod draw;
pub mod guide;
mod interim;
mod pace;
mod pages;
pub mod positions;
mod theme;

use std::io::{self, Stderr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use ratatui::backend::CrosstermBackend;
use ratatui::{Frame, Terminal};

use crate::output::{Notes, Output};
use crate::terminal::{self, AlternateScreen, RawMode};
pub use theme::Theme;

/// Without a change, the screen is drawn again after this time.
const REFRESH: Duration = Duration::from_millis(100);

/// What there is to see.
pub trait View: Send + 'static {
    /// Draws all of it.
    fn draw(&self, frame: &mut Frame<'_>, theme: Theme);

    /// Takes a note that would otherwise be a line on the terminal.
    fn note(&mut self, text: &str);
}

/// A view on the terminal. Dropping it gives the terminal back as it was, with the notes that were taken meanwhile.
pub struct Screen<V: View> {
    shown: Arc<Mutex<TerminalView<V>>>,
    /// Left before the notes are written.
    alternate: Option<AlternateScreen>,
    notes: Notes,
}

struct TerminalView<V> {
    terminal: Terminal<CrosstermBackend<Stderr>>,
    view: V,
    theme: Theme,
    drawn: Instant,
}

impl<V: View> Screen<V> {
    /// Takes the terminal of this output, which is in raw mode.
    ///
    /// # Errors
    /// When the terminal cannot be taken.
    pub fn open(view: V, raw: Arc<RawMode>, output: &Output) -> io::Result<Self> {
        let alternate = Some(AlternateScreen::enter(raw)?);
        let terminal = Terminal::new(CrosstermBackend::new(io::stderr()))?;
        let theme = Theme { color: output.screen_in_color() };
        let shown = TerminalView { terminal, view, theme, drawn: Instant::now() };
        let shown = Arc::new(Mutex::new(shown));
        let notes = output.notes();
        // The client says while it waits that the rig is silent: nothing else would draw then.
        let noted = Arc::clone(&shown);
        notes.divert(move |text| {
            let mut shown = locked(&noted);
            shown.view.note(text);
            shown.draw();
        });
        let screen = Self { shown, alternate, notes };
        screen.draw();
        Ok(screen)
    }

    /// Changes the view, which is drawn soon.
    pub fn update<T>(&self, change: impl FnOnce(&mut V) -> T) -> T {
        change(&mut locked(&self.shown).view)
    }

    /// Draws the view.
    pub fn draw(&self) {
        locked(&self.shown).draw();
    }

    /// Draws the view if the last drawing is old.
    pub fn refresh(&self) {
        let mut shown = locked(&self.shown);
        if shown.drawn.elapsed() >= REFRESH {
            shown.draw();
        }
    }
}

impl<V: View> TerminalView<V> {
    fn draw(&mut self) {
        self.drawn = Instant::now();
        let (view, theme) = (&self.view, self.theme);
        // A terminal that is gone ends the program by its hang-up; until then nothing can be shown.
        terminal::draw(|| drop(self.terminal.draw(|frame| view.draw(frame, theme))));
    }
}

impl<V: View> Drop for Screen<V> {
    fn drop(&mut self) {
        self.alternate = None;
        self.notes.resume();
    }
}

fn locked<V>(shown: &Mutex<TerminalView<V>>) -> MutexGuard<'_, TerminalView<V>> {
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}
