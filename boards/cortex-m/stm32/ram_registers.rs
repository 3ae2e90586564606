//! Registers in RAM, for a program that runs where the peripheral does not exist. A test of registers includes this
//! file.

use core::cell::UnsafeCell;

/// Registers of a peripheral, all zero.
pub struct RamRegisters(UnsafeCell<[u32; 40]>);

// SAFETY: the program has one thread.
unsafe impl Sync for RamRegisters {}

impl RamRegisters {
    /// Zeros.
    pub const fn new() -> Self {
        Self(UnsafeCell::new([0; 40]))
    }

    /// Their address. They are more than those of any peripheral that is tested.
    pub fn address(&self) -> *mut () {
        self.0.get().cast()
    }
}
