//! Firmware that overflows its stack in small steps. Tests use it to verify that the guard of the stack turns that into a
//! fault with a name.
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
#[path = "../../../cortex-m/armv7m/stack_guard.rs"]
mod stack_guard;

#[cfg(target_os = "none")]
mod firmware {
    use core::hint::black_box;

    #[cortex_m_rt::entry]
    fn main() -> ! {
        super::stack_guard::set();
        panic!("{} calls and no end", deeper(0))
    }

    /// Calls itself for ever, with locals that are in use until it returns.
    #[allow(unconditional_recursion, reason = "it is to overflow the stack")]
    fn deeper(calls: u32) -> u32 {
        let locals = black_box([calls; 16]);
        let deepest = deeper(calls + 1);
        black_box(locals).iter().fold(deepest, |sum, local| sum.wrapping_add(*local))
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
