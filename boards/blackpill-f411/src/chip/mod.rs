//! What runs on the chip.

mod adc;
mod info;
mod panel;
mod registers;
mod usb;

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, entry, exception};
use embassy_executor::{Executor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, flash, rcc};
use embassy_time::{Duration, Timer};
use massline_blackpill_f411::STORE;
use massline_cortex_m::flash::Window;
use massline_cortex_m::last_words;
use massline_cortex_m::panel::RigPanel;
use massline_firmware::Memory;
use massline_firmware::board::Board;
use static_cell::{ConstStaticCell, StaticCell};

/// Longer than any sector of the store takes to be erased, during which nothing runs: 0.8 s at most.
const WATCHDOG: Duration = Duration::from_secs(8);
const WATCHDOG_FED: Duration = Duration::from_secs(1);

type RigBoard = Board<
    adc::AdcSampler,
    usb::Link,
    Window<flash::Bank1Region1<'static, flash::Blocking>>,
    RigPanel,
>;

#[entry]
fn main() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let info = info::read();
    let p = embassy_stm32::init(clocks());
    let (device, link) = usb::open(p.USB_OTG_FS, p.PA12, p.PA11);
    let screen = panel::screen(p.I2C1, p.PB6, p.PB7, p.DMA1_CH6, p.DMA1_CH0);
    let contacts = panel::contacts(p.PB12, p.PB13, p.PB14);
    let sounder = panel::sounder(p.TIM4, p.PB8, p.PC13);
    let board = Board {
        info,
        sampler: adc::sampler(adc::Parts {
            adc: p.ADC1,
            dma: p.DMA2_CH0,
            timer: p.TIM3,
            channels: (p.PA0, p.PA1, p.PA2, p.PA3, p.PA4, p.PA5, p.PA6, p.PA7, p.PB0, p.PB1),
        }),
        link,
        flash: Window::new(
            flash::Flash::new_blocking(p.FLASH).into_blocking_regions().bank1_region1,
            STORE.start,
            STORE.end - STORE.start,
        ),
        panel: RigPanel::new(panel::wires()),
    };
    let mut watchdog = IndependentWatchdog::new(p.IWDG, WATCHDOG.as_micros() as u32);
    watchdog.unleash();
    EXECUTOR.init(Executor::new()).run(|spawner| {
        start(spawner, feed(watchdog));
        start(spawner, usb::run(device));
        start(spawner, panel::show(screen));
        start(spawner, panel::watch(contacts));
        start(spawner, panel::play(sounder));
        start(spawner, rig(board));
    })
}

fn start<S>(spawner: Spawner, task: Result<SpawnToken<S>, SpawnError>) {
    match task {
        Ok(token) => spawner.spawn(token),
        Err(_) => unreachable!("every task is spawned once"),
    }
}

#[embassy_executor::task]
async fn rig(board: RigBoard) {
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
    massline_firmware::run(board, MEMORY.take()).await;
}

/// The executor comes round: the rig is alive.
#[embassy_executor::task]
async fn feed(mut watchdog: IndependentWatchdog<'static, IWDG>) {
    loop {
        watchdog.pet();
        Timer::after(WATCHDOG_FED).await;
    }
}

/// A crystal of 25 MHz makes 96 MHz for the core and 48 MHz for USB.
fn clocks() -> Config {
    use rcc::{
        AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv,
        PllSource, Sysclk,
    };
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: embassy_stm32::time::mhz(25), mode: HseMode::Oscillator });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV25,
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

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    last_words::panicked(info)
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    last_words::hard_fault(frame)
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    panic!("interrupt {number} has no handler");
}
