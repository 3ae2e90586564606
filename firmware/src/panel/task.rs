//! The panel's loop: redraws the screen after changes, turns presses into actions, plays cues.
//!
//! Measuring never waits for the panel. The panel waits for the store if an action needs the flash.

use core::future::pending;

use embassy_futures::select::{Either3, select3};
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_time::{Instant, Timer};
use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::MAX_LAYOUT;

use super::controller::{PanelController, PendingAction};
use super::layout_under::LayoutUnder;
use super::menu::{Menu, Screen};
use super::modal::ModalState;
use super::pace::TimeEstimator;
use super::refused::RefusalReason;
use super::self_test::SelfTestState;
use super::summary::{self, PIECE};
use super::{Panel, PanelModel};
use crate::info::BoardInfo;
use crate::pulse::Part;
use crate::rig::Rig;
use crate::store::Store;

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
    panel.use_screen(store.lock().await.screen());
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
                PendingAction::Open(_) => run_pending(pending, &mut controller, piece).await,
                PendingAction::Delete(_) => {
                    rig.deleting(async || run_pending(pending, &mut controller, piece).await).await
                }
                _ => {
                    rig.changing(async || run_pending(pending, &mut controller, piece).await).await
                }
            };
            if let (PendingAction::UseScreen(setting), Ok(())) = (pending, &done) {
                panel.use_screen(setting);
            }
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

/// Does what the panel has left to be done with the flash.
async fn run_pending<F: NorFlash>(
    pending: PendingAction,
    controller: &mut PanelController<'_, '_, F>,
    piece: &mut [u8; PIECE],
) -> Result<(), RefusalReason> {
    let mut store = controller.store.lock().await;
    match pending {
        PendingAction::Open(stored) => {
            let opened = summary::open(&mut store, &stored, piece).await?;
            *controller.modal = ModalState::Result(opened);
            controller.menu.open(Screen::Result);
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
            let layout = store.layout(&mut room).await.ok_or(RefusalReason::NotFound)?;
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
        PendingAction::UseScreen(setting) => store.put_screen(setting).await?,
    }
    Ok(())
}
