//! The error budget that a fit uses: the stated one, or what the data have taught about it.

use crate::capacity::Capacity;
use crate::layout::{HitUncertainty, Layout, SensorUncertainty};
use crate::real::Real;

/// Factors on the standard deviations of the stated error budget. There is none on the hammer's gain, which
/// the residuals cannot show.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BudgetScales<R> {
    /// On the scatter of the hits' positions.
    pub hit_position: R,
    /// On the scatter of the hits' directions.
    pub hit_direction: R,
    /// On what stays the same over the test: gains, cross-axis sensitivities, rotations and positions of the
    /// sensors, and the marks that are hit.
    pub constant: R,
}

/// What a learned budget was learned from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LearnedFrom {
    /// The scatter of the hits from the differences between repeat hits, the constant scale from the residuals.
    #[default]
    RepeatHits,
    /// All three scales from the residuals, where no repeat hits show the scatter: what is constant is then the
    /// sensors alone, and the scales of position and direction are on the marks as well.
    Residuals,
}

/// What the data have taught about the error budget (theory, section 12).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LearnedBudget<R> {
    /// Learned over stated standard deviations.
    pub scales: BudgetScales<R>,
    /// Degrees of freedom of the scatter of position and of direction each; zero when the repeat hits are too
    /// few, and the stated scatter, or one learned from the residuals, is used.
    pub scatter_degrees_of_freedom: u16,
    /// What the scales were learned from. Not stored: a rig has its repeat hits.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub learned_from: LearnedFrom,
    /// Variance of the logarithm of the constant scale; zero when the residuals are too few, and the stated
    /// standard deviations are used.
    pub constant_log_variance: R,
    /// Factors on the half widths of the intervals of theta, at least one: the learned budget is uncertain
    /// itself.
    pub widening: [R; 10],
}

/// The error budget that a fit uses.
///
/// Two terms of second order in the errors of the hits matter when the hits scatter by more than 30 mrad
/// (theory, section 12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ErrorBudget {
    /// The stated budget, without the terms of second order: to compare with programs that lack them, and for
    /// readings without any scatter.
    FirstOrder,
    /// The stated budget.
    Stated,
    /// The budget learned from the data, with the stated one as prior (theory, section 12).
    #[default]
    Learned,
}

impl ErrorBudget {
    /// The stated budget where the layout does not permit learning.
    pub(super) fn permitted_by<R: Real, C: Capacity>(self, layout: &Layout<R, C>) -> Self {
        match self {
            Self::Learned if !layout.learn_budget => Self::Stated,
            permitted => permitted,
        }
    }
}

impl<R: Real> LearnedBudget<R> {
    /// True when what stays the same over the test is significantly more than twice what is stated: a mistake,
    /// such as a wrong axis, is then more likely than sensors of that quality. Chance alone does this in one of
    /// forty tests whose errors are twice those stated.
    pub fn exceeds_statement(&self) -> bool {
        let deviation = self.constant_log_variance.sqrt();
        let log_scale = libm::log(self.scales.constant.to_f64());
        log_scale - 2.0 * deviation.to_f64() > core::f64::consts::LN_2
    }

    /// Replaces the stated budget of a layout by the learned one.
    pub fn apply_to<C: Capacity>(&self, layout: &mut Layout<R, C>) {
        self.scales.apply_to(layout);
        if self.learned_from == LearnedFrom::Residuals {
            let BudgetScales { hit_position, hit_direction, constant } = self.scales;
            for hit in layout.hits.iter_mut() {
                hit.uncertainty.node_position *= hit_position / constant;
                hit.uncertainty.node_direction *= hit_direction / constant;
            }
        }
    }

    /// The same in another precision.
    pub fn cast<Q: Real>(&self) -> LearnedBudget<Q> {
        let to = |v: R| Q::of(v.to_f64());
        let BudgetScales { hit_position, hit_direction, constant } = self.scales;
        LearnedBudget {
            scales: BudgetScales {
                hit_position: to(hit_position),
                hit_direction: to(hit_direction),
                constant: to(constant),
            },
            scatter_degrees_of_freedom: self.scatter_degrees_of_freedom,
            learned_from: self.learned_from,
            constant_log_variance: to(self.constant_log_variance),
            widening: self.widening.map(to),
        }
    }
}

impl<R: Real> Default for BudgetScales<R> {
    /// The stated budget.
    fn default() -> Self {
        Self { hit_position: R::one(), hit_direction: R::one(), constant: R::one() }
    }
}

impl<R: Real> BudgetScales<R> {
    /// Replaces the stated budget of a layout by the scaled one.
    pub fn apply_to<C: Capacity>(&self, layout: &mut Layout<R, C>) {
        layout.sensors.iter_mut().for_each(|s| s.uncertainty = self.of_sensor(&s.uncertainty));
        layout.hits.iter_mut().for_each(|hit| hit.uncertainty = self.of_hit(&hit.uncertainty));
    }

    pub(super) fn of_hit(&self, stated: &HitUncertainty<R>) -> HitUncertainty<R> {
        HitUncertainty {
            position: stated.position * self.hit_position,
            direction: stated.direction * self.hit_direction,
            node_position: stated.node_position * self.constant,
            node_direction: stated.node_direction * self.constant,
        }
    }

    pub(super) fn of_sensor(&self, stated: &SensorUncertainty<R>) -> SensorUncertainty<R> {
        stated.scaled(self.constant)
    }
}
