//! The guard of the stack of an ARMv7-M: memory at its end that the MPU lets nobody access, so that an overflow that
//! meets it is a fault. Each board with such a core includes this file.

use super::stack::{GUARD_BYTES, guard};
use cortex_m::peripheral::MPU;

/// MPU_CTRL: on, with the usual rules for all memory outside of the regions.
const ON: u32 = 1 << 2 | 1;
/// MPU_RASR: nobody reads, writes or executes it; the size is given as its logarithm less 1; on.
const NO_ACCESS: u32 = 1 << 28 | (GUARD_BYTES.ilog2() - 1) << 1 | 1;
const _: () = assert!(GUARD_BYTES.is_power_of_two() && GUARD_BYTES >= 32);

/// Sets the guard up. To be called once, before anything that needs much of the stack.
pub fn set() {
    // SAFETY: the region is memory that nothing uses; nothing else uses the MPU.
    unsafe {
        let mpu = &*MPU::PTR;
        mpu.ctrl.write(0);
        mpu.rnr.write(0);
        mpu.rbar.write(guard().start as u32);
        mpu.rasr.write(NO_ACCESS);
        mpu.ctrl.write(ON);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}
