//! The panel's loop: shows what changes, turns presses into actions, plays cues.
//!
//! Measuring never waits for it. It waits for the store where an action needs the flash.

use core::cell::RefCell;
use massline_shared::signal::StaticReading;

use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::Instant;
use embedded_storage_async::nor_flash::NorFlash;
use heapless::Vec;
use massline_protocol::message::{CampaignCommand, CommandRequest, Reason, ResultEntry, Stats};
use massline_shared::calibration::CalibrationRecord;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::RigLayout;
use massline_shared::signal::Record;

use super::draw::{LayoutLine, View, canvas, draw};
use super::held::Held;
use super::menu::{Action, Menu, Screen};
use super::pace::Pace;
use super::summary::{self, PIECE};
use super::trial::{self, Problem, Readings};
use super::{Button, Cue, PanelModel, cues};
use crate::board::Panel;
use crate::deadline::Deadline;
use crate::rig::{Reading, Rig};
use crate::store::{Kept, KeptLayout, LAYOUTS, RESULTS, Store};

/// What the panel keeps.
pub(crate) struct PanelMemory {
    held: Held,
    /// A piece of a result that is read, or an encoded calibration.
    piece: [u8; PIECE],
}

impl PanelMemory {
    /// All zero bytes.
    pub const fn new() -> Self {
        Self { held: Held::Nothing, piece: [0; PIECE] }
    }
}

/// The loop and what it works on.
pub(crate) struct PanelTask<'a, F: NorFlash> {
    pub rig: &'a Rig,
    pub store: &'a Mutex<NoopRawMutex, Store<F>>,
    pub record: &'a RefCell<Record>,
    pub memory: &'a mut PanelMemory,
}

/// Shows and listens for ever.
pub(crate) async fn run<F: NorFlash>(mut panel: impl Panel, task: PanelTask<'_, F>) -> ! {
    let PanelTask { rig, store, record, memory: PanelMemory { held, piece } } = task;
    let (menu, pace, before) = (Menu::new(), Pace::new(Instant::now()), PanelModel::START);
    let mut desk = Desk { rig, store, record, menu, held, pace, before };
    loop {
        for cue in desk.follow() {
            panel.cue(cue);
        }
        panel.tell(&desk.before);
        desk.draw(&*store.lock().await, panel.screen());
        panel.flush().await;
        if let Either::Second(button) = select(rig.show.wait(), panel.button()).await
            && let Some(errand) = desk.press(button)
        {
            let done = match errand {
                Errand::Start(block) => {
                    let full = store.lock().await.is_full(rig.dofs()).await;
                    desk.command(CampaignCommand::Start, block, full)
                }
                other => rig.changing(async || run_errand(other, &mut desk, piece).await).await,
            };
            desk.answer(done);
        }
    }
}

/// What needs the flash.
#[derive(Clone, Copy)]
enum Errand {
    /// A campaign, with the mass of the block when it is one.
    Start(Option<f32>),
    Open(Kept),
    Delete(u32),
    UseLayout(u32),
    SolveBlock,
    KeepCalibration,
}

async fn run_errand<F: NorFlash>(
    errand: Errand,
    desk: &mut Desk<'_, F>,
    piece: &mut [u8; PIECE],
) -> Result<(), Reason> {
    let mut store = desk.store.lock().await;
    match errand {
        Errand::Open(kept) => {
            *desk.held = Held::Result(summary::open(&mut store, &kept, piece).await?);
            desk.menu.open(Screen::Result);
        }
        Errand::Delete(number) => {
            store.delete_result(number).await?;
            *desk.held = Held::Nothing;
        }
        // Not here: nothing is changed in the flash.
        Errand::Start(_) => {}
        Errand::UseLayout(hash) => {
            store.use_layout(hash).await?;
            let layout = store.layout().await.ok_or(Reason::NotFound)?;
            desk.use_layout(layout);
        }
        Errand::SolveBlock => {
            let kept = store.calibration().await;
            desk.solve_block(kept.unwrap_or_default());
        }
        Errand::KeepCalibration => {
            store.put_calibration(desk.encode_calibration(piece)?).await?;
            desk.calibrated();
        }
    }
    Ok(())
}

/// All of the loop that does not wait. Plain functions: what an async function computes is compiled with
/// the board.
struct Desk<'a, F: NorFlash> {
    rig: &'a Rig,
    store: &'a Mutex<NoopRawMutex, Store<F>>,
    record: &'a RefCell<Record>,
    menu: Menu,
    held: &'a mut Held,
    pace: Pace,
    /// What was shown last.
    before: PanelModel,
}

