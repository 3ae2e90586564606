//! Disturbances of the link during a campaign.

use std::fmt;
use std::io::{Read, Write};
use std::time::Duration;

use massline_firmware::panel::PanelModel;
use massline_shared::measurement::campaign::Phase;
use massline_tests::garbage::{garbage, question};
use massline_virtual::VirtualRig;
use massline_virtual::pipe::HostEnd;
use massline_virtual::pipe::faults::{FaultRates, FaultyPipe};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::LATE;

/// The disturbance of one campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// Bytes and writes are lost, doubled and changed while the host keeps sending requests.
    BadLine,
    /// The plug is pulled in the middle of requests and answers.
    Pulled,
    /// The plug stays out for several hits.
    Out,
    /// Bytes that are not frames arrive.
    Garbage,
    /// The host neither reads nor sends.
    Silence,
    /// The host sends requests and never reads.
    Flood,
}

/// Weight of each kind. A silent host makes the rig wait by the wall clock, so that kind is less
/// frequent.
const KINDS: [(Kind, u32); 6] = [
    (Kind::BadLine, 8),
    (Kind::Pulled, 8),
    (Kind::Out, 8),
    (Kind::Garbage, 8),
    (Kind::Silence, 1),
    (Kind::Flood, 1),
];

/// Disturbs the link and counts the disturbances.
#[derive(Debug)]
pub struct Trouble {
    kind: Kind,
    line_faults: u64,
    pulled: u64,
    out: u64,
    garbage: u64,
    silent: u64,
    unread: u64,
    sequence: u16,
    campaigns: u32,
}

impl Trouble {
    pub fn new() -> Self {
        Self {
            kind: Kind::Silence,
            line_faults: 0,
            pulled: 0,
            out: 0,
            garbage: 0,
            silent: 0,
            unread: 0,
            sequence: 0,
            campaigns: 0,
        }
    }

    /// Chooses the disturbance of the next campaign; a bad line is bad even before the campaign starts.
    pub fn choose(&mut self, rig: &VirtualRig, random: &mut ChaCha8Rng) -> Option<FaultyPipe> {
        let total: u32 = KINDS.iter().map(|(_, weight)| weight).sum();
        // A mixed order with every kind as often as its weight: 13 and the sum of the weights are
        // coprime.
        let mut draw = 13 * self.campaigns % total;
        self.campaigns += 1;
        for (kind, weight) in KINDS {
            if draw < weight {
                self.kind = kind;
                break;
            }
            draw -= weight;
        }
        self.silent += u64::from(self.kind == Kind::Silence);
        let seed = random.random();
        (self.kind == Kind::BadLine)
            .then(|| FaultyPipe::on(&rig.link(), seed, FaultRates::one_in(600.0, 8.0)))
    }

    /// Makes one disturbance while the campaign runs.
    pub fn make(&mut self, rig: &VirtualRig, random: &mut ChaCha8Rng) {
        let mut link = rig.link();
        link.set_timeout(Duration::from_millis(10));
        match self.kind {
            Kind::BadLine => self.ask(&link),
            Kind::Pulled => self.pull(&mut link, random),
            Kind::Out => self.leave(rig, &link),
            Kind::Garbage => self.send_garbage(&mut link, random),
            Kind::Silence => {
                rig.wait_for(LATE, |model| model.phase == Phase::Done);
            }
            Kind::Flood => {
                self.sequence = self.sequence.wrapping_add(1);
                // There is no room while the rig is stuck writing an answer, which it then abandons.
                self.unread += u64::from(link.write_all(&question(self.sequence)).is_ok());
            }
        }
    }

    /// Removes the disturbance from the link.
    pub fn end(&mut self, rig: &VirtualRig, faulty: Option<FaultyPipe>) {
        if let Some(faulty) = faulty {
            FaultyPipe::repair(&rig.link());
            self.line_faults += faulty.faults();
        }
    }

    pub fn all_kinds_happened(&self) -> bool {
        let Self { line_faults, pulled, out, garbage, silent, unread, .. } = *self;
        [line_faults, pulled, out, garbage, silent, unread].iter().all(|&count| count > 0)
    }

    /// Sends a request and discards everything that has arrived.
    fn ask(&mut self, link: &HostEnd) {
        self.sequence = self.sequence.wrapping_add(1);
        let mut link = link.clone();
        // A bad line may change or lose the request.
        let _ = link.write_all(&question(self.sequence));
        while link.read(&mut [0; 2048]).is_ok() {
            link.set_timeout(Duration::ZERO);
        }
    }

    /// Sends part of a request or reads part of an answer, and pulls the plug.
    fn pull(&mut self, link: &mut HostEnd, random: &mut ChaCha8Rng) {
        let whole = question(self.sequence);
        let cut = random.random_range(1..=whole.len());
        let _ = link.write_all(&whole[..cut]);
        if cut == whole.len() {
            let mut some = vec![0; random.random_range(1..60)];
            let _ = link.read(&mut some);
        }
        link.unplug();
        link.plug();
        self.pulled += 1;
        self.ask(link);
    }

    /// Pulls the plug until the rig has made progress.
    fn leave(&mut self, rig: &VirtualRig, link: &HostEnd) {
        let before = rig.panel();
        link.unplug();
        let further =
            |model: &PanelModel| model.armings > before.armings + 2 || model.phase != before.phase;
        rig.wait_for(LATE, |model| further(model) || model.phase == Phase::Done);
        link.plug();
        self.out += 1;
    }

    fn send_garbage(&mut self, link: &mut HostEnd, random: &mut ChaCha8Rng) {
        for piece in garbage(random) {
            self.garbage += u64::from(link.write_all(&piece).is_ok());
        }
        self.ask(link);
    }
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line_faults, pulled, out, garbage, silent, unread, .. } = self;
        write!(
            f,
            "trouble: {line_faults} faults on a bad line, {pulled} plugs pulled in mid-frame, {out} times \
             unplugged while the rig went on, {garbage} pieces of garbage, {silent} campaigns that nobody \
             read, {unread} questions whose answers nobody read"
        )
    }
}
