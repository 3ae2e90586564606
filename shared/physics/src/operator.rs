//! The simulated person at the bench, who makes it a source of scans.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use massline_shared::layout::{HitUncertainty, HostLayout};
use massline_shared::signal::{AdcProperties, Scan};
use massline_shared::units::{Hertz, Seconds, Volts};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::body::{compose, point};
use super::channels::Channels;
use super::dynamics::check_node;
use super::error_sizes::ErrorSizes;
use super::errors::TestErrors;
use super::faults;
use super::habit::HitHabit;
use super::simulation::{Drive, Simulation};
use super::streams::stream;
use super::taps::{Tap, TapKind};
use crate::bench::{Bench, BenchError};
use crate::source::ScanSource;

/// Time between a key press and its tap, s: longer than the scans before the trigger.
const HAND_S: f64 = 0.03;

/// Largest number of taps after one arming: a person whose taps do not trigger stops after these until
/// the rig arms again.
const MOST_TAPS: u32 = 10;

/// Makes scans of a layout on a bench, with an operator who follows the prompts of the rig.
///
/// The scans after an arming depend only on bench, layout, seed, arming, DOF and, in manual mode, on when
/// the key was pressed. The object is brought to rest when the rig arms.
#[derive(Debug)]
pub struct BenchSource {
    bench: Bench,
    layout: HostLayout,
    seed: u64,
    sizes: ErrorSizes,
    errors: TestErrors,
    simulation: Simulation,
    noise: ChaCha8Rng,
    /// Decides which scans are lost.
    losses: ChaCha8Rng,
    drives: Vec<Drive>,
    armed: Option<(u32, usize)>,
    /// The DOF of the last arming, where a person goes on hitting when the rig waits for nothing.
    last_dof: usize,
    last_tap: Option<Tap>,
    prompt: Prompt,
    /// Taps since the arming.
    taps: u32,
    /// The object still swings from before the arming.
    impatient: bool,
}

/// Makes the operator of a manual bench tap at once, from any thread.
#[derive(Clone, Debug, Default)]
pub struct TapHandle(Arc<AtomicU32>);

impl TapHandle {
    /// Taps once at the DOF that the rig waits for, or else where the last tap was: first at the first DOF.
    pub fn tap(&self) {
        self.0.fetch_add(1, Ordering::Relaxed);
    }

    fn presses(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }
}

/// What makes the operator tap.
#[derive(Debug)]
enum Prompt {
    /// The rig's prompt: the next tap comes at this time after arming, s.
    Rig { next: f64 },
    /// A key: the number of presses that have been handled.
    Key { handle: TapHandle, answered: u32 },
}

/// Number of the arming of taps for which no rig has armed.
const NO_ARMING: u32 = 0xff_ffff;
/// Numbers of the random streams of one arming.
const NOISE: u64 = 0;
const TAPS: u64 = 1;
/// Phase of the mains and jitter; above the number of the last tap.
const DISTURBANCES: u64 = 0x1_0000;
/// Lost scans.
const LOSSES: u64 = DISTURBANCES + 1;
/// Whether the person has waited, and how the object swings if not.
const IMPATIENCE: u64 = DISTURBANCES + 2;
/// Stream of the errors of the test; no arming has this number.
pub(super) const TEST: u64 = u64::MAX;
/// Streams of the mountings, numbered 1 to 65535.
const MOUNTINGS: u64 = TEST - 0x10_0000;
/// Streams of what the hits at a DOF have in common, one for each DOF.
const HABITS: u64 = TEST - 0x20_0000;

