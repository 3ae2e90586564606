//! The test suite that runs on the chip, common to all boards.

/// The content of a board's `tests/hardware.rs`, after the program's attributes. `$board` is the board's
/// library. Tests that follow it are specific to the board; they may use its `chip`, `Parts` and
/// [`checks`](crate::checks).
#[macro_export]
macro_rules! hardware_tests {
    ($board:ident $($own:tt)*) => {
        #[cfg(target_os = "none")]
        #[embedded_test::tests]
        mod tests {
            use static_cell::ConstStaticCell;
            use $board::chip::{self, Parts, Store, Watchdog};
            use $crate::checks;

            #[init]
            fn init() -> Parts {
                chip::parts()
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
            async fn a_page_is_erased_and_written(mut board: Parts) {
                const PAGE: usize = checks::page::<Store>();
                static KEEP: ConstStaticCell<[u8; PAGE]> = ConstStaticCell::new([0; PAGE]);
                checks::a_page_is_erased_and_written(&mut board.rig.flash, KEEP.take()).await;
            }

            #[test]
            async fn the_screen_answers_or_is_absent(mut board: Parts) {
                checks::the_screen_answers_or_is_absent(&mut board.rig.panel.bus).await;
            }

            #[test]
            fn the_reason_of_the_start_is_reported(board: Parts) {
                checks::the_reason_of_the_start_is_reported(&board.rig.info);
            }

            #[test]
            fn the_message_of_a_panic_survives(_board: Parts) {
                checks::the_message_of_a_panic_survives();
            }

            #[test]
            #[timeout(30)]
            async fn a_watchdog_that_is_fed_sleeps(_board: Parts) {
                checks::a_watchdog_that_is_fed_sleeps::<Watchdog>().await;
            }

            $($own)*
        }

        #[cfg(not(target_os = "none"))]
        fn main() {
            eprintln!("These tests run on the chip: `cargo image test BOARD --test hardware`.");
        }
    };
}
