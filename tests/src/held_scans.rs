//! Scans of a bench that stop after each arming until the test has looked at the rig.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use massline_shared::signal::{AdcProperties, Scan};
use massline_virtual::VirtualRig;
use massline_virtual::bench::BenchSource;
use massline_virtual::source::ScanSource;

/// Number of scans between an arming and the stop: 0.1 s, enough for the level bars and before the hit.
const STOP_AFTER: usize = 500;

/// A bench whose scans stop after each arming, so that a test misses no state of the rig, which simulates
/// faster than a test can look.
pub struct HeldScans {
    bench: BenchSource,
    scans: usize,
    looked: Arc<AtomicBool>,
}

/// Lets the scans of [`HeldScans`] go on.
pub struct Looked(Arc<AtomicBool>);

impl HeldScans {
    /// The scans of this bench, and what lets them go on.
    pub fn of(bench: BenchSource) -> (Self, Looked) {
        let looked = Arc::new(AtomicBool::new(false));
        (Self { bench, scans: 0, looked: looked.clone() }, Looked(looked))
    }
}

impl Looked {
    /// Lets the scans of this rig go on to the next arming.
    pub fn go_on(&self, rig: &VirtualRig) {
        self.0.store(true, Ordering::Release);
        rig.poke();
    }
}

impl ScanSource for HeldScans {
    fn adc(&self) -> AdcProperties {
        self.bench.adc()
    }

    fn started(&mut self) {
        self.bench.started();
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.looked.store(false, Ordering::Release);
        self.scans = 0;
        self.bench.armed(arming, dof);
    }

    fn next_scan(&mut self) -> Option<Scan> {
        if self.scans >= STOP_AFTER && !self.looked.load(Ordering::Acquire) {
            return None;
        }
        self.scans += 1;
        self.bench.next_scan()
    }
}
