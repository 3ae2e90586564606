//! Whether the board's crystal oscillates. Each board with an STM32 includes this file.

use embassy_stm32::pac::rcc::Rcc;
use massline_firmware::board::Clock;

/// Times that the crystal is looked at before it is given up: at 16 MHz a tenth of a second at least. A crystal starts
/// within a few milliseconds.
const LOOKS: u32 = 400_000;

/// Starts the crystal; the clocks must be derived from what this returns, because the HAL waits for a crystal for ever.
/// To be called before the clocks are set up.
pub fn start(rcc: Rcc) -> Clock {
    rcc.cr().modify(|w| w.set_hseon(true));
    if (0..LOOKS).any(|_| rcc.cr().read().hserdy()) {
        return Clock::Crystal;
    }
    rcc.cr().modify(|w| w.set_hseon(false));
    Clock::Internal
}
