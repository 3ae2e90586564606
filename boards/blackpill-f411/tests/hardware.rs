//! Tests on the chip: `cargo hardware-test` in the board's folder, with a probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[embedded_test::tests]
mod tests {
    use embassy_time::Timer;
    use massline_blackpill_f411::chip::adc;
    use massline_blackpill_f411::chip::{Parts, parts};
    use massline_cortex_m::checks;
    use massline_cortex_m::rig::WATCHDOG;
    use static_cell::ConstStaticCell;

    /// Bytes that are erased at a time.
    const PAGE: usize = 16 * 1024;

    #[init]
    fn init() -> Parts {
        parts()
    }

    #[test]
    async fn scans_come_at_their_rate(mut board: Parts) {
        checks::scans_come_at_their_rate(&mut board.rig.sampler).await;
    }

    #[test]
    async fn a_stopped_sampler_starts_again(mut board: Parts) {
        checks::a_stopped_sampler_starts_again(&mut board.rig.sampler).await;
    }

    #[test]
    fn the_maker_has_noted_the_reference() {
        // 1.18 to 1.24 V at 3.3 V; that it reads so is asked of every scan.
        let noted = adc::noted_code();
        assert!((1464..=1539).contains(&noted), "{noted}");
    }

    #[test]
    async fn a_page_is_erased_and_written(mut board: Parts) {
        static KEEP: ConstStaticCell<[u8; PAGE]> = ConstStaticCell::new([0; PAGE]);
        checks::a_page_is_erased_and_written(&mut board.rig.flash, KEEP.take()).await;
    }

    #[test]
    async fn the_screen_answers_or_is_absent(mut board: Parts) {
        checks::the_screen_answers_or_is_absent(&mut board.rig.panel.bus).await;
    }

    #[test]
    fn the_start_is_told(board: Parts) {
        checks::the_start_is_told(&board.rig.info);
    }

    #[test]
    fn last_words_are_kept(_board: Parts) {
        checks::last_words_are_kept();
    }

    /// Longer than a watchdog waits that is not fed.
    #[test]
    #[timeout(30)]
    async fn a_watchdog_that_is_fed_sleeps(mut board: Parts) {
        board.watchdog.unleash();
        for _ in 0..=2 * WATCHDOG.as_secs() {
            Timer::after_millis(500).await;
            board.watchdog.pet();
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("These tests run on the chip: `cargo hardware-test` in boards/blackpill-f411.");
}
