//! The panel: an OLED of 128 × 64 pixels with an SSD1306, three buttons, a buzzer with a light.
//!
//! The application's part never waits for a wire: pages, presses and cues go over channels to tasks of
//! their own, so whatever the application gives up leaves no transfer half done.

use core::fmt::Write;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Instant, Ticker, Timer, with_timeout};
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::FONT_6X10;
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{Drawable, Point};
use embedded_graphics::text::{Baseline, Text};
use embedded_hal_async::i2c::I2c;
use massline_firmware::board::Panel;
use massline_firmware::panel::{Button, PanelModel};
use massline_shared::protocol::message::Phase;
use ssd1306::command::AddrMode;
use ssd1306::mode::BasicMode;
use ssd1306::prelude::{DisplayRotation, I2CInterface};
use ssd1306::size::DisplaySize128x64;
use ssd1306::{I2CDisplayInterface, Ssd1306Async};
use static_cell::StaticCell;

use crate::debounce::Debounce;
use crate::frame::{Frame, Page, WIDTH};

type DisplayError = display_interface::DisplayError;

/// What is told by sound and light, because hands and eyes are at the hammer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cue {
    /// Hit now.
    Armed,
    /// The hit is good.
    Accepted,
    /// The hit does not count.
    Rejected,
    /// The measurement is complete.
    Done,
    /// It cannot go on.
    Failed,
}

/// Contacts have settled after this.
const SETTLE: Duration = Duration::from_millis(20);
/// Buttons are looked at so often.
const LOOK: Duration = Duration::from_millis(5);
/// A page takes 3 ms at 400 kHz; a bus that takes longer hangs.
const BUS_TIMEOUT: Duration = Duration::from_millis(50);
/// A screen that did not answer is tried again after this.
const SCREEN_PAUSE: Duration = Duration::from_secs(5);

/// Between the application and the tasks of the panel.
pub struct Wires {
    pages: Channel<CriticalSectionRawMutex, (u8, Page), 1>,
    presses: Channel<CriticalSectionRawMutex, Button, 4>,
    cues: Channel<CriticalSectionRawMutex, Cue, 4>,
    /// The glass does not show what was sent before.
    redraw: AtomicBool,
}

impl Default for Wires {
    fn default() -> Self {
        Self::new()
    }
}

impl Wires {
    /// Nothing under way.
    pub const fn new() -> Self {
        Self {
            pages: Channel::new(),
            presses: Channel::new(),
            cues: Channel::new(),
            redraw: AtomicBool::new(false),
        }
    }
}

/// The application's end.
pub struct RigPanel {
    frame: &'static mut Frame,
    wires: &'static Wires,
    shown: PanelModel,
}

impl RigPanel {
    /// A black screen. To be called once.
    pub fn new(wires: &'static Wires) -> Self {
        static FRAME: StaticCell<Frame> = StaticCell::new();
        Self { frame: FRAME.init_with(Frame::new), wires, shown: PanelModel::START }
    }

    /// What is drawn on.
    pub fn screen(&mut self) -> &mut Frame {
        self.frame
    }

    /// Brings what was drawn to the glass; returns at once when no screen is connected. Cancel-safe: a
    /// page is sent whole or again.
    pub async fn flush(&mut self) {
        loop {
            if self.wires.redraw.swap(false, Ordering::Relaxed) {
                self.frame.change_all();
            }
            let Some((number, page)) = self.frame.changed() else { return };
            self.wires.pages.send((number, *page)).await;
            self.frame.sent(number);
        }
    }

    /// Waits for a press. Cancel-safe.
    pub async fn button(&mut self) -> Button {
        self.wires.presses.receive().await
    }

    /// Starts a cue of sound or light and returns; one too many is not heard.
    pub fn cue(&mut self, cue: Cue) {
        let _ = self.wires.cues.try_send(cue);
    }

    fn announce(&mut self, model: &PanelModel) {
        let (before, now) = (self.shown, model);
        if now.phase == Phase::Armed && (before.phase != now.phase || before.armings != now.armings)
        {
            self.cue(Cue::Armed);
        }
        if now.accepted > before.accepted {
            self.cue(Cue::Accepted);
        }
        if now.rejected_for.is_some() && now.rejected_for != before.rejected_for {
            self.cue(Cue::Rejected);
        }
        if now.phase == Phase::Done && before.phase != now.phase {
            self.cue(Cue::Done);
        }
    }

    fn line(&mut self, row: i32, text: &str) {
        let style = MonoTextStyle::new(&FONT_6X10, BinaryColor::On);
        let Ok(_) = Text::with_baseline(text, Point::new(0, 12 * row), style, Baseline::Top)
            .draw(self.frame);
    }
}

