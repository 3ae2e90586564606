//! Which screen is shown, and what a button does on it. A pure state machine: it reads a [`PanelModel`],
//! returns an [`Action`], and draws nothing.
//!
//! `Back` leads towards home from every screen, `Ok` enters or confirms, `Next` moves to the next item. The
//! campaign's phase decides what the screen [`Screen::Measure`] shows:
//!
//! ```text
//! Home ─┬─ Measure ─┬─ Findings          ┌ Ok: start, Next: Profile
//!       │  (phase)  ├─ Precision    Idle ┤      armed ─ Next: pause ─ list: go on, undo, again, skip, finish, end
//!       │           └─ Sure: end?        └      target ─ Ok: finish, Next: go on
//!       ├─ Results ── Result ── Sure: delete?
//!       ├─ Layouts
//!       ├─ Calibration ─┬─ Tumble ── proposal: keep?
//!       │               └─ BlockMass ── Measure ── proposal: keep?
//!       ├─ Self-test
//!       ├─ Storage
//!       └─ About
//! ```

mod entry;

use massline_shared::layout::TestProfile;
use massline_shared::measurement::campaign::{Command, Phase};

use super::calibration_wizard::CalibrationWizard;
use super::refused::RefusalReason;
use super::self_test::SelfTestState;
use super::{Button, PanelModel};

pub use entry::{Entries, Entry};

/// What is on the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Screen {
    /// The main list.
    Home,
    /// The phase of the campaign.
    Measure,
    /// The diagnostics of the campaign or of a refused layout, page by page.
    Findings,
    /// How precise the answer of the campaign would be so far.
    Precision,
    /// What is measured with the layout.
    Profile,
    /// The stored layouts.
    Layouts,
    /// The stored results.
    Results,
    /// The pages of the open result.
    Result,
    /// What can be calibrated.
    Calibration,
    /// Entry of the block's mass, digit by digit.
    BlockMass,
    /// A calibration in progress: positions, problems, the proposal.
    CalibrationWizard,
    /// The self-test.
    SelfTest,
    /// How full the flash is, and its wear.
    Storage,
    /// Identity of the rig.
    About,
    /// A question before something is deleted.
    Sure(Question),
    /// Why the rig has refused an action.
    Refused(RefusalReason),
}

/// What would be deleted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// The campaign.
    End,
    /// The hits of the current DOF.
    Redo,
    /// The open result.
    Delete,
}

/// An action that the rig is to perform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Pass a command to the campaign.
    Command(Command),
    /// Start a campaign.
    Start,
    /// Start a campaign on a block of known mass.
    StartBlock {
        /// Mass of the block, including what is glued to it.
        decigrams: u32,
    },
    /// Measure this with the layout in use.
    UseProfile(TestProfile),
    /// Use the layout at this position of the list.
    UseLayout(u8),
    /// Open the result at this position of the list, newest first.
    OpenResult(u8),
    /// Open the result of this campaign.
    OpenLast,
    /// Delete the open result permanently.
    DeleteResult,
    /// Begin a self-test.
    StartSelfTest,
    /// Stop it.
    StopSelfTest,
    /// Begin a tumble test.
    StartTumble,
    /// Read the sensors in the current position.
    ReadPosition,
    /// Compute a calibration from the result of the block test.
    SolveBlock,
    /// Store the proposed calibration.
    KeepCalibration,
    /// Discard readings and proposals.
    CancelCalibration,
    /// The screen has another controller.
    NextScreen,
}

/// Digits of the mass of a block: up to 99 999.9 g.
pub const DIGITS: u8 = 6;

/// The state of the menu.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Menu {
    screen: Screen,
    /// Index of the current line, page or digit.
    cursor: u8,
    /// Line of the main list to return to.
    home: u8,
    /// Mass of the block.
    decigrams: u32,
    /// The campaign's phase at the last [`Menu::follow`].
    phase: Phase,
}

impl Default for Menu {
    fn default() -> Self {
        Self::new()
    }
}

impl Menu {
    /// The menu at home, with a block mass of 1 kg.
    pub const fn new() -> Self {
        Self { screen: Screen::Home, cursor: 0, home: 0, decigrams: 10_000, phase: Phase::Idle }
    }

