//! What runs on the chip.

mod adc;
mod ecc;
mod info;
mod link;
mod panel;

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, entry, exception};
use defmt_rtt as _;
use embassy_executor::{Executor, SpawnError, SpawnToken, Spawner};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, flash, rcc};
use embassy_time::{Duration, Timer};
use massline_cortex_m::flash::Window;
use massline_cortex_m::last_words;
use massline_cortex_m::panel::RigPanel;
use massline_firmware::Memory;
use massline_firmware::board::Board;
use massline_nucleo_g474re::STORE_IN_BANK_2;
use static_cell::{ConstStaticCell, StaticCell};

/// Longer than anything that the rig computes at a time; a page is erased in 25 ms.
const WATCHDOG: Duration = Duration::from_secs(8);
const WATCHDOG_FED: Duration = Duration::from_secs(1);

type RigBoard = Board<
    adc::AdcSampler,
    link::SerialLink,
    Window<flash::Bank2Region<'static, flash::Blocking>, ecc::Ecc>,
    RigPanel,
>;

#[entry]
fn main() -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let info = info::read();
    let p = embassy_stm32::init(clocks());
    defmt::info!("massline {} ({})", info.firmware, info.git_hash);
    if !info.last_panic.is_empty() {
        defmt::error!("the last run ended with: {}", info.last_panic);
    }
    let screen = panel::screen(p.I2C1, p.PA15, p.PB7, p.DMA1_CH4, p.DMA1_CH5);
    let contacts = panel::contacts(p.PB4, p.PB5, p.PB10);
    let sounder = panel::sounder(p.TIM4, p.PB6, p.PA5);
    let uart = link::Parts {
        uart: p.LPUART1,
        tx: p.PA2,
        rx: p.PA3,
        tx_dma: p.DMA1_CH2,
        rx_dma: p.DMA1_CH3,
    };
    let Ok(link) = link::open(uart) else { unreachable!("the clocks are those of this file") };
    let board = Board {
        info,
        sampler: adc::sampler(adc::Parts {
            adcs: (p.ADC1, p.ADC2),
            dma: p.DMA1_CH1,
            timer: p.TIM6,
            channels: (p.PA0, p.PA1, p.PC0, p.PC1, p.PC2, p.PC3, p.PB0, p.PA4, p.PB14, p.PA6),
        }),
        link,
        flash: Window::checked(
            flash::Flash::new_blocking(p.FLASH).into_blocking_regions().bank2_region,
            STORE_IN_BANK_2.start,
            STORE_IN_BANK_2.end - STORE_IN_BANK_2.start,
            ecc::Ecc,
        ),
        panel: RigPanel::new(panel::wires()),
    };
    let mut watchdog = IndependentWatchdog::new(p.IWDG, WATCHDOG.as_micros() as u32);
    watchdog.unleash();
    EXECUTOR.init(Executor::new()).run(|spawner| {
        start(spawner, feed(watchdog));
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

/// The board's crystal of 24 MHz makes 170 MHz.
fn clocks() -> Config {
    use rcc::{Hse, HseMode, Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: embassy_stm32::time::mhz(24), mode: HseMode::Oscillator });
    config.rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: PllPreDiv::DIV6,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    config
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    defmt::error!("{}", defmt::Display2Format(info));
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
