//! Single-key commands of the operator.

use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

use crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use crossterm::terminal;
use massline_protocol::message::CampaignCommand;
use massline_shared::measurement::campaign::Phase;

use crate::campaign::OperatorAction;

/// The help line for the keys.
pub const HELP: &str = "keys: a accept  r reject  u undo the last hit  d redo this DOF  s skip it  \
     f finish it with the hits it has  p pause  q abort (twice)";

/// Within this time, a second `q` aborts.
const TWICE: Duration = Duration::from_secs(3);

/// What the keys mean that were pressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    /// Something for the campaign.
    Action(OperatorAction),
    /// The first of two presses that abort.
    QuitOnce,
}

/// The terminal in raw mode; dropping this restores it.
#[derive(Debug)]
pub struct Keyboard {
    /// When `q` was the last key.
    quit_once: Option<Instant>,
}

impl Keyboard {
    /// Puts the terminal in raw mode; `None` when stdin is not a terminal.
    ///
    /// # Errors
    /// When the terminal cannot be put in raw mode.
    pub fn take() -> io::Result<Option<Self>> {
        if !io::stdin().is_terminal() {
            return Ok(None);
        }
        terminal::enable_raw_mode()?;
        Ok(Some(Self { quit_once: None }))
    }

    /// What the next key means that was pressed, if any; `takes` gets every key first, and returns true for one that is
    /// none of the campaign's.
    ///
    /// # Errors
    /// When the terminal cannot be read any more.
    pub fn poll(
        &mut self,
        phase: Option<Phase>,
        mut takes: impl FnMut(KeyCode) -> bool,
    ) -> io::Result<Option<Pressed>> {
        while event::poll(Duration::ZERO)? {
            let Event::Key(key) = event::read()? else { continue };
            if key.kind != KeyEventKind::Press {
                continue;
            }
            let control = key.modifiers.contains(KeyModifiers::CONTROL);
            if !control && takes(key.code) {
                self.quit_once = None;
                continue;
            }
            if let Some(pressed) = self.meaning(key.code, control, phase) {
                return Ok(Some(pressed));
            }
        }
        Ok(None)
    }

    fn meaning(&mut self, key: KeyCode, control: bool, phase: Option<Phase>) -> Option<Pressed> {
        use CampaignCommand as C;
        let quit_once = self.quit_once.take().is_some_and(|at| at.elapsed() < TWICE);
        let leave = Some(Pressed::Action(OperatorAction::Leave));
        // In raw mode Ctrl-C arrives as an ordinary key.
        if control {
            return leave.filter(|_| key == KeyCode::Char('c'));
        }
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
            KeyCode::Char('p') => return leave,
            KeyCode::Char('q') if quit_once => C::Abort,
            KeyCode::Char('q') => {
                self.quit_once = Some(Instant::now());
                return Some(Pressed::QuitOnce);
            }
            _ => return None,
        };
        Some(Pressed::Action(OperatorAction::Command(command)))
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // If this fails, the terminal is gone.
        let _ = terminal::disable_raw_mode();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds keys without a terminal; `forget` prevents the drop from changing one.
    fn press(keys: &[(char, bool)], phase: Phase) -> Vec<Option<Pressed>> {
        let mut keyboard = std::mem::ManuallyDrop::new(Keyboard { quit_once: None });
        keys.iter()
            .map(|&(c, control)| keyboard.meaning(KeyCode::Char(c), control, Some(phase)))
            .collect()
    }

    /// The first press of `q`.
    const ONCE: Option<Pressed> = Some(Pressed::QuitOnce);

    fn command(command: CampaignCommand) -> Option<Pressed> {
        Some(Pressed::Action(OperatorAction::Command(command)))
    }

    #[test]
    fn a_hit_is_accepted_only_when_it_waits_for_it() {
        let accept = command(CampaignCommand::Accept);
        assert_eq!(press(&[('a', false)], Phase::Confirming), [accept]);
        assert_eq!(press(&[('a', false)], Phase::Armed), [None]);
    }

    #[test]
    fn the_question_at_the_target_has_two_answers_and_only_there() {
        use CampaignCommand::{Conclude, Continue};
        let [finish, go_on] = [Conclude, Continue].map(command);
        let keys = [('y', false), ('n', false), ('a', false)];
        assert_eq!(press(&keys, Phase::TargetReached), [finish, go_on, None]);
        assert_eq!(press(&keys, Phase::Armed), [None, None, None]);
    }

    #[test]
    fn abort_needs_two_presses_in_a_row() {
        let abort = command(CampaignCommand::Abort);
        assert_eq!(press(&[('q', false), ('q', false)], Phase::Armed), [ONCE, abort]);
        let keys = [('q', false), ('x', false), ('q', false)];
        assert_eq!(press(&keys, Phase::Armed), [ONCE, None, ONCE]);
    }

    #[test]
    fn the_last_hit_is_undone_in_any_phase_and_the_rig_decides() {
        let undo = command(CampaignCommand::Undo);
        for phase in [Phase::Armed, Phase::Busy, Phase::Confirming, Phase::TargetReached] {
            assert_eq!(press(&[('u', false)], phase), [undo]);
        }
    }

    #[test]
    fn control_c_interrupts_and_nothing_else_with_control_does_anything() {
        assert_eq!(
            press(&[('c', true)], Phase::Armed),
            [Some(Pressed::Action(OperatorAction::Leave))]
        );
        assert_eq!(press(&[('d', true)], Phase::Armed), [None]);
    }
}
