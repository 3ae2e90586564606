//! The four seams between the application and a board: samples, link, flash, panel.

use core::fmt;

use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::ScanIndex;

pub use crate::info::{BoardInfo, BrownOut, Circuit, NO_CONVERTER_FAULT, StackUse, Supply};
pub use crate::panel::Panel;
pub use crate::screen_setting::ScreenSetting;
pub use massline_protocol::{BootReason, Clock, ConverterFault};

/// Why a block of scans could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleError {
    /// Scans were lost because they were not read in time; sampling has restarted.
    Overrun {
        /// Number of lost scans.
        lost: u32,
    },
    /// The converter does not answer.
    Stopped,
}

impl fmt::Display for SampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overrun { lost } => write!(f, "{lost} scans were lost"),
            Self::Stopped => f.write_str("the converter does not answer"),
        }
    }
}

impl core::error::Error for SampleError {}

/// Takes whole scans at a constant rate.
pub trait Sampler {
    /// Rate, resolution, channel delay.
    fn adc(&self) -> AdcProperties;

    /// Starts sampling and discards scans of an earlier run. Cancel-safe: the caller calls `stop` next.
    fn start(&mut self) -> impl Future<Output = Result<(), SampleError>>;

    /// Waits until `block` is full of consecutive scans; returns the index of the first.
    ///
    /// Deadline: the board buffers at least 40 ms of scans between two calls.
    /// Cancel-safe: dropping the future loses at most the scans of this block.
    ///
    /// # Errors
    /// [`SampleError::Overrun`] when scans were lost: a gap is always reported. [`SampleError::Stopped`]
    /// when the converter does not answer.
    fn read(&mut self, block: &mut [Scan]) -> impl Future<Output = Result<ScanIndex, SampleError>>;

    /// Stops sampling.
    fn stop(&mut self);
}

/// A stream of bytes to and from the host.
pub trait Link {
    /// From the host. Its `read` waits for bytes and loses none when its future is dropped. While the
    /// link is disconnected it waits, or returns `Ok(0)` or an error.
    type Rx: Read;
    /// To the host. `flush` returns when the bytes have been sent, as far as the board can determine.
    type Tx: Write;

    /// True when the link carries [`AdcProperties::rate`] scans of 20 bytes per second.
    const STREAMS: bool;

    /// Splits the link into its two directions, which can be used concurrently.
    fn split(self) -> (Self::Rx, Self::Tx);
}

/// Everything that the application needs from a board.
pub struct Board<S: Sampler, L: Link, F: NorFlash, P: Panel> {
    /// What the board reports about itself.
    pub info: BoardInfo,
    /// Source of the scans.
    pub sampler: S,
    /// Link to the host.
    pub link: L,
    /// A region of flash for the exclusive use of the store: three pages or more of 1 KiB or more, words
    /// of up to 16 bytes. A word is written once between two erases. `read` returns an error for a word
    /// that cannot be read, such as a torn word in flash with an error correcting code; the board
    /// survives that.
    ///
    /// Latency: an erase may stop the core. It is requested only while the sampler is stopped: between
    /// two hits, or while the rig is idle. By the data sheets it takes 0.25 to 0.5 s for 16 KiB of an
    /// STM32F411, 25 ms for 2 KiB of an STM32G474, 0.05 to 0.4 s for 4 KiB of a serial flash. The period
    /// of a watchdog must be longer. A campaign of three DOFs writes about 3.5 KiB.
    pub flash: F,
    /// Screen and buttons.
    pub panel: P,
    /// Restarts the period of the board's watchdog, of 8 s or more. The application calls it every second while
    /// measuring, session and panel get on with their work.
    pub feed_watchdog: fn(),
}
