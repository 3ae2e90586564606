//! Runs the parts of the firmware that write the ADC's sequence and the flash interface, and reads the registers back
//! field by field. It is for QEMU's machine `netduinoplus2`, which has the ADC of the same family; it has no flash
//! interface, in place of which the registers are in RAM. The gate runs it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
use massline_blackpill_f411::chip;

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

    use embassy_stm32::pac::ADC1;
    use embassy_stm32::pac::flash::Flash;
    use embassy_stm32::pac::flash::regs::Acr;
    use embassy_stm32::pac::flash::vals::Latency;
    use embassy_stm32::pac::pwr::Pwr;
    use embassy_stm32::pac::rcc::Rcc;
    use embassy_stm32::pac::rcc::vals::Sw;
    use massline_blackpill_f411::chip::flash_interface::{
        drop_cached, empty_and_on, enable_caches,
    };
    use massline_blackpill_f411::chip::{internal_clock, registers, supply};
    use massline_blackpill_f411::plan::{INPUTS, RANKS};

    use super::ram_registers::RamRegisters;
    use super::read_back;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        adc();
        flash();
        clock_of_the_boot_loader();
        read_back::dead_or_alive_crystal();
        read_back::period_of_the_watchdog();
        levels_of_supply();
        debug::exit(EXIT_SUCCESS);
        unreachable!("the emulator has ended")
    }

    fn adc() {
        registers::configure();
        assert_eq!(usize::from(ADC1.sqr1().read().l()) + 1, RANKS, "length");
        for (rank, input) in INPUTS.iter().enumerate() {
            let channel = match rank {
                0..6 => ADC1.sqr3().read().sq(rank),
                6..12 => ADC1.sqr2().read().sq(rank - 6),
                _ => ADC1.sqr1().read().sq(rank - 12),
            };
            assert_eq!(u32::from(channel), input.channel, "rank {rank}");
            let time = match usize::from(channel) {
                channel @ 0..10 => ADC1.smpr2().read().smp(channel),
                channel => ADC1.smpr1().read().smp(channel - 10),
            };
            assert_eq!(time as u32, input.time, "rank {rank}");
            hprintln!("rank {} channel {} time {}", rank, channel, time as u32);
        }
        assert!(ADC1.cr1().read().scan(), "all ranks are converted");
    }

    fn flash() {
        static BLOCK: RamRegisters = RamRegisters::new();
        // SAFETY: the block is as long as the registers and is accessed as them alone.
        let flash = unsafe { Flash::from_ptr(BLOCK.address()) };
        // As the HAL leaves it for 96 MHz.
        flash.acr().write(|w| w.set_latency(Latency::WS3));
        enable_caches(flash);
        check(flash.acr().read());
        drop_cached(flash);
        check(flash.acr().read());
        let steps = empty_and_on(flash.acr().read());
        for step in steps {
            assert_eq!(step.latency(), Latency::WS3, "wait states during a change");
            let on = step.icen() || step.dcen();
            assert!(!on || !(step.icrst() || step.dcrst()), "a cache is emptied while it is on");
        }
        assert!(steps.iter().any(|step| step.icrst() && step.dcrst()), "both caches are emptied");
        hprintln!("flash interface {:#06x}", flash.acr().read().0);
    }

    fn check(register: Acr) {
        assert_eq!(register.latency(), Latency::WS3, "wait states");
        assert!(register.icen() && register.dcen() && register.prften(), "caches and prefetch");
        assert!(!(register.icrst() || register.dcrst()), "caches are not held empty");
    }

    /// What the boot loader leaves: the core runs from the PLL.
    fn clock_of_the_boot_loader() {
        static RCC: RamRegisters = RamRegisters::new();
        // SAFETY: as above.
        let rcc = unsafe { Rcc::from_ptr(RCC.address()) };
        rcc.cr().modify(|w| w.set_pllon(true));
        rcc.cfgr().modify(|w| w.set_sw(Sw::PLL1_P));
        internal_clock::select(rcc);
        assert!(rcc.cr().read().hsion() && !rcc.cr().read().pllon(), "the PLL is stopped");
        assert_eq!(rcc.cfgr().read().sw(), Sw::HSI, "the core runs from the internal oscillator");
        hprintln!("clock at the start: {:?}", rcc.cfgr().read().sw());
    }

    fn levels_of_supply() {
        static POWER: RamRegisters = RamRegisters::new();
        static FLASH: RamRegisters = RamRegisters::new();
        // SAFETY: as above.
        let (pwr, flash) =
            unsafe { (Pwr::from_ptr(POWER.address()), Flash::from_ptr(FLASH.address())) };
        supply::watch(pwr);
        assert!(pwr.cr1().read().pvde() && pwr.cr1().read().pls() == 7, "detector at 2.9 V");
        assert!(!supply::is_low(pwr));
        pwr.csr1().modify(|w| w.set_pvdo(true));
        assert!(supply::is_low(pwr));

        // As the chip is delivered: readout allowed, no sector protected, no brown-out reset.
        flash.optcr().modify(|w| {
            w.set_bor_lev(3);
            w.set_rdp(0xAA);
            w.set_n_wrp(0xFF);
            w.set_wdg_sw(true);
        });
        let mut expected = flash.optcr().read();
        assert_eq!(supply::brown_out_mv(flash), 1700);
        supply::raise(flash);
        assert_eq!(supply::brown_out_mv(flash), 2700);
        expected.set_bor_lev(0);
        expected.set_optstrt(true);
        expected.set_optlock(true);
        assert_eq!(flash.optcr().read().0, expected.0, "nothing else changes");
        flash.optcr().modify(|w| w.set_optstrt(false));
        supply::raise(flash);
        assert!(!flash.optcr().read().optstrt(), "what is there is not written again");
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
    eprintln!("This is firmware, for the test of the ADC's registers.");
    std::process::exit(2);
}
