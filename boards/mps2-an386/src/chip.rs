//! The part of the board's code that runs on the emulated Cortex-M4F.

mod executor;
#[macro_use]
#[path = "../../cortex-m/src/hard_fault.rs"]
mod hard_fault;
mod fault;
mod interrupts;
mod link;
mod panel;
mod registers;
mod sampler;
// Shared unchanged with the boards that have a chip, as is `hard_fault`.
#[path = "../../cortex-m/src/stack.rs"]
mod stack;
#[path = "../../cortex-m/armv7m/stack_guard.rs"]
mod stack_guard;
mod time;

use cortex_m_rt::entry;
use embassy_executor::Spawner;
use massline_firmware::Memory;
use massline_firmware::board::{
    Board, BoardInfo, BootReason, Circuit, Clock, NO_CONVERTER_FAULT, Supply,
};
use massline_mps2_an386::facts::NAME;
use massline_mps2_an386::flash::MemoryFlash;
use massline_mps2_an386::ring::Ring;
use massline_mps2_an386::{FLASH_OFFSET, FLASH_SIZE, PSRAM_ADDRESS, RING_OFFSET};
use static_cell::ConstStaticCell;

const INFO: BoardInfo = BoardInfo {
    name: NAME,
    firmware: env!("CARGO_PKG_VERSION"),
    git_hash: env!("MASSLINE_GIT_HASH"),
    git_dirty: matches!(env!("MASSLINE_GIT_DIRTY").as_bytes(), b"true"),
    boot_reason: BootReason::PowerOn,
    // A panic ends the emulator, so no start follows one.
    last_panic: "",
    clock: Clock::Unknown,
    supply: Supply::STEADY,
    circuit: Circuit { flash_select: None },
    converter_fault: NO_CONVERTER_FAULT,
    stack: stack::measure,
};

#[entry]
fn main() -> ! {
    stack_guard::set();
    time::start();
    executor::run(|spawner: Spawner| match rig() {
        Ok(token) => spawner.spawn(token),
        Err(_) => unreachable!("the task is spawned once"),
    })
}

#[embassy_executor::task]
async fn rig() {
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
    let ring = ring();
    let mut flash = flash();
    if ring.adc().is_none() {
        // No host has prepared the PSRAM.
        flash.erase_all();
    }
    let board = Board {
        info: INFO,
        sampler: sampler::RingSampler::new(ring),
        link: link::start(),
        flash,
        panel: panel::NoPanel::default(),
        // The machine has none.
        feed_watchdog: || {},
    };
    massline_firmware::run(board, MEMORY.take()).await;
}

fn ring() -> &'static Ring {
    // SAFETY: PSRAM is accessible from power-on, `Ring` consists of atomics, and any bytes are a valid
    // `Ring`.
    unsafe { &*((PSRAM_ADDRESS + RING_OFFSET) as *const Ring) }
}

fn flash() -> MemoryFlash<'static> {
    let start = (PSRAM_ADDRESS + FLASH_OFFSET) as *mut u8;
    // SAFETY: this part of the PSRAM is used for the flash only, and the only task calls this once.
    MemoryFlash::new(unsafe { core::slice::from_raw_parts_mut(start, FLASH_SIZE) })
}
