//! The panel's loop: redraws the screen after changes, turns presses into actions, plays cues.
//!
//! Measuring never waits for the panel. The panel waits for the store if an action needs the flash.

use massline_shared::signal::{AdcProperties, RestStatistics, ringing_s};

use core::future::pending;

use embassy_futures::select::{Either3, select3};
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Duration, Instant, Timer};
use embedded_storage_async::nor_flash::NorFlash;
use heapless::{String, Vec};
use massline_protocol::MAX_LAYOUT;
use massline_protocol::message::{ResultEntry, Stats};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::TumbleTest;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::{RigLayout, TestProfile};
use massline_shared::measurement::campaign::{Object, Start};
use massline_shared::measurement::{Measurement, Recorded, StartError};

use super::calibration_wizard::{self, WizardProblem};
use super::draw::{LayoutLine, View, canvas, draw};
use super::menu::{Action, Menu, Screen};
use super::modal::ModalState;
use super::pace::TimeEstimator;
use super::refused::Refused;
use super::self_test::{SelfTestRun, SelfTestState};
use super::summary::{self, PIECE, Page};
use super::{Button, Cue, Panel, PanelModel, cues};
use crate::deadline::Deadline;
use crate::encoded::{self, Bytes};
use crate::info::BoardInfo;
use crate::pulse::Part;
use crate::rig::Rig;
use crate::store::{LAYOUTS, LayoutHandle, RESULTS, ResultHandle, Shortage, Source, Store};

/// Memory of the panel.
pub(crate) struct PanelMemory {
    modal: ModalState,
    /// Buffer for a piece of a result, or for an encoded calibration.
    piece: [u8; PIECE],
}

impl PanelMemory {
    /// Memory of all zero bytes.
    pub const fn new() -> Self {
        Self { modal: ModalState::Nothing, piece: [0; PIECE] }
    }
}

/// The loop and what it works on.
pub(crate) struct PanelTask<'a, 'm, F: NorFlash> {
    pub rig: &'a Rig<'m>,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub memory: &'a mut PanelMemory,
}

/// Runs the panel; never returns.
pub(crate) async fn run<F: NorFlash>(mut panel: impl Panel, task: PanelTask<'_, '_, F>) -> ! {
    let PanelTask { rig, store, memory: PanelMemory { modal, piece } } = task;
    let (menu, pace, before) = (Menu::new(), TimeEstimator::new(Instant::now()), PanelModel::START);
    let mut controller = PanelController { rig, store, menu, modal, pace, before };
    rig.pulse.works(Part::Panel);
    loop {
        for cue in controller.follow() {
            panel.cue(cue);
        }
        panel.report(&controller.before);
        controller.draw(&*store.lock().await, panel.screen());
        panel.flush().await;
        if matches!(controller.before.self_test, SelfTestState::Running { .. }) {
            // A panel may take the picture without waiting, and the next step is due at once.
            yield_now().await;
        }
        rig.pulse.waits(Part::Panel);
        let event = select3(rig.show.wait(), panel.button(), charge_changes(&rig.info)).await;
        rig.pulse.works(Part::Panel);
        if let Either3::Second(button) = event
            && let Some(pending) = controller.press(button)
        {
            let done = match pending {
                PendingAction::Start(object) => {
                    let shortage = store.lock().await.shortage(rig.campaign_size()).await;
                    controller.start(object, shortage)
                }
                PendingAction::SelfTest => {
                    let stored = store.lock().await.calibration().await.unwrap_or_default();
                    controller.start_self_test(stored.method.knows_sensors())
                }
                PendingAction::Open(..) | PendingAction::Delete(_) => {
                    run_pending(pending, &mut controller, piece).await
                }
                _ => {
                    rig.changing(async || run_pending(pending, &mut controller, piece).await).await
                }
            };
            controller.answer(done);
        }
    }
}

/// Waits until the charge of a battery may be another one.
async fn charge_changes(info: &BoardInfo) {
    match info.supply.battery {
        Some(_) => Timer::after_secs(10).await,
        None => pending().await,
    }
}

/// An action that needs the flash.
#[derive(Clone, Copy)]
enum PendingAction {
    /// Start a campaign; the store is asked whether it has room.
    Start(Object),
    /// Read a result with what a page of it shows; the flag is true when it was not open before.
    Open(ResultHandle, Page, bool),
    Delete(u32),
    /// Begin a self-test; the store says whether the sensors are known.
    SelfTest,
    UseLayout(u32),
    UseProfile(TestProfile),
    SolveBlock,
    KeepCalibration,
}

