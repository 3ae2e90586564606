//! Runs the part of the firmware that writes the ADC's sequence, and reads the registers back field by
//! field. It is for QEMU's machine `netduinoplus2`, which has the ADC of the same family; the gate runs it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod firmware {
    use core::panic::PanicInfo;

    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use embassy_stm32::pac::ADC1;
    use massline_blackpill_f411::chip::registers;
    use massline_blackpill_f411::plan::{INPUTS, RANKS};

    #[cortex_m_rt::entry]
    fn main() -> ! {
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
        debug::exit(EXIT_SUCCESS);
        unreachable!("the emulator has ended")
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
