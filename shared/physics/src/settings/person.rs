//! `[tap]` and `[operator]`.

use std::ops::RangeInclusive;

use serde::Deserialize;

use super::{FORCE, OFFSET, SHARE, SIGMA, SettingProblem, out_of_range, range_problem};

/// `[tap]`: the distribution from which each good tap is drawn.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [tap]")]
pub struct TapSettings {
    /// Peak force, from and to, N.
    pub force_n: [f64; 2],
    /// Contact time, from and to, s.
    pub duration_s: [f64; 2],
    /// Error of the point of impact along each axis normal to the direction, 1 σ, m.
    pub point_sigma_m: f64,
    /// Tilt of the hammer about each axis normal to the direction, 1 σ, rad.
    pub direction_sigma_rad: f64,
    /// Error of each mark against the layout along each axis normal to the direction, 1 σ, m; drawn once for
    /// each DOF.
    pub mark_position_sigma_m: f64,
    /// Error of the direction at each mark about each axis normal to it, 1 σ, rad; drawn once for each DOF.
    pub mark_direction_sigma_rad: f64,
    /// Distance from the mark at which all hits of a DOF land, across their direction, m; the side is
    /// drawn once for each DOF.
    pub offset_m: f64,
    /// Free moment of the tip: the arm that times the force gives it, m; its axis, any in space, is drawn
    /// once for each DOF.
    pub free_moment_m: f64,
    /// Lateral force of the tip as a share of the force, which the hammer does not measure; its direction
    /// across is drawn once for each DOF.
    pub lateral: f64,
}

impl Default for TapSettings {
    fn default() -> Self {
        Self {
            force_n: [18.0, 30.0],
            duration_s: [0.004, 0.006],
            point_sigma_m: 0.002,
            direction_sigma_rad: 0.030,
            mark_position_sigma_m: 0.0,
            mark_direction_sigma_rad: 0.0,
            offset_m: 0.0,
            free_moment_m: 0.0,
            lateral: 0.0,
        }
    }
}

impl TapSettings {
    pub(crate) fn problem(&self) -> SettingProblem {
        out_of_range(&[
            (self.point_sigma_m, "point_sigma_m", SIGMA),
            (self.direction_sigma_rad, "direction_sigma_rad", SIGMA),
            (self.mark_position_sigma_m, "mark_position_sigma_m", SIGMA),
            (self.mark_direction_sigma_rad, "mark_direction_sigma_rad", SIGMA),
            (self.offset_m, "offset_m", OFFSET),
            (self.free_moment_m, "free_moment_m", OFFSET),
            (self.lateral, "lateral", SHARE),
        ])
        .or(range_problem(self.force_n, "force_n", FORCE))
        .or(range_problem(self.duration_s, "duration_s", DURATION))
    }
}

/// Allowed contact time, s.
const DURATION: RangeInclusive<f64> = 1e-5..=1.0;

/// `[operator]`: the person with the hammer.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [operator]")]
pub struct OperatorSettings {
    /// Rig time between *armed* and the tap, s.
    pub delay_s: f64,
    /// Rig time between a tap that does not trigger and the next one, s; after ten such taps the operator
    /// waits for the next arming.
    pub patience_s: f64,
    /// Share of the taps that are too weak.
    pub too_weak_rate: f64,
    /// Peak force of these, from and to, N.
    pub too_weak_n: [f64; 2],
    /// Contact time of these, from and to, s; that of good taps when it is left out. A tap may also be too
    /// weak because it is too short.
    pub too_weak_s: Option<[f64; 2]>,
    /// Share of the taps that are too hard.
    pub too_hard_rate: f64,
    /// Peak force of these, from and to, N; more than the hammer channel can measure.
    pub too_hard_n: [f64; 2],
    /// Contact time of these, from and to, s; that of good taps when it is left out.
    pub too_hard_s: Option<[f64; 2]>,
    /// Share of the taps that bounce: a second, weaker one follows.
    pub double_rate: f64,
    /// Time between the two, from and to, s.
    pub double_gap_s: [f64; 2],
    /// Peak force of the second over that of the first, from and to.
    pub double_share: [f64; 2],
    /// Share of the taps before which the hammer brushes the object.
    pub grazing_rate: f64,
    /// Share of the taps after which the hammer stays on the object.
    pub sustained_contact_rate: f64,
    /// Share of the taps made with a soft tip: the contact is five times as long.
    pub soft_rate: f64,
    /// Share of the taps that land 80 mm beside the mark.
    pub misplaced_rate: f64,
    /// Share of the taps whose strongest response is flat at a share of its peak.
    pub flat_rate: f64,
    /// This share: the response channel of the largest rigid-body accelerance to the tap ends at this
    /// times its rigid response to the peak force.
    pub flat_level: f64,
    /// Share of the armings at which the object still swings from the tap before, because the person has not
    /// waited; it counts apart from the other shares.
    pub impatient_rate: f64,
    /// How much it still swings: the amplitude of each mode over that which a tap of mean force and contact
    /// time excites, from and to. The phases are drawn.
    pub impatient_share: [f64; 2],
    /// Tilt of each position of a tumble test about each of two axes, 1 σ, rad.
    pub tilt_sigma_rad: f64,
}