async fn run_pending<F: NorFlash>(
    pending: PendingAction,
    controller: &mut PanelController<'_, '_, F>,
    piece: &mut [u8; PIECE],
) -> Result<(), Refused> {
    let mut store = controller.store.lock().await;
    match pending {
        PendingAction::Open(stored, page, is_new) => {
            let opened = summary::open(&mut store, &stored, piece, page).await?;
            *controller.modal = ModalState::Result(opened);
            if is_new {
                controller.menu.open(Screen::Result);
            }
        }
        PendingAction::Delete(number) => {
            store.delete_result(number).await?;
            *controller.modal = ModalState::Nothing;
        }
        // Handled by the caller, because they do not change the flash.
        PendingAction::Start(_) | PendingAction::SelfTest => {}
        PendingAction::UseLayout(hash) => {
            store.use_layout(hash).await?;
            let mut room = [0; MAX_LAYOUT];
            let layout = store.layout(&mut room).await.ok_or(Refused::NotFound)?;
            controller.rig.use_layout(layout)?;
        }
        PendingAction::UseProfile(profile) => {
            let layout = LayoutUnder { rig: controller.rig, profile };
            store.put_named_layout(&layout, &layout.title(), profile).await?;
            layout.put_into_use();
            controller.menu.open(Screen::Measure);
        }
        PendingAction::SolveBlock => {
            let stored = store.calibration().await;
            controller.solve_block(stored.unwrap_or_default());
        }
        PendingAction::KeepCalibration => {
            store.put_calibration(controller.encode_calibration(piece)?).await?;
            controller.calibrated();
        }
    }
    Ok(())
}

/// The parts of the loop that do not wait. They are plain functions, because the code of an async function
/// is compiled with the board.
struct PanelController<'a, 'm, F: NorFlash> {
    rig: &'a Rig<'m>,
    store: &'a Mutex<NoopRawMutex, Store<F>>,
    menu: Menu,
    modal: &'a mut ModalState,
    pace: TimeEstimator,
    /// The model that was shown last.
    before: PanelModel,
}

impl<F: NorFlash> PanelController<'_, '_, F> {
    /// Updates the panel after a change; returns the cues to be played.
    fn follow(&mut self) -> Vec<Cue, 3> {
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
        model.seconds_left = self.pace.seconds_left(&model, Instant::now());
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
    fn draw(&self, store: &Store<F>, screen: &mut impl canvas::Screen) {
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
        };
        draw(&view, screen);
    }

    /// Handles a button; returns the action that needs the flash, if any.
    fn press(&mut self, button: Button) -> Option<PendingAction> {
        let shown = self.page();
        let done = match self.menu.press(button, &self.before) {
            Some(action) => self.act(action),
            None => self.turned(shown),
        };
        match done {
            Ok(pending) => pending,
            Err(reason) => {
                self.menu.refuse(reason);
                None
            }
        }
    }

    /// Handles the outcome of a pending action.
    fn answer(&mut self, done: Result<(), Refused>) {
        if let Err(reason) = done {
            self.menu.refuse(reason);
        }
    }

    fn act(&mut self, action: Action) -> Result<Option<PendingAction>, Refused> {
        match action {
            Action::Start => return Ok(Some(PendingAction::Start(Object::Unknown))),
            Action::Command(command) => self.rig.command(command)?,
            Action::StartBlock { decigrams } => {
                let mass = decigrams as f32 * 1e-4;
                return Ok(Some(PendingAction::Start(Object::Block { mass })));
            }
            Action::StartSelfTest => return self.when_idle(PendingAction::SelfTest),
            Action::StopSelfTest => self.stop_self_test(),
            Action::StartTumble => {
                *self.modal = ModalState::Tumble(TumbleTest::new(), false);
                self.menu.open(Screen::CalibrationWizard);
            }
            Action::ReadPosition => self.read_position()?,
            Action::CancelCalibration => self.cancel_calibration(),
            Action::OpenResult(place) => {
                let store = self.store.try_lock().map_err(|_| Refused::Busy)?;
                let stored = store.results().iter().rev().nth(usize::from(place));
                return open(stored.copied());
            }
            Action::OpenLast => {
                let store = self.store.try_lock().map_err(|_| Refused::Busy)?;
                return open(store.find(self.before.result));
            }
            Action::DeleteResult => {
                let summary = self.modal.summary().ok_or(Refused::NotFound)?;
                let rests = self
                    .rig
                    .measurement
                    .borrow()
                    .rests()
                    .then_some(PendingAction::Delete(summary.number));
                return rests.ok_or(Refused::WrongPhase).map(Some);
            }
            Action::UseProfile(profile) => {
                if profile == self.before.profile {
                    self.menu.open(Screen::Measure);
                    return Ok(None);
                }
                return self.when_idle(PendingAction::UseProfile(profile));
            }
            Action::UseLayout(place) => {
                let store = self.store.try_lock().map_err(|_| Refused::Busy)?;
                let stored = store.layouts().get(usize::from(place)).ok_or(Refused::NotFound)?;
                return match stored.in_use {
                    true => Ok(None),
                    false => self.when_idle(PendingAction::UseLayout(stored.hash)),
                };
            }
            Action::SolveBlock => return self.when_idle(PendingAction::SolveBlock),
            Action::KeepCalibration => return self.when_idle(PendingAction::KeepCalibration),
        }
        Ok(None)
    }

