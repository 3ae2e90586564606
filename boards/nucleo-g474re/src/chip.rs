//! The part of the board's code that accesses the chip.

pub mod adc;
#[path = "../../cortex-m/stm32/crystal.rs"]
pub mod crystal;
mod ecc;
mod panel;
mod serial;
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
use embassy_stm32::{Config, flash, pac, rcc};
use massline_cortex_m::boot::ResetFlags;
use massline_cortex_m::flash::Window;
use massline_cortex_m::panel::Wiring;
use massline_cortex_m::rig::{self, Rig, Watchdog as _};
use massline_cortex_m::twin::{ActiveLink, TwinLink};
use massline_cortex_m::{stack, ticks};
use massline_firmware::board::Clock;
use static_cell::StaticCell;
use supply::SUPPLY;

use crate::STORE_IN_BANK_2;
use crate::facts::{FLASH_SELECT, NAME};
use crate::plan::LONGEST_ERASE_US;

const _: () =
    assert!(ticks::outlast(ticks::TICK_HZ, LONGEST_ERASE_US), "no time is lost in an erase");

/// The store's part of the flash.
pub type Store = Window<flash::Bank2Region<'static, flash::Blocking>, ecc::Ecc>;
/// The link: the ST-LINK's serial port, until the host sends something over USB.
pub type Link = TwinLink<serial::SerialLink, usb::Link>;
/// The panel's hardware.
pub type PanelWiring = Wiring<panel::Bus, Input<'static>, panel::Buzzer, Output<'static>>;

/// The parts of the board.
pub struct Parts {
    /// The parts that the application uses.
    pub rig: Rig<adc::AdcSampler, Link, Store, PanelWiring>,
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
    static USED: ActiveLink = ActiveLink::new();
    stack_guard::set();
    let clock = crystal::start(pac::RCC);
    let info = rig::info(NAME, FLASH_SELECT, reset_flags(), clock, SUPPLY);
    let p = embassy_stm32::init(clocks(clock));
    supply::watch(pac::PWR);
    let serial = serial::open(serial::Parts {
        uart: p.LPUART1,
        tx: p.PA2,
        rx: p.PA3,
        tx_dma: p.DMA1_CH2,
        rx_dma: p.DMA1_CH3,
    });
    let Ok(serial) = serial else { unreachable!("the clocks are those of this file") };
    let (usb, usb_link) = usb::open(p.USB, p.PA12, p.PA11);
    let sampler = adc::sampler(adc::Parts {
        adcs: (p.ADC1, p.ADC2),
        dma: p.DMA1_CH1,
        timer: p.TIM6,
        channels: (p.PA0, p.PA1, p.PC0, p.PC1, p.PC2, p.PC3, p.PB0, p.PA4, p.PB14, p.PA6),
        spare: p.PA7,
    });
    let flash = Window::new(
        flash::Flash::new_blocking(p.FLASH).into_blocking_regions().bank2_region,
        STORE_IN_BANK_2.start,
        STORE_IN_BANK_2.end - STORE_IN_BANK_2.start,
        ecc::Ecc,
    );
    let panel = Wiring {
        bus: panel::screen(p.I2C1, p.PA15, p.PB7, p.DMA1_CH4, p.DMA1_CH5),
        buttons: [panel::button(p.PB4), panel::button(p.PB5), panel::button(p.PB10)],
        tone: panel::buzzer(p.TIM4, p.PB6),
        light: Output::new(p.PA5, Level::High, Speed::Low),
    };
    Parts {
        rig: Rig { info, sampler, link: TwinLink::new(serial, usb_link, &USED), flash, panel },
        usb,
    }
}

/// Reads and clears the reset flags.
fn reset_flags() -> ResetFlags {
    let csr = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    ResetFlags {
        power: csr.borrstf(),
        pin: csr.pinrstf(),
        watchdog: csr.iwdgrstf() || csr.wwdgrstf(),
        software: csr.sftrstf(),
    }
}

/// Switches the light on, before anything that may hang.
fn light_on() {
    pac::RCC.ahb2enr().modify(|w| w.set_gpioaen(true));
    // The port can be accessed two cycles later.
    cortex_m::asm::dsb();
    let _ = pac::RCC.ahb2enr().read();
    pac::GPIOA.moder().modify(|w| w.set_moder(5, Moder::OUTPUT));
    pac::GPIOA.bsrr().write(|w| w.set_bs(5, true));
}

/// Derives 170 MHz from the board's crystal of 24 MHz, or from the chip's 16 MHz. USB has its own 48 MHz oscillator,
/// synchronised to the host's frames.
fn clocks(clock: Clock) -> Config {
    use rcc::mux::Clk48sel;
    use rcc::{Hse, HseMode, Hsi48Config, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
    let mut config = Config::default();
    let (source, prediv) = match clock {
        Clock::Crystal => {
            let freq = embassy_stm32::time::mhz(24);
            config.rcc.hse = Some(Hse { freq, mode: HseMode::Oscillator });
            (PllSource::HSE, PllPreDiv::DIV6)
        }
        Clock::Internal | Clock::Unknown => {
            config.rcc.hsi = true;
            (PllSource::HSI, PllPreDiv::DIV4)
        }
    };
    config.rcc.pll = Some(Pll {
        source,
        prediv,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    config.rcc.hsi48 = Some(Hsi48Config { sync_from_usb: true });
    config.rcc.mux.clk48sel = Clk48sel::HSI48;
    config
}