impl BenchSource {
    /// A bench whose operator taps without being asked (*auto*).
    ///
    /// # Errors
    /// When the layout has more sensors than the rig has channels or uses a node at which the elastic
    /// modes of the bench are not defined, or a fault refers to something that the layout does not have.
    pub fn new(bench: &Bench, layout: &HostLayout, seed: u64) -> Result<Self, BenchError> {
        faults::check(bench, layout)?;
        let sizes = ErrorSizes::of(bench, layout);
        let errors = errors_of(bench, &sizes, seed);
        let bench = errors.hung(bench);
        let mut simulation = Simulation::new(&bench, layout, &errors)?;
        for (dof, _) in layout.hits.iter().enumerate() {
            if let Some((node, mark, _)) = faults::mark(&bench, layout, dof) {
                let written = mark - faults::misplaced(&bench, node);
                check_node(&bench, node, written.into())?;
            }
        }
        let mut noise = stream(seed, TEST - 1);
        simulation.reset(&mut noise, stream(seed, TEST - 2));
        Ok(Self {
            bench,
            layout: layout.clone(),
            seed,
            sizes,
            errors,
            simulation,
            noise,
            losses: stream(seed, TEST - 3),
            drives: Vec::new(),
            armed: None,
            last_dof: 0,
            last_tap: None,
            prompt: Prompt::Rig { next: 0.0 },
            taps: 0,
            impatient: false,
        })
    }

    /// Switches to *manual*: from now on the operator taps only when the handle asks for it.
    pub fn manual(&mut self) -> TapHandle {
        let handle = TapHandle::default();
        self.prompt = Prompt::Key { handle: handle.clone(), answered: 0 };
        handle
    }

    /// The errors that stay constant over this test.
    pub fn errors(&self) -> &TestErrors {
        &self.errors
    }

    /// The last tap with its true values; it may still be about to happen.
    pub fn last_tap(&self) -> Option<&Tap> {
        self.last_tap.as_ref()
    }

    /// Lets the operator decide, before each scan, whether to tap.
    fn decide(&mut self) {
        let now = self.simulation.time();
        let scan = self.bench.adc.clock_stretch() / self.bench.adc.rate_hz;
        let start = match &mut self.prompt {
            // Decided one scan ahead, so that no contact begins in the past.
            Prompt::Rig { next } if self.taps < MOST_TAPS && now + scan >= *next => {
                let start = now.max(*next);
                *next = start + self.bench.operator.patience_s;
                start
            }
            Prompt::Key { handle, answered } if *answered != handle.presses() => {
                *answered = answered.wrapping_add(1);
                now + HAND_S
            }
            _ => return,
        };
        self.tap(start);
    }

    /// Prepares a tap at the DOF that the rig waits for.
    fn tap(&mut self, start: f64) {
        let unprompted =
            matches!(self.prompt, Prompt::Key { .. }).then_some((NO_ARMING, self.last_dof));
        let Some((arming, dof)) = self.armed.or(unprompted) else { return };
        let Some((node, point, direction)) = faults::mark(&self.bench, &self.layout, dof) else {
            return;
        };
        let mut rng = stream(self.seed, purpose(arming, dof, TAPS + u64::from(self.taps)));
        self.taps += 1;
        let habit = self.habit(dof, &direction);
        let scatter = self.sizes.hits.get(dof).copied().unwrap_or_else(HitUncertainty::none);
        let mark = (point, direction);
        let mut tap = Tap::draw(&self.bench, &scatter, dof, mark, &habit, start, &mut rng);
        if std::mem::take(&mut self.impatient) && tap.kind == TapKind::Good {
            tap.kind = TapKind::Impatient;
        }
        self.last_tap = Some(tap.clone());
        let now = self.simulation.time();
        self.drives.retain(|d| d.tap.end() >= now);
        // Cannot fail: `new` has refused layouts with a node at which the elastic modes are not defined.
        if let Ok(drive) = self.simulation.drive(&self.bench, node, tap) {
            self.drives.push(drive);
        }
    }

    /// Decides whether the object still swings from the tap before, and lets it.
    fn draw_impatience(&mut self, arming: u32, dof: usize) {
        let operator = &self.bench.operator;
        let mut rng = stream(self.seed, purpose(arming, dof, IMPATIENCE));
        self.impatient = rng.random::<f64>() < operator.impatient_rate;
        let Some((node, point, direction)) =
            faults::mark(&self.bench, &self.layout, dof).filter(|_| self.impatient)
        else {
            return;
        };
        let [least, most] = operator.impatient_share;
        let share = least + (most - least) * rng.random::<f64>();
        let mean = Tap::mean(&self.bench, dof, (point, direction));
        // Cannot fail, as in `tap`.
        if let Ok(drive) = self.simulation.drive(&self.bench, node, mean) {
            self.simulation.swing(&drive, share, &mut rng);
        }
    }

