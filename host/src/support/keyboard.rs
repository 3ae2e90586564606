//! Single-key commands of the person at the terminal.
//!
//! A thread waits for the keys, so that Ctrl-C and `p` are seen at once, whatever the command waits for.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use massline_shared::measurement::campaign::{Command, Phase};

use crate::output::Output;
use crate::terminal::RawMode;
use crate::{Error, Result};
use massline_client::interrupt::{Guard, Interrupt};

/// The help line for the keys.
pub const HELP: &str = "keys: a accept  r reject  u undo the last hit  d redo this DOF  s skip it  \
     f finish it with the hits it has  p pause  q abort (twice)";

/// Within this time, a second `q` aborts.
const TWICE: Duration = Duration::from_secs(3);
/// Time between two looks of the thread at whether it is to end.
const LOOK: Duration = Duration::from_millis(50);
/// The thread ends within this time, unless the terminal is gone.
const END: Duration = Duration::from_millis(500);

/// What the keys mean that were pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyMeaning {
    /// A command for the campaign.
    Command(Command),
    /// The first of two presses that abort.
    QuitOnce,
}

/// The keys of a terminal in raw mode. Ctrl-C and `p` press the [`Interrupt`] of the output, which is guarded
/// meanwhile; the other keys wait until they are asked for. Dropping this discards those that are left, and gives the
/// terminal back.
#[derive(Debug)]
pub struct Keyboard {
    keys: Receiver<KeyCode>,
    ends: Arc<AtomicBool>,
    raw: Arc<RawMode>,
    meanings: Meanings,
    _guard: Guard,
}

impl Keyboard {
    /// Takes the keyboard of this output.
    ///
    /// # Errors
    /// When the terminal cannot be put in raw mode.
    pub fn take(output: &Output) -> Result<Self> {
        let interrupt = output.interrupt().clone();
        let guard = interrupt.guard();
        let raw = Arc::new(RawMode::enter().map_err(no_terminal)?);
        let (sender, keys) = channel();
        let ends = Arc::new(AtomicBool::new(false));
        let end = Arc::clone(&ends);
        let read = move || {
            if read_keys(&sender, &end, &interrupt).is_err() {
                // The terminal is gone, and the person with it.
                interrupt.press_key();
            }
        };
        thread::Builder::new().name("keyboard".into()).spawn(read).map_err(no_terminal)?;
        Ok(Self { keys, ends, raw, meanings: Meanings::default(), _guard: guard })
    }

    /// The raw mode that the keys need, for a screen on the same terminal.
    pub fn raw_mode(&self) -> Arc<RawMode> {
        Arc::clone(&self.raw)
    }

    /// The next key, which is waited for no longer than this.
    pub fn next_key(&mut self, patience: Duration) -> Option<KeyCode> {
        self.keys.recv_timeout(patience).ok()
    }

    /// What the next key means that was pressed, if any; `takes` gets every key first, and returns true for one that is
    /// none of the campaign's.
    pub fn poll(
        &mut self,
        phase: Option<Phase>,
        mut takes: impl FnMut(KeyCode) -> bool,
    ) -> Option<KeyMeaning> {
        while let Ok(key) = self.keys.try_recv() {
            if takes(key) {
                self.meanings = Meanings::default();
            } else if let Some(pressed) = self.meanings.of(key, phase) {
                return Some(pressed);
            }
        }
        None
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::SeqCst);
        let deadline = Instant::now() + END;
        // Its end of the channel goes with the thread.
        let left = || deadline.saturating_duration_since(Instant::now());
        while self.keys.recv_timeout(left()).is_ok() {}
    }
}

/// An error of the terminal.
pub fn no_terminal(error: io::Error) -> Error {
    Error::internal("no_keyboard", format!("the terminal: {error}"))
}

/// Reads keys until the end, and then those that are left, which are not for the shell.
fn read_keys(keys: &Sender<KeyCode>, ends: &AtomicBool, interrupt: &Interrupt) -> io::Result<()> {
    while !ends.load(Ordering::SeqCst) {
        if !event::poll(LOOK)? {
            continue;
        }
        match Key::of(&event::read()?) {
            Some(Key::Interrupt) => interrupt.press_key(),
            // After the last question for a key there is nobody to get it.
            Some(Key::Other(key)) => keys.send(key).unwrap_or_default(),
            None => {}
        }
    }
    while event::poll(Duration::ZERO)? {
        event::read()?;
    }
    Ok(())
}

