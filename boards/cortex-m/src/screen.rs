//! The screen: an OLED of 128 × 64 pixels with an SSD1306 on an I²C bus, which a glitch on a wire may leave hanging.
//!
//! A screen that has seen one clock too many or too few waits for more of them with the data line pulled low, and then no
//! transfer ever begins. Nine clocks end whatever byte it believes in, a stop ends the transfer, and the peripheral is set up anew.

use display_interface::DisplayError;
use embassy_time::{Duration, Instant, Timer, with_deadline};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::i2c::I2c;
use massline_protocol::message::Battery;
use ssd1306::command::AddrMode;
use ssd1306::mode::BasicMode;
use ssd1306::prelude::{DisplayRotation, I2CInterface};
use ssd1306::size::DisplaySize128x64;
use ssd1306::{I2CDisplayInterface, Ssd1306Async};

use crate::frame::Page;
use crate::gauge;
use crate::patience::PatientBus;

/// Half a period of the clocks that free the bus: slower than any screen.
const HALF_CLOCK: Duration = Duration::from_micros(5);
/// Clocks that end a byte and its acknowledgement.
const CLOCKS: usize = 9;
/// Pause before a screen that does not answer is tried again, doubled after each attempt: its supply may rise more slowly
/// than the chip's.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
/// Longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// The bus of the screen, which can be opened again and again.
pub trait ScreenBus {
    /// The open bus.
    type Open<'a>: I2c
    where
        Self: 'a;
    /// A line of the bus: it is pulled low, or let go and read.
    type Line<'a>: InputPin + OutputPin
    where
        Self: 'a;

    /// Resets the peripheral and sets it up.
    fn open(&mut self) -> Self::Open<'_>;

    /// False while the peripheral would wait for the bus without letting anything else run. To be asked while it is open.
    fn is_free() -> bool {
        true
    }

    /// Clock and data as pins, without the peripheral, let go.
    fn lines(&mut self) -> [Self::Line<'_>; 2];
}

/// The application's side of the screen.
pub trait Pages {
    /// Waits for the next page to be shown, with its number.
    fn next(&self) -> impl Future<Output = (u8, Page)>;

    /// The screen has been switched on, and has lost what was sent before.
    fn woken(&self);
}

type Screen<I> = Ssd1306Async<I2CInterface<I>, DisplaySize128x64, BasicMode>;

/// Shows the pages; never returns. A screen that has answered is tried again at once, because its bus may only hang; while it
/// does not answer, pages are discarded, and it is tried again later.
///
/// Every [`gauge::INTERVAL`] the gauge of the battery is read, which is on the same bus, and `charged` gets the charge. A
/// gauge that does not answer costs the screen nothing but a new start of the bus.
pub async fn drive<B: ScreenBus>(
    mut bus: B,
    pages: &impl Pages,
    charged: impl Fn(Option<Battery>),
) -> ! {
    let mut pause = Duration::MIN;
    let mut reading = Instant::now();
    loop {
        free(bus.lines()).await;
        let mut open = PatientBus::new(bus.open(), B::is_free);
        // The driver holds the bus, so there is a new one after each reading.
        if screen(&mut open).init_with_addr_mode(AddrMode::Page).await.is_ok() {
            pages.woken();
            pause = Duration::MIN;
            while show(&mut screen(&mut open), pages, reading).await {
                charged(gauge::read(&mut open).await);
                reading = Instant::now() + gauge::INTERVAL;
            }
        } else {
            charged(gauge::read(&mut open).await);
            let again = Instant::now() + pause;
            while with_deadline(again, pages.next()).await.is_ok() {}
            pause = (pause * 2).clamp(SHORTEST_PAUSE, LONGEST_PAUSE);
        }
    }
}

/// The screen on this bus.
fn screen<I: I2c>(bus: I) -> Screen<I> {
    let interface = I2CDisplayInterface::new(bus);
    Ssd1306Async::new(interface, DisplaySize128x64, DisplayRotation::Rotate0)
}

/// Sends pages until this time; false when the screen does not take one.
async fn show<I: I2c>(screen: &mut Screen<I>, pages: &impl Pages, until: Instant) -> bool {
    while let Ok((number, page)) = with_deadline(until, pages.next()).await {
        if send_page(screen, number, &page).await.is_err() {
            return false;
        }
    }
    true
}

async fn send_page<I: I2c>(
    screen: &mut Screen<I>,
    number: u8,
    page: &Page,
) -> Result<(), DisplayError> {
    screen.set_row(8 * number).await?;
    screen.set_column(0).await?;
    screen.draw(page).await
}

/// Lets a screen that holds the data line finish its byte, and ends the transfer: I²C specification (UM10204), 3.1.16. Errors of
/// pins do not occur on a chip.
async fn free<L: InputPin + OutputPin>([mut clock, mut data]: [L; 2]) {
    let _ = data.set_high();
    for _ in 0..CLOCKS {
        let _ = clock.set_low();
        Timer::after(HALF_CLOCK).await;
        let _ = clock.set_high();
        Timer::after(HALF_CLOCK).await;
    }
    let _ = clock.set_low();
    let _ = data.set_low();
    Timer::after(HALF_CLOCK).await;
    let _ = clock.set_high();
    Timer::after(HALF_CLOCK).await;
    let _ = data.set_high();
    Timer::after(HALF_CLOCK).await;
}
