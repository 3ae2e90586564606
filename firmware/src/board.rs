//! The four seams between the application and a board: samples, link, flash, panel.

use core::convert::Infallible;
use core::fmt;

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_io_async::{Read, Write};
use embedded_storage_async::nor_flash::NorFlash;
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::ScanIndex;

use crate::panel::{Button, Cue, PanelModel};

/// Why a block of scans did not come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleError {
    /// Scans were lost because they were not read in time; sampling has restarted.
    Overrun {
        /// How many.
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

    /// Starts sampling; scans of an earlier run are gone. Cancel-safe: `stop` follows.
    fn start(&mut self) -> impl Future<Output = Result<(), SampleError>>;

    /// Waits until `block` is full of consecutive scans; gives the index of its first.
    ///
    /// Deadline: the board buffers at least 40 ms of scans between two calls.
    /// Cancel-safe: dropping the future loses at most the scans of this block.
    ///
    /// # Errors
    /// When scans were lost: never a silent gap.
    fn read(&mut self, block: &mut [Scan]) -> impl Future<Output = Result<ScanIndex, SampleError>>;

    /// Stops sampling.
    fn stop(&mut self);
}

/// A stream of bytes to and from the host.
pub trait Link {
    /// From the host. Its `read` waits for bytes and loses none when its future is dropped; while
    /// the link is gone it waits, or gives `Ok(0)` or an error.
    type Rx: Read;
    /// To the host. `flush` returns when the bytes have left, as far as the board can tell.
    type Tx: Write;

    /// True when the link carries [`AdcProperties::rate`] scans of 20 bytes per second.
    const STREAMS: bool;

    /// Both directions, to be used at the same time.
    fn split(self) -> (Self::Rx, Self::Tx);
}

/// A screen of 128 × 64 pixels, three buttons, a sound or light.
pub trait Panel {
    /// What is drawn on: 128 × 64 pixels, buffered by the board (1 KiB).
    type Screen: DrawTarget<Color = BinaryColor, Error = Infallible>;

    /// What is drawn on. Every picture is drawn as a whole.
    fn screen(&mut self) -> &mut Self::Screen;

    /// Brings what was drawn to the glass; returns at once when no screen is connected. Cancel-safe.
    ///
    /// Latency: the others go on while it waits. A glass of 1 KiB takes 24 ms over I²C at 400 kHz, nine
    /// bits a byte; what is done in one go is at most a page of 128 bytes, 3 ms.
    fn flush(&mut self) -> impl Future<Output = ()>;

    /// Waits for a press. Cancel-safe.
    fn button(&mut self) -> impl Future<Output = Button>;

    /// Starts a cue of sound or light and returns.
    fn cue(&mut self, cue: Cue);

    /// What the next picture shows, for a board whose glass is looked at by a program.
    fn tell(&mut self, _model: &PanelModel) {}
}

/// What a board says of itself.
#[derive(Clone, Copy, Debug)]
pub struct BoardInfo {
    /// The folder under `boards/`.
    pub name: &'static str,
    /// Version of the firmware.
    pub firmware: &'static str,
    /// Commit that it was built from.
    pub git_hash: &'static str,
    /// True when that commit had been changed before the build.
    pub git_dirty: bool,
    /// Why it started: 0 unknown, 1 power-on, 2 reset pin, 3 watchdog, 4 panic.
    pub boot_reason: u8,
    /// The last words of a panic before this start.
    pub last_panic: &'static str,
    /// Most stack ever used and stack that there is, bytes.
    pub stack: fn() -> StackUse,
}

/// Stack of the board, bytes; zeros when it does not measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StackUse {
    /// Most ever used.
    pub high_water: u32,
    /// Size.
    pub size: u32,
}

/// Everything that the application needs of a board.
pub struct Board<S: Sampler, L: Link, F: NorFlash, P: Panel> {
    /// What it says of itself.
    pub info: BoardInfo,
    /// Samples.
    pub sampler: S,
    /// Host.
    pub link: L,
    /// A region of flash that belongs to the store alone: three pages or more of 1 KiB or more, words of
    /// up to 16 bytes. A word is written once between two erases. A word that cannot be read, as
    /// a torn one of flash with an error correcting code, is an error of `read`, which the board survives.
    ///
    /// Latency: an erase may stop the core, and is asked for only while the sampler is stopped: between two
    /// hits, or at rest. By the data sheets 0.25 to 0.5 s for 16 KiB of an STM32F411, 25 ms for 2 KiB of an
    /// STM32G474, 0.05 to 0.4 s for 4 KiB of a serial flash. No watchdog may be shorter. A campaign of three
    /// DOFs writes about 3.5 KiB.
    pub flash: F,
    /// Screen and buttons.
    pub panel: P,
}