impl<F: NorFlash> Desk<'_, F> {
    /// Takes note of what has changed; gives what is to be heard of it.
    #[inline(never)]
    fn follow(&mut self) -> Vec<Cue, 3> {
        self.take_reading();
        let mut model = self.model();
        self.menu.follow(&model);
        if !self.held.belongs_to(self.menu.screen()) {
            *self.held = Held::Nothing;
            model = self.model();
            self.menu.follow(&model);
        }
        self.pace.follow(&model, Instant::now());
        model.seconds_left = self.pace.seconds_left(&model);
        let heard = cues(&self.before, &model);
        self.before = model;
        heard
    }

    /// What can be shown now. While the flash is at work its lists are those of before.
    fn model(&self) -> PanelModel {
        let mut model = self.rig.panel();
        let lists = |store: &Store<F>| (store.results().len() as u8, store.layouts().len() as u8);
        let before = (self.before.results, self.before.layouts);
        (model.results, model.layouts) =
            self.store.try_lock().map_or(before, |store| lists(&store));
        if let Held::Refusal(findings) = &*self.held {
            model.findings = findings.len() as u8;
        }
        model.pages = self.held.summary().map_or(0, summary::Summary::pages);
        model.trial = self.held.trial();
        model
    }

    /// Draws what there is to see.
    #[inline(never)]
    fn draw(&self, store: &Store<F>, screen: &mut impl canvas::Screen) {
        let rig = self.rig;
        let _deadline = Deadline::begin(rig);
        let newest_first = store.results().iter().rev().map(|kept| kept.entry);
        let results: Vec<ResultEntry, RESULTS> = newest_first.take(RESULTS).collect();
        let (layout, campaign) = (rig.layout.borrow(), rig.diagnostics.borrow());
        let findings = match &*self.held {
            Held::Refusal(findings) => findings,
            _ => &*campaign,
        };
        let view = View {
            menu: &self.menu,
            model: &self.before,
            layout: layout.as_ref(),
            layouts: &layouts(store),
            results: &results,
            summary: self.held.summary(),
            findings,
            info: &rig.info,
            stats: &Stats { store_failures: store.failures(), ..rig.stats() },
        };
        draw(&view, screen);
    }

    /// Does what a button means, as far as that needs no flash; gives the rest.
    #[inline(never)]
    fn press(&mut self, button: Button) -> Option<Errand> {
        let action = self.menu.press(button, &self.before)?;
        match self.act(action) {
            Ok(errand) => errand,
            Err(reason) => {
                self.menu.refuse(reason);
                None
            }
        }
    }

    /// What has come of an errand.
    fn answer(&mut self, done: Result<(), Reason>) {
        if let Err(reason) = done {
            self.menu.refuse(reason);
        }
    }

    fn act(&mut self, action: Action) -> Result<Option<Errand>, Reason> {
        match action {
            Action::Command(CampaignCommand::Start) => return Ok(Some(Errand::Start(None))),
            Action::Command(command) => self.command(command, None, false)?,
            Action::StartBlock { decigrams } => {
                return Ok(Some(Errand::Start(Some(decigrams as f32 * 1e-4))));
            }
            Action::StartTumble => {
                *self.held = Held::Tumble(Readings::new(), false);
                self.menu.open(Screen::Trial);
            }
            Action::ReadPosition => self.read_position()?,
            Action::DropTrial => self.drop_trial(),
            Action::OpenResult(place) => {
                let store = self.store.try_lock().map_err(|_| Reason::Busy)?;
                let kept = store.results().iter().rev().nth(usize::from(place));
                return Ok(Some(Errand::Open(*kept.ok_or(Reason::NotFound)?)));
            }
            Action::OpenLast => {
                let store = self.store.try_lock().map_err(|_| Reason::Busy)?;
                let kept = store.find(self.before.result).ok_or(Reason::NotFound)?;
                return Ok(Some(Errand::Open(kept)));
            }
            Action::DeleteResult => {
                let summary = self.held.summary().ok_or(Reason::NotFound)?;
                let rests = self.rig.rests().then_some(Errand::Delete(summary.number));
                return rests.ok_or(Reason::WrongPhase).map(Some);
            }
            Action::UseLayout(place) => {
                let store = self.store.try_lock().map_err(|_| Reason::Busy)?;
                let kept = store.layouts().get(usize::from(place)).ok_or(Reason::NotFound)?;
                return match kept.in_use {
                    true => Ok(None),
                    false => self.when_idle(Errand::UseLayout(kept.hash)),
                };
            }
            Action::SolveBlock => return self.when_idle(Errand::SolveBlock),
            Action::KeepCalibration => return self.when_idle(Errand::KeepCalibration),
        }
        Ok(None)
    }

    fn when_idle(&self, errand: Errand) -> Result<Option<Errand>, Reason> {
        if self.rig.is_idle() { Ok(Some(errand)) } else { Err(Reason::WrongPhase) }
    }

    /// Steers the campaign; with the mass of a block it starts one that calibrates. `full` when the
    /// store has no room for a campaign.
    fn command(
        &mut self,
        command: CampaignCommand,
        block: Option<f32>,
        full: bool,
    ) -> Result<(), Reason> {
        let request = CommandRequest {
            command: command as u8,
            confirm: false,
            force: false,
            block: block.is_some(),
        };
        let done = self.rig.command(request, full);
        match done {
            Ok(()) if command == CampaignCommand::Start => self.rig.block_mass.set(block),
            Err(Reason::LayoutRefused) => {
                let layout = self.rig.layout.borrow();
                let check = |layout| self.rig.check(layout);
                *self.held = Held::Refusal(layout.as_ref().map_or_else(Diagnostics::new, check));
            }
            _ => {}
        }
        done
    }

    fn use_layout(&self, layout: RigLayout) {
        self.rig.set_layout(layout);
        self.rig.changed();
    }

    fn read_position(&mut self) -> Result<(), Reason> {
        if !self.rig.is_idle() {
            return Err(Reason::WrongPhase);
        }
        match self.held {
            Held::Tumble(_, reading) => *reading = true,
            Held::Retry(readings, _) => *self.held = Held::Tumble(readings.clone(), true),
            _ => return Err(Reason::NotFound),
        }
        self.rig.reading.set(Reading::Wanted);
        self.rig.steer.signal(());
        Ok(())
    }

    /// Forgets the calibration on its way, and the reading that it waits for.
    fn drop_trial(&mut self) {
        if matches!(self.held, Held::Tumble(_, true)) && self.rig.reading.get() == Reading::Wanted {
            self.rig.reading.set(Reading::None);
            self.rig.steer.signal(());
        }
        *self.held = Held::Nothing;
    }

    /// Takes a reading that has come into the tumble test; after the last one it is solved.
    #[inline(never)]
    fn take_reading(&mut self) {
        let Held::Tumble(readings, true) = &mut *self.held else { return };
        let refused = |reason| Err(Problem::Refused(reason));
        let sensors = sensors(self.rig);
        let taken = match self.rig.reading.get() {
            Reading::Wanted => return,
            Reading::None => refused(Reason::Busy),
            Reading::Failed => refused(Reason::SamplerStopped),
            Reading::Held => match self.record.try_borrow() {
                Ok(record) => readings.add(&StaticReading::of(&record), sensors, &self.rig.adc),
                Err(_) => refused(Reason::Busy),
            },
        };
        *self.held = match taken {
            Ok(false) => Held::Tumble(readings.clone(), false),
            Err(problem) => Held::Retry(readings.clone(), problem),
            Ok(true) => {
                let mut record = CalibrationRecord::from(*self.rig.calibration.borrow());
                match readings.solve(sensors, &self.rig.adc, &mut record) {
                    Ok(proposal) => Held::Proposal(record, proposal),
                    Err(problem) => Held::Failed(problem),
                }
            }
        };
    }

    /// What the block test says of the hammer, against the calibration `kept`.
    #[inline(never)]
    fn solve_block(&mut self, kept: CalibrationRecord) {
        let calibration = *self.rig.calibration.borrow();
        let mut record = CalibrationRecord { calibration, ..kept };
        let proposal = match self.rig.block_ratio.get() {
            Some(Ok(ratio)) => trial::of_block(&ratio, &mut record),
            Some(Err(error)) => Err(Problem::Block(error)),
            None => Err(Problem::NoMass),
        };
        *self.held = match proposal {
            Ok(proposal) => Held::Proposal(record, proposal),
            Err(problem) => Held::Failed(problem),
        };
        self.menu.open(Screen::Trial);
    }

    /// The bytes of the calibration that is proposed.
    fn encode_calibration<'p>(&self, piece: &'p mut [u8; PIECE]) -> Result<&'p [u8], Reason> {
        let Held::Proposal(record, _) = &*self.held else { return Err(Reason::NotFound) };
        let encoded = postcard::to_slice(record, piece);
        encoded.map(|bytes| &*bytes).map_err(|_| Reason::StoreFailed)
    }

    /// The calibration that was proposed is kept.
    fn calibrated(&mut self) {
        let Held::Proposal(record, _) = &*self.held else { return };
        *self.rig.calibration.borrow_mut() = record.calibration;
        // The block has told what it knew: its ratio is about the calibration of before.
        self.rig.block_ratio.set(None);
        *self.held = Held::Kept;
    }
}

/// The layouts that are kept.
fn layouts<F: NorFlash>(store: &Store<F>) -> Vec<LayoutLine, LAYOUTS> {
    let line = |kept: &KeptLayout| LayoutLine {
        hash: kept.hash,
        title: crate::rig::cut(&kept.title),
        in_use: kept.in_use,
    };
    store.layouts().iter().map(line).collect()
}

/// Sensors that are calibrated: those of the layout, else all that there are inputs for.
fn sensors(rig: &Rig) -> usize {
    let all = rig.adc.responses() / 3;
    rig.layout.borrow().as_ref().map_or(all, |layout| layout.sensors.len().min(all))
}
