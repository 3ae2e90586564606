//! The panel: an OLED of 128 × 64 pixels with an SSD1306, three buttons, a buzzer with a light.
//!
//! The application's part never waits for a wire: pages, presses and cues go over channels to tasks of
//! their own, so whatever the application gives up leaves no transfer half done.

use embassy_futures::join::join3;
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Ticker, Timer, with_deadline, with_timeout};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::i2c::I2c;
use massline_firmware::board::Panel;
use massline_firmware::panel::{Button, Cue};
use ssd1306::command::AddrMode;
use ssd1306::mode::BasicMode;
use ssd1306::prelude::{DisplayRotation, I2CInterface};
use ssd1306::size::DisplaySize128x64;
use ssd1306::{I2CDisplayInterface, Ssd1306Async};
use static_cell::StaticCell;

use crate::debounce::Debounce;
use crate::frame::{Frame, Page, WIDTH};

type DisplayError = display_interface::DisplayError;

/// Contacts have settled after this.
const SETTLE: Duration = Duration::from_millis(20);
/// Buttons are looked at so often.
const LOOK: Duration = Duration::from_millis(5);
/// A page takes 3 ms at 400 kHz; a bus that takes longer hangs.
const BUS_TIMEOUT: Duration = Duration::from_millis(50);
/// A screen that did not answer is tried again after this, and each time after twice as long: its supply
/// may rise more slowly than the chip's.
const SHORTEST_PAUSE: Duration = Duration::from_millis(100);
/// After at most this.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);

/// Between the application and the tasks of the panel.
struct Wires {
    pages: Channel<CriticalSectionRawMutex, (u8, Page), 1>,
    presses: Channel<CriticalSectionRawMutex, Button, 4>,
    cues: Channel<CriticalSectionRawMutex, Cue, 4>,
    /// The screen has been switched on: it shows nothing that was sent before.
    woken: Signal<CriticalSectionRawMutex, ()>,
}

static WIRES: Wires = Wires {
    pages: Channel::new(),
    presses: Channel::new(),
    cues: Channel::new(),
    woken: Signal::new(),
};

/// The application's end.
pub struct RigPanel {
    frame: &'static mut Frame,
}

impl RigPanel {
    /// A black screen. To be called once.
    pub fn open() -> Self {
        static FRAME: StaticCell<Frame> = StaticCell::new();
        Self { frame: FRAME.init_with(Frame::new) }
    }
}

/// What the panel is wired to.
pub struct Wiring<I, P, T, L> {
    /// The bus of the screen.
    pub bus: I,
    /// Ok, back, next: each to ground while pressed.
    pub buttons: [P; 3],
    /// The buzzer.
    pub tone: T,
    /// The light that shines while the buzzer sounds.
    pub light: L,
}

/// A light that shines when its pin is low.
pub struct ActiveLow<P>(pub P);

impl<P: OutputPin> ErrorType for ActiveLow<P> {
    type Error = P::Error;
}

impl<P: OutputPin> OutputPin for ActiveLow<P> {
    fn set_low(&mut self) -> Result<(), P::Error> {
        self.0.set_high()
    }

    fn set_high(&mut self) -> Result<(), P::Error> {
        self.0.set_low()
    }
}

/// Something that sounds.
pub trait Tone {
    /// Sounds until it is told something else; `None` is silence.
    fn sound(&mut self, hertz: Option<u32>);
}

impl<I: I2c, P: InputPin, T: Tone, L: OutputPin> Wiring<I, P, T, L> {
    /// Serves the screen, the buttons and the buzzer, for ever.
    pub async fn run(self) {
        join3(
            drive_screen(self.bus),
            watch_buttons(self.buttons),
            play_cues(self.tone, self.light),
        )
        .await;
    }
}

impl Panel for RigPanel {
    type Screen = Frame;

    fn screen(&mut self) -> &mut Frame {
        self.frame
    }

    // A page is sent whole or again.
    async fn flush(&mut self) {
        while let Some((number, page)) = self.frame.changed() {
            WIRES.pages.send((number, *page)).await;
            self.frame.sent(number);
        }
    }

    // The application waits here whenever it has nothing to draw: what a screen that has just woken
    // missed is sent meanwhile. When that is given up, the next flush sends the rest.
    async fn button(&mut self) -> Button {
        loop {
            match select(WIRES.presses.receive(), WIRES.woken.wait()).await {
                Either::First(button) => return button,
                Either::Second(()) => {
                    self.frame.change_all();
                    self.flush().await;
                }
            }
        }
    }

    fn cue(&mut self, cue: Cue) {
        // One too many is not heard.
        let _ = WIRES.cues.try_send(cue);
    }
}

type Screen<I> = Ssd1306Async<I2CInterface<I>, DisplaySize128x64, BasicMode>;

/// Brings pages to the screen, for ever. While the screen does not answer its pages are thrown away; it is
/// asked again later.
async fn drive_screen<I: I2c>(bus: I) -> ! {
    let interface = I2CDisplayInterface::new(bus);
    let mut screen = Ssd1306Async::new(interface, DisplaySize128x64, DisplayRotation::Rotate0);
    loop {
        wake(&mut screen).await;
        WIRES.woken.signal(());
        let mut shown = true;
        while shown {
            let (number, page) = WIRES.pages.receive().await;
            let sent = with_timeout(BUS_TIMEOUT, send_page(&mut screen, number, &page)).await;
            shown = matches!(sent, Ok(Ok(())));
        }
    }
}

/// Switches the screen on, as soon as it answers.
async fn wake<I: I2c>(screen: &mut Screen<I>) {
    let mut pause = SHORTEST_PAUSE;
    loop {
        let begun = screen.init_with_addr_mode(AddrMode::Horizontal);
        if let Ok(Ok(())) = with_timeout(BUS_TIMEOUT, begun).await {
            return;
        }
        let again = Instant::now() + pause;
        while with_deadline(again, WIRES.pages.receive()).await.is_ok() {}
        pause = (pause * 2).min(LONGEST_PAUSE);
    }
}

async fn send_page<I: I2c>(
    screen: &mut Screen<I>,
    number: u8,
    page: &Page,
) -> Result<(), DisplayError> {
    let row = 8 * number;
    screen.set_draw_area((0, row), (WIDTH as u8, row + 8)).await?;
    screen.draw(page).await
}

/// Tells presses, for ever. A contact that cannot be read is not pressed.
async fn watch_buttons<P: InputPin>(mut contacts: [P; 3]) -> ! {
    let mut buttons = [Debounce::new(SETTLE.as_ticks()); 3];
    let mut ticker = Ticker::every(LOOK);
    loop {
        ticker.next().await;
        let now = Instant::now().as_ticks();
        let meanings = [Button::Ok, Button::Back, Button::Next];
        for ((button, contact), meaning) in buttons.iter_mut().zip(&mut contacts).zip(meanings) {
            if button.feed(contact.is_low().unwrap_or(false), now) {
                // Four presses that nobody has answered yet are enough.
                let _ = WIRES.presses.try_send(meaning);
            }
        }
    }
}

/// Plays cues, for ever.
async fn play_cues(mut buzzer: impl Tone, mut light: impl OutputPin) -> ! {
    loop {
        for &(hertz, milliseconds) in score(WIRES.cues.receive().await) {
            buzzer.sound(Some(hertz));
            // A light that cannot be switched is only a light.
            let _ = light.set_high();
            Timer::after_millis(milliseconds).await;
            buzzer.sound(None);
            let _ = light.set_low();
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