    /// Puts the pad on the mark of a DOF, if there is one.
    fn put_pad(&mut self, dof: usize) {
        let mass = faults::pad_mass(&self.bench);
        let Some((_, mark, _)) =
            faults::mark(&self.bench, &self.layout, dof).filter(|_| mass > 0.0)
        else {
            return;
        };
        let body = compose(&[self.bench.body, point(mass, mark)]);
        let padded = Bench { body, ..self.bench.clone() };
        // Cannot fail where the object without the pad hangs.
        if let Ok(simulation) = Simulation::new(&padded, &self.layout, &self.errors) {
            self.simulation = simulation;
        }
    }

    /// The gain of each channel over that at the first hit of the test.
    fn gains(&self, arming: u32) -> Channels {
        let hits = self.layout.hits.len() * usize::from(self.layout.test.hits_per_dof);
        let last = hits.saturating_sub(1).max(1) as f64;
        // Armings are counted from one; those after rejected hits come on top.
        let share = (f64::from(arming.saturating_sub(1)) / last).min(1.0);
        faults::drift(&self.bench).map(|change| 1.0 + change * share)
    }

    /// What all hits at a DOF have in common.
    fn habit(&self, dof: usize, direction: &Vector3<f64>) -> HitHabit {
        let mut rng = stream(self.seed, HABITS + dof as u64);
        let axis = &self.errors.hits_axis;
        HitHabit::draw(&self.bench, &self.sizes, dof, direction, axis, &mut rng)
    }
}

impl ScanSource for BenchSource {
    fn adc(&self) -> AdcProperties {
        self.bench.converter(self.layout.sensors.len())
    }

    fn started(&mut self) {
        self.armed = None;
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.armed = Some((arming, dof));
        self.last_dof = dof;
        self.drives.clear();
        self.noise = stream(self.seed, purpose(arming, dof, NOISE));
        let disturbances = stream(self.seed, purpose(arming, dof, DISTURBANCES));
        self.put_pad(dof);
        self.simulation.set_gains(&self.gains(arming));
        self.simulation.reset(&mut self.noise, disturbances);
        self.losses = stream(self.seed, purpose(arming, dof, LOSSES));
        self.taps = 0;
        self.draw_impatience(arming, dof);
        match &mut self.prompt {
            Prompt::Rig { next } => *next = self.bench.operator.delay_s,
            Prompt::Key { handle, answered } => *answered = handle.presses(),
        }
    }

    fn next_scan(&mut self) -> Option<Scan> {
        loop {
            self.decide();
            let scan = self.simulation.scan(&self.drives, &mut self.noise);
            let rate = self.bench.adc.lost_rate;
            if rate == 0.0 || self.losses.random::<f64>() >= rate {
                return Some(scan);
            }
        }
    }
}

/// The constant errors of a test.
fn errors_of(bench: &Bench, sizes: &ErrorSizes, seed: u64) -> TestErrors {
    let mut errors = TestErrors::draw(bench, sizes, &mut stream(seed, TEST));
    if bench.mounting > 0 {
        let mounting = MOUNTINGS + u64::from(bench.mounting);
        errors.mount_again(sizes, &mut stream(seed, mounting));
    }
    errors
}

impl Bench {
    /// Its converter with this many sensors.
    pub fn converter(&self, sensors: usize) -> AdcProperties {
        let adc = &self.adc;
        AdcProperties {
            rate: Hertz(adc.rate_hz as f32),
            channels: 1 + 3 * sensors as u8,
            bits: adc.bits,
            reference: Volts(adc.reference_v as f32),
            channel_delay: Seconds(adc.channel_delay_s as f32),
        }
    }
}

fn purpose(arming: u32, dof: usize, purpose: u64) -> u64 {
    // 24 bits of arming, 8 of DOF, 32 of purpose: no two share a stream.
    (u64::from(arming) & 0x00ff_ffff) << 40 | (dof as u64 & 0xff) << 32 | (purpose & 0xffff_ffff)
}
