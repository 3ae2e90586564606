//! The screen: an OLED of 128 × 64 pixels with an SSD1306 or an SH1106 on an I²C bus, which a glitch on a wire may
//! leave hanging.
//!
//! Both take the same commands, page by page. An SH1106 has 132 columns, of which the glass shows all but two at each
//! side.
//!
//! A screen that has seen one clock too many or too few waits for more of them with the data line pulled low, and
//! then no transfer ever begins. Nine clocks end whatever byte it believes in, a stop ends the transfer, and the
//! peripheral is set up anew.

use display_interface::DisplayError;
use embassy_time::{Duration, Instant, Timer, with_deadline};
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal_async::i2c::{Error, ErrorKind, I2c};
use massline_firmware::board::ScreenSetting;
use massline_protocol::message::Battery;
use ssd1306::Ssd1306Async;
use ssd1306::command::AddrMode;
use ssd1306::mode::BasicMode;
use ssd1306::prelude::{DisplayRotation, I2CInterface};
use ssd1306::size::DisplaySize128x64;

use crate::frame::Page;
use crate::gauge;
use crate::patience::PatientBus;

/// Half a period of the clocks that free the bus: slower than any screen.
const HALF_CLOCK: Duration = Duration::from_micros(5);
/// Clocks that end a byte and its acknowledgement.
const CLOCKS: usize = 9;
/// Pause before a screen that does not answer is tried again, doubled after each attempt: its supply may rise more
/// slowly than the chip's.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
/// Longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// I²C addresses of a screen, by the resistor on its back.
pub const ADDRESSES: [u8; 2] = [0x3C, 0x3D];
/// What precedes commands, and pixels.
const COMMANDS: u8 = 0x00;
const PIXELS: u8 = 0x40;
/// The command that sets the oscillator.
const RATE: u8 = 0xD5;
/// The command that does nothing.
const NOTHING: u8 = 0xE3;

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

    /// False while the peripheral would wait for the bus without letting anything else run. To be asked while it is
    /// open.
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

    /// What the operator says of the controller.
    fn setting(&self) -> ScreenSetting;
}

/// The controller of a screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Controller {
    Ssd1306,
    Sh1106,
}

impl Controller {
    /// By the lower half of its status byte: 8 is that of an SH1106; an SSD1306 answers 3, 6 or 7. Neither data sheet
    /// says so.
    fn of_status(status: u8) -> Self {
        if status & 0x0F == 8 { Self::Sh1106 } else { Self::Ssd1306 }
    }

    /// What sets about 105 pictures a second: the oscillator of an SH1106 is 15 % faster with the setting of an
    /// SSD1306.
    fn rate(self) -> u8 {
        match self {
            Self::Ssd1306 => 0x80,
            Self::Sh1106 => 0x50,
        }
    }

    /// The column of its memory that is the first on the glass.
    fn first_column(self) -> u8 {
        match self {
            Self::Ssd1306 => 0,
            Self::Sh1106 => 2,
        }
    }
}

/// A screen that has answered.
#[derive(Clone, Copy, Debug)]
struct ScreenAnswer {
    address: u8,
    controller: Controller,
}

impl ScreenAnswer {
    /// The controller by the operator's word, or else by its answer.
    fn controller(self, setting: ScreenSetting) -> Controller {
        match setting {
            ScreenSetting::Automatic => self.controller,
            ScreenSetting::Ssd1306 => Controller::Ssd1306,
            ScreenSetting::Sh1106 => Controller::Sh1106,
        }
    }
}

type Screen<I> = Ssd1306Async<I2CInterface<I>, DisplaySize128x64, BasicMode>;

/// Shows the pages; never returns. A screen that has answered is tried again at once, because its bus may only hang;
/// while it does not answer, pages are discarded, and it is tried again later.
///
/// Every [`gauge::INTERVAL`] the gauge of the battery is read, which is on the same bus, and `charged` gets the
/// charge. A gauge that does not answer costs the screen nothing but a new start of the bus.
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
        let answer = find(&mut open).await;
        if let Some(answer) = answer
            && switch_on(&mut open, answer.address).await.is_ok()
        {
            pages.woken();
            pause = Duration::MIN;
            let mut shower = Shower { answer, rate_of: Controller::Ssd1306 };
            while shower.show(&mut open, pages, reading).await {
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

/// The screen that answers; `None` also when the bus hangs. One that does not tell its status counts as an SSD1306.
async fn find(bus: &mut impl I2c) -> Option<ScreenAnswer> {
    for address in ADDRESSES {
        if acknowledged(bus.write(address, &[COMMANDS, NOTHING]).await)? {
            let mut status = [0];
            let has_status = acknowledged(bus.write_read(address, &[COMMANDS], &mut status).await)?;
            let controller =
                if has_status { Controller::of_status(status[0]) } else { Controller::Ssd1306 };
            return Some(ScreenAnswer { address, controller });
        }
    }
    None
}

/// Whether somebody has answered; `None` when the bus hangs.
fn acknowledged<E: Error>(transfer: Result<(), E>) -> Option<bool> {
    match transfer.map_err(|error| error.kind()) {
        Ok(()) => Some(true),
        Err(ErrorKind::NoAcknowledge(_)) => Some(false),
        Err(_) => None,
    }
}

/// The screen on this bus. The driver holds the bus, so there is a new one after each other use of it.
fn screen<I: I2c>(bus: I, address: u8) -> Screen<I> {
    let interface = I2CInterface::new(bus, address, PIXELS);
    Ssd1306Async::new(interface, DisplaySize128x64, DisplayRotation::Rotate0)
}

/// Sets the screen up as an SSD1306. What an SH1106 does not know of it has no effect.
async fn switch_on<I: I2c>(bus: &mut I, address: u8) -> Result<(), DisplayError> {
    screen(bus, address).init_with_addr_mode(AddrMode::Page).await
}

/// Sends pages to a screen that is on.
struct Shower {
    answer: ScreenAnswer,
    /// The controller for which the rate of pictures is set.
    rate_of: Controller,
}

impl Shower {
    /// Sends pages until this time; false when the screen does not take one.
    async fn show<I: I2c>(&mut self, bus: &mut I, pages: &impl Pages, until: Instant) -> bool {
        while let Ok((number, page)) = with_deadline(until, pages.next()).await {
            let controller = self.answer.controller(pages.setting());
            if self.set_rate(bus, controller).await.is_err() {
                return false;
            }
            let mut screen = screen(&mut *bus, self.answer.address);
            if send_page(&mut screen, (number, controller.first_column()), &page).await.is_err() {
                return false;
            }
        }
        true
    }

    /// Sets the rate of pictures, if the controller is another one than before.
    async fn set_rate<I: I2c>(
        &mut self,
        bus: &mut I,
        controller: Controller,
    ) -> Result<(), I::Error> {
        if controller != self.rate_of {
            let rate = [COMMANDS, RATE, controller.rate()];
            bus.write(self.answer.address, &rate).await?;
            self.rate_of = controller;
        }
        Ok(())
    }
}

/// Sends a page, which begins at this column.
async fn send_page<I: I2c>(
    screen: &mut Screen<I>,
    (number, column): (u8, u8),
    page: &Page,
) -> Result<(), DisplayError> {
    screen.set_row(8 * number).await?;
    screen.set_column(column).await?;
    screen.draw(page).await
}

/// Lets a screen that holds the data line finish its byte, and ends the transfer: I²C specification (UM10204),
/// 3.1.16. Errors of pins do not occur on a chip.
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
