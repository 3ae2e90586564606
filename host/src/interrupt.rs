//! Ctrl-C: a command that has something to put in order asks to be told; any other ends at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Knows whether the user has pressed Ctrl-C. Clones share what they know.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    pressed: AtomicBool,
    guards: AtomicUsize,
}

/// While this lives, Ctrl-C is only noted; without one it ends the process.
#[derive(Debug)]
pub struct Guard(Interrupt);

impl Interrupt {
    /// Not pressed.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes Ctrl-C and termination of the process from now on.
    ///
    /// The first press is noted while a [`Guard`] lives. Without a guard, or with the second press,
    /// the process ends with exit code 130.
    pub fn of_process() -> Self {
        let interrupt = Self::new();
        let state = interrupt.clone();
        // Fails only when called twice or out of memory; then Ctrl-C kills the process as usual.
        let _ = ctrlc::set_handler(move || {
            if !state.press() {
                std::process::exit(130);
            }
        });
        interrupt
    }

    /// Notes a press; false when nobody waits for it.
    pub fn press(&self) -> bool {
        let first = !self.0.pressed.swap(true, Ordering::SeqCst);
        first && self.0.guards.load(Ordering::SeqCst) > 0
    }

    /// True when the user has pressed Ctrl-C.
    pub fn pressed(&self) -> bool {
        self.0.pressed.load(Ordering::SeqCst)
    }

    /// From now on until the guard is dropped the caller looks at [`Interrupt::pressed`].
    pub fn guard(&self) -> Guard {
        self.0.guards.fetch_add(1, Ordering::SeqCst);
        Guard(self.clone())
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        self.0.0.guards.fetch_sub(1, Ordering::SeqCst);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_press_is_noted_only_while_somebody_waits() {
        let interrupt = Interrupt::new();
        let guard = interrupt.guard();
        assert!(interrupt.press());
        assert!(interrupt.pressed());
        drop(guard);
        assert!(!Interrupt::new().press());
    }

    #[test]
    fn the_second_press_is_not_waited_for() {
        let interrupt = Interrupt::new();
        let _guard = interrupt.guard();
        assert!(interrupt.press());
        assert!(!interrupt.press());
    }
}
