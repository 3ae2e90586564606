//! The application and what runs beside it, as one future: a board's program is a task that awaits it.

use embassy_futures::join::join4;
use embassy_time::{Duration, Timer};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::i2c::I2c;
use embedded_storage_async::nor_flash::NorFlash;
use massline_firmware::Memory;
use massline_firmware::board::{Board, BoardInfo, Link, Sampler};
use static_cell::ConstStaticCell;

use crate::boot::{ResetFlags, reason};
use crate::panel::{RigPanel, Tone, Wiring};
use crate::{last_words, stack};

/// Longer than anything takes during which nothing runs, even where its clock is half as fast again as
/// stated. The longest is the erasure of a sector of an STM32F411's store, 0.8 s; between two of them the
/// store lets the rest run.
pub const WATCHDOG: Duration = Duration::from_secs(8);
const WATCHDOG_FED: Duration = Duration::from_secs(1);

/// Starts the chip again when it has not been fed for [`WATCHDOG`].
pub trait Watchdog {
    /// From now on it wants to be fed.
    fn start(&mut self);

    /// Calms it for another while.
    fn feed(&mut self);
}

/// What the board of this name says of itself, and what the run before has left. To be called once,
/// before anything else.
pub fn info(name: &'static str, flags: ResetFlags) -> BoardInfo {
    let last_panic = last_words::take();
    BoardInfo {
        name,
        firmware: env!("CARGO_PKG_VERSION"),
        git_hash: env!("MASSLINE_GIT_HASH"),
        git_dirty: matches!(env!("MASSLINE_GIT_DIRTY").as_bytes(), b"true"),
        boot_reason: reason(flags, !last_panic.is_empty()),
        last_panic,
        stack: stack::measure,
    }
}

/// What a board has for the application.
pub struct Rig<S, L, F, W> {
    /// What the board says of itself.
    pub info: BoardInfo,
    /// Samples.
    pub sampler: S,
    /// Host.
    pub link: L,
    /// The store's.
    pub flash: F,
    /// Screen, buttons, buzzer.
    pub panel: W,
}

impl<S, L, F, I, P, T, O> Rig<S, L, F, Wiring<I, P, T, O>>
where
    S: Sampler,
    L: Link,
    F: NorFlash,
    I: I2c,
    P: InputPin,
    T: Tone,
    O: OutputPin,
{
    /// The rig, for ever, with `beside` it, which serves the link.
    pub async fn run(self, watchdog: impl Watchdog, beside: impl Future) {
        static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
        let Self { info, sampler, link, flash, panel } = self;
        let board = Board { info, sampler, link, flash, panel: RigPanel::open() };
        let application = massline_firmware::run(board, MEMORY.take());
        join4(application, panel.run(), beside, guard(watchdog)).await;
    }
}

/// The executor comes round: the rig is alive.
async fn guard(mut watchdog: impl Watchdog) -> ! {
    watchdog.start();
    loop {
        watchdog.feed();
        Timer::after(WATCHDOG_FED).await;
    }
}