    fn when_idle(&self, pending: PendingAction) -> Result<Option<PendingAction>, Refused> {
        if self.rig.measurement.borrow().is_idle() {
            Ok(Some(pending))
        } else {
            Err(Refused::WrongPhase)
        }
    }

    /// After a press that may have turned from this page: what the new one shows has to be read.
    fn turned(&self, from: Option<(u32, Page)>) -> Result<Option<PendingAction>, Refused> {
        let Some((number, page)) = self.page().filter(|page| Some(*page) != from) else {
            return Ok(None);
        };
        let store = self.store.try_lock().map_err(|_| Refused::Busy)?;
        let stored = store.find(number).ok_or(Refused::NotFound)?;
        Ok(page.has_detail().then_some(PendingAction::Open(stored, page, false)))
    }

    /// Number of the open result, and its page on the screen.
    fn page(&self) -> Option<(u32, Page)> {
        let summary = self.modal.summary().filter(|_| self.menu.screen() == Screen::Result)?;
        Some((summary.number, summary.page(self.menu.cursor())))
    }

    /// Starts a campaign, for which the store lacks `shortage`.
    fn start(&mut self, object: Object, shortage: Option<Shortage>) -> Result<(), Refused> {
        let start = Start { object, ..Start::DEFAULT };
        let started = self.rig.start(start, false, shortage.is_none());
        if let (Err(StartError::NoRoom), Some(shortage)) = (started, shortage) {
            return Err(Refused::TooLittleRoom(shortage.results_to_delete()));
        }
        if started == Err(StartError::LayoutRefused) {
            let measurement = self.rig.measurement.borrow();
            let check = |layout| measurement.check(layout);
            *self.modal =
                ModalState::Refusal(measurement.layout().map_or_else(Diagnostics::new, check));
        }
        Ok(started?)
    }

    fn read_position(&mut self) -> Result<(), Refused> {
        if !self.rig.measurement.borrow().is_idle() {
            return Err(Refused::WrongPhase);
        }
        let readings = match &*self.modal {
            ModalState::Tumble(readings, _) | ModalState::Retry(readings, _) => readings.clone(),
            _ => return Err(Refused::NotFound),
        };
        // If the request is refused, the record still holds an older reading, not one of this position.
        self.rig.take_reading()?;
        *self.modal = ModalState::Tumble(readings, true);
        Ok(())
    }

    fn start_self_test(&mut self, knows_sensors: bool) -> Result<(), Refused> {
        self.rig.take_reading()?;
        *self.modal = ModalState::SelfTest(SelfTestRun::Reading, knows_sensors);
        self.menu.open(Screen::SelfTest);
        Ok(())
    }

    /// Goes on with the self-test by one channel, and asks for the next turn: link and watchdog get on in between. Deadline:
    /// [`crate::deadline::DEADLINE`].
    fn step_self_test(&mut self) {
        let ModalState::SelfTest(run, knows_sensors) = &mut *self.modal else { return };
        let _deadline = Deadline::begin(&self.rig.stats);
        let mut measurement = self.rig.measurement.borrow_mut();
        if run.step(&mut measurement, &self.rig.info, *knows_sensors) {
            self.rig.show.signal(());
        }
    }

    /// Stops the self-test and the reading that it waits for.
    fn stop_self_test(&mut self) {
        if matches!(self.modal, ModalState::SelfTest(SelfTestRun::Reading, _)) {
            self.rig.measurement.borrow_mut().drop_reading();
            self.rig.steered();
        }
        *self.modal = ModalState::Nothing;
    }

    /// Cancels the calibration in progress and the reading that it waits for.
    fn cancel_calibration(&mut self) {
        if matches!(self.modal, ModalState::Tumble(_, true)) {
            self.rig.measurement.borrow_mut().drop_reading();
            self.rig.steered();
        }
        *self.modal = ModalState::Nothing;
    }

