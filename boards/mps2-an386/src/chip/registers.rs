//! The registers of the machine's timers and UARTs (Arm CMSDK), and its interrupts.

use core::ptr::{read_volatile, write_volatile};

use cortex_m::interrupt::InterruptNumber;

/// An interrupt of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    Uart0Rx = 0,
    Uart0Tx = 1,
    Timer0 = 8,
    Timer1 = 9,
}

// SAFETY: these are the machine's interrupt numbers, all below the 32 of its vector table.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// A block of 32-bit registers.
#[derive(Clone, Copy, Debug)]
struct Block(usize);

impl Block {
    fn read(self, offset: usize) -> u32 {
        // SAFETY: only the constants below create a block, each at a peripheral of the machine.
        unsafe { read_volatile((self.0 + offset) as *const u32) }
    }

    fn write(self, offset: usize, value: u32) {
        // SAFETY: as above; no register of these peripherals accesses memory.
        unsafe { write_volatile((self.0 + offset) as *mut u32, value) }
    }
}

/// A UART.
#[derive(Clone, Copy, Debug)]
pub struct Uart(Block);

/// The link to the host.
pub const UART0: Uart = Uart(Block(0x4000_4000));
/// The output of panic messages.
pub const UART1: Uart = Uart(Block(0x4000_5000));

impl Uart {
    const DATA: usize = 0x00;
    const STATE: usize = 0x04;
    const CONTROL: usize = 0x08;
    const INTERRUPT: usize = 0x0C;
    const DIVIDER: usize = 0x10;

    /// Enables sending, receiving, and both interrupts.
    pub fn enable(self) {
        self.0.write(Self::DIVIDER, 16);
        self.0.write(Self::CONTROL, 0b1111);
    }

    /// Enables sending only, without interrupts.
    pub fn enable_sending(self) {
        self.0.write(Self::DIVIDER, 16);
        self.0.write(Self::CONTROL, 0b0001);
    }

    /// True when a byte can be sent.
    pub fn can_send(self) -> bool {
        self.0.read(Self::STATE) & 1 == 0
    }

    /// Sends a byte.
    pub fn send(self, byte: u8) {
        self.0.write(Self::DATA, u32::from(byte));
    }

    /// Reads the received byte. The interrupt is cleared before the byte is read: as soon as it is read,
    /// the next may arrive and raise the interrupt again.
    pub fn take(self) -> Option<u8> {
        if self.0.read(Self::STATE) & 2 == 0 {
            return None;
        }
        self.0.write(Self::INTERRUPT, 2);
        Some(self.0.read(Self::DATA) as u8)
    }

    /// Clears the interrupt of sending.
    pub fn clear_sent(self) {
        self.0.write(Self::INTERRUPT, 1);
    }
}

/// A timer that counts down at 25 MHz.
#[derive(Clone, Copy, Debug)]
pub struct Timer(Block);

/// The clock.
pub const TIMER0: Timer = Timer(Block(0x4000_0000));
/// The alarm.
pub const TIMER1: Timer = Timer(Block(0x4000_1000));

impl Timer {
    const CONTROL: usize = 0x00;
    const VALUE: usize = 0x04;
    const RELOAD: usize = 0x08;
    const INTERRUPT: usize = 0x0C;

    /// Counts down from `cycles`, raises the interrupt at zero, then wraps every 2³² cycles.
    pub fn start(self, cycles: u32) {
        self.stop();
        // A timer with a zero in this register does not run.
        self.0.write(Self::RELOAD, u32::MAX);
        self.0.write(Self::VALUE, cycles);
        self.clear();
        self.0.write(Self::CONTROL, 0b1001);
    }

    /// Stops the timer.
    pub fn stop(self) {
        self.0.write(Self::CONTROL, 0);
    }

    /// Cycles until zero.
    pub fn value(self) -> u32 {
        self.0.read(Self::VALUE)
    }

    /// True when the timer has reached zero since the last [`Self::clear`].
    pub fn raised(self) -> bool {
        self.0.read(Self::INTERRUPT) & 1 != 0
    }

    /// Clears the interrupt.
    pub fn clear(self) {
        self.0.write(Self::INTERRUPT, 1);
    }
}
