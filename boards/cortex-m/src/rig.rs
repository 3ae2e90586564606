//! The application and the tasks beside it, as one future, which the task of a board's program awaits.

use core::pin::pin;

use embassy_futures::join::join4;
use embassy_time::{Duration, Timer};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_storage_async::nor_flash::NorFlash;
use massline_firmware::Memory;
use massline_firmware::board::{
    Board, BoardInfo, Circuit, Clock, Link, NO_CONVERTER_FAULT, Sampler, Supply,
};
use static_cell::ConstStaticCell;

use crate::boot::{ResetFlags, after_failures, reason};
use crate::panel::{RigPanel, Tone, Wiring};
use crate::screen::ScreenBus;
use crate::{last_words, stack};

/// Period of the watchdog: longer than any operation that blocks everything else, even if the watchdog's
/// clock is half as fast again as stated. The longest is the erase of a sector of an STM32F411's store, 0.8
/// s; the store yields between two erases.
pub const WATCHDOG: Duration = Duration::from_secs(8);
/// A start has not failed when the rig runs for this time.
const SUCCESS: Duration = Duration::from_secs(60);

/// Resets the chip when it has not been fed for [`WATCHDOG`].
pub trait Watchdog {
    /// Starts the watchdog; from now on it must be fed. To be called before the clocks, which may hang.
    fn start();

    /// Restarts its period.
    fn feed();
}

/// Information about the board with this name, including the panic message of the previous run. To be
/// called once, before anything else but the clock, on which it does not depend.
///
/// `flash_select` is the channel on which some of these boards have the select pin of a flash chip.
pub fn info(
    name: &'static str,
    flash_select: Option<u8>,
    flags: ResetFlags,
    clock: Clock,
    supply: Supply,
) -> BoardInfo {
    let last_panic = last_words::take();
    let reason = reason(flags, !last_panic.is_empty());
    let (boot_reason, failures) = after_failures(reason, last_words::failures());
    last_words::note_failures(failures);
    BoardInfo {
        name,
        firmware: env!("CARGO_PKG_VERSION"),
        git_hash: env!("MASSLINE_GIT_HASH"),
        git_dirty: matches!(env!("MASSLINE_GIT_DIRTY").as_bytes(), b"true"),
        boot_reason,
        clock,
        supply,
        circuit: Circuit { flash_select },
        converter_fault: NO_CONVERTER_FAULT,
        last_panic,
        stack: stack::measure,
    }
}

/// The parts of a board that the application uses.
pub struct Rig<S, L, F, W> {
    /// What the board reports about itself.
    pub info: BoardInfo,
    /// Source of the scans.
    pub sampler: S,
    /// Link to the host.
    pub link: L,
    /// Flash of the store.
    pub flash: F,
    /// Screen, buttons, buzzer.
    pub panel: W,
}

impl<S, L, F, I, P, T, O> Rig<S, L, F, Wiring<I, P, T, O>>
where
    S: Sampler,
    L: Link,
    F: NorFlash,
    I: ScreenBus,
    P: InputPin,
    T: Tone,
    O: OutputPin,
{
    /// Runs the rig, which feeds the watchdog `D`, and concurrently `beside`, which serves the link; never returns.
    pub async fn run<D: Watchdog>(self, beside: impl Future) {
        static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
        let Self { info, sampler, link, flash, panel } = self;
        let feed_watchdog = D::feed;
        let board = Board { info, sampler, link, flash, panel: RigPanel::open(), feed_watchdog };
        // Pinned in their places: a future that is moved lies on the stack of whoever polls it.
        let application = pin!(massline_firmware::run(board, MEMORY.take()));
        let (panel, beside) = (pin!(panel.run(info)), pin!(beside));
        join4(application, panel, beside, note_success()).await;
    }
}

/// Notes that this start has not failed, once the rig has run for a while.
async fn note_success() {
    Timer::after(SUCCESS).await;
    last_words::note_failures(0);
}
