//! The guard of the stack of an ARMv7-M: addresses below the stack, and so below RAM, that the MPU lets nobody access.
//! An overflow is a fault, and has changed nothing. Each board with such a core includes this file. An ARMv8-M needs no
//! guard, because it has a limit of the stack pointer.

use super::stack;
use cortex_m::peripheral::MPU;

/// Size of the guard, larger than the whole stack, so that the locals of no function reach beyond it. What an STM32 has
/// at lower addresses, such as the calibration of its reference, can still be read.
const BYTES: usize = 32 << 10;
const _: () = assert!(BYTES.is_power_of_two() && BYTES >= 32);

/// MPU_CTRL: on, with the usual rules for all memory outside of the regions.
const ON: u32 = 1 << 2 | 1;
/// MPU_RASR: nobody reads, writes or executes it; the size is given as its logarithm less 1; on.
const NO_ACCESS: u32 = 1 << 28 | (BYTES.ilog2() - 1) << 1 | 1;

/// Sets the guard up. To be called once, before anything that needs much of the stack.
pub fn set() {
    // SAFETY: nothing is in the region, and nothing else uses the MPU.
    unsafe {
        let mpu = &*MPU::PTR;
        mpu.ctrl.write(0);
        mpu.rnr.write(0);
        mpu.rbar.write(start());
        mpu.rasr.write(NO_ACCESS);
        mpu.ctrl.write(ON);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// The first address of the guard. The start of RAM, and so of the stack, is a multiple of its size.
fn start() -> u32 {
    (stack::addresses().start - BYTES) as u32
}