    /// What is on the screen.
    pub fn screen(&self) -> Screen {
        self.screen
    }

    /// Index of the current line, page or digit.
    pub fn cursor(&self) -> u8 {
        self.cursor
    }

    /// Mass of the block, in tenths of a gram.
    pub fn decigrams(&self) -> u32 {
        self.decigrams
    }

    /// The lines of the list on the screen; empty when the screen shows no list.
    pub fn entries(&self, model: &PanelModel) -> Entries {
        let mut entries = Entries::new();
        let list: &[Entry] = match (self.screen, model.phase) {
            (Screen::Home, _) => &[
                Entry::Measure,
                Entry::Results,
                Entry::Layouts,
                Entry::Calibration,
                Entry::SelfTest,
                Entry::Storage,
                Entry::About,
            ],
            (Screen::Measure, Phase::Confirming) => &[Entry::Accept, Entry::Reject],
            (Screen::Measure, Phase::Paused) => &[
                Entry::Resume,
                Entry::Undo,
                Entry::Redo,
                Entry::Skip,
                Entry::Finish,
                Entry::Precision,
                Entry::Findings,
                Entry::End,
            ],
            (Screen::Calibration, _) => &[Entry::Tumble, Entry::Block],
            (Screen::Profile, _) => &[Entry::MassLines, Entry::Modes],
            _ => &[],
        };
        let complete = is_complete(model);
        let solved = complete || model.at_target;
        let is_offered = |entry: &&Entry| match entry {
            // Without a hit to undo the rig says why.
            Entry::Undo => !complete && model.averaged > 0,
            Entry::Redo | Entry::Skip => !solved,
            Entry::Finish => !solved && model.accepted > 0,
            Entry::Precision => model.precision.is_some(),
            Entry::Findings => model.findings > 0,
            _ => true,
        };
        // No list has more than eight lines.
        entries.extend(list.iter().filter(is_offered).copied().take(8));
        entries
    }

    /// Number of lines, pages or digits.
    fn length(&self, model: &PanelModel) -> u8 {
        match self.screen {
            Screen::Findings => model.findings,
            Screen::Layouts => model.layouts,
            Screen::Results => model.results,
            Screen::Result => model.pages,
            Screen::BlockMass => DIGITS,
            Screen::SelfTest => model.self_test.pages(),
            Screen::About => ABOUT_PAGES,
            _ => self.entries(model).len() as u8,
        }
    }

    /// Updates the menu after a change: a campaign that starts or is interrupted is brought to the front,
    /// and the cursor is kept within its list.
    pub fn follow(&mut self, model: &PanelModel) {
        let before = core::mem::replace(&mut self.phase, model.phase);
        let held = matches!(before, Phase::Idle | Phase::Done | Phase::Paused);
        let measures = matches!(model.phase, Phase::Armed | Phase::Busy | Phase::Confirming);
        if before != model.phase {
            if held && measures && self.screen != Screen::Measure {
                self.go(Screen::Measure);
            } else if model.phase == Phase::Paused && model.interrupted && model.findings > 0 {
                self.go(Screen::Findings);
            } else if self.screen == Screen::Measure {
                self.cursor = 0;
            }
        }
        match self.screen {
            Screen::Sure(Question::End | Question::Redo) if model.phase != Phase::Paused => {
                self.go(Screen::Measure);
            }
            Screen::Result | Screen::Sure(Question::Delete) if model.pages == 0 => {
                self.go(Screen::Results);
            }
            Screen::Findings if model.findings == 0 => self.go(Screen::Measure),
            Screen::Precision if model.phase != Phase::Paused => self.go(Screen::Measure),
            Screen::Profile if model.phase != Phase::Idle => self.go(Screen::Measure),
            Screen::CalibrationWizard if model.calibration_wizard == CalibrationWizard::Off => {
                self.go(Screen::Calibration)
            }
            Screen::SelfTest if model.self_test == SelfTestState::Off => self.go(Screen::Home),
            _ => {}
        }
        self.cursor = self.cursor.min(self.length(model).saturating_sub(1));
    }

