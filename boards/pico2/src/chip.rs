//! The part of the board's code that accesses the chip.

pub mod adc;
mod crystal;
mod panel;
mod supply;
mod usb;

use embassy_executor::{Executor, Spawner};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::gpio::{Input, Level, Output};
use embassy_rp::pac;
use embassy_rp::peripherals::FLASH;
use massline_cortex_m::boot::ResetFlags;
use massline_cortex_m::flash::{NoSupervisor, Window};
use massline_cortex_m::panel::Wiring;
use massline_cortex_m::rig::{self, Rig, WATCHDOG, Watchdog as _};
use massline_firmware::board::{BoardInfo, Clock};
use static_cell::StaticCell;
use supply::SUPPLY;

use crate::facts::{FLASH_BYTES, FLASH_SELECT, NAME, STORE};

/// The store's part of the flash. A word is a byte, a page 4 KiB. During a write (3 ms at most for what the
/// store writes at a time) or an erase (400 ms at most) nothing else runs, because code is fetched from the
/// same chip.
pub type Store = Window<Flash<'static, FLASH, Blocking, { FLASH_BYTES as usize }>, NoSupervisor>;
/// The panel's hardware.
pub type PanelWiring = Wiring<panel::Bus, Input<'static>, panel::Buzzer, Output<'static>>;

/// The parts of the board.
pub struct Parts {
    /// The parts that the application uses.
    pub rig: Rig<adc::AdcSampler, usb::Link, Store, PanelWiring>,
    /// The USB device, which must be run.
    pub usb: usb::Device,
}

/// The watchdog, which resets the whole chip.
pub struct Watchdog;

impl rig::Watchdog for Watchdog {
    fn start() {
        watchdog_resets_all();
        // It counts microseconds; until the clocks are set up, cycles of the ring oscillator, of 24 MHz at most.
        pac::TICKS.watchdog_cycles().write(|w| w.0 = 24);
        pac::TICKS.watchdog_ctrl().write(|w| w.set_enable(true));
        Self::feed();
        pac::WATCHDOG.ctrl().modify(|w| w.set_enable(true));
    }

    fn feed() {
        pac::WATCHDOG.load().write(|w| w.set_load(WATCHDOG.as_micros() as u32));
    }
}

/// Runs the rig; never returns.
pub fn main() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    Watchdog::start();
    let parts = parts();
    EXECUTOR.init(Executor::new()).run(|spawner: Spawner| match run(parts) {
        Ok(token) => spawner.spawn(token),
        Err(_) => unreachable!("it is spawned once"),
    })
}

#[embassy_executor::task]
async fn run(parts: Parts) {
    let Parts { rig, mut usb } = parts;
    // Built in its place: before it is moved there it would lie on the stack of whoever polls it, for ever.
    core::pin::pin!(rig.run::<Watchdog>(usb.run())).await;
}

/// Initialises the chip. To be called once.
pub fn parts() -> Parts {
    if !crystal::starts() {
        crystal::blink_forever::<Watchdog>();
    }
    let info = rig::info(NAME, FLASH_SELECT, reset_flags(), Clock::Crystal, SUPPLY);
    let info = BoardInfo { converter_fault: adc::fault, ..info };
    let p = embassy_rp::init(Default::default());
    supply::watch(supply::Parts { adc: p.ADC, vsys: p.PIN_29, constant_rate: p.PIN_23 });
    let (usb, link) = usb::open(p.USB);
    let sampler = adc::sampler(adc::Parts {
        pio: p.PIO0,
        dma: (p.DMA_CH0, p.DMA_CH1, p.DMA_CH2, p.DMA_CH3),
        data_out: p.PIN_16,
        data_in: p.PIN_17,
        clock: p.PIN_18,
        select: p.PIN_19,
    });
    let flash = Window::new(
        Flash::new_blocking(p.FLASH),
        STORE.start,
        STORE.end - STORE.start,
        NoSupervisor,
    );
    let panel = Wiring {
        bus: panel::Bus { i2c: p.I2C0, clock: p.PIN_5, data: p.PIN_4 },
        buttons: [panel::button(p.PIN_10), panel::button(p.PIN_11), panel::button(p.PIN_12)],
        tone: panel::buzzer(p.PWM_SLICE7, p.PIN_14),
        light: Output::new(p.PIN_25, Level::High),
    };
    Parts { rig: Rig { info, sampler, link, flash, panel }, usb }
}

/// Restarts the whole chip through the watchdog: a reset requested by the core would not reset the rest of
/// the chip.
pub fn restart() -> ! {
    watchdog_resets_all();
    pac::WATCHDOG.ctrl().write(|w| w.set_trigger(true));
    loop {
        cortex_m::asm::nop();
    }
}

/// Makes the watchdog reset everything except the oscillators.
fn watchdog_resets_all() {
    let mut stages = pac::psm::regs::Wdsel(0x01FF_FFFF);
    stages.set_rosc(false);
    stages.set_xosc(false);
    pac::PSM.wdsel().write_value(stages);
}

/// Reads the reset flags. Those of the supply and the pin are from the last reset of the whole chip; they
/// persist when the watchdog, which `restart` uses, resets the chip.
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
