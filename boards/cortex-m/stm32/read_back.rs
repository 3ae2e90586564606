//! Starts crystal and watchdog on registers in RAM and reads these back. A test of registers includes this file and
//! names the chip's modules `chip`.

use cortex_m_semihosting::hprintln;
use embassy_stm32::pac::iwdg::Iwdg;
use embassy_stm32::pac::iwdg::vals::Pr;
use embassy_stm32::pac::rcc::Rcc;
use massline_firmware::board::Clock;

use super::chip::{crystal, watchdog};
use super::ram_registers::RamRegisters;

/// Without the limit of `start`, the first of these would never end.
pub fn dead_or_alive_crystal() {
    static RCC: RamRegisters = RamRegisters::new();
    // SAFETY: the block is as long as the registers and is accessed as them alone.
    let rcc = unsafe { Rcc::from_ptr(RCC.address()) };
    assert_eq!(crystal::start(rcc), Clock::Internal, "a dead crystal");
    assert!(!rcc.cr().read().hseon(), "a dead crystal is switched off");
    rcc.cr().modify(|w| w.set_hserdy(true));
    assert_eq!(crystal::start(rcc), Clock::Crystal, "a crystal that oscillates");
    assert!(rcc.cr().read().hseon(), "it is switched on");
    hprintln!("crystal: {:?}", crystal::start(rcc));
}

pub fn period_of_the_watchdog() {
    static WATCHDOG: RamRegisters = RamRegisters::new();
    // SAFETY: as above.
    let iwdg = unsafe { Iwdg::from_ptr(WATCHDOG.address()) };
    watchdog::start(iwdg);
    let (divider, reload) = (iwdg.pr().read().pr(), iwdg.rlr().read().rl());
    assert_eq!(divider, Pr::DIVIDE_BY64, "divider");
    // 64 * 4000 / 32 kHz
    assert_eq!(reload, 3999, "a period of 8 s");
    hprintln!("watchdog: {} periods of 2 ms", u32::from(reload) + 1);
}
