//! A day of continuous use: campaign after campaign over a faulty link, in simulated time as fast as
//! possible.
//!
//! ```text
//! MASSLINE_LONG=1 cargo test --release -p massline-tests --test endurance -- --nocapture
//! ```
//! runs 24 simulated hours; without `MASSLINE_LONG` 20 minutes.
//!
//! Two rigs run the same campaigns on the same bench: the link of the first has every fault in
//! [`trouble`], that of the second has none. Both lose scans in the middle of records. The requirements:
//!
//! * **No stall.** Every campaign ends within [`LIMIT_S`] of the rig's own time.
//! * **No lost result.** A result that was announced can be read back, byte for byte, until it is
//!   deleted, and there are no others. It has the same bytes as on the undisturbed rig. A full store
//!   refuses a campaign with a named reason and deletes nothing; then the test checks and deletes the
//!   older half.
//! * **No leak.** The allocations of both rigs and their links, and the memory of the process, do not
//!   grow after the first tenth of the run.

mod memory;
mod trouble;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use massline::rig::PipeTransport;
use massline_client::{Client, Timing};
use massline_firmware::board::SampleError;
use massline_physics::Bench;
use massline_protocol::message::{Reason, Stats};
use massline_protocol::object::{ObjectId, ObjectKind};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::Phase;
use massline_shared::signal::Scan;
use massline_tests::campaign::{IMPATIENT, LATE, scans, three_bar};
use massline_tests::faulty_sampler::{Strikes, rig_that_loses};
use massline_virtual::{VirtualRig, VirtualRigOptions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use memory::Memory;
use trouble::Trouble;

/// Longest duration of a campaign by the rig's clock, s. Each of its fifteen hits takes 0.8 s; one in ten
/// is requested again, a tap that does not trigger is repeated after 3 s, and while the rig waits for a
/// host that does not read, its clock follows the wall clock.
const LIMIT_S: f64 = 60.0;
/// Capacity of the disturbed rig's link, bytes: a few frames.
const SHORT_LINK: usize = 2048;
/// Room for all events of a campaign, so that the undisturbed rig never waits for its host.
const LONG_LINK: usize = 1 << 20;
/// One in this many records loses scans.
const RECORDS_PER_LOSS: u32 = 20;
/// Number of layouts that alternate: more than a rig stores.
const LAYOUTS: usize = 6;
/// Allowed growth of allocated memory, bytes: the queues and tables of the test itself are always equally
/// full, except for the results of a store that is filled and emptied.
const GROWTH: usize = 512 * 1024;
/// Allowed growth of the process's memory, bytes, for fragmentation in the allocator.
const PROCESS_GROWTH: usize = 16 * 1024 * 1024;

/// Simulated time of the run, s.
fn wanted_s() -> f64 {
    let hours = if massline_tests::long() { 24.0 } else { 1.0 / 3.0 };
    hours * 3600.0
}

/// The same test with another title, which makes it another layout.
fn layout(campaign: usize) -> RigLayout {
    let mut layout = three_bar().rig_layout().unwrap();
    let title = format!("frame {}", campaign % LAYOUTS);
    layout.title = title.as_str().try_into().unwrap();
    layout
}

/// Loses scans in the middle of some records, the same ones on every rig.
fn losses() -> impl FnMut(&[Scan]) -> Option<SampleError> + Send {
    let mut strikes = Strikes::above(300);
    move |block| {
        let (strike, blocks) = strikes.see(block)?;
        if blocks != 50 || strike % RECORDS_PER_LOSS != 0 {
            return None;
        }
        strikes.forget();
        Some(SampleError::Overrun { lost: 20 })
    }
}

/// A rig and the results that it has announced.
struct Rig {
    rig: VirtualRig,
    /// Every result that was announced and not deleted, with the bytes read when it was announced.
    results: BTreeMap<u32, Vec<u8>>,
    next: u32,
    checked: u64,
    full: u32,
}

impl Rig {
    /// A rig whose link has this capacity in bytes.
    fn start(link_capacity: usize) -> Self {
        let bench = Bench::named("default").unwrap();
        let source = scans(&bench, &three_bar(), 1);
        let options = VirtualRigOptions { link_capacity, ..VirtualRigOptions::new(source) };
        let rig = rig_that_loses(options, losses()).unwrap();
        Self { rig, results: BTreeMap::new(), next: 1, checked: 0, full: 0 }
    }

    fn client(&self) -> Client {
        let timing = Timing { answer: Duration::from_millis(10), ..IMPATIENT };
        Client::with_timing(PipeTransport::new(self.rig.link()), timing)
    }

    /// Starts a campaign, after making room when the rig reports that its store is full.
    fn begin(&mut self, campaign: usize) {
        let mut client = self.client();
        client.put_layout(&layout(campaign)).unwrap();
        if campaign.is_multiple_of(10) {
            let calibration = client.calibration().unwrap();
            client.put_calibration(&calibration).unwrap();
        }
        if let Err(refused) = client.start(false, false) {
            assert_eq!(refused.refusal(), Some(Reason::StoreFull), "campaign {campaign}");
            self.full += 1;
            self.make_room();
            client.start(false, false).unwrap();
        }
    }

    /// True when the current campaign has ended with a result.
    fn is_done(&self) -> bool {
        let panel = self.rig.panel();
        panel.phase == Phase::Done && panel.result == self.next
    }

    fn wait_done(&self) {
        let number = self.next;
        let done = |model: &massline_firmware::panel::PanelModel| {
            model.phase == Phase::Done && model.result == number
        };
        assert!(self.rig.wait_for(LATE, done).is_some(), "stalled: {:?}", self.rig);
    }

    /// Reads the announced result and the list of results.
    fn take_result(&mut self) -> &[u8] {
        let number = self.next;
        let status = self.client().status().unwrap();
        assert_eq!((status.result, &status.accepted[..]), (number, &[5, 5, 5][..]));
        let result = self.read(number);
        self.results.insert(number, result);
        self.next += 1;
        let listed: Vec<_> =
            self.client().results().unwrap().iter().map(|entry| entry.number).collect();
        assert!(listed.iter().eq(self.results.keys()), "{listed:?}");
        &self.results[&number]
    }

    fn read(&self, number: u32) -> Vec<u8> {
        let object = ObjectId { kind: ObjectKind::Result as u8, number };
        self.client().download(object, |_, _| ()).unwrap()
    }

    /// Reads again a result that was announced earlier.
    fn check(&mut self, number: u32) {
        assert!(self.read(number) == self.results[&number], "result {number} has changed");
        self.checked += 1;
    }

    fn check_all(&mut self) {
        let numbers: Vec<_> = self.results.keys().copied().collect();
        numbers.into_iter().for_each(|number| self.check(number));
    }

    /// Checks all stored results and deletes the older half.
    fn make_room(&mut self) {
        self.check_all();
        let half = self.results.len() / 2;
        assert!(half > 0, "a store without results is not full");
        for _ in 0..half {
            let (number, _) = self.results.pop_first().unwrap();
            self.client().delete_result(number).unwrap();
        }
    }

    fn counters(&self) -> Stats {
        let mut client = self.client();
        client.stats().unwrap()
    }
}

#[test]
fn a_day_of_hits_link_faults_and_pulled_plugs_loses_nothing() {
    let (wall, wanted) = (Instant::now(), wanted_s());
    let (mut disturbed, mut calm) = (Rig::start(SHORT_LINK), Rig::start(LONG_LINK));
    let mut random = ChaCha8Rng::seed_from_u64(24);
    let mut trouble = Trouble::new();
    let mut memory = Memory::default();
    let (mut campaigns, mut clock, mut longest, mut rejected) = (0, 0.0, 0.0_f64, 0);
    while clock < wanted {
        calm.begin(campaigns);
        let faulty = trouble.choose(&disturbed.rig, &mut random);
        disturbed.begin(campaigns);
        let began = Instant::now();
        while !disturbed.is_done() {
            assert!(began.elapsed() < LATE, "stalled: {:?}", disturbed.rig);
            assert_eq!(disturbed.rig.panicked(), None);
            trouble.make(&disturbed.rig, &mut random);
        }
        let result = disturbed.take_result().to_vec();
        trouble.end(&disturbed.rig, faulty);
        calm.wait_done();
        assert!(result == calm.take_result(), "campaign {campaigns} has another result");
        let (older, _) =
            disturbed.results.iter().nth(random.random_range(0..disturbed.results.len())).unwrap();
        disturbed.check(*older);

        let now = disturbed.counters().uptime_ms as f64 / 1000.0;
        longest = longest.max(now - clock);
        assert!(now - clock < LIMIT_S, "campaign {campaigns} took {} s", now - clock);
        clock = now;
        rejected += u64::from(disturbed.client().status().unwrap().rejected);
        campaigns += 1;
        memory.look(clock / wanted);
    }
    disturbed.check_all();
    calm.check_all();
    let stats = disturbed.counters();
    println!(
        "{:.2} h simulated in {:.0} s: {campaigns} campaigns, {} triggers, {rejected} hits rejected, {} of \
         them aborted for lost scans; the longest campaign took {longest:.1} s of {LIMIT_S} s",
        clock / 3600.0,
        wall.elapsed().as_secs_f64(),
        stats.triggers,
        stats.hits_aborted,
    );
    println!("{trouble}");
    println!(
        "results: {} announced and equal to those of the undisturbed rig, {} read back later, store full {} \
         times, {} still kept",
        disturbed.next - 1,
        disturbed.checked,
        disturbed.full,
        disturbed.results.len(),
    );
    println!("the rig: {stats:?}\n{memory}");
    assert_eq!((stats.store_failures, stats.read_back_failures), (0, 0));
    assert!(stats.hits_aborted > 0 && trouble.all_kinds_happened(), "{trouble}");
    memory.check(GROWTH, PROCESS_GROWTH);
    disturbed.rig.stop().unwrap();
    calm.rig.stop().unwrap();
}
