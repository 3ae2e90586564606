//! Scans that stop after each arming, once or at several places, until the test has looked at the rig.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Instant;

use massline_physics::source::ScanSource;
use massline_shared::signal::{AdcProperties, Scan};
use massline_virtual::VirtualRig;

use crate::campaign::LATE;

/// Number of scans between an arming and the stop: 0.1 s, enough for the level bars and before the hit.
const STOP_AFTER: usize = 500;

/// Scans that stop after each arming, so that a test misses no state of the rig, which simulates
/// faster than a test can look.
pub struct HeldScans<S> {
    source: S,
    /// Scans after an arming before each stop.
    stops: Vec<usize>,
    /// Scans since the arming; `None` before it.
    scans: Option<usize>,
    place: ScanRelease,
}

/// Lets the scans of [`HeldScans`] go on.
#[derive(Clone, Default)]
pub struct ScanRelease(Arc<Mutex<Place>>);

/// Where the scans are.
#[derive(Default)]
struct Place {
    /// They are at a stop.
    held: bool,
    /// Stops since the arming that they have passed.
    passed: usize,
}

impl<S: ScanSource> HeldScans<S> {
    /// These scans, and what lets them go on.
    pub fn of(source: S) -> (Self, ScanRelease) {
        Self::at(source, vec![STOP_AFTER])
    }

    /// The same with a stop after each of these numbers of scans since the arming.
    pub fn at(source: S, stops: Vec<usize>) -> (Self, ScanRelease) {
        let place = ScanRelease::default();
        (Self { source, stops, scans: None, place: place.clone() }, place)
    }
}

impl ScanRelease {
    /// Lets the scans of this rig go on to the next stop, as soon as they are at one.
    #[track_caller]
    pub fn go_on(&self, rig: &VirtualRig) {
        let start = Instant::now();
        while !std::mem::take(&mut self.place().held) {
            assert!(start.elapsed() < LATE, "the scans do not come to a stop");
            thread::yield_now();
        }
        self.place().passed += 1;
        rig.poke();
    }

    fn place(&self) -> MutexGuard<'_, Place> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<S: ScanSource> ScanSource for HeldScans<S> {
    fn adc(&self) -> AdcProperties {
        self.source.adc()
    }

    fn started(&mut self) {
        self.scans = None;
        *self.place.place() = Place::default();
        self.source.started();
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.scans = Some(0);
        *self.place.place() = Place::default();
        self.source.armed(arming, dof);
    }

    fn next_scan(&mut self) -> Option<Scan> {
        if let Some(scans) = &mut self.scans {
            let mut place = self.place.place();
            if self.stops.get(place.passed).is_some_and(|&stop| *scans >= stop) {
                place.held = true;
                return None;
            }
            *scans += 1;
        }
        self.source.next_scan()
    }
}
