//! The screen's bus hangs at each byte of a picture: the rig frees it and shows the picture, and nothing else waits.
//!
//! The model is that of a screen which has lost count of the clocks: it holds the data line low, and no transfer goes
//! on, until it has seen the clocks of a whole byte and a stop. Time is counted in steps of the simulation, to which a
//! busy machine adds nothing.

mod model;

use std::cell::{Cell, RefCell};

use embassy_futures::select::{Either, Either3, select, select3};
use embassy_futures::yield_now;
use embassy_time::{Duration, Instant};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Circle, PrimitiveStyle};
use massline_cortex_m::frame::{Frame, PAGES, Page, WIDTH};
use massline_cortex_m::gauge::INTERVAL;
use massline_cortex_m::screen::{Pages, drive};
use massline_firmware::board::ScreenSetting;
use massline_protocol::message::Battery;
use massline_virtual::clock::{Executor, advance_to};

use model::{Bus, Controller, Model};

/// A step of the simulated time.
const STEP: Duration = Duration::from_micros(10);

/// The application, which has this picture to show.
struct Application {
    frame: RefCell<Frame>,
    setting: Cell<ScreenSetting>,
}

impl Application {
    fn new() -> Self {
        Self { frame: RefCell::new(picture()), setting: Cell::default() }
    }

    fn take(&self) -> Option<(u8, Page)> {
        let mut frame = self.frame.borrow_mut();
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
        self.frame.borrow_mut().change_all();
    }

    fn setting(&self) -> ScreenSetting {
        self.setting.get()
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
fn show_picture(glitch: Option<usize>) -> Model {
    let model = Model::new(glitch);
    let application = Application::new();
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
                _ if model.displayed_pages() != wanted => {}
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
        let right = model.displayed_pages().iter().zip(&wanted).filter(|(a, b)| a == b).count();
        panic!(
            "byte {glitch:?}: not shown in a second; {right} pages are right, {} bytes taken, hangs {:?}",
            model.taken.get(),
            model.hangs.get()
        );
    };
    let tasks = select3(drive(Bus(&model), &application, |_| {}), other_work, time);
    let ended = Executor::default().run(tasks);
    assert!(matches!(ended, Some(Either3::Third(()))));
    model
}

#[test]
fn a_bus_that_hangs_at_any_byte_of_a_picture_is_freed_and_nothing_waits() {
    let undisturbed = show_picture(None);
    let bytes = undisturbed.taken.get();
    // 1024 of the picture, the commands before each page, and those that switch the screen on.
    assert!((1024..1400).contains(&bytes), "{bytes}");
    for byte in 0..bytes {
        let model = show_picture(Some(byte));
        let hung = STEP * model.hung.get() as u32;
        assert!(hung > STEP && hung <= Duration::from_millis(50), "byte {byte}: {hung}");
    }
}

#[test]
fn the_gauge_is_read_between_the_pages_and_may_be_missing() {
    let model = Model::new(None);
    let application = Application::new();
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
        for (gauge, expected) in readings {
            model.gauge.set(gauge);
            let until = Instant::now() + INTERVAL + Duration::from_secs(1);
            while Instant::now() < until {
                yield_now().await;
                advance_to(Instant::now() + STEP);
            }
            assert_eq!(charge.get(), expected);
            // A new picture while the gauge is there, and while it is not.
            assert_eq!(model.displayed_pages(), wanted);
            model.clear();
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
    let application = Application::new();
    let wanted = pages(picture());
    let time = async {
        for _ in 0..3 {
            let late = Instant::now() + Duration::from_secs(60);
            while model.displayed_pages() != wanted {
                assert!(Instant::now() < late, "not shown in a minute");
                yield_now().await;
                advance_to(Instant::now() + Duration::from_millis(40));
            }
            model.clear();
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
    let application = Application::new();
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
    assert_eq!(model.displayed_pages(), wanted);
    assert_eq!(charge.get(), None);
}

/// The application shows its picture for a second to each setting; what is on the glass after each.
fn glass<const N: usize>(
    controller: Controller,
    settings: [ScreenSetting; N],
) -> [[Page; PAGES]; N] {
    let model = Model::with(controller, None);
    let application = Application::new();
    let seen = RefCell::new([[[0; WIDTH]; PAGES]; N]);
    let time = async {
        for (place, setting) in settings.into_iter().enumerate() {
            application.setting.set(setting);
            application.woken();
            let until = Instant::now() + Duration::from_secs(1);
            while Instant::now() < until {
                yield_now().await;
                advance_to(Instant::now() + STEP);
            }
            seen.borrow_mut()[place] = model.displayed_pages();
        }
    };
    let drive = drive(Bus(&model), &application, |_| {});
    let ended = Executor::default().run(select(drive, time));
    assert!(matches!(ended, Some(Either::Second(()))));
    seen.into_inner()
}

#[test]
fn either_controller_is_told_by_its_answer_at_either_address() {
    let wanted = pages(picture());
    for controller in [Controller::SSD1306, Controller::SH1106] {
        for address in [0x3C, 0x3D] {
            for status in [controller.status, controller.status.map(|status| status | 0x40)] {
                let controller = Controller { address, status, ..controller };
                let [shown] = glass(controller, [ScreenSetting::Automatic]);
                assert!(shown == wanted, "{controller:?}");
            }
        }
    }
}

#[test]
fn a_screen_that_does_not_tell_its_status_counts_as_an_ssd1306_until_the_operator_says_otherwise() {
    use ScreenSetting::{Automatic, Sh1106, Ssd1306};
    let wanted = pages(picture());
    let silent = Controller { status: None, ..Controller::SSD1306 };
    assert!(glass(silent, [Automatic]) == [wanted]);
    // One that neither answers nor is what it is taken for, and one that answers as another.
    for status in [None, Some(6)] {
        let controller = Controller { status, ..Controller::SH1106 };
        let [automatic, right, wrong, back] =
            glass(controller, [Automatic, Sh1106, Ssd1306, Sh1106]);
        assert!(automatic != wanted && wrong != wanted, "it is shifted by two columns");
        for (page, shifted) in wanted.iter().zip(&wrong) {
            assert_eq!(page[2..], shifted[..WIDTH - 2]);
        }
        assert!(right == wanted && back == wanted, "{controller:?}");
    }
    let [wrong, automatic] = glass(Controller::SSD1306, [Sh1106, Automatic]);
    assert!(wrong != wanted && automatic == wanted);
}
