//! `[tap]` and `[operator]`.

use super::{DURATION, FORCE, OFFSET, SHARE, SIGMA, SettingProblem};

settings! {
    /// `[tap]`: the distribution from which each good tap is drawn.
    TapSettings, "a table [tap]" {
        /// Peak force, from and to, N.
        force_n: [f64; 2] = [18.0, 30.0], FORCE;
        /// Contact time, from and to, s.
        duration_s: [f64; 2] = [0.004, 0.006], DURATION;
        /// Error of the point of impact along each axis normal to the direction, 1 σ, m.
        point_sigma_m: f64 = 0.002, SIGMA;
        /// Tilt of the hammer about each axis normal to the direction, 1 σ, rad.
        direction_sigma_rad: f64 = 0.030, SIGMA;
        /// Error of each mark against the layout along each axis normal to the direction, 1 σ, m; drawn once for
        /// each DOF.
        mark_position_sigma_m: f64 = 0.0, SIGMA;
        /// Error of the direction at each mark about each axis normal to it, 1 σ, rad; drawn once for each DOF.
        mark_direction_sigma_rad: f64 = 0.0, SIGMA;
        /// Distance from the mark at which all hits of a DOF land, across their direction, m; the side is
        /// drawn once for each DOF.
        offset_m: f64 = 0.0, OFFSET;
        /// Free moment of the tip: the arm that times the force gives it, m; its axis, any in space, is drawn
        /// once for each DOF.
        free_moment_m: f64 = 0.0, OFFSET;
        /// Lateral force of the tip as a share of the force, which the hammer does not measure; its direction
        /// across is drawn once for each DOF.
        lateral: f64 = 0.0, SHARE;
    }
}

settings! {
    /// `[operator]`: the person with the hammer.
    OperatorSettings, "a table [operator]", contradiction {
        /// Rig time between *armed* and the tap, s.
        delay_s: f64 = 0.3, 0.0..=600.0;
        /// Rig time between a tap that does not trigger and the next one, s; after ten such taps the operator
        /// waits for the next arming.
        patience_s: f64 = 3.0, 1e-3..=600.0;
        /// Share of the taps that are too weak.
        too_weak_rate: f64 = 0.03, SHARE;
        /// Peak force of these, from and to, N.
        too_weak_n: [f64; 2] = [4.5, 6.5], FORCE;
        /// Contact time of these, from and to, s; that of good taps when it is left out. A tap may also be too
        /// weak because it is too short.
        too_weak_s: Option<[f64; 2]> = None, DURATION;
        /// Share of the taps that are too hard.
        too_hard_rate: f64 = 0.02, SHARE;
        /// Peak force of these, from and to, N; more than the hammer channel can measure.
        too_hard_n: [f64; 2] = [150.0, 200.0], FORCE;
        /// Contact time of these, from and to, s; that of good taps when it is left out.
        too_hard_s: Option<[f64; 2]> = None, DURATION;
        /// Share of the taps that bounce: a second, weaker one follows.
        double_rate: f64 = 0.0, SHARE;
        /// Time between the two, from and to, s.
        double_gap_s: [f64; 2] = [0.03, 0.08], 1e-4..=10.0;
        /// Peak force of the second over that of the first, from and to.
        double_share: [f64; 2] = [0.3, 0.7], SHARE;
        /// Share of the taps before which the hammer brushes the object.
        grazing_rate: f64 = 0.0, SHARE;
        /// Share of the taps after which the hammer stays on the object.
        sustained_contact_rate: f64 = 0.0, SHARE;
        /// Share of the taps made with a soft tip: the contact is five times as long.
        soft_rate: f64 = 0.0, SHARE;
        /// Share of the taps that land 80 mm beside the mark.
        misplaced_rate: f64 = 0.0, SHARE;
        /// Share of the taps whose strongest response is flat at a share of its peak.
        flat_rate: f64 = 0.0, SHARE;
        /// This share: the response channel of the largest rigid-body accelerance to the tap ends at this
        /// times its rigid response to the peak force.
        flat_level: f64 = 0.75, SHARE;
        /// Share of the armings at which the object still swings from the tap before, because the person has not
        /// waited; it counts apart from the other shares.
        impatient_rate: f64 = 0.0, SHARE;
        /// How much it still swings: the amplitude of each mode over that which a tap of mean force and contact
        /// time excites, from and to. The phases are drawn.
        impatient_share: [f64; 2] = [0.05, 0.3], SHARE;
        /// Tilt of each position of a tumble test about each of two axes, 1 σ, rad.
        tilt_sigma_rad: f64 = 0.003, SIGMA;
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

    fn contradiction(&self) -> SettingProblem {
        let share: f64 = self.rates().into_iter().sum();
        (share > 1.0).then(|| ("too_weak_rate", "the rates add up to more than 1".into()))
    }
}
