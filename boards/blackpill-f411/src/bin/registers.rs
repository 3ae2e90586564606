//! Runs the parts of the firmware that write the ADC's sequence and the flash interface, and reads the registers back field
//! by field. It is for QEMU's machine `netduinoplus2`, which has the ADC of the same family; it has no flash interface, in
//! place of which the registers are in RAM. The gate runs it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::panic::PanicInfo;

    use core::cell::UnsafeCell;
    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;

    use embassy_stm32::pac::ADC1;
    use embassy_stm32::pac::flash::Flash;
    use embassy_stm32::pac::flash::regs::Acr;
    use embassy_stm32::pac::flash::vals::Latency;
    use massline_blackpill_f411::chip::flash_interface::{
        drop_cached, empty_and_on, enable_caches,
    };
    use massline_blackpill_f411::chip::registers;
    use massline_blackpill_f411::plan::{INPUTS, RANKS};

    #[cortex_m_rt::entry]
    fn main() -> ! {
        adc();
        flash();
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

    /// Registers of the flash interface in RAM.
    struct Block(UnsafeCell<[u32; 8]>);

    // SAFETY: one thread runs.
    unsafe impl Sync for Block {}

    fn flash() {
        static BLOCK: Block = Block(UnsafeCell::new([0; 8]));
        // SAFETY: the block is as long as the registers and is accessed as them alone.
        let flash = unsafe { Flash::from_ptr(BLOCK.0.get().cast()) };
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