    /// Shows why an action was refused.
    pub fn refuse(&mut self, reason: RefusalReason) {
        self.go(match reason {
            RefusalReason::LayoutRefused => Screen::Findings,
            reason => Screen::Refused(reason),
        });
    }

    /// Shows a screen whose content has been loaded.
    pub fn open(&mut self, screen: Screen) {
        self.go(screen);
    }

    /// Handles a button; returns the action for the rig, if any. `model` is the one last passed to
    /// [`Self::follow`].
    pub fn press(&mut self, button: Button, model: &PanelModel) -> Option<Action> {
        match button {
            Button::Ok => self.ok(model),
            Button::Back => self.back(model),
            Button::Next => self.next(model),
        }
    }

    fn ok(&mut self, model: &PanelModel) -> Option<Action> {
        let entry = self.entries(model).get(usize::from(self.cursor)).copied();
        if let Some(entry) = entry {
            return self.enter(entry, model);
        }
        match self.screen {
            Screen::Measure => self.ok_measuring(model),
            Screen::SelfTest if model.self_test == SelfTestState::Disturbed => self.back(model),
            Screen::About if self.cursor == SCREEN_PAGE => Some(Action::NextScreen),
            Screen::Findings | Screen::Result | Screen::SelfTest | Screen::About => {
                self.next(model)
            }
            Screen::Layouts if model.layouts > 0 && model.idle => {
                Some(Action::UseLayout(self.cursor))
            }
            Screen::Results if model.results > 0 => Some(Action::OpenResult(self.cursor)),
            Screen::BlockMass => self.ok_digit(model),
            Screen::CalibrationWizard => self.ok_calibration_wizard(model),
            Screen::Sure(question) => self.yes(question, model),
            Screen::Refused(_) | Screen::Precision => self.back(model),
            _ => None,
        }
    }

    fn enter(&mut self, entry: Entry, model: &PanelModel) -> Option<Action> {
        use Command as C;
        if self.screen == Screen::Home {
            self.home = self.cursor;
        }
        let screen = match entry {
            Entry::Measure => Screen::Measure,
            Entry::Results => Screen::Results,
            Entry::Layouts => Screen::Layouts,
            Entry::Calibration => Screen::Calibration,
            Entry::Storage => Screen::Storage,
            Entry::About => Screen::About,
            Entry::Precision => Screen::Precision,
            Entry::Findings => Screen::Findings,
            Entry::Redo => Screen::Sure(Question::Redo),
            Entry::End => Screen::Sure(Question::End),
            Entry::Block => Screen::BlockMass,
            Entry::SelfTest if model.idle => return Some(Action::StartSelfTest),
            Entry::SelfTest => Screen::Refused(RefusalReason::WrongPhase),
            Entry::Tumble if model.idle => return Some(Action::StartTumble),
            Entry::Tumble => Screen::Refused(RefusalReason::WrongPhase),
            Entry::Resume => return Some(Action::Command(C::Resume)),
            Entry::Undo => return Some(Action::Command(C::Undo)),
            Entry::Skip => return Some(Action::Command(C::Skip)),
            Entry::Finish => return Some(Action::Command(C::Finish)),
            Entry::Accept => return Some(Action::Command(C::Accept)),
            Entry::Reject => return Some(Action::Command(C::Reject)),
            Entry::MassLines => return Some(Action::UseProfile(TestProfile::MassLine)),
            Entry::Modes => return Some(Action::UseProfile(TestProfile::Suspension)),
        };
        self.go(screen);
        None
    }

    fn ok_measuring(&mut self, model: &PanelModel) -> Option<Action> {
        match model.phase {
            Phase::Idle => Some(Action::Start),
            Phase::TargetReached => Some(Action::Command(Command::Conclude)),
            Phase::Done if model.block => Some(Action::SolveBlock),
            Phase::Done => Some(Action::OpenLast),
            _ => None,
        }
    }

    fn ok_digit(&mut self, model: &PanelModel) -> Option<Action> {
        if self.cursor + 1 < DIGITS {
            self.cursor += 1;
            return None;
        }
        if self.decigrams == 0 {
            self.cursor = 0;
            return None;
        }
        self.go(Screen::Measure);
        if !model.idle {
            self.refuse(RefusalReason::WrongPhase);
            return None;
        }
        Some(Action::StartBlock { decigrams: self.decigrams })
    }

