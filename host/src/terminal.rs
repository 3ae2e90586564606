//! The terminal of the process, while single keys are read from it or a full screen is drawn on it.
//!
//! Raw mode passes every key on at once, Ctrl-C included, and prints none. The alternate screen leaves the lines of the
//! shell untouched. Each has one guard, and [`give_back`] ends both where no guard is dropped: before a signal ends the
//! process, and before the message of a panic is printed.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once, PoisonError, TryLockError};
use std::thread;
use std::time::Duration;

use crossterm::cursor::{Hide, Show};
use crossterm::execute;
use crossterm::terminal::{self, EnterAlternateScreen, LeaveAlternateScreen};

/// Whether the alternate screen is shown.
static SHOWN: AtomicBool = AtomicBool::new(false);
/// Held by whoever draws on the alternate screen.
static DRAWING: Mutex<()> = Mutex::new(());
/// A drawing is over within this time, ms, unless it is the one that panics.
const DRAWING_MS: u32 = 100;

/// Raw mode; dropping this ends it.
#[derive(Debug)]
pub struct RawMode(());

impl RawMode {
    /// Puts the terminal in raw mode.
    ///
    /// # Errors
    /// When it cannot be put in raw mode.
    pub fn enter() -> io::Result<Self> {
        terminal::enable_raw_mode()?;
        Ok(Self(()))
    }

    /// Whether the terminal is in raw mode, where a line feed does not return to the first column.
    pub fn is_on() -> bool {
        terminal::is_raw_mode_enabled().unwrap_or(false)
    }
}

impl Drop for RawMode {
    fn drop(&mut self) {
        leave_raw_mode();
    }
}

/// The alternate screen, without a cursor; dropping this shows the lines of the shell again.
#[derive(Debug)]
pub struct AlternateScreen {
    _raw: Arc<RawMode>,
}

impl AlternateScreen {
    /// Shows the alternate screen of a terminal in raw mode.
    ///
    /// # Errors
    /// When the terminal cannot be written.
    pub fn enter(raw: Arc<RawMode>) -> io::Result<Self> {
        give_back_before_a_panic();
        SHOWN.store(true, Ordering::SeqCst);
        let screen = Self { _raw: raw };
        execute!(io::stderr(), EnterAlternateScreen, Hide)?;
        Ok(screen)
    }
}

impl Drop for AlternateScreen {
    fn drop(&mut self) {
        leave_alternate_screen();
    }
}

/// Draws on the alternate screen, unless it has been given back.
pub fn draw(draw: impl FnOnce()) {
    let _drawing = DRAWING.lock().unwrap_or_else(PoisonError::into_inner);
    if SHOWN.load(Ordering::SeqCst) {
        draw();
    }
}

/// Gives the terminal back, whatever has been taken of it. Nothing is drawn on the alternate screen after this.
pub fn give_back() {
    leave_alternate_screen();
    leave_raw_mode();
}

fn leave_alternate_screen() {
    // Leaving it a second time would move the cursor into the lines that were printed after the first.
    if !SHOWN.swap(false, Ordering::SeqCst) {
        return;
    }
    for _ in 0..DRAWING_MS {
        match DRAWING.try_lock() {
            Err(TryLockError::WouldBlock) => thread::sleep(Duration::from_millis(1)),
            Ok(_) | Err(TryLockError::Poisoned(_)) => break,
        }
    }
    // If this fails, the terminal is gone.
    let _ = execute!(io::stderr(), LeaveAlternateScreen, Show);
}

fn leave_raw_mode() {
    // If this fails, the terminal is gone.
    let _ = terminal::disable_raw_mode();
}

/// The message of a panic must not stay on a screen that is gone a moment later.
fn give_back_before_a_panic() {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            give_back();
            usual(panic);
        }));
    });
}
