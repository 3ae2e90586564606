//! Single-key commands of the operator.

use std::io::{self, IsTerminal};
use std::time::Duration;

use crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use crossterm::terminal;
use massline_protocol::message::CampaignCommand;
use massline_shared::measurement::campaign::Phase;

use crate::campaign::OperatorAction;

/// The help line for the keys.
pub const HELP: &str = "keys: a accept  r reject  u undo the last hit  d redo this DOF  s skip it  \
     f finish it with the hits it has  p pause  q abort (twice)";

/// The terminal in raw mode; dropping this restores it.
#[derive(Debug)]
pub struct Keyboard {
    quit_once: bool,
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
        Ok(Some(Self { quit_once: false }))
    }

    /// The action for the key that was pressed, if any; `takes` gets every key first, and returns true for one that is
    /// none of the campaign's.
    ///
    /// # Errors
    /// When the terminal cannot be read any more.
    pub fn poll(
        &mut self,
        phase: Option<Phase>,
        mut takes: impl FnMut(KeyCode) -> bool,
    ) -> io::Result<Option<OperatorAction>> {
        while event::poll(Duration::ZERO)? {
            let Event::Key(key) = event::read()? else { continue };
            if key.kind != KeyEventKind::Press {
                continue;
            }
            let control = key.modifiers.contains(KeyModifiers::CONTROL);
            if !control && takes(key.code) {
                continue;
            }
            if let Some(steer) = self.meaning(key.code, control, phase) {
                return Ok(Some(steer));
            }
        }
        Ok(None)
    }

    fn meaning(
        &mut self,
        key: KeyCode,
        control: bool,
        phase: Option<Phase>,
    ) -> Option<OperatorAction> {
        use CampaignCommand as C;
        let quit_once = std::mem::take(&mut self.quit_once);
        // In raw mode Ctrl-C arrives as an ordinary key.
        if control {
            return (key == KeyCode::Char('c')).then_some(OperatorAction::Leave);
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
            KeyCode::Char('p') => return Some(OperatorAction::Leave),
            KeyCode::Char('q') if quit_once => C::Abort,
            KeyCode::Char('q') => {
                self.quit_once = true;
                return None;
            }
            _ => return None,
        };
        Some(OperatorAction::Command(command))
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
    fn press(keys: &[(char, bool)], phase: Phase) -> Vec<Option<OperatorAction>> {
        let mut keyboard = std::mem::ManuallyDrop::new(Keyboard { quit_once: false });
        keys.iter()
            .map(|&(c, control)| keyboard.meaning(KeyCode::Char(c), control, Some(phase)))
            .collect()
    }

    #[test]
    fn a_hit_is_accepted_only_when_it_waits_for_it() {
        let accept = Some(OperatorAction::Command(CampaignCommand::Accept));
        assert_eq!(press(&[('a', false)], Phase::Confirming), [accept]);
        assert_eq!(press(&[('a', false)], Phase::Armed), [None]);
    }

    #[test]
    fn the_question_at_the_target_has_two_answers_and_only_there() {
        use CampaignCommand::{Conclude, Continue};
        let [finish, go_on] =
            [Conclude, Continue].map(|command| Some(OperatorAction::Command(command)));
        let keys = [('y', false), ('n', false), ('a', false)];
        assert_eq!(press(&keys, Phase::TargetReached), [finish, go_on, None]);
        assert_eq!(press(&keys, Phase::Armed), [None, None, None]);
    }

    #[test]
    fn abort_needs_two_presses_in_a_row() {
        let abort = Some(OperatorAction::Command(CampaignCommand::Abort));
        assert_eq!(press(&[('q', false), ('q', false)], Phase::Armed), [None, abort]);
        let keys = [('q', false), ('x', false), ('q', false)];
        assert_eq!(press(&keys, Phase::Armed), [None, None, None]);
    }

    #[test]
    fn the_last_hit_is_undone_in_any_phase_and_the_rig_decides() {
        let undo = Some(OperatorAction::Command(CampaignCommand::Undo));
        for phase in [Phase::Armed, Phase::Busy, Phase::Confirming, Phase::TargetReached] {
            assert_eq!(press(&[('u', false)], phase), [undo]);
        }
    }

    #[test]
    fn control_c_interrupts_and_nothing_else_with_control_does_anything() {
        assert_eq!(press(&[('c', true)], Phase::Armed), [Some(OperatorAction::Leave)]);
        assert_eq!(press(&[('d', true)], Phase::Armed), [None]);
    }
}