impl Panel for RigPanel {
    fn show(&mut self, model: &PanelModel) {
        self.announce(model);
        self.shown = *model;
        let Ok(()) = self.frame.clear(BinaryColor::Off);
        // A line that is too long is cut at the edge of the screen.
        let mut text = heapless::String::<32>::new();
        let _ = write!(text, "{:?}", model.phase);
        self.line(0, &text);
        if let Some((index, dof)) = model.dof {
            text.clear();
            let _ = write!(text, "{dof}  DOF {}/{}", index + 1, model.dofs);
            self.line(1, &text);
            text.clear();
            let _ = write!(text, "hit {}/{}", model.accepted, model.wanted);
            self.line(2, &text);
        }
        if let Some(code) = model.rejected_for {
            text.clear();
            let _ = write!(text, "rejected: {code}");
            self.line(3, &text);
        }
        if let Some(mass) = model.mass {
            text.clear();
            let _ = write!(text, "{:.3} kg", mass.value);
            if let Some(sigma) = mass.sigma {
                let _ = write!(text, " +-{sigma:.3}");
            }
            self.line(4, &text);
        }
    }

    async fn button(&mut self) -> Button {
        self.flush().await;
        RigPanel::button(self).await
    }
}

/// Brings pages to the glass, for ever. A screen that does not answer is asked again later; until then
/// its pages are thrown away.
pub async fn drive_screen<I: I2c>(bus: I, wires: &Wires) -> ! {
    let mut screen = Ssd1306Async::new(
        I2CDisplayInterface::new(bus),
        DisplaySize128x64,
        DisplayRotation::Rotate0,
    );
    let mut retry = Some(Instant::MIN);
    loop {
        let (number, page) = wires.pages.receive().await;
        if let Some(when) = retry {
            if Instant::now() < when {
                continue;
            }
            // Whatever was thrown away is to be drawn again.
            wires.redraw.store(true, Ordering::Relaxed);
        }
        let begin = retry.is_some();
        let sent = with_timeout(BUS_TIMEOUT, send_page(&mut screen, begin, number, &page)).await;
        retry = match sent {
            Ok(Ok(())) => None,
            _ => Some(Instant::now() + SCREEN_PAUSE),
        };
    }
}

async fn send_page<I: I2c>(
    screen: &mut Ssd1306Async<I2CInterface<I>, DisplaySize128x64, BasicMode>,
    begin: bool,
    number: u8,
    page: &Page,
) -> Result<(), DisplayError> {
    if begin {
        screen.init_with_addr_mode(AddrMode::Horizontal).await?;
    }
    let row = 8 * number;
    screen.set_draw_area((0, row), (WIDTH as u8, row + 8)).await?;
    screen.draw(page).await
}

/// The three contacts, true while pressed.
pub trait Contacts {
    /// Ok, back, next.
    fn down(&self) -> [bool; 3];
}

/// Tells presses, for ever.
pub async fn watch_buttons(contacts: impl Contacts, wires: &Wires) -> ! {
    let mut buttons = [Debounce::new(SETTLE.as_ticks()); 3];
    let mut ticker = Ticker::every(LOOK);
    loop {
        ticker.next().await;
        let now = Instant::now().as_ticks();
        let meanings = [Button::Ok, Button::Back, Button::Next];
        for ((button, down), meaning) in buttons.iter_mut().zip(contacts.down()).zip(meanings) {
            if button.feed(down, now) {
                // Four presses that nobody has answered yet are enough.
                let _ = wires.presses.try_send(meaning);
            }
        }
    }
}

/// A buzzer and a light.
pub trait Sounder {
    /// Sounds and shines, or neither.
    fn tone(&mut self, hertz: Option<u32>);
}

/// Plays cues, for ever.
pub async fn play_cues(mut sounder: impl Sounder, wires: &Wires) -> ! {
    loop {
        for &(hertz, milliseconds) in score(wires.cues.receive().await) {
            sounder.tone(Some(hertz));
            Timer::after_millis(milliseconds).await;
            sounder.tone(None);
            Timer::after_millis(40).await;
        }
    }
}

/// Tones and how long they last: rising is good, falling is bad.
fn score(cue: Cue) -> &'static [(u32, u64)] {
    match cue {
        Cue::Armed => &[(2000, 60)],
        Cue::Accepted => &[(1500, 80), (2500, 120)],
        Cue::Rejected => &[(1500, 150), (700, 350)],
        Cue::Done => &[(1000, 120), (1500, 120), (2000, 120), (3000, 300)],
        Cue::Failed => &[(700, 300), (500, 300), (350, 600)],
    }
}
