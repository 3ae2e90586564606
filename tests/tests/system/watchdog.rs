//! The watchdog is fed while the parts of the application get on with their work, and not when one of them hangs.

use std::convert::Infallible;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant as Wall};

use embassy_time::Instant;
use massline_firmware::Memory;
use massline_firmware::board::Board;
use massline_firmware::panel::{Button, Cue, Panel, PanelModel};
use massline_tests::campaign::{scans, steady_hand, three_bar};
use massline_virtual::clock::advance_to;
use massline_virtual::framebuffer::Framebuffer;
use massline_virtual::panel::OperatorPanel;
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

/// Time that passes for the rig while a picture is sent: longer than the patience of the watchdog.
const LONG: embassy_time::Duration = embassy_time::Duration::from_secs(20);

/// A panel whose screen takes long to take a picture, or for ever.
struct SlowPanel<const HANGS: bool>(OperatorPanel);

impl<const HANGS: bool> Panel for SlowPanel<HANGS> {
    type Screen = Framebuffer;

    fn screen(&mut self) -> &mut Framebuffer {
        self.0.screen()
    }

    async fn flush(&mut self) {
        advance_to(Instant::now() + LONG);
        if HANGS {
            core::future::pending::<Infallible>().await;
        }
        self.0.flush().await;
    }

    async fn button(&mut self) -> Button {
        self.0.button().await
    }

    fn cue(&mut self, cue: Cue) {
        self.0.cue(cue);
    }

    fn report(&mut self, model: &PanelModel) {
        self.0.report(model);
    }
}

/// Starts a rig with such a panel.
fn start<const HANGS: bool>(feed_watchdog: fn()) -> VirtualRig {
    let bench = scans(&steady_hand("default"), &three_bar(), 1);
    VirtualRig::start_application(VirtualRigOptions::new(bench), async move |board| {
        let Board { info, sampler, link, flash, panel, .. } = board;
        let panel = SlowPanel::<HANGS>(panel);
        let board = Board { info, sampler, link, flash, panel, feed_watchdog };
        let mut memory = Box::new(Memory::new());
        massline_firmware::run(board, &mut memory).await
    })
    .expect("the rig starts")
}

#[test]
fn a_rig_that_waits_feeds_its_watchdog() {
    static FED: AtomicU32 = AtomicU32::new(0);
    let _rig = start::<false>(|| _ = FED.fetch_add(1, Ordering::Relaxed));
    let start = Wall::now();
    // Every second of the wall clock, which an idle rig follows; a busy machine may be late.
    while FED.load(Ordering::Relaxed) < 4 {
        assert!(start.elapsed() < Duration::from_secs(60), "it is not fed");
        thread::yield_now();
    }
}

#[test]
fn a_rig_whose_panel_hangs_does_not_feed_its_watchdog() {
    static FED: AtomicU32 = AtomicU32::new(0);
    let _rig = start::<true>(|| _ = FED.fetch_add(1, Ordering::Relaxed));
    let start = Wall::now();
    // A rig that waits would have fed it three times.
    while start.elapsed() < Duration::from_secs(3) {
        thread::yield_now();
    }
    // Once at the most, at the start, before the panel has drawn anything.
    assert!(FED.load(Ordering::Relaxed) <= 1);
}
