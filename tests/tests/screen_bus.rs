//! The screen's bus hangs at each byte of a picture: the rig frees it and shows the picture, and nothing else waits.
//!
//! The model is that of a screen which has lost count of the clocks: it holds the data line low, and no transfer goes on, until
//! it has seen the clocks of a whole byte and a stop. Time is counted in steps of the simulation, to which a busy machine adds
//! nothing.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::pending;

use embassy_futures::select::{Either, Either3, select, select3};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant, Timer};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, PrimitiveStyle};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::i2c::{self, I2c, Operation};
use massline_cortex_m::frame::{Frame, PAGES, Page, WIDTH};
use massline_cortex_m::gauge::INTERVAL;
use massline_cortex_m::screen::{Pages, ScreenBus, drive};
use massline_protocol::message::Battery;
use massline_virtual::clock::{Executor, advance_to};

/// A byte and its acknowledgement at 400 kHz, rounded up.
const BYTE: Duration = Duration::from_micros(23);
/// A step of the simulated time.
const STEP: Duration = Duration::from_micros(10);
/// Clocks that end any byte and its acknowledgement.
const WHOLE_BYTE: u32 = 9;
/// Address of the gauge.
const GAUGE: u8 = 0x36;

/// The screen and the wires to it.
struct Model {
    /// Bytes that the screen has taken.
    taken: Cell<usize>,
    /// The byte during which it loses count.
    glitch: Cell<Option<usize>>,
    /// It has lost count: since which step, and the clocks that it has seen since.
    hangs: Cell<Option<(u64, u32)>>,
    /// Steps for which it hung.
    hung: Cell<u64>,
    /// Steps that have passed.
    steps: Cell<u64>,
    /// The lines are let go: clock, data.
    high: [Cell<bool>; 2],
    /// The picture that it shows, and where the next byte of it goes.
    shown: RefCell<[Page; PAGES]>,
    column: Cell<usize>,
    page: Cell<usize>,
    /// Registers of a gauge on the same bus, from its voltage on, and how often it was read.
    gauge: Cell<Option<[u8; 4]>>,
    asked: Cell<u32>,
    /// It holds the bus for ever.
    gauge_hangs: Cell<bool>,
    /// The machine computes between two looks at the bus.
    is_slow: Cell<bool>,
    /// How often the screen was switched on.
    starts: Cell<u32>,
}

impl Model {
    /// A black screen that loses count during this byte.
    fn new(glitch: Option<usize>) -> Self {
        Self {
            taken: Cell::new(0),
            glitch: Cell::new(glitch),
            hangs: Cell::new(None),
            hung: Cell::new(0),
            steps: Cell::new(0),
            high: [Cell::new(true), Cell::new(true)],
            shown: RefCell::new([[0; WIDTH]; PAGES]),
            column: Cell::new(0),
            page: Cell::new(0),
            gauge: Cell::new(None),
            asked: Cell::new(0),
            gauge_hangs: Cell::new(false),
            is_slow: Cell::new(false),
            starts: Cell::new(0),
        }
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
            // The peripheral sends by itself; the rig looks when it has begun, when the address is taken, and at the end.
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
        let column = self.column.replace(self.column.get() + 1);
        self.shown.borrow_mut()[self.page.get() % PAGES][column % WIDTH] = pixels;
    }
}

