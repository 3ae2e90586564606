//! Checks of the hardware tests that every board must pass; a failed check panics.

use embassy_time::{Duration, Instant, Timer, with_timeout};
use embedded_hal_async::i2c::I2c;
use embedded_storage_async::nor_flash::NorFlash;
use massline_firmware::board::{BoardInfo, BootReason, Sampler};
use massline_shared::signal::CHANNELS;

use crate::rig::{WATCHDOG, Watchdog};
use crate::screen::{ADDRESSES, ScreenBus};
use crate::{last_words, stack};

/// Scans per block, as the rig reads them.
const BLOCK: usize = 20;
/// Command that switches the screen off.
const OFF: [u8; 2] = [0x00, 0xAE];

/// Samples for a second; no scan may be lost, and the rate must be the one that the board states.
pub async fn scans_come_at_their_rate(sampler: &mut impl Sampler) {
    let adc = sampler.adc();
    let blocks = adc.rate.0 as u64 / BLOCK as u64;
    let mut block = [[0; CHANNELS]; BLOCK];
    assert_eq!(sampler.start().await, Ok(()));
    let mut last = sampler.read(&mut block).await.expect("the first block comes");
    let start = Instant::now();
    for _ in 0..blocks {
        let first = sampler.read(&mut block).await.expect("no scan is lost");
        assert_eq!(first.0, last.0 + BLOCK as u64, "the next block follows the last one");
        last = first;
        let full = ((1_u32 << adc.bits) - 1) as u16;
        assert!(block.as_flattened().iter().all(|&code| code <= full), "a code has its bits");
    }
    let elapsed = start.elapsed().as_micros() as f32 / 1e6;
    let expected = (blocks * BLOCK as u64) as f32 / adc.rate.0;
    sampler.stop();
    // At either end of the second, a block may wait up to 3.5 ms until the half of the transfer's buffer
    // in which it ends is complete. Crystal clocks differ by 0.01 %.
    assert!((elapsed - expected).abs() < 0.008, "{elapsed} s instead of {expected} s");
}

/// A sampler that was stopped starts again, and its indices continue.
pub async fn a_stopped_sampler_starts_again(sampler: &mut impl Sampler) {
    let mut block = [[0; CHANNELS]; BLOCK];
    let mut next = 0;
    for _ in 0..20 {
        assert_eq!(sampler.start().await, Ok(()));
        let first = sampler.read(&mut block).await.expect("a block after a start");
        assert!(first.0 >= next, "indices do not run backwards");
        next = first.0 + BLOCK as u64;
        sampler.stop();
    }
}

/// Erases a page of the store, writes it word for word, and restores its content. `keep` is a buffer of the
/// length of a page. The content is lost only if the power fails meanwhile.
pub async fn a_page_is_erased_and_written<F: NorFlash>(flash: &mut F, keep: &mut [u8]) {
    assert_eq!(keep.len(), F::ERASE_SIZE);
    let mut pages = (0..flash.capacity() as u32).step_by(F::ERASE_SIZE);
    let page = loop {
        // A page with a torn word cannot be read as a whole, and is skipped.
        let page = pages.next().expect("a page that can be read");
        if flash.read(page, keep).await.is_ok() {
            break page;
        }
    };
    let end = page + F::ERASE_SIZE as u32;
    flash.erase(page, end).await.expect("the page is erased");
    for at in words::<F>() {
        assert_eq!(read(flash, page + at).await, [0xFF; WORD], "erased at {at:#x}");
    }
    for at in words::<F>() {
        flash.write(page + at, &pattern(at)).await.expect("a word is written");
    }
    for at in words::<F>() {
        assert_eq!(read(flash, page + at).await, pattern(at), "written at {at:#x}");
    }
    flash.erase(page, end).await.expect("the page is erased again");
    for (at, word) in words::<F>().zip(keep.as_chunks::<WORD>().0) {
        // A blank word is not written, so that it can still be written later.
        if word != &[0xFF; WORD] {
            flash.write(page + at, word).await.expect("a word is written again");
        }
    }
    for (at, word) in words::<F>().zip(keep.as_chunks::<WORD>().0) {
        assert_eq!(&read(flash, page + at).await, word, "as before at {at:#x}");
    }
}

/// Word size that the flash of every board can write and read.
const WORD: usize = 8;

fn words<F: NorFlash>() -> impl Iterator<Item = u32> {
    (0..F::ERASE_SIZE as u32).step_by(WORD)
}

/// A pattern that differs for each address within 64 KiB.
fn pattern(at: u32) -> [u8; WORD] {
    let [low, high, ..] = at.to_le_bytes();
    [low, high, 0x5A, 0xA5, !low, !high, 0x0F, 0xF0]
}

async fn read<F: NorFlash>(flash: &mut F, at: u32) -> [u8; WORD] {
    let mut word = [0; WORD];
    flash.read(at, &mut word).await.expect("a word is read");
    word
}

/// Bytes of a page of this flash.
pub const fn page<F: NorFlash>() -> usize {
    F::ERASE_SIZE
}

/// A screen acknowledges, or its absence is detected; the bus does not hang.
pub async fn the_screen_answers_or_is_absent(bus: &mut impl ScreenBus) {
    for address in ADDRESSES.into_iter().cycle().take(6) {
        let mut open = bus.open();
        let answer = with_timeout(Duration::from_millis(50), open.write(address, &OFF)).await;
        assert!(answer.is_ok(), "the bus hangs");
    }
}

/// The board was started by the probe, not by its watchdog or a panic, and the stack was painted.
pub fn the_reason_of_the_start_is_reported(info: &BoardInfo) {
    let harmless = [BootReason::Unknown, BootReason::PowerOn, BootReason::ResetPin];
    assert!(harmless.contains(&info.boot_reason), "{:?}", info.boot_reason);
    assert_eq!(info.last_panic, "");
    let used = stack::measure();
    assert!(used.high_water > 0 && used.high_water < used.size, "{used:?}");
}

/// An STM32 stores the ADC's reading of the reference, at 12 bits and 3.3 V. The sampler compares every
/// scan with it.
pub fn the_reference_reading_of_the_factory_is_plausible(noted: u16) {
    // By the data sheets of both families the reference is 1.18 to 1.24 V.
    assert!((1464..=1539).contains(&noted), "{noted}");
}

/// A watchdog that is fed does not reset the chip, even after more than its period.
pub async fn a_watchdog_that_is_fed_sleeps<D: Watchdog>() {
    D::start();
    for _ in 0..=2 * WATCHDOG.as_secs() {
        Timer::after_millis(500).await;
        D::feed();
    }
}

/// A panic message can be stored in memory that the start-up code does not initialise.
pub fn the_message_of_a_panic_survives() {
    last_words::keep(format_args!("word {}", 7));
    assert_eq!(last_words::take(), "word 7");
}
