//! The rig's application: it connects measuring, storage, the host session and the panel over the four
//! seams of [`board`]. What is measured and computed is in [`massline_shared::measurement`]. Nothing here
//! depends on a chip.
//!
//! ```text
//!        Sampler ─▶ measure ─▶ Measurement ─▶ outcome ─▶ store ◀─▶ session ◀─▶ Link
//!                                   │                                │
//!                                  rig (shared) ─────────────────────┴───▶ panel ◀─▶ Panel
//! ```
//!
//! [`run`] is one future for any executor. All large memory is in [`Memory`], which a board places
//! in a static.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod board;
mod checkpoint;
mod deadline;
mod encoded;
pub mod info;
mod levels;
mod measure;
mod outcome;
mod own_frame;
pub mod panel;
mod pulse;
mod rig;
mod safe_mode;
pub mod scan_ring;
mod screen_setting;
mod session;
pub mod store;

use core::convert::Infallible;
use core::pin::pin;

use embassy_futures::join::join4;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::{BootReason, MAX_LAYOUT};
use massline_shared::measurement;

use crate::board::{Board, Link, Panel, Sampler};
use crate::checkpoint::{Checkpoint, CheckpointBuffer};
use crate::measure::MeasuringLoop;
use crate::own_frame::poll_in_own_frame;
use crate::panel::task::{PanelMemory, PanelTask};
use crate::rig::Rig;
use crate::session::{Session, SessionMemory};
use crate::store::{MAX_DOF, Store};

/// All large memory of the application, about 80 KiB. It starts as all zeros, so that it lies in `.bss`.
pub struct Memory {
    measurement: measurement::Memory<f32>,
    room: CheckpointBuffer,
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
            measurement: measurement::Memory::<f32>::new(),
            room: [0; MAX_DOF],
            session: SessionMemory::new(),
            panel: PanelMemory::new(),
        }
    }
}

/// Runs the rig on a board; never returns. A rig that starts for the reason [`BootReason::SafeMode`] runs in safe mode.
pub async fn run<S, L, F, P>(board: Board<S, L, F, P>, memory: &mut Memory) -> Infallible
where
    S: Sampler,
    L: Link,
    F: NorFlash,
    P: Panel,
{
    if board.info.boot_reason == BootReason::SafeMode {
        return poll_in_own_frame(pin!(safe_mode::run(board, &mut memory.session))).await;
    }
    let Board { info, sampler, link, flash, panel, feed_watchdog } = board;
    let Memory { measurement, room, session: session_memory, panel: panel_memory } = memory;
    let rig = Rig::new(info, sampler.adc(), L::STREAMS, measurement);
    let store = Mutex::<NoopRawMutex, _>::new(Store::new(flash, board.info.supply.is_low));
    let checkpoint = poll_in_own_frame(pin!(recall(&rig, &store, room))).await;
    let (rx, tx) = link.split();
    let session = Session { rig: &rig, store: &store };
    let measuring = MeasuringLoop { sampler, rig: &rig, store: &store, checkpoint, room };
    let task = PanelTask { rig: &rig, store: &store, memory: panel_memory };
    let panel = panel::task::run(panel, task);
    join4(
        poll_in_own_frame(pin!(measuring.run())),
        poll_in_own_frame(pin!(session.run(rx, tx, session_memory))),
        poll_in_own_frame(pin!(panel)),
        rig.pulse.watch(feed_watchdog),
    )
    .await
    .0
}

/// Restores the layout, the calibration, the last mass and an interrupted campaign from the store.
async fn recall<F: NorFlash>(
    rig: &Rig<'_>,
    store: &Mutex<NoopRawMutex, Store<F>>,
    room: &mut CheckpointBuffer,
) -> Checkpoint {
    let mut store = store.lock().await;
    store.open().await;
    if let Some(layout) = store.layout(&mut [0; MAX_LAYOUT]).await {
        // The bytes were checked before they were stored. If they are refused, the rig asks for a layout.
        let _ = rig.use_layout(layout);
    }
    if let Some(calibration) = store.calibration().await.filter(|stored| stored.is_usable()) {
        let gains = calibration.budget();
        rig.measurement.borrow_mut().set_calibration(calibration.calibration, gains);
    }
    rig.last_mass.set(store.results().last().and_then(|stored| stored.entry.mass));
    Checkpoint::recall(rig, &mut store, room).await
}
