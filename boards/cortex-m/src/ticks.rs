//! The clock that everything on an STM32 waits by. The HAL's driver counts its ticks with 16 bits of a timer and adds
//! half a turn at each of two interrupts a turn: a second one that comes before the first is served is lost, and with
//! it half a turn. While a board erases the flash that its code is in, no interrupt is served.

pub use embassy_time::TICK_HZ;

/// Ticks from one of the driver's interrupts to the next.
const HALF_TURN: u64 = 0x8000;

/// True when no interrupt of a clock with this many ticks per second is lost during an erase that takes up to this
/// long, and a quarter more for a clock that runs fast and for the interrupts before.
pub const fn outlast(tick_hz: u64, longest_erase_us: u64) -> bool {
    HALF_TURN * 1_000_000 / tick_hz > longest_erase_us + longest_erase_us / 4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The HAL's driver on its timer: embassy-stm32 0.6, `time_driver/gp16.rs`.
    struct Driver {
        tick_hz: u64,
        /// Nanoseconds since the start.
        time: u64,
        /// Half turns that the interrupt has counted.
        period: u32,
        /// An interrupt at the end of a turn, and at its half, is pending.
        pending: [bool; 2],
        /// Interrupts are served.
        open: bool,
    }

    impl Driver {
        fn new(tick_hz: u32) -> Self {
            Self { tick_hz: tick_hz.into(), time: 0, period: 0, pending: [false; 2], open: true }
        }

        fn ticks(&self) -> u64 {
            (u128::from(self.time) * u128::from(self.tick_hz) / 1_000_000_000) as u64
        }

        /// Lets time pass, from one half turn to the next.
        fn pass(&mut self, nanoseconds: u64) {
            let end = self.time + nanoseconds;
            while self.time < end {
                let next = (self.ticks() / HALF_TURN + 1) * HALF_TURN;
                // The first nanosecond of that tick.
                let at = (u128::from(next) * 1_000_000_000).div_ceil(self.tick_hz.into()) as u64;
                self.time = end.min(at);
                if at <= end {
                    self.pending[(next / HALF_TURN % 2) as usize] = true;
                }
                self.serve();
            }
        }

        /// The interrupt handler.
        fn serve(&mut self) {
            if self.open {
                for flag in &mut self.pending {
                    self.period += u32::from(core::mem::take(flag));
                }
            }
        }

        fn erase(&mut self, nanoseconds: u64) {
            self.open = false;
            self.pass(nanoseconds);
            self.open = true;
            self.serve();
        }

        fn now(&self) -> u64 {
            let counter = (self.ticks() & 0xFFFF) as u32;
            (u64::from(self.period) << 15) + u64::from(counter ^ ((self.period & 1) << 15))
        }

        /// How far the clock is behind, ms.
        fn lost_ms(&self) -> f64 {
            (self.ticks() as f64 - self.now() as f64) * 1e3 / self.tick_hz as f64
        }
    }

    /// The most that an erase loses, ms, and whether the clock ever ran backwards, over 10 000 erases of up to this
    /// long with pauses of up to 0.1 s.
    fn erased(tick_hz: u32, longest_erase_us: u64) -> (f64, bool) {
        let mut driver = Driver::new(tick_hz);
        let (mut most, mut back, mut state) = (0.0_f64, false, 1_u64);
        // The generator of Knuth; its high bits are used.
        let mut random = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) % below
        };
        let mut last = driver.now();
        for _ in 0..10_000 {
            driver.pass(random(100_000_000));
            let before = driver.lost_ms();
            back |= driver.now() < last;
            last = driver.now();
            let [shortest, longest] = [300, 1000].map(|part| part * longest_erase_us);
            driver.erase(shortest + random(longest - shortest));
            back |= driver.now() < last;
            last = driver.now();
            most = most.max(driver.lost_ms() - before);
        }
        (most, back)
    }

    #[test]
    fn ten_thousand_erases_lose_no_time_and_never_turn_the_clock_back() {
        // Of an STM32F411 and of an STM32G474.
        for (tick_hz, longest_erase_us) in [(32_000, 800_000), (1_000_000, 24_500)] {
            assert!(outlast(tick_hz, longest_erase_us));
            assert_eq!(erased(tick_hz as u32, longest_erase_us), (0.0, false), "{tick_hz} Hz");
        }
    }

    #[test]
    fn the_model_shows_what_a_faster_clock_loses() {
        // A half turn of 33 ms: of up to 24 that an erase spans, two are counted.
        assert!(!outlast(1_000_000, 800_000));
        let (most, back) = erased(1_000_000, 800_000);
        // It does not run backwards here, since it is read between erases, not while one interrupt of two is served.
        assert!(most > 600.0, "{most} ms, {back}");
    }
}