    fn ok_calibration_wizard(&mut self, model: &PanelModel) -> Option<Action> {
        match model.calibration_wizard {
            CalibrationWizard::Wanted(_) if model.idle => Some(Action::ReadPosition),
            CalibrationWizard::Wanted(_) => {
                self.go(Screen::Refused(RefusalReason::WrongPhase));
                None
            }
            CalibrationWizard::Wrong(problem) if problem.read_again() => Some(Action::ReadPosition),
            CalibrationWizard::Proposed(_) => Some(Action::KeepCalibration),
            CalibrationWizard::Wrong(_) | CalibrationWizard::Stored => self.back(model),
            CalibrationWizard::Off | CalibrationWizard::Reading(_) => None,
        }
    }

    fn yes(&mut self, question: Question, model: &PanelModel) -> Option<Action> {
        self.back(model);
        match question {
            Question::End => Some(Action::Command(Command::Abort)),
            Question::Redo => Some(Action::Command(Command::Redo)),
            Question::Delete => Some(Action::DeleteResult),
        }
    }

    fn next(&mut self, model: &PanelModel) -> Option<Action> {
        match (self.screen, model.phase) {
            (Screen::Measure, Phase::Armed | Phase::Busy) => {
                return Some(Action::Command(Command::Pause));
            }
            (Screen::Measure, Phase::TargetReached) => {
                return Some(Action::Command(Command::Continue));
            }
            (Screen::Measure, Phase::Done) => {
                return Some(Action::Start);
            }
            (Screen::Measure, Phase::Idle) if model.dofs > 0 => {
                self.go(Screen::Profile);
                self.cursor = u8::from(model.profile == TestProfile::Suspension);
            }
            (Screen::BlockMass, _) => self.turn_digit(),
            // The last page asks whether to delete.
            (Screen::Result, _) if self.cursor + 1 >= model.pages => {
                self.go(Screen::Sure(Question::Delete));
            }
            _ => self.cursor = (self.cursor + 1) % self.length(model).max(1),
        }
        None
    }

    /// Increments the current digit; nine becomes zero.
    fn turn_digit(&mut self) {
        let unit = 10_u32.pow(u32::from(DIGITS - 1 - self.cursor.min(DIGITS - 1)));
        let digit = self.decigrams / unit % 10;
        self.decigrams = self.decigrams - digit * unit + (digit + 1) % 10 * unit;
    }

    fn back(&mut self, model: &PanelModel) -> Option<Action> {
        let (screen, action) = match self.screen {
            Screen::Home => {
                self.home = 0;
                (Screen::Home, None)
            }
            // An operator who leaves the screen does not hit.
            Screen::Measure if matches!(model.phase, Phase::Armed | Phase::Busy) => {
                (Screen::Home, Some(Action::Command(Command::Pause)))
            }
            Screen::Findings
            | Screen::Precision
            | Screen::Profile
            | Screen::Sure(Question::End | Question::Redo) => (Screen::Measure, None),
            Screen::Result => (Screen::Results, None),
            Screen::Sure(Question::Delete) => (Screen::Result, None),
            Screen::BlockMass => (Screen::Calibration, None),
            Screen::CalibrationWizard => (Screen::Calibration, Some(Action::CancelCalibration)),
            Screen::SelfTest => (Screen::Home, Some(Action::StopSelfTest)),
            _ => (Screen::Home, None),
        };
        self.go(screen);
        action
    }

    fn go(&mut self, screen: Screen) {
        self.cursor = if screen == Screen::Home { self.home } else { 0 };
        self.screen = screen;
    }
}

/// Number of pages about the rig.
pub const ABOUT_PAGES: u8 = 5;
/// The one of them that says which controller the screen has.
pub const SCREEN_PAGE: u8 = 3;

/// True when no hit is wanted any more.
fn is_complete(model: &PanelModel) -> bool {
    model.hits > 0 && model.hits_done >= model.hits
}

#[cfg(test)]
mod tests;
