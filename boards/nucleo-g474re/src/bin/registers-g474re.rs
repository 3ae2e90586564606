//! Runs the parts of the firmware that write the registers of clock, watchdog and supply, and reads them back. No
//! emulated machine has these peripherals: the registers are in RAM, on QEMU's machine `netduinoplus2`. The gate runs
//! it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use massline_nucleo_g474re::chip;

#[cfg(target_os = "none")]
#[path = "../../../cortex-m/stm32/ram_registers.rs"]
mod ram_registers;
#[cfg(target_os = "none")]
#[path = "../../../cortex-m/stm32/read_back.rs"]
mod read_back;

#[cfg(target_os = "none")]
mod firmware {
    use core::panic::PanicInfo;

    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use embassy_stm32::pac::flash::Flash;
    use embassy_stm32::pac::pwr::Pwr;
    use massline_nucleo_g474re::chip::supply;

    use super::ram_registers::RamRegisters;
    use super::read_back;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        read_back::dead_or_alive_crystal();
        read_back::period_of_the_watchdog();
        levels_of_supply();
        debug::exit(EXIT_SUCCESS);
        unreachable!("the emulator has ended")
    }

    fn levels_of_supply() {
        static POWER: RamRegisters = RamRegisters::new();
        static FLASH: RamRegisters = RamRegisters::new();
        // SAFETY: each block is accessed as the registers of its peripheral alone.
        let (pwr, flash) =
            unsafe { (Pwr::from_ptr(POWER.address()), Flash::from_ptr(FLASH.address())) };
        supply::watch(pwr);
        assert!(pwr.cr2().read().pvde() && pwr.cr2().read().pls() == 6, "detector at 2.9 V");
        assert!(!supply::is_low(pwr));
        let mut status = pwr.sr2().read();
        status.set_pvdo(true);
        // SAFETY: as above; the chip's own register can only be read.
        unsafe { pwr.sr2().as_ptr().write_volatile(status) };
        assert!(supply::is_low(pwr));

        // As the chip is delivered: readout allowed, two banks, no brown-out reset.
        flash.optr().modify(|w| {
            w.set_rdp(0xAA.into());
            w.set_dbank(true);
            w.set_bor_lev(0);
        });
        let mut expected = flash.optr().read();
        assert_eq!(supply::brown_out_mv(flash), 1700);
        supply::raise(flash);
        assert_eq!(supply::brown_out_mv(flash), 2800);
        expected.set_bor_lev(4);
        assert_eq!(flash.optr().read().0, expected.0, "nothing else changes");
        let control = flash.cr().read();
        assert!(control.optstrt() && control.optlock() && control.lock(), "written, then locked");
        flash.cr().modify(|w| w.set_optstrt(false));
        supply::raise(flash);
        assert!(!flash.cr().read().optstrt(), "what is there is not written again");
        hprintln!("brown-out level: {} mV", supply::brown_out_mv(flash));
    }

    #[panic_handler]
    fn panic(info: &PanicInfo<'_>) -> ! {
        hprintln!("{}", info);
        debug::exit(EXIT_FAILURE);
        loop {
            cortex_m::asm::wfi();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is firmware, for the test of registers.");
    std::process::exit(2);
}
