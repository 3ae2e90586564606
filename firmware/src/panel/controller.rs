//! What the panel does between two waits: follows the measurement, draws, acts on a button.

mod calibration;
mod self_test;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Instant};
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::message::{ResultEntry, Stats};
use massline_shared::calibration::tumble::TumbleTest;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::TestProfile;
use massline_shared::measurement::StartError;
use massline_shared::measurement::campaign::{Object, Start};
use massline_shared::signal::ringing_s;

use super::draw::{LayoutLine, View, canvas, draw};
use super::menu::{Action, Menu, Screen};
use super::modal::ModalState;
use super::pace::TimeEstimator;
use super::refused::RefusalReason;
use super::summary;
use super::{Button, Cue, PanelModel, cues};
use crate::deadline::Deadline;
use crate::rig::Rig;
use crate::screen_setting::ScreenSetting;
use crate::store::{LAYOUTS, LayoutHandle, RESULTS, ResultHandle, Shortage, Store};

/// An action that needs the flash.
#[derive(Clone, Copy)]
pub(super) enum PendingAction {
    /// Start a campaign; the store is asked whether it has room.
    Start(Object),
    /// Read a result.
    Open(ResultHandle),
    Delete(u32),
    /// Begin a self-test; the store says whether the sensors are known.
    SelfTest,
    UseLayout(u32),
    UseProfile(TestProfile),
    SolveBlock,
    KeepCalibration,
    UseScreen(ScreenSetting),
}

/// The parts of the loop that do not wait. They are plain functions, because the code of an async function
/// is compiled with the board.
pub(super) struct PanelController<'a, 'm, F: NorFlash> {
    pub(super) rig: &'a Rig<'m>,
    pub(super) store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub(super) menu: Menu,
    pub(super) modal: &'a mut ModalState,
    pub(super) pace: TimeEstimator,
    /// The model that was shown last.
    pub(super) before: PanelModel,
}

impl<F: NorFlash> PanelController<'_, '_, F> {
    /// Updates the panel after a change; returns the cues to be played.
    pub(super) fn follow(&mut self) -> Vec<Cue, 3> {
        self.take_reading();
        self.step_self_test();
        let mut model = self.model();
        self.menu.follow(&model);
        if !self.modal.belongs_to(self.menu.screen()) {
            *self.modal = ModalState::Nothing;
            model = self.model();
            self.menu.follow(&model);
        }
        self.pace.follow(&model, Instant::now());
        model.seconds_left = self.pace.seconds_left(&model);
        let record_ms = 1e3 * ringing_s(self.rig.measurement.borrow().adc());
        let record = Duration::from_millis(record_ms as u64);
        model.ringing_left = self.pace.ringing_left(record, Instant::now());
        let heard = cues(&self.before, &model);
        self.before = model;
        heard
    }

    /// The current model. While the flash is being written it has the previous lists.
    fn model(&self) -> PanelModel {
        let mut model = PanelModel::of(self.rig);
        let lists = |store: &Store<F>| (store.results().len() as u8, store.layouts().len() as u8);
        let before = (self.before.results, self.before.layouts);
        (model.results, model.layouts) =
            self.store.try_lock().map_or(before, |store| lists(&store));
        if let ModalState::Refusal(findings) = &*self.modal {
            model.findings = findings.len() as u8;
        }
        model.pages = self.modal.summary().map_or(0, summary::Summary::pages);
        model.calibration_wizard = self.modal.calibration_wizard();
        model.self_test = self.modal.self_test();
        model
    }

    /// Draws the current screen.
    pub(super) fn draw(&self, store: &Store<F>, screen: &mut impl canvas::Screen) {
        let rig = self.rig;
        let _deadline = Deadline::begin(&rig.stats);
        let newest_first = store.results().iter().rev().map(|stored| stored.entry);
        let results: Vec<ResultEntry, RESULTS> = newest_first.take(RESULTS).collect();
        let stats = &Stats { store_failures: store.failures(), ..rig.stats() };
        let measurement = rig.measurement.borrow();
        let findings = match &*self.modal {
            ModalState::Refusal(findings) => findings,
            ModalState::SelfTest(run, _) => run.findings(),
            _ => measurement.diagnostics(),
        };
        let at_rest = match &*self.modal {
            ModalState::SelfTest(run, _) => run.channels(),
            _ => &[],
        };
        let view = View {
            menu: &self.menu,
            model: &self.before,
            layout: measurement.layout(),
            layout_hash: self.rig.layout_hash.get(),
            layouts: &layouts(store),
            results: &results,
            summary: self.modal.summary(),
            findings,
            at_rest,
            info: &rig.info,
            stats,
            screen: store.screen(),
        };
        draw(&view, screen);
    }

    /// Handles a button; returns the action that needs the flash, if any.
    pub(super) fn press(&mut self, button: Button) -> Option<PendingAction> {
        let action = self.menu.press(button, &self.before)?;
        match self.act(action) {
            Ok(pending) => pending,
            Err(reason) => {
                self.menu.refuse(reason);
                None
            }
        }
    }

