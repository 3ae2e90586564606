//! Hits that are simulated once and played as often as the rig asks for them, to the last bit alike.

use std::sync::Arc;

use massline::support::bench_test::nominal_calibration;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::Start;
use massline_shared::measurement::{Measurement, Memory, NextAction};
use massline_shared::signal::{AdcProperties, DECIMATION, Scan};
use massline_shared::units::ScanIndex;

/// The scans of every hit of a campaign, by DOF.
pub type Hits = Arc<Vec<Vec<Vec<Scan>>>>;

/// A source that plays the hits of each DOF in turn. A hit that the rig has not taken to its end is played again at the
/// next arming, and without an arming there are no scans.
///
/// The decimated responses of a hit depend on where its scans lie among those since the rig was switched on: every hit
/// begins with a whole row, after a rest.
pub struct TapedHits {
    adc: AdcProperties,
    hits: Hits,
    /// Where the arming plays: DOF, hit, scan.
    at: Option<[usize; 3]>,
    /// Scans of rest before it.
    rest: usize,
    /// Scans since the rig was switched on.
    given: usize,
}

impl TapedHits {
    /// Plays these hits of a converter.
    pub fn new(adc: AdcProperties, hits: &Hits) -> Self {
        Self { adc, hits: hits.clone(), at: None, rest: 0, given: 0 }
    }

    fn scans(&self, dof: usize, hit: usize) -> &[Scan] {
        self.hits.get(dof).and_then(|of_dof| of_dof.get(hit)).map_or(&[], Vec::as_slice)
    }
}

impl ScanSource for TapedHits {
    fn adc(&self) -> AdcProperties {
        self.adc
    }

    fn armed(&mut self, _: u32, dof: usize) {
        let hit = match self.at {
            Some([previous, hit, scan])
                if previous == dof && scan >= self.scans(dof, hit).len() =>
            {
                hit + 1
            }
            Some([previous, hit, _]) if previous == dof => hit,
            _ => 0,
        };
        self.at = Some([dof, hit, 0]);
        self.rest = self.given.next_multiple_of(DECIMATION) - self.given;
    }

    fn next_scan(&mut self) -> Option<Scan> {
        let [dof, hit, scan] = self.at?;
        let next = *self.scans(dof, hit).get(if self.rest > 0 { 0 } else { scan })?;
        self.given += 1;
        match self.rest.checked_sub(1) {
            Some(left) => self.rest = left,
            None => self.at = Some([dof, hit, scan + 1]),
        }
        Some(next)
    }
}

/// Scans that a rig reads at a time: it takes a whole number of such blocks of every hit.
const BLOCK: usize = 20;

/// Takes every hit of a campaign on `bench`, whose person must hit well each time; every random number comes from
/// `seed`.
///
/// # Panics
/// When the layout does not fit the bench, or a hit is rejected.
#[track_caller]
pub fn take_hits(bench: &Bench, layout: &RigLayout, seed: u64) -> (AdcProperties, Hits) {
    let of_host = layout.cast().expect("it fits the host");
    let mut source = BenchSource::new(bench, &of_host, seed).expect("the layout fits the bench");
    let mut memory = Box::new(Memory::<f32>::new());
    let mut rig = Measurement::new(source.adc(), &mut memory);
    rig.set_layout(layout.clone());
    rig.set_calibration(nominal_calibration(bench), None);
    rig.start(Start::DEFAULT, false, true).expect("the campaign starts");
    let mut hits = vec![Vec::new(); layout.hits.len()];
    loop {
        match rig.next_action() {
            NextAction::Sample => {
                rig.sampling_started();
                let dof = rig.campaign().expect("it runs").dof();
                source.armed(rig.armings(), dof);
                let mut scans = Vec::new();
                while rig.next_action() == NextAction::Sample || scans.len() % BLOCK != 0 {
                    let scan = source.next_scan().expect("a bench has scans at any time");
                    rig.feed(ScanIndex(scans.len() as u64), &[scan]);
                    scans.push(scan);
                }
                hits[dof].push(scans);
            }
            NextAction::Compute => rig.work(),
            NextAction::StoreLines { .. } => rig.lines_stored(),
            // All hits are taken.
            _ => break,
        }
    }
    let wanted = usize::from(layout.test.hits_per_dof);
    assert!(hits.iter().all(|of_dof| of_dof.len() == wanted), "no hit is rejected");
    (source.adc(), Arc::new(hits))
}
