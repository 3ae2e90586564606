//! Safe mode, for a rig whose last starts have all ended in a failure: only the link and the panel run. They say
//! what the failure was and erase the store, whose content may be the cause; it is not read before that.

use core::cell::Cell;
use core::convert::Infallible;

use embassy_futures::join::join3;
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::mutex::Mutex;
use embassy_sync::signal::Signal;
use embassy_time::{Timer, with_timeout};
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use massline_protocol::message::{
    ANSWER, EraseStore, GetIdentity, Identity, REFUSED, Reason, Refusal,
};
use massline_protocol::{Endpoint, Frame, MAX_FRAME, encode_frame};

use crate::board::{Board, Link, Panel, Sampler};
use crate::info::BoardInfo;
use crate::panel::draw::{StoreState, safe_mode};
use crate::panel::{Button, Cue};
use crate::pulse::Pulse;
use crate::rig::identity;
use crate::session::{LINK_PAUSE, SessionMemory, WRITE_TIMEOUT};

/// Runs safe mode; never returns.
pub(crate) async fn run<S, L, F, P>(
    board: Board<S, L, F, P>,
    memory: &mut SessionMemory,
) -> Infallible
where
    S: Sampler,
    L: Link,
    F: NorFlash,
    P: Panel,
{
    let Board { info, sampler, link, flash, panel, feed_watchdog } = board;
    let identity = identity(&info, sampler.adc(), L::STREAMS);
    let (rx, tx) = link.split();
    let state = Cell::new(StoreState::Unread);
    let supply_is_low = info.supply.is_low;
    let flash = Mutex::new(flash);
    let safe = SafeMode { flash, state, changed: Signal::new(), supply_is_low };
    // Nothing of it works longer than an erase, so that the executor alone is watched.
    let watched = Pulse::new();
    join3(
        safe.serve(rx, tx, &identity, memory),
        safe.show(panel, &info),
        watched.watch(feed_watchdog),
    )
    .await
    .0
}

struct SafeMode<F> {
    flash: Mutex<NoopRawMutex, F>,
    state: Cell<StoreState>,
    changed: Signal<NoopRawMutex, ()>,
    supply_is_low: fn() -> bool,
}

impl<F: NorFlash> SafeMode<F> {
    /// Answers the host; never returns.
    async fn serve(
        &self,
        mut rx: impl Read,
        mut tx: impl Write,
        identity: &Identity,
        memory: &mut SessionMemory,
    ) -> Infallible {
        let SessionMemory { deframer, out, .. } = memory;
        let mut bytes = [0; 64];
        loop {
            let mut rest = match rx.read(&mut bytes).await {
                Ok(n @ 1..) => bytes.get(..n).unwrap_or_default(),
                Ok(0) | Err(_) => {
                    Timer::after(LINK_PAUSE).await;
                    continue;
                }
            };
            while !rest.is_empty() {
                let (taken, frame) = deframer.push(rest);
                rest = rest.get(taken..).unwrap_or_default();
                let Some(Ok(frame)) = frame else { continue };
                let length = self.answer(frame, identity, out).await;
                let answer = out.get(..length).unwrap_or_default();
                // A host that does not read loses the answer, and asks again.
                let _ = with_timeout(WRITE_TIMEOUT, async {
                    tx.write_all(&[0]).await?;
                    tx.write_all(answer).await?;
                    tx.flush().await
                })
                .await;
            }
        }
    }

    /// Executes a request; returns the length of its framed answer.
    async fn answer(
        &self,
        frame: Frame<'_>,
        identity: &Identity,
        out: &mut [u8; MAX_FRAME],
    ) -> usize {
        let Frame { kind, sequence, .. } = frame;
        let refusal = match kind {
            GetIdentity::KIND => {
                return encode_frame(kind | ANSWER, sequence, identity, out).unwrap_or(0);
            }
            EraseStore::KIND if !frame.body.is_empty() => Reason::Malformed,
            EraseStore::KIND if self.erase().await => {
                return encode_frame(kind | ANSWER, sequence, &(), out).unwrap_or(0);
            }
            EraseStore::KIND if (self.supply_is_low)() => Reason::SupplyLow,
            EraseStore::KIND => Reason::StoreFailed,
            _ => Reason::SafeMode,
        };
        encode_frame(REFUSED, sequence, &Refusal::from(refusal), out).unwrap_or(0)
    }

    /// Serves the panel; never returns.
    async fn show(&self, mut panel: impl Panel, info: &BoardInfo) -> Infallible {
        panel.cue(Cue::Failed);
        loop {
            let state = self.state.get();
            safe_mode(panel.screen(), state, info.last_panic);
            panel.flush().await;
            if state == StoreState::Erasing {
                self.erase().await;
                continue;
            }
            if let Either::Second(button) = select(self.changed.wait(), panel.button()).await {
                self.state.set(pressed(self.state.get(), button));
            }
        }
    }

    /// Erases the store, unless it is empty already: a request that arrives twice is executed once. True when the store
    /// is empty.
    async fn erase(&self) -> bool {
        let mut flash = self.flash.lock().await;
        if self.state.get() != StoreState::Erased {
            self.state.set(StoreState::Erasing);
            self.changed.signal(());
            let erased = self.erase_pages(&mut *flash).await;
            self.state.set(if erased { StoreState::Erased } else { StoreState::Failed });
            self.changed.signal(());
        }
        self.state.get() == StoreState::Erased
    }

    /// Erases page by page, so that the watchdog can be fed in between. Stops while the supply is too low.
    async fn erase_pages(&self, flash: &mut F) -> bool {
        let mut erased = true;
        for page in (0..flash.capacity() as u32).step_by(F::ERASE_SIZE) {
            if (self.supply_is_low)() {
                return false;
            }
            erased &= flash.erase(page, page + F::ERASE_SIZE as u32).await.is_ok();
            yield_now().await;
        }
        erased
    }
}

/// The state after a press.
fn pressed(state: StoreState, button: Button) -> StoreState {
    match (state, button) {
        (StoreState::Unread | StoreState::Failed, Button::Ok) => StoreState::Asked,
        (StoreState::Asked, Button::Ok) => StoreState::Erasing,
        (StoreState::Asked, Button::Back | Button::Next) => StoreState::Unread,
        (state, _) => state,
    }
}