    /// Handles the outcome of a pending action.
    pub(super) fn answer(&mut self, done: Result<(), RefusalReason>) {
        if let Err(reason) = done {
            self.menu.refuse(reason);
        }
    }

    fn act(&mut self, action: Action) -> Result<Option<PendingAction>, RefusalReason> {
        match action {
            Action::Start => return Ok(Some(PendingAction::Start(Object::Unknown))),
            Action::Command(command) => self.rig.command(command)?,
            Action::StartBlock { decigrams } => {
                let mass = decigrams as f32 * 1e-4;
                return Ok(Some(PendingAction::Start(Object::Block { mass })));
            }
            Action::StartSelfTest => return self.when_idle(PendingAction::SelfTest),
            Action::StartTumble => {
                *self.modal = ModalState::Tumble(TumbleTest::new(), false);
                self.menu.open(Screen::CalibrationWizard);
            }
            Action::ReadPosition => self.read_position()?,
            Action::StopSelfTest | Action::CancelCalibration => self.cancel(),
            Action::OpenResult(place) => {
                let store = self.store.try_lock().map_err(|_| RefusalReason::Busy)?;
                let stored = store.results().iter().rev().nth(usize::from(place));
                return open(stored.copied());
            }
            Action::OpenLast => {
                let store = self.store.try_lock().map_err(|_| RefusalReason::Busy)?;
                return open(store.find(self.before.result));
            }
            Action::DeleteResult => {
                let summary = self.modal.summary().ok_or(RefusalReason::NotFound)?;
                let rests = self
                    .rig
                    .measurement
                    .borrow()
                    .rests()
                    .then_some(PendingAction::Delete(summary.number));
                return rests.ok_or(RefusalReason::WrongPhase).map(Some);
            }
            Action::UseProfile(profile) => {
                if profile == self.before.profile {
                    self.menu.open(Screen::Measure);
                    return Ok(None);
                }
                return self.when_idle(PendingAction::UseProfile(profile));
            }
            Action::UseLayout(place) => {
                let store = self.store.try_lock().map_err(|_| RefusalReason::Busy)?;
                let stored =
                    store.layouts().get(usize::from(place)).ok_or(RefusalReason::NotFound)?;
                return match stored.in_use {
                    true => Ok(None),
                    false => self.when_idle(PendingAction::UseLayout(stored.hash)),
                };
            }
            Action::SolveBlock => return self.when_idle(PendingAction::SolveBlock),
            Action::KeepCalibration => return self.when_idle(PendingAction::KeepCalibration),
            Action::NextScreen => {
                let store = self.store.try_lock().map_err(|_| RefusalReason::Busy)?;
                return self.when_idle(PendingAction::UseScreen(store.screen().next()));
            }
        }
        Ok(None)
    }

    /// Cancels the calibration or self-test in progress, and the reading that it waits for.
    fn cancel(&mut self) {
        if self.modal.waits_for_reading() {
            self.rig.measurement.borrow_mut().drop_reading();
            self.rig.steered();
        }
        *self.modal = ModalState::Nothing;
    }

    fn when_idle(&self, pending: PendingAction) -> Result<Option<PendingAction>, RefusalReason> {
        if self.rig.measurement.borrow().is_idle() {
            Ok(Some(pending))
        } else {
            Err(RefusalReason::WrongPhase)
        }
    }

    /// Starts a campaign, for which the store lacks `shortage`.
    pub(super) fn start(
        &mut self,
        object: Object,
        shortage: Option<Shortage>,
    ) -> Result<(), RefusalReason> {
        let start = Start { object, ..Start::DEFAULT };
        let started = self.rig.start(start, false, shortage.is_none());
        if let (Err(StartError::NoRoom), Some(shortage)) = (started, shortage) {
            return Err(RefusalReason::TooLittleRoom(shortage.results_to_delete()));
        }
        if started == Err(StartError::LayoutRefused) {
            let measurement = self.rig.measurement.borrow();
            let check = |layout| measurement.check(layout);
            *self.modal =
                ModalState::Refusal(measurement.layout().map_or_else(Diagnostics::new, check));
        }
        Ok(started?)
    }
}

/// Opens this result.
fn open(stored: Option<ResultHandle>) -> Result<Option<PendingAction>, RefusalReason> {
    Ok(Some(PendingAction::Open(stored.ok_or(RefusalReason::NotFound)?)))
}

/// The stored layouts.
fn layouts<F: NorFlash>(store: &Store<F>) -> Vec<LayoutLine, LAYOUTS> {
    let line = |stored: &LayoutHandle| LayoutLine {
        hash: stored.hash,
        title: crate::rig::cut(&stored.title),
        in_use: stored.in_use,
        profile: stored.profile,
    };
    store.layouts().iter().map(line).collect()
}
