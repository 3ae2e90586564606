//! Overflows the stack of an emulated Cortex-M33, whose start-up code has set the limit of the stack pointer as that of
//! a Pico 2 does: the core faults at the limit, and the message of the fault is the one that the next start would
//! report.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod overflow;

#[cfg(target_os = "none")]
massline_cortex_m::last_words!(firmware::finish);

#[cfg(target_os = "none")]
mod firmware {
    use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
    use cortex_m_semihosting::hprintln;
    use massline_cortex_m::last_words;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        crate::overflow::overflow()
    }

    /// Ends the emulator; it has succeeded when the overflow was noticed.
    pub fn finish() -> ! {
        let words = last_words::take();
        hprintln!("{}", words);
        let is_noticed = words == "the stack has overflowed";
        debug::exit(if is_noticed { EXIT_SUCCESS } else { EXIT_FAILURE });
        loop {
            cortex_m::asm::nop();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is firmware, for the tests of the emulated rig.");
    std::process::exit(2);
}
