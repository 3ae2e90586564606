//! A screen with an SSD1306 or an SH1106 on its bus, which may lose count of the clocks, and a gauge beside it.
//!
//! The two controllers differ as their data sheets say: 128 columns of memory, all on the glass, or 132, of which two
//! at each side are not. Both go on with the next column of the page after each byte, and begin it again after the
//! last.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::pending;

use embassy_futures::yield_now;
use embassy_time::{Duration, Timer};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::i2c::{self, I2c, NoAcknowledgeSource, Operation};
use massline_cortex_m::frame::{PAGES, Page, WIDTH};
use massline_cortex_m::screen::ScreenBus;

/// A byte and its acknowledgement at 400 kHz, rounded up.
const BYTE: Duration = Duration::from_micros(23);
/// Clocks that end any byte and its acknowledgement.
const WHOLE_BYTE: u32 = 9;
/// Address of the gauge.
const GAUGE: u8 = 0x36;

/// Columns of memory of an SH1106.
const MOST_COLUMNS: usize = 132;

/// The controller of a screen, as the bus sees it.
#[derive(Clone, Copy, Debug)]
pub struct Controller {
    /// Address of the screen.
    pub address: u8,
    /// Columns of its memory.
    pub columns: usize,
    /// The lower half of its status byte; `None` when it does not answer to a read.
    pub status: Option<u8>,
}

impl Controller {
    /// The most common one.
    pub const SSD1306: Self = Self { address: 0x3C, columns: WIDTH, status: Some(6) };
    /// That of screens of 1.3 inches.
    pub const SH1106: Self = Self { address: 0x3C, columns: MOST_COLUMNS, status: Some(8) };

    /// The columns that are not on the glass, at each side.
    fn hidden(self) -> usize {
        (self.columns - WIDTH) / 2
    }
}

/// The screen and the wires to it.
pub struct Model {
    controller: Controller,
    /// Bytes that the screen has taken.
    pub taken: Cell<usize>,
    /// The byte during which it loses count.
    glitch: Cell<Option<usize>>,
    /// It has lost count: since which step, and the clocks that it has seen since.
    pub hangs: Cell<Option<(u64, u32)>>,
    /// Steps for which it hung.
    pub hung: Cell<u64>,
    /// Steps that have passed.
    pub steps: Cell<u64>,
    /// The lines are let go: clock, data.
    high: [Cell<bool>; 2],
    /// Its memory, and where the next byte of it goes.
    memory: RefCell<[[u8; MOST_COLUMNS]; PAGES]>,
    column: Cell<usize>,
    page: Cell<usize>,
    /// Registers of a gauge on the same bus, from its voltage on, and how often it was read.
    pub gauge: Cell<Option<[u8; 4]>>,
    pub asked: Cell<u32>,
    /// It holds the bus for ever.
    pub gauge_hangs: Cell<bool>,
    /// The machine computes between two looks at the bus.
    pub is_slow: Cell<bool>,
    /// How often the screen was switched on.
    pub starts: Cell<u32>,
}

impl Model {
    /// A black screen that loses count during this byte.
    pub fn new(glitch: Option<usize>) -> Self {
        Self::with(Controller::SSD1306, glitch)
    }

    /// The same with another controller.
    pub fn with(controller: Controller, glitch: Option<usize>) -> Self {
        Self {
            controller,
            taken: Cell::new(0),
            glitch: Cell::new(glitch),
            hangs: Cell::new(None),
            hung: Cell::new(0),
            steps: Cell::new(0),
            high: [Cell::new(true), Cell::new(true)],
            memory: RefCell::new([[0; MOST_COLUMNS]; PAGES]),
            column: Cell::new(0),
            page: Cell::new(0),
            gauge: Cell::new(None),
            asked: Cell::new(0),
            gauge_hangs: Cell::new(false),
            is_slow: Cell::new(false),
            starts: Cell::new(0),
        }
    }

    /// The picture on the glass.
    pub fn displayed_pages(&self) -> [Page; PAGES] {
        let (first, memory) = (self.controller.hidden(), self.memory.borrow());
        memory.map(|page| std::array::from_fn(|column| page[first + column]))
    }

    /// Blackens it, as when it is switched off.
    pub fn clear(&self) {
        *self.memory.borrow_mut() = [[0; MOST_COLUMNS]; PAGES];
    }

