//! Taps: what the hammer does when it is used well and when it is used badly.

use massline_shared::layout::HitUncertainty;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::errors::normal_vector;
use super::habit::HitHabit;
pub use super::habit::Tip;
use crate::bench::Bench;

/// Kind of a tap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TapKind {
    /// A correct tap.
    Good,
    /// Too little force.
    TooWeak,
    /// More force than the channels can measure.
    TooHard,
    /// The hammer bounces: a second tap follows.
    Double,
    /// The hammer brushes the object before it strikes.
    Grazing,
    /// The hammer stays on the object.
    SustainedContact,
    /// As long as with a soft tip.
    Soft,
    /// Lands beside the mark.
    Misplaced,
    /// The strongest response is flat at a share of its peak.
    Flat,
    /// Comes before the swinging of the tap before has died down.
    Impatient,
}

impl TapKind {
    /// The kinds of bad taps, in the order of
    /// [`OperatorSettings::rates`](super::settings::OperatorSettings).
    const WRONG: [Self; 8] = [
        Self::TooWeak,
        Self::TooHard,
        Self::Double,
        Self::Grazing,
        Self::SustainedContact,
        Self::Soft,
        Self::Misplaced,
        Self::Flat,
    ];
}

/// Force with which a hammer brushes the object, N; it does not trigger.
const GRAZE_N: f64 = 2.0;
/// Time from that contact to the strike, s: within the scans before the trigger. The two do not overlap: after a long
/// contact the time is this multiple of it.
const GRAZE_S: f64 = 0.012;
const GRAZE_CONTACTS: f64 = 1.5;
/// Force of a hammer that stays on the object, as a share of the peak, and its duration, s.
const SUSTAINED_SHARE: f64 = 0.3;
const SUSTAINED_S: f64 = 2.0;
/// Factor by which a soft tip lengthens the contact.
const SOFT: f64 = 5.0;
/// Distance of a misplaced tap from its mark, m.
const MISPLACED_M: f64 = 0.08;

/// Mean of `sin^1.5` over half a period: `Γ(5/4) / (√π Γ(7/4))`.
const PULSE_AREA: f64 = 0.556_417_894_4;

/// One contact of the hammer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// First touch, s after arming.
    pub start: f64,
    /// Contact time, s.
    pub duration: f64,
    /// Peak force, N.
    pub peak: f64,
}

impl Contact {
    /// Force at a time, N: `sin^1.5`, the pulse of a soft tip with Hertzian contact, whose slope is
    /// zero at both ends.
    pub fn force(&self, time: f64) -> f64 {
        let phase = (time - self.start) / self.duration;
        if phase <= 0.0 || phase >= 1.0 {
            return 0.0;
        }
        let sine = (std::f64::consts::PI * phase).sin();
        self.peak * sine * sine.sqrt()
    }

    /// Impulse of the contact, N s.
    pub fn impulse(&self) -> f64 {
        PULSE_AREA * self.peak * self.duration
    }

    /// When the contact ends, s after arming.
    pub fn end(&self) -> f64 {
        self.start + self.duration
    }
}

/// A tap with its true values.
#[derive(Clone, Debug, PartialEq)]
pub struct Tap {
    /// Index of the hit in the layout, from 0.
    pub dof: usize,
    /// What kind of tap it is.
    pub kind: TapKind,
    /// Where it landed, body frame, m.
    pub point: Vector3<f64>,
    /// Direction of the force: a unit vector in the body frame.
    pub direction: Vector3<f64>,
    /// What the tip of the hammer does besides.
    pub tip: Tip,
    /// Relative error of the hammer's gain at this DOF against the others.
    pub gain_error: f64,
    /// One contact, or two when the hammer bounced.
    pub contacts: Vec<Contact>,
}

impl Tap {
    /// Draws a tap at the marked point with this scatter, beginning at `start` seconds after arming.
    ///
    /// Every kind of tap draws the same number of random values, so that a rate changes nothing else.
    pub(super) fn draw(
        bench: &Bench,
        scatter: &HitUncertainty<f64>,
        dof: usize,
        (mark, along): (Vector3<f64>, Vector3<f64>),
        habit: &HitHabit,
        start: f64,
        rng: &mut ChaCha8Rng,
    ) -> Self {
        let (tap, operator) = (&bench.tap, &bench.operator);
        let across = Matrix3::identity() - along * along.transpose();
        let point = mark + across * normal_vector(rng) * scatter.position + habit.offset;
        let turn = habit.turn + across * normal_vector(rng) * scatter.direction;
        let direction = (along + turn).normalize();
        let kind = kind(bench, rng.random());
        let (range, time) = match kind {
            TapKind::TooWeak => (operator.too_weak_n, operator.too_weak_s),
            TapKind::TooHard => (operator.too_hard_n, operator.too_hard_s),
            _ => (tap.force_n, None),
        };
        let contact = Contact {
            // A random time within a scan.
            start: start + rng.random::<f64>() / bench.adc.rate_hz,
            duration: within(time.unwrap_or(tap.duration_s), rng.random()),
            peak: within(range, rng.random()),
        };
        let bounce = Contact {
            start: contact.end() + within(operator.double_gap_s, rng.random()),
            duration: within(tap.duration_s, rng.random()),
            peak: contact.peak * within(operator.double_share, rng.random()),
        };
        let contacts = match kind {
            TapKind::Double => vec![contact, bounce],
            TapKind::Grazing => {
                let graze = Contact { peak: GRAZE_N, ..contact };
                let strike = contact.start + GRAZE_S.max(GRAZE_CONTACTS * contact.duration);
                vec![graze, Contact { start: strike, ..contact }]
            }
            TapKind::SustainedContact => {
                vec![
                    contact,
                    Contact {
                        duration: SUSTAINED_S,
                        peak: SUSTAINED_SHARE * contact.peak,
                        ..contact
                    },
                ]
            }
            TapKind::Soft => vec![Contact { duration: SOFT * contact.duration, ..contact }],
            _ => vec![contact],
        };
        let beside = (across * Vector3::repeat(1.0)).normalize();
        let point = if kind == TapKind::Misplaced { point + beside * MISPLACED_M } else { point };
        Self { dof, kind, point, direction, tip: habit.tip, gain_error: habit.gain_error, contacts }
    }

