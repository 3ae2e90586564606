//! Firmware that panics at once. Tests use it to verify that a panic of the rig makes QEMU exit with a
//! failure, and that the host reports the panic message.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[macro_use]
#[path = "../../../cortex-m/src/hard_fault.rs"]
mod hard_fault;
#[cfg(target_os = "none")]
#[path = "../chip/fault.rs"]
mod fault;
#[cfg(target_os = "none")]
#[path = "../chip/registers.rs"]
#[allow(dead_code, reason = "only the UART of the last words is used here")]
mod registers;
#[cfg(target_os = "none")]
#[path = "../../../cortex-m/src/stack.rs"]
#[allow(dead_code, reason = "only the place of the stack is used here")]
mod stack;

#[cfg(target_os = "none")]
mod firmware {
    #[cortex_m_rt::entry]
    fn main() -> ! {
        panic!("these are the last words")
    }

    // The linker script requires the table, although no interrupt is ever enabled.
    #[unsafe(link_section = ".vector_table.interrupts")]
    #[unsafe(no_mangle)]
    static __INTERRUPTS: [usize; 32] = [0; 32];
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("This is firmware, for the tests of the emulated rig.");
    std::process::exit(2);
}
