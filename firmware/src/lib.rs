//! The rig's application: wires measuring, analysing, storing, talking and showing together over the
//! four seams of [`board`]. Nothing here knows a chip.
//!
//! ```text
//!            Sampler ─▶ measure ─▶ analysis ─▶ store ◀─▶ session ◀─▶ Link
//!                          ▲          │                     │
//!                          └───────── rig (shared state) ───┴───▶ panel ◀─▶ Panel
//! ```
//!
//! [`run`] is one future for any executor. All large memory is in [`Memory`], which a board places
//! in a static.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod analysis;
mod apart;
mod block;
pub mod board;
mod consistency;
mod deadline;
mod identification;
mod levels;
mod measure;
mod objects;
pub mod panel;
mod progress;
mod rig;
pub mod scan_ring;
mod session;
pub mod store;

use core::cell::RefCell;
use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::join::join3;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use massline_shared::averaging::DofSpectra;
use massline_shared::signal::Record;

use crate::analysis::AnalysisMemory;
use crate::apart::apart;
use crate::board::{Board, Link, Panel, Sampler};
use crate::measure::Measuring;
use crate::objects::Objects;
use crate::panel::task::{PanelMemory, PanelTask};
use crate::progress::Kept;
use crate::rig::Rig;
use crate::session::{Session, SessionMemory};
use crate::store::Store;

/// All large memory of the application, about 75 KiB. Its initial value is all zeros, so that it
/// lies in `.bss`.
pub struct Memory {
    record: RefCell<Record>,
    spectra: RefCell<DofSpectra<f32>>,
    analysis: AnalysisMemory,
    session: SessionMemory,
    panel: PanelMemory,
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

impl Memory {
    /// Empty memory.
    pub const fn new() -> Self {
        Self {
            record: RefCell::new(Record::new()),
            spectra: RefCell::new(DofSpectra::<f32>::new()),
            analysis: AnalysisMemory::new(),
            session: SessionMemory::new(),
            panel: PanelMemory::new(),
        }
    }
}

/// Runs the rig on a board, for ever.
pub async fn run<S, L, F, P>(board: Board<S, L, F, P>, memory: &mut Memory) -> Infallible
where
    S: Sampler,
    L: Link,
    F: NorFlash,
    P: Panel,
{
    let Board { info, sampler, link, flash, panel } = board;
    let Memory { record, spectra, analysis, session: session_memory, panel: panel_memory } = memory;
    let rig = Rig::new(info, sampler.adc(), L::STREAMS);
    let store = store_over(flash);
    let kept = apart(pin!(recall(&rig, &store, analysis))).await;
    let (rx, tx) = link.split();
    let objects = Objects { rig: &rig, store: &store, record, spectra };
    let session = Session { rig: &rig, store: &store, record, objects };
    let measuring = Measuring {
        sampler,
        rig: &rig,
        store: &store,
        record,
        spectra,
        memory: analysis,
        kept,
        losses: 0,
    };
    let task = PanelTask { rig: &rig, store: &store, record, memory: panel_memory };
    join3(
        apart(pin!(measuring.run())),
        apart(pin!(session.run(rx, tx, session_memory))),
        apart(pin!(panel::task::run(panel, task))),
    )
    .await
    .0
}

/// A function of its own: its stack is not needed afterwards.
#[inline(never)]
fn store_over<F: NorFlash>(flash: F) -> Mutex<NoopRawMutex, Store<F>> {
    Mutex::new(Store::new(flash))
}

/// Takes up what the store has kept over a restart.
async fn recall<F: NorFlash>(
    rig: &Rig,
    store: &Mutex<NoopRawMutex, Store<F>>,
    memory: &mut AnalysisMemory,
) -> Kept {
    let mut store = store.lock().await;
    store.open().await;
    if let Some(layout) = store.layout().await {
        rig.set_layout(layout);
    }
    if let Some(calibration) = store.calibration().await.filter(|kept| kept.is_usable()) {
        *rig.calibration.borrow_mut() = calibration.calibration;
    }
    rig.last_mass.set(store.results().last().and_then(|kept| kept.entry.mass));
    Kept::recall(rig, &mut store, memory).await
}