/// A key that does something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Key {
    /// Ctrl-C, which is no signal in raw mode, and `p`.
    Interrupt,
    Other(KeyCode),
}

impl Key {
    fn of(event: &Event) -> Option<Self> {
        let Event::Key(KeyEvent { code, modifiers, kind: KeyEventKind::Press, .. }) = *event else {
            return None;
        };
        match (code, modifiers.contains(KeyModifiers::CONTROL)) {
            (KeyCode::Char('c'), true) | (KeyCode::Char('p'), false) => Some(Self::Interrupt),
            (_, true) => None,
            (code, false) => Some(Self::Other(code)),
        }
    }
}

/// What keys mean, one after the other.
#[derive(Debug, Default)]
struct Meanings {
    /// When `q` was the last key.
    quit_once: Option<Instant>,
}

impl Meanings {
    /// What the next key means in this phase.
    fn of(&mut self, key: KeyCode, phase: Option<Phase>) -> Option<KeyMeaning> {
        use Command as C;
        let quit_once = self.quit_once.take().is_some_and(|at| at.elapsed() < TWICE);
        let confirming = phase == Some(Phase::Confirming);
        let at_target = phase == Some(Phase::TargetReached);
        let command = match key {
            KeyCode::Char('a' | 'y') | KeyCode::Enter if confirming => C::Accept,
            KeyCode::Char('r' | 'n') | KeyCode::Backspace if confirming => C::Reject,
            KeyCode::Char('y') | KeyCode::Enter if at_target => C::Conclude,
            KeyCode::Char('n') if at_target => C::Continue,
            KeyCode::Char('u') => C::Undo,
            KeyCode::Char('d') => C::Redo,
            KeyCode::Char('s') => C::Skip,
            KeyCode::Char('f') => C::Finish,
            KeyCode::Char('q') if quit_once => C::Abort,
            KeyCode::Char('q') => {
                self.quit_once = Some(Instant::now());
                return Some(KeyMeaning::QuitOnce);
            }
            _ => return None,
        };
        Some(KeyMeaning::Command(command))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn press(keys: &str, phase: Phase) -> Vec<Option<KeyMeaning>> {
        let mut meanings = Meanings::default();
        keys.chars().map(|key| meanings.of(KeyCode::Char(key), Some(phase))).collect()
    }

    /// The first press of `q`.
    const ONCE: Option<KeyMeaning> = Some(KeyMeaning::QuitOnce);

    fn command(command: Command) -> Option<KeyMeaning> {
        Some(KeyMeaning::Command(command))
    }

    #[test]
    fn a_hit_is_accepted_only_when_it_waits_for_it() {
        assert_eq!(press("a", Phase::Confirming), [command(Command::Accept)]);
        assert_eq!(press("a", Phase::Armed), [None]);
    }

    #[test]
    fn the_question_at_the_target_has_two_answers_and_only_there() {
        use Command::{Conclude, Continue};
        let [finish, go_on] = [Conclude, Continue].map(command);
        assert_eq!(press("yna", Phase::TargetReached), [finish, go_on, None]);
        assert_eq!(press("yna", Phase::Armed), [None, None, None]);
    }

    #[test]
    fn abort_needs_two_presses_in_a_row() {
        let abort = command(Command::Abort);
        assert_eq!(press("qq", Phase::Armed), [ONCE, abort]);
        assert_eq!(press("qxq", Phase::Armed), [ONCE, None, ONCE]);
    }

    #[test]
    fn the_last_hit_is_undone_in_any_phase_and_the_rig_decides() {
        let undo = command(Command::Undo);
        for phase in [Phase::Armed, Phase::Busy, Phase::Confirming, Phase::TargetReached] {
            assert_eq!(press("u", phase), [undo]);
        }
    }

    #[test]
    fn control_c_and_p_interrupt_and_nothing_else_with_control_does_anything() {
        let key =
            |key, modifiers| Key::of(&Event::Key(KeyEvent::new(KeyCode::Char(key), modifiers)));
        let (control, none) = (KeyModifiers::CONTROL, KeyModifiers::NONE);
        assert_eq!(key('c', control), Some(Key::Interrupt));
        assert_eq!(key('p', none), Some(Key::Interrupt));
        assert_eq!(key('c', none), Some(Key::Other(KeyCode::Char('c'))));
        assert_eq!([key('d', control), key('p', control)], [None, None]);
    }
}
