//! Ctrl-C: a command that must clean up asks to be notified; any other command ends at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Records whether the user has pressed Ctrl-C. Clones share their state.
#[derive(Clone, Debug, Default)]
pub struct Interrupt(Arc<State>);

#[derive(Debug, Default)]
struct State {
    pressed: AtomicBool,
    guards: AtomicUsize,
}

/// While a guard exists, Ctrl-C is only recorded; without one it ends the process.
#[derive(Debug)]
pub struct Guard(Interrupt);

impl Interrupt {
    /// An interrupt that has not been pressed.
    pub fn new() -> Self {
        Self::default()
    }

    /// Handles Ctrl-C and termination of the process from now on.
    ///
    /// The first press is only recorded while a [`Guard`] exists. Without a guard, or at the second press,
    /// `clean_up` is called and the process ends with exit code 130.
    pub fn of_process(clean_up: fn()) -> Self {
        let interrupt = Self::new();
        let state = interrupt.clone();
        // This fails only when called twice or out of memory; Ctrl-C then kills the process as usual.
        let _ = ctrlc::set_handler(move || {
            if !state.press() {
                clean_up();
                std::process::exit(130);
            }
        });
        interrupt
    }

    /// Records a key that stands for Ctrl-C; unlike a second signal, a second key is no more than the first.
    pub fn press_key(&self) {
        self.0.pressed.store(true, Ordering::SeqCst);
    }

    /// Records a press; returns false when no guard exists, and at the second press.
    pub fn press(&self) -> bool {
        let first = !self.0.pressed.swap(true, Ordering::SeqCst);
        first && self.0.guards.load(Ordering::SeqCst) > 0
    }

    /// True when the user has pressed Ctrl-C.
    pub fn pressed(&self) -> bool {
        self.0.pressed.load(Ordering::SeqCst)
    }

    /// Returns a guard. Until it is dropped the caller must check [`Interrupt::pressed`].
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