    /// A tap on the mark of mean force and contact time, at the arming.
    pub(super) fn mean(
        bench: &Bench,
        dof: usize,
        (mark, along): (Vector3<f64>, Vector3<f64>),
    ) -> Self {
        let middle = |[low, high]: [f64; 2]| 0.5 * (low + high);
        let (duration, peak) = (middle(bench.tap.duration_s), middle(bench.tap.force_n));
        Self {
            dof,
            kind: TapKind::Good,
            point: mark,
            direction: along,
            tip: Tip::default(),
            gain_error: 0.0,
            contacts: vec![Contact { start: 0.0, duration, peak }],
        }
    }

    /// First touch, s after arming.
    pub fn start(&self) -> f64 {
        self.contacts.iter().map(|c| c.start).fold(f64::INFINITY, f64::min)
    }

    /// When the last contact ends, s after arming.
    pub fn end(&self) -> f64 {
        self.contacts.iter().map(Contact::end).fold(0.0, f64::max)
    }

    /// Largest peak force of its contacts, N.
    pub fn peak(&self) -> f64 {
        self.contacts.iter().map(|c| c.peak).fold(0.0, f64::max)
    }

    /// Impulse of all contacts, N s.
    pub fn impulse(&self) -> f64 {
        self.contacts.iter().map(Contact::impulse).sum()
    }

    /// Force at a time, N.
    pub fn force(&self, time: f64) -> f64 {
        self.contacts.iter().map(|c| c.force(time)).sum()
    }
}

fn kind(bench: &Bench, draw: f64) -> TapKind {
    let mut below = 0.0;
    for (kind, rate) in TapKind::WRONG.into_iter().zip(bench.operator.rates()) {
        below += rate;
        if draw < below {
            return kind;
        }
    }
    TapKind::Good
}

fn within([low, high]: [f64; 2], draw: f64) -> f64 {
    low + (high - low) * draw
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_sizes::ErrorSizes;
    use rand::SeedableRng;

    fn taps(bench: &Bench, count: u64) -> Vec<Tap> {
        let mark = (Vector3::zeros(), Vector3::new(0.0, 0.0, 1.0));
        let scatter = ErrorSizes::of_bench(bench, 0, 1).hits[0];
        (0..count)
            .map(|seed| {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                Tap::draw(bench, &scatter, 0, mark, &HitHabit::default(), 0.3, &mut rng)
            })
            .collect()
    }

    #[test]
    fn errors_of_point_and_direction_have_the_deviations_asked_for() {
        let bench = Bench::named("default").unwrap();
        let taps = taps(&bench, 4000);
        let rms = |value: &dyn Fn(&Tap) -> f64| {
            (taps.iter().map(|t| value(t).powi(2)).sum::<f64>() / 4000.0).sqrt()
        };
        // 4000 draws determine the standard deviation to 1.1 %; four times that is allowed.
        assert!((rms(&|t| t.point.x) / 0.002 - 1.0).abs() < 0.045);
        assert!((rms(&|t| t.direction.y) / 0.030 - 1.0).abs() < 0.045);
        assert!(taps.iter().all(|t| t.point.z == 0.0 && (t.direction.norm() - 1.0).abs() < 1e-12));
    }

    #[test]
    fn bad_taps_come_at_the_rates_asked_for() {
        let mut bench = Bench::named("default").unwrap();
        bench.operator.too_weak_rate = 0.2;
        bench.operator.too_hard_rate = 0.1;
        bench.operator.double_rate = 0.3;
        bench.operator.flat_rate = 0.25;
        let taps = taps(&bench, 4000);
        for (kind, rate) in [
            (TapKind::TooWeak, 0.2),
            (TapKind::TooHard, 0.1),
            (TapKind::Double, 0.3),
            (TapKind::Flat, 0.25),
        ] {
            let share = taps.iter().filter(|t| t.kind == kind).count() as f64 / 4000.0;
            // Four standard deviations of a share over 4000 draws.
            assert!((share - rate).abs() < 4.0 * (rate * (1.0 - rate) / 4000.0).sqrt());
        }
    }

    #[test]
    fn a_double_tap_has_two_separate_contacts() {
        let mut bench = Bench::named("default").unwrap();
        bench.operator.double_rate = 1.0;
        bench.operator.too_weak_rate = 0.0;
        bench.operator.too_hard_rate = 0.0;
        for tap in taps(&bench, 50) {
            let [first, second] = tap.contacts[..] else { panic!("not two contacts") };
            assert!((0.03..0.08).contains(&(second.start - first.end())));
            assert_eq!(tap.force(first.start + 0.5 * first.duration), first.peak);
            assert_eq!(tap.force(0.5 * (first.end() + second.start)), 0.0);
        }
    }
}
