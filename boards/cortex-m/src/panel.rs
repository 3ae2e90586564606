//! The panel: an OLED of 128 × 64 pixels, three buttons, a buzzer, and a light.
//!
//! The application never accesses the hardware itself: pages, presses and cues pass through channels to
//! separate tasks, so that a future dropped by the application leaves no transfer unfinished.

use core::cell::Cell;

use embassy_futures::join::join3;
use embassy_futures::select::{Either, select};
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Instant, Ticker, Timer};
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use massline_firmware::board::{BoardInfo, Panel, ScreenSetting};
use massline_firmware::panel::{Button, Cue};
use static_cell::StaticCell;

use crate::debounce::Debounce;
use crate::frame::{Frame, Page};
use crate::gauge;
use crate::light::flashes;
use crate::screen::{self, Pages, ScreenBus};

/// Time after which contacts have settled.
const SETTLE: Duration = Duration::from_millis(20);
/// Time between two groups of flashes.
const BETWEEN_FLASHES: Duration = Duration::from_secs(2);
/// Interval at which the buttons are polled.
const LOOK: Duration = Duration::from_millis(5);

/// Channels between the application and the tasks of the panel.
struct Wires {
    pages: Channel<CriticalSectionRawMutex, (u8, Page), 1>,
    presses: Channel<CriticalSectionRawMutex, Button, 4>,
    cues: Channel<CriticalSectionRawMutex, Cue, 4>,
    /// Signals that the screen has been switched on and has lost what was sent before.
    woken: Signal<CriticalSectionRawMutex, ()>,
    /// What the operator says of the screen.
    setting: Mutex<CriticalSectionRawMutex, Cell<ScreenSetting>>,
}

static WIRES: Wires = Wires {
    pages: Channel::new(),
    presses: Channel::new(),
    cues: Channel::new(),
    woken: Signal::new(),
    setting: Mutex::new(Cell::new(ScreenSetting::Automatic)),
};

/// The application's side of the panel.
pub struct RigPanel {
    frame: &'static mut Frame,
}

impl RigPanel {
    /// Opens the panel with a black screen. To be called once.
    pub fn open() -> Self {
        static FRAME: StaticCell<Frame> = StaticCell::new();
        Self { frame: FRAME.init_with(Frame::new) }
    }
}

/// The hardware of the panel.
pub struct Wiring<I, P, T, L> {
    /// The bus of the screen.
    pub bus: I,
    /// The buttons OK, Back and Next; each connects its pin to ground while pressed.
    pub buttons: [P; 3],
    /// The buzzer.
    pub tone: T,
    /// The light that is on while the buzzer sounds, and flashes in between: see [`light`](crate::light).
    pub light: L,
}

/// A light that is on when its pin is low.
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

/// A buzzer.
pub trait Tone {
    /// Sounds at this frequency until the next call; `None` is silence.
    fn sound(&mut self, hertz: Option<u32>);
}

impl<I: ScreenBus, P: InputPin, T: Tone, L: OutputPin> Wiring<I, P, T, L> {
    /// Serves the screen, the buttons and the buzzer; never returns.
    pub async fn run(self, info: BoardInfo) {
        join3(
            screen::drive(self.bus, &WIRES, gauge::note),
            watch_buttons(self.buttons),
            play_cues(self.tone, self.light, info),
        )
        .await;
    }
}

impl Panel for RigPanel {
    type Screen = Frame;

    fn screen(&mut self) -> &mut Frame {
        self.frame
    }

    // A page that was not sent completely is sent again.
    async fn flush(&mut self) {
        while let Some((number, page)) = self.frame.changed() {
            WIRES.pages.send((number, *page)).await;
            self.frame.sent(number);
        }
    }

    // The application waits here whenever it has nothing to draw. If the screen is switched on meanwhile,
    // the pages are sent again; if this future is dropped, the next flush sends the rest.
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

    // The columns of another controller lie elsewhere.
    fn use_screen(&mut self, setting: ScreenSetting) {
        WIRES.setting.lock(|kept| kept.set(setting));
        self.frame.change_all();
    }

    fn cue(&mut self, cue: Cue) {
        // A cue that does not fit the queue is dropped.
        let _ = WIRES.cues.try_send(cue);
    }
}

/// The channels as the screen sees them.
impl Pages for Wires {
    async fn next(&self) -> (u8, Page) {
        self.pages.receive().await
    }

    fn woken(&self) {
        self.woken.signal(());
    }

    fn setting(&self) -> ScreenSetting {
        self.setting.lock(Cell::get)
    }
}

/// Reports presses; never returns. A contact that cannot be read counts as not pressed.
async fn watch_buttons<P: InputPin>(mut contacts: [P; 3]) -> ! {
    let mut buttons = [Debounce::new(SETTLE.as_ticks()); 3];
    let mut ticker = Ticker::every(LOOK);
    loop {
        ticker.next().await;
        let now = Instant::now().as_ticks();
        let meanings = [Button::Ok, Button::Back, Button::Next];
        for ((button, contact), meaning) in buttons.iter_mut().zip(&mut contacts).zip(meanings) {
            if button.feed(contact.is_low().unwrap_or(false), now) {
                // If four presses are already waiting, further ones are dropped.
                let _ = WIRES.presses.try_send(meaning);
            }
        }
    }
}

/// Plays cues, and flashes the light without one; never returns.
async fn play_cues(mut buzzer: impl Tone, mut light: impl OutputPin, info: BoardInfo) -> ! {
    loop {
        // The light is on since the start. An error of the light is harmless.
        let _ = light.set_low();
        // A cue does not wait for the end of the flashes.
        let cue = match select(WIRES.cues.receive(), say(&mut light, &info)).await {
            Either::First(cue) => cue,
            Either::Second(()) => continue,
        };
        for &(hertz, milliseconds) in score(cue) {
            buzzer.sound(Some(hertz));
            flash(&mut light, milliseconds).await;
            buzzer.sound(None);
            Timer::after_millis(40).await;
        }
    }
}

/// Waits, and then flashes what there is to say.
async fn say(light: &mut impl OutputPin, info: &BoardInfo) {
    Timer::after(BETWEEN_FLASHES).await;
    for _ in 0..flashes(info) {
        flash(light, 150).await;
        Timer::after_millis(250).await;
    }
}

/// Switches the light on for a time.
async fn flash(light: &mut impl OutputPin, milliseconds: u64) {
    let _ = light.set_high();
    Timer::after_millis(milliseconds).await;
    let _ = light.set_low();
}

/// Frequencies and durations of the tones of a cue: rising for success, falling for failure.
fn score(cue: Cue) -> &'static [(u32, u64)] {
    match cue {
        Cue::Armed => &[(2000, 60)],
        Cue::Accepted => &[(1500, 80), (2500, 120)],
        Cue::Rejected => &[(1500, 150), (700, 350)],
        Cue::Done => &[(1000, 120), (1500, 120), (2000, 120), (3000, 300)],
        Cue::Failed => &[(700, 300), (500, 300), (350, 600)],
    }
}