    /// The master has let a line go or pulled it low.
    fn set(&self, line: usize, high: bool) {
        let was_high = self.high[line].replace(high);
        let rises = high && !was_high;
        let Some((since, clocks)) = self.hangs.get().filter(|_| rises) else { return };
        match line {
            0 => self.hangs.set(Some((since, clocks + 1))),
            // Data rises while the clock is high: a stop, unless the screen still holds the line.
            _ if self.high[0].get() && clocks >= WHOLE_BYTE => {
                self.hangs.set(None);
                self.hung.set(self.steps.get() - since);
            }
            _ => {}
        }
    }

    async fn take(&self, bytes: &[u8]) {
        if self.is_slow.get() {
            // The peripheral sends by itself; the rig looks when it has begun, when the address is taken, and at the
            // end.
            for _ in 0..3 {
                yield_now().await;
            }
        }
        for _ in bytes {
            if self.hangs.get().is_some() {
                return pending().await;
            }
            if !self.is_slow.get() {
                Timer::after(BYTE).await;
            }
            let taken = self.taken.replace(self.taken.get() + 1);
            if self.glitch.get() == Some(taken) {
                self.hangs.set(Some((self.steps.get(), 0)));
            }
        }
        match bytes {
            [0x00, 0xAF] => self.starts.set(self.starts.get() + 1),
            [0x00, page @ 0xB0..=0xB7] => self.page.set(usize::from(page - 0xB0)),
            [0x00, low @ 0x00..=0x0F, high @ 0x10..=0x1F] => {
                self.column.set(usize::from((high - 0x10) << 4 | low));
            }
            [0x40, pixels @ ..] => pixels.iter().for_each(|pixels| self.draw(*pixels)),
            _ => {}
        }
    }

    /// The gauge answers, if there is one; the screen may still hold the data line.
    async fn answer(&self, operations: &mut [Operation<'_>]) -> Result<(), i2c::ErrorKind> {
        if self.hangs.get().is_some() || self.gauge_hangs.get() {
            return pending().await;
        }
        let registers = self.gauge.get().ok_or(i2c::ErrorKind::Other)?;
        self.asked.set(self.asked.get() + 1);
        for operation in operations {
            if let Operation::Read(bytes) = operation {
                for (byte, register) in bytes.iter_mut().zip(registers) {
                    Timer::after(BYTE).await;
                    *byte = register;
                }
            }
        }
        Ok(())
    }

    fn draw(&self, pixels: u8) {
        let column = self.column.get() % self.controller.columns;
        self.column.set(column + 1);
        self.memory.borrow_mut()[self.page.get() % PAGES][column] = pixels;
    }
}

/// The rig's end of the bus.
pub struct Bus<'m>(pub &'m Model);
pub struct Open<'m>(&'m Model);
pub struct Line<'m>(&'m Model, usize);

impl ScreenBus for Bus<'_> {
    type Open<'a>
        = Open<'a>
    where
        Self: 'a;
    type Line<'a>
        = Line<'a>
    where
        Self: 'a;

    fn open(&mut self) -> Open<'_> {
        Open(self.0)
    }

    fn lines(&mut self) -> [Line<'_>; 2] {
        [Line(self.0, 0), Line(self.0, 1)]
    }
}

impl i2c::ErrorType for Open<'_> {
    type Error = i2c::ErrorKind;
}

impl I2c for Open<'_> {
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), i2c::ErrorKind> {
        if address == GAUGE {
            return self.0.answer(operations).await;
        }
        let refused = i2c::ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
        let controller = self.0.controller;
        for operation in operations {
            match operation {
                // Nobody holds the line for an address that is not there.
                _ if address != controller.address => return Err(refused),
                Operation::Write(bytes) => self.0.take(bytes).await,
                Operation::Read(bytes) => {
                    let status = controller.status.ok_or(refused)?;
                    self.0.take(&[0]).await;
                    bytes.fill(status);
                }
            }
        }
        Ok(())
    }
}

impl ErrorType for Line<'_> {
    type Error = Infallible;
}

impl OutputPin for Line<'_> {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set(self.1, false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set(self.1, true);
        Ok(())
    }
}

impl InputPin for Line<'_> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let held = self.1 == 1 && self.0.hangs.get().is_some_and(|(_, seen)| seen < WHOLE_BYTE);
        Ok(self.0.high[self.1].get() && !held)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
