//! The part of the board's code that accesses the chip.

pub mod adc;
#[path = "../../cortex-m/stm32/crystal.rs"]
pub mod crystal;
pub mod flash_interface;
pub mod internal_clock;
mod panel;
pub mod registers;
#[path = "../../cortex-m/armv7m/stack_guard.rs"]
mod stack_guard;
pub mod supply;
mod usb;
#[path = "../../cortex-m/stm32/watchdog.rs"]
pub mod watchdog;

pub use watchdog::Watchdog;

use embassy_executor::{Executor, Spawner};
use embassy_stm32::gpio::{Input, Level, Output, Speed};
use embassy_stm32::pac::gpio::vals::Moder;
use embassy_stm32::{Config, Peripherals, flash, pac, rcc};
use massline_cortex_m::boot::ResetFlags;
use massline_cortex_m::flash::{Supervisor, Window};
use massline_cortex_m::panel::{ActiveLow, Wiring};
use massline_cortex_m::rig::{self, Rig, Watchdog as _};
use massline_cortex_m::ticks::TICK_HZ;
use massline_cortex_m::{stack, ticks};
use massline_firmware::board::Clock;
use static_cell::StaticCell;
use supply::SUPPLY;

use crate::facts::{FLASH_SELECT, NAME, STORE};
use crate::plan::{CORE_HZ, LONGEST_ERASE_US};

const _: () = assert!((CORE_HZ as u64).is_multiple_of(TICK_HZ), "the clock is exact");
const _: () = assert!(CORE_HZ as u64 / TICK_HZ <= 0x1_0000, "the prescaler has 16 bits");
const _: () = assert!(ticks::outlast(TICK_HZ, LONGEST_ERASE_US), "no time is lost in an erase");

/// The store's part of the flash.
pub type Store = Window<flash::Bank1Region1<'static, flash::Blocking>, Caches>;
/// The panel's hardware.
pub type PanelWiring =
    Wiring<panel::Bus, Input<'static>, panel::Buzzer, ActiveLow<Output<'static>>>;

/// The parts of the board.
pub struct Parts {
    /// The parts that the application uses.
    pub rig: Rig<adc::AdcSampler, usb::Link, Store, PanelWiring>,
    /// The USB device, which must be run.
    pub usb: usb::Device,
}

/// Runs the rig; never returns.
pub fn main() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    light_on();
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
    stack_guard::set();
    internal_clock::select(pac::RCC);
    let clock = crystal::start(pac::RCC);
    let info = rig::info(NAME, FLASH_SELECT, reset_flags(), clock, SUPPLY);
    let p: Peripherals = embassy_stm32::init(clocks(clock));
    supply::watch(pac::PWR);
    flash_interface::enable_caches(pac::FLASH);
    let (usb, link) = usb::open(p.USB_OTG_FS, p.PA12, p.PA11);
    let sampler = adc::sampler(adc::Parts {
        adc: p.ADC1,
        dma: p.DMA2_CH0,
        timer: p.TIM3,
        channels: (p.PA0, p.PA1, p.PA2, p.PA3, p.PA4, p.PA5, p.PA6, p.PA7, p.PB0, p.PB1),
    });
    let regions = flash::Flash::new_blocking(p.FLASH).into_blocking_regions();
    let flash = Window::new(regions.bank1_region1, STORE.start, STORE.end - STORE.start, Caches);
    let panel = Wiring {
        bus: panel::screen(p.I2C1, p.PB6, p.PB7, p.DMA1_CH6, p.DMA1_CH0),
        buttons: [panel::button(p.PB12), panel::button(p.PB13), panel::button(p.PB14)],
        tone: panel::buzzer(p.TIM4, p.PB8),
        light: ActiveLow(Output::new(p.PC13, Level::Low, Speed::Low)),
    };
    Parts { rig: Rig { info, sampler, link, flash, panel }, usb }
}

/// The caches, which know nothing of what is written.
pub struct Caches;

impl Supervisor for Caches {
    fn changed(&mut self) {
        flash_interface::drop_cached(pac::FLASH);
    }
}

/// Reads and clears the reset flags.
fn reset_flags() -> ResetFlags {
    let csr = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    ResetFlags {
        power: csr.porrstf() || csr.borrstf(),
        pin: csr.padrstf(),
        watchdog: csr.wdgrstf() || csr.wwdgrstf(),
        software: csr.sftrstf(),
    }
}

/// Switches the light on, before anything that may hang; its pin is low.
fn light_on() {
    pac::RCC.ahb1enr().modify(|w| w.set_gpiocen(true));
    // The port can be accessed two cycles later.
    cortex_m::asm::dsb();
    let _ = pac::RCC.ahb1enr().read();
    pac::GPIOC.moder().modify(|w| w.set_moder(13, Moder::OUTPUT));
}

/// Derives 96 MHz for the core and 48 MHz for USB from a crystal of 25 MHz, or from the chip's 16 MHz.
fn clocks(clock: Clock) -> Config {
    use rcc::{
        AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv,
        PllSource, Sysclk,
    };
    let mut config = Config::default();
    let prediv = match clock {
        Clock::Crystal => {
            let freq = embassy_stm32::time::mhz(25);
            config.rcc.hse = Some(Hse { freq, mode: HseMode::Oscillator });
            config.rcc.pll_src = PllSource::HSE;
            PllPreDiv::DIV25
        }
        Clock::Internal | Clock::Unknown => {
            config.rcc.pll_src = PllSource::HSI;
            PllPreDiv::DIV16
        }
    };
    config.rcc.pll = Some(Pll {
        prediv,
        mul: PllMul::MUL192,
        divp: Some(PllPDiv::DIV2),
        divq: Some(PllQDiv::DIV4),
        divr: None,
    });
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV2;
    config.rcc.apb2_pre = APBPrescaler::DIV1;
    config.rcc.sys = Sysclk::PLL1_P;
    config
}