    /// Adds a finished reading to the tumble test, and solves the test after the last one.
    fn take_reading(&mut self) {
        let ModalState::Tumble(readings, true) = &mut *self.modal else { return };
        let measurement = self.rig.measurement.borrow();
        let adc = calibrated(&measurement);
        let taken = match measurement.recorded() {
            _ if measurement.reads() => return,
            Recorded::Reading => calibration_wizard::add_reading(
                readings,
                &RestStatistics::of(measurement.record()),
                &adc,
            ),
            Recorded::ReadingFailed => Err(WizardProblem::Refused(Refused::SamplerStopped)),
            Recorded::Nothing | Recorded::Hit(_) | Recorded::HitBefore(_) => {
                Err(WizardProblem::Refused(Refused::Busy))
            }
        };
        *self.modal = match taken {
            Ok(false) => ModalState::Tumble(readings.clone(), false),
            Err(problem) => ModalState::Retry(readings.clone(), problem),
            Ok(true) => {
                let mut record = CalibrationRecord::from(*measurement.calibration());
                match calibration_wizard::of_tumble(readings, &mut record) {
                    Ok(proposal) => ModalState::Proposal(record, proposal),
                    Err(problem) => ModalState::Failed(problem),
                }
            }
        };
    }

    /// Computes the hammer's gain from the block test, relative to the calibration `stored`.
    fn solve_block(&mut self, stored: CalibrationRecord) {
        let measurement = self.rig.measurement.borrow();
        let mut record = CalibrationRecord { calibration: *measurement.calibration(), ..stored };
        let proposal = match measurement.result().block {
            Some(Ok(ratio)) => calibration_wizard::of_block(&ratio, &mut record),
            Some(Err(error)) => Err(WizardProblem::Block(error)),
            None => Err(WizardProblem::NoMass),
        };
        *self.modal = match proposal {
            Ok(proposal) => ModalState::Proposal(record, proposal),
            Err(problem) => ModalState::Failed(problem),
        };
        self.menu.open(Screen::CalibrationWizard);
    }

    /// Encodes the proposed calibration.
    fn encode_calibration<'p>(&self, piece: &'p mut [u8; PIECE]) -> Result<&'p [u8], Refused> {
        let ModalState::Proposal(record, _) = &*self.modal else { return Err(Refused::NotFound) };
        let encoded = postcard::to_slice(record, piece);
        encoded.map(|bytes| &*bytes).map_err(|_| Refused::StoreFailed)
    }

    /// Puts the proposed calibration, which has been stored, into force.
    fn calibrated(&mut self) {
        let ModalState::Proposal(record, _) = &*self.modal else { return };
        self.rig.measurement.borrow_mut().set_calibration(record.calibration, record.budget());
        *self.modal = ModalState::CalibrationStored;
    }
}

/// The layout in use with the settings of another profile, as the bytes that are stored: it takes no memory while the
/// flash is written.
struct LayoutUnder<'a, 'm> {
    rig: &'a Rig<'m>,
    profile: TestProfile,
}

impl LayoutUnder<'_, '_> {
    /// The layout; an empty one when there is none, which no campaign accepts.
    fn layout(&self) -> RigLayout {
        let mut layout = self.rig.measurement.borrow().stated_layout().unwrap_or_default();
        layout.test = layout.test.under(self.profile);
        layout
    }

    // Not inlined: the layout is built on its stack.
    #[inline(never)]
    fn put(&self, bytes: &mut Bytes<'_>) {
        bytes.put(&self.layout());
    }

    fn title(&self) -> String<48> {
        let measurement = self.rig.measurement.borrow();
        measurement.layout().map_or_else(String::new, |layout| layout.title.clone())
    }

    /// Puts it into use.
    fn put_into_use(&self) {
        let (layout, hash) = (self.layout(), self.checksum());
        self.rig.use_decoded(layout, hash);
    }
}

impl Source for LayoutUnder<'_, '_> {
    fn length(&self) -> usize {
        encoded::measured(&|bytes| self.put(bytes)).0
    }

    fn checksum(&self) -> u32 {
        encoded::measured(&|bytes| self.put(bytes)).1
    }

    fn read(&self, offset: usize, out: &mut [u8]) {
        encoded::read(&|bytes| self.put(bytes), offset, out);
    }
}

/// Opens this result at its first page.
fn open(stored: Option<ResultHandle>) -> Result<Option<PendingAction>, Refused> {
    Ok(Some(PendingAction::Open(stored.ok_or(Refused::NotFound)?, Page::Mass, true)))
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

/// Properties of the converter, with the channels of the sensors to be calibrated: those of the layout, or
/// without one, all that have inputs.
fn calibrated(measurement: &Measurement<'_, f32>) -> AdcProperties {
    match measurement.layout() {
        Some(_) => measurement.adc_in_use(),
        None => *measurement.adc(),
    }
}