impl Default for OperatorSettings {
    fn default() -> Self {
        Self {
            delay_s: 0.3,
            patience_s: 3.0,
            too_weak_rate: 0.03,
            too_weak_n: [4.5, 6.5],
            too_weak_s: None,
            too_hard_rate: 0.02,
            too_hard_n: [150.0, 200.0],
            too_hard_s: None,
            double_rate: 0.0,
            double_gap_s: [0.03, 0.08],
            double_share: [0.3, 0.7],
            grazing_rate: 0.0,
            sustained_contact_rate: 0.0,
            soft_rate: 0.0,
            misplaced_rate: 0.0,
            flat_rate: 0.0,
            flat_level: 0.75,
            impatient_rate: 0.0,
            impatient_share: [0.05, 0.3],
            tilt_sigma_rad: 0.003,
        }
    }
}

impl OperatorSettings {
    /// Shares of the bad taps: too weak, too hard, double, grazing, sustained contact, soft, misplaced,
    /// flat.
    pub(crate) fn rates(&self) -> [f64; 8] {
        [
            self.too_weak_rate,
            self.too_hard_rate,
            self.double_rate,
            self.grazing_rate,
            self.sustained_contact_rate,
            self.soft_rate,
            self.misplaced_rate,
            self.flat_rate,
        ]
    }

    pub(crate) fn problem(&self) -> SettingProblem {
        let share: f64 = self.rates().into_iter().sum();
        out_of_range(&[
            (self.delay_s, "delay_s", 0.0..=600.0),
            (self.patience_s, "patience_s", 1e-3..=600.0),
            (self.too_weak_rate, "too_weak_rate", SHARE),
            (self.too_hard_rate, "too_hard_rate", SHARE),
            (self.double_rate, "double_rate", SHARE),
            (self.grazing_rate, "grazing_rate", SHARE),
            (self.sustained_contact_rate, "sustained_contact_rate", SHARE),
            (self.soft_rate, "soft_rate", SHARE),
            (self.misplaced_rate, "misplaced_rate", SHARE),
            (self.flat_rate, "flat_rate", SHARE),
            (self.flat_level, "flat_level", SHARE),
            (self.impatient_rate, "impatient_rate", SHARE),
            (self.tilt_sigma_rad, "tilt_sigma_rad", SIGMA),
        ])
        .or(range_problem(self.too_weak_n, "too_weak_n", FORCE))
        .or(range_problem(self.too_hard_n, "too_hard_n", FORCE))
        .or(range_problem(self.double_gap_s, "double_gap_s", 1e-4..=10.0))
        .or(range_problem(self.double_share, "double_share", SHARE))
        .or(range_problem(self.impatient_share, "impatient_share", SHARE))
        .or_else(|| range_problem(self.too_weak_s?, "too_weak_s", DURATION))
        .or_else(|| range_problem(self.too_hard_s?, "too_hard_s", DURATION))
        .or((share > 1.0).then(|| ("too_weak_rate", "the rates add up to more than 1".into())))
    }
}
