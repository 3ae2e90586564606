//! Firmware that overflows its stack. Tests use it to verify that the guard of the stack turns that into a fault with a
//! name before any static has changed.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[macro_use]
#[path = "../../../cortex-m/src/hard_fault.rs"]
mod hard_fault;
#[cfg(target_os = "none")]
#[path = "../chip/fault.rs"]
mod fault;
#[cfg(target_os = "none")]
#[path = "../../../../tests/stack-limit/src/overflow.rs"]
mod overflow;
#[cfg(target_os = "none")]
#[path = "../chip/registers.rs"]
#[allow(dead_code, reason = "only the UART of the last words is used here")]
mod registers;
#[cfg(target_os = "none")]
#[path = "../../../cortex-m/src/stack.rs"]
#[allow(dead_code, reason = "only the place of the stack is used here")]
mod stack;

#[cfg(target_os = "none")]
#[path = "../../../cortex-m/armv7m/stack_guard.rs"]
mod stack_guard;

#[cfg(target_os = "none")]
mod firmware {
    #[cortex_m_rt::entry]
    fn main() -> ! {
        super::stack_guard::set();
        super::overflow::overflow()
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
