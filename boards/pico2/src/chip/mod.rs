//! What runs on the chip.

pub mod adc;
mod panel;
mod usb;

use embassy_executor::{Executor, Spawner};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::gpio::{Input, Level, Output};
use embassy_rp::pac;
use embassy_rp::peripherals::FLASH;
use embassy_rp::watchdog::Watchdog;
use massline_cortex_m::boot::ResetFlags;
use massline_cortex_m::flash::Window;
use massline_cortex_m::panel::Wiring;
use massline_cortex_m::rig::{self, Rig, WATCHDOG};
use static_cell::StaticCell;

use crate::facts::{FLASH_BYTES, NAME, STORE};

/// The store's part of the flash. Words are bytes, pages 4 KiB. While something is written (3 ms at most for
/// what the store writes at a time) or erased (400 ms at most) nothing else runs, because code is fetched
/// from the same chip.
pub type Store = Window<Flash<'static, FLASH, Blocking, { FLASH_BYTES as usize }>>;
/// The panel's wires.
pub type PanelWiring = Wiring<panel::Bus, Input<'static>, panel::Buzzer, Output<'static>>;

/// Everything that the board has.
pub struct Parts {
    /// What the application needs.
    pub rig: Rig<adc::AdcSampler, usb::Link, Store, PanelWiring>,
    /// Answers the host's bus.
    pub usb: usb::Device,
    /// Sleeps.
    pub watchdog: WholeWatchdog,
}

/// Starts the whole chip again.
pub struct WholeWatchdog(Watchdog);

impl rig::Watchdog for WholeWatchdog {
    fn start(&mut self) {
        self.0.start(WATCHDOG);
        watchdog_resets_all();
    }

    fn feed(&mut self) {
        self.0.feed(WATCHDOG);
    }
}

/// Runs the rig.
pub fn main() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let parts = parts();
    EXECUTOR.init(Executor::new()).run(|spawner: Spawner| match run(parts) {
        Ok(token) => spawner.spawn(token),
        Err(_) => unreachable!("it is spawned once"),
    })
}

#[embassy_executor::task]
async fn run(parts: Parts) {
    let Parts { rig, mut usb, watchdog } = parts;
    rig.run(watchdog, usb.run()).await;
}

/// Starts the chip. To be called once.
pub fn parts() -> Parts {
    let info = rig::info(NAME, reset_flags());
    let p = embassy_rp::init(Default::default());
    let (usb, link) = usb::open(p.USB);
    let sampler = adc::sampler(adc::Parts {
        pio: p.PIO0,
        dma: (p.DMA_CH0, p.DMA_CH1, p.DMA_CH2, p.DMA_CH3),
        data_out: p.PIN_16,
        data_in: p.PIN_17,
        clock: p.PIN_18,
        select: p.PIN_19,
    });
    let flash = Window::new(Flash::new_blocking(p.FLASH), STORE.start, STORE.end - STORE.start);
    let panel = Wiring {
        bus: panel::screen(p.I2C0, p.PIN_5, p.PIN_4),
        buttons: [panel::button(p.PIN_10), panel::button(p.PIN_11), panel::button(p.PIN_12)],
        tone: panel::buzzer(p.PWM_SLICE7, p.PIN_14),
        light: Output::new(p.PIN_25, Level::Low),
    };
    Parts {
        rig: Rig { info, sampler, link, flash, panel },
        usb,
        watchdog: WholeWatchdog(Watchdog::new(p.WATCHDOG)),
    }
}

/// Starts the whole chip again, by the watchdog: the core's own request would leave all else as it is.
pub fn restart() -> ! {
    watchdog_resets_all();
    pac::WATCHDOG.ctrl().write(|w| w.set_trigger(true));
    loop {
        cortex_m::asm::nop();
    }
}

/// All but the oscillators.
fn watchdog_resets_all() {
    let mut stages = pac::psm::regs::Wdsel(0x01FF_FFFF);
    stages.set_rosc(false);
    stages.set_xosc(false);
    pac::PSM.wdsel().write_value(stages);
}

/// What the reset has left. What is said of the supply and the pin is of the last reset of the whole chip,
/// and stays when the watchdog, of which `restart` makes use, starts it again.
fn reset_flags() -> ResetFlags {
    let watchdog = pac::WATCHDOG.reason().read();
    let whole = !watchdog.timer() && !watchdog.force();
    let reset = pac::POWMAN.chip_reset().read();
    ResetFlags {
        power: whole && (reset.had_por() || reset.had_bor()),
        pin: whole && reset.had_run_low(),
        watchdog: watchdog.timer(),
        software: watchdog.force(),
    }
}