/// The rig's end of the bus.
struct Bus<'m>(&'m Model);
struct Open<'m>(&'m Model);
struct Line<'m>(&'m Model, usize);

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
        for operation in operations {
            if let Operation::Write(bytes) = operation {
                self.0.take(bytes).await;
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

/// The application, which has this picture to show.
struct Application(RefCell<Frame>);

impl Application {
    fn take(&self) -> Option<(u8, Page)> {
        let mut frame = self.0.borrow_mut();
        let next = frame.changed().map(|(number, page)| (number, *page))?;
        frame.sent(next.0);
        Some(next)
    }
}

impl Pages for Application {
    async fn next(&self) -> (u8, Page) {
        loop {
            if let Some(next) = self.take() {
                return next;
            }
            yield_now().await;
        }
    }

    fn woken(&self) {
        self.0.borrow_mut().change_all();
    }
}

/// A picture without a blank byte, which the screen would show before it has been sent.
fn picture() -> Frame {
    let mut frame = Frame::new();
    let ring = PrimitiveStyle::with_stroke(BinaryColor::Off, 3);
    frame.clear(BinaryColor::On).unwrap();
    Circle::new(Point::new(32, 0), 64).into_styled(ring).draw(&mut frame).unwrap();
    frame
}

fn pages(mut frame: Frame) -> [Page; PAGES] {
    let mut pages = [[0; WIDTH]; PAGES];
    frame.change_all();
    while let Some((number, page)) = frame.changed().map(|(number, page)| (number, *page)) {
        pages[usize::from(number)] = page;
        frame.sent(number);
    }
    pages
}

/// Shows a picture on a screen that loses count during this byte, with other work beside it.
fn shown(glitch: Option<usize>) -> Model {
    let model = Model::new(glitch);
    let application = Application(RefCell::new(picture()));
    let wanted = pages(picture());
    let worked = Cell::new(0);
    let other_work = async {
        loop {
            worked.set(worked.get() + 1);
            yield_now().await;
        }
    };
    // Time passes after everything has done what it can.
    let mut redrawn = false;
    let time = async {
        while model.steps.get() < 100_000 {
            match model.hangs.get() {
                _ if *model.shown.borrow() != wanted => {}
                None => return,
                // After the last byte the next picture finds that the bus hangs.
                Some(_) if !core::mem::replace(&mut redrawn, true) => application.woken(),
                Some(_) => {}
            }
            yield_now().await;
            advance_to(Instant::now() + STEP);
            model.steps.set(model.steps.get() + 1);
            assert!(worked.get() >= model.steps.get(), "byte {glitch:?}: other work waits");
        }
        let right = model.shown.borrow().iter().zip(&wanted).filter(|(a, b)| a == b).count();
        panic!(
            "byte {glitch:?}: not shown in a second; {right} pages are right, {} bytes taken, hangs {:?}",
            model.taken.get(),
            model.hangs.get()
        );
    };
    let all = select3(drive(Bus(&model), &application, |_| {}), other_work, time);
    let ended = Executor::default().run(all);
    assert!(matches!(ended, Some(Either3::Third(()))));
    model
}

#[test]
fn a_bus_that_hangs_at_any_byte_of_a_picture_is_freed_and_nothing_waits() {
    let undisturbed = shown(None);
    let bytes = undisturbed.taken.get();
    // 1024 of the picture, the commands before each page, and those that switch the screen on.
    assert!((1024..1400).contains(&bytes), "{bytes}");
    for byte in 0..bytes {
        let model = shown(Some(byte));
        let hung = STEP * model.hung.get() as u32;
        assert!(hung > STEP && hung <= Duration::from_millis(50), "byte {byte}: {hung}");
    }
}

#[test]
fn the_gauge_is_read_between_the_pages_and_may_be_missing() {
    let model = Model::new(None);
    let application = Application(RefCell::new(picture()));
    let wanted = pages(picture());
    let charge = Cell::new(None);
    let first = Battery { millivolts: 3840, percent: 64 };
    let later = Battery { millivolts: 3600, percent: 20 };
    // 3.84 V, then none that answers, then 3.60 V: 0xB400 · 78.125 µV.
    let readings = [
        (Some([0xC0, 0x00, 0x40, 0x80]), Some(first)),
        (None, None),
        (Some([0xB4, 0x00, 0x14, 0x00]), Some(later)),
    ];
    let time = async {
        for (gauge, told) in readings {
            model.gauge.set(gauge);
            let until = Instant::now() + INTERVAL + Duration::from_secs(1);
            while Instant::now() < until {
                yield_now().await;
                advance_to(Instant::now() + STEP);
            }
            assert_eq!(charge.get(), told);
            // A new picture while the gauge is there, and while it is not.
            assert_eq!(*model.shown.borrow(), wanted);
            *model.shown.borrow_mut() = [[0; WIDTH]; PAGES];
            application.woken();
        }
    };
    let drive = drive(Bus(&model), &application, |read| charge.set(read));
    let ended = Executor::default().run(select(drive, time));
    assert!(matches!(ended, Some(Either::Second(()))));
    // At 0, 10 and 30 s.
    assert_eq!(model.asked.get(), 3);
}

/// A step of the computation is 40 ms at most; what a poll of the bus costs then has nothing to do with the bus.
#[test]
fn while_the_rig_computes_pages_arrive_and_the_screen_stays_on() {
    let model = Model::new(None);
    model.is_slow.set(true);
    let application = Application(RefCell::new(picture()));
    let wanted = pages(picture());
    let time = async {
        for _ in 0..3 {
            let late = Instant::now() + Duration::from_secs(60);
            while *model.shown.borrow() != wanted {
                assert!(Instant::now() < late, "not shown in a minute");
                yield_now().await;
                advance_to(Instant::now() + Duration::from_millis(40));
            }
            *model.shown.borrow_mut() = [[0; WIDTH]; PAGES];
            application.woken();
        }
    };
    let drive = drive(Bus(&model), &application, |_| {});
    let ended = Executor::default().run(select(drive, time));
    assert!(matches!(ended, Some(Either::Second(()))));
    assert_eq!(model.starts.get(), 1, "switched on once");
}

/// A gauge that holds the bus costs the charge, and no picture.
#[test]
fn a_gauge_that_hangs_takes_the_screen_with_it_only_for_a_moment() {
    let model = Model::new(None);
    model.gauge.set(Some([0xFF; 4]));
    model.gauge_hangs.set(true);
    let application = Application(RefCell::new(picture()));
    let wanted = pages(picture());
    let charge = Cell::new(Some(Battery { millivolts: 3840, percent: 64 }));
    let time = async {
        let until = Instant::now() + Duration::from_secs(1);
        while Instant::now() < until {
            yield_now().await;
            advance_to(Instant::now() + STEP);
        }
    };
    let drive = drive(Bus(&model), &application, |read| charge.set(read));
    let ended = Executor::default().run(select(drive, time));
    assert!(matches!(ended, Some(Either::Second(()))));
    assert_eq!(*model.shown.borrow(), wanted);
    assert_eq!(charge.get(), None);
}
