//! How precisely an estimate knows the ten properties, compared with what the user wants.

use nalgebra::SVector;

use crate::body::scale;
use crate::diagnosis::Code;
use crate::identify::{Estimate, Method};
use crate::layout::Target;
use crate::real::Real;

/// Half widths of the 95 % intervals of an estimate, and the limits that they are compared with.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::design::Precision;
/// # use massline_shared::identify::*;
/// # use massline_shared::layout::Target;
/// let layout = frame::layout();
/// let mass_lines = frame::mass_lines(&layout);
/// let observed = Observations::of_mass_lines(&layout, &mass_lines);
/// let mut memory = vec![0.0; workspace(&Method::ALL, layout.sensors.len(), layout.hits.len())];
/// let identification = identify(&observed, &observed.methods(), &IdentifySettings::default(), &mut memory);
/// let length = layout.characteristic_length();
/// let with_target = |target| Precision::of(identification.estimates(), target, length).unwrap();
/// let widths = with_target(Target::default()).widths();
/// assert!(with_target(Target { mass: Some(1.01 * widths.mass), ..Target::default() }).is_reached());
/// assert!(!with_target(Target { mass: Some(0.99 * widths.mass), ..Target::default() }).is_reached());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Precision<R> {
    /// Half widths of the 95 % intervals of `theta`.
    pub half_widths: SVector<R, 10>,
    /// Mass, characteristic length and `m L²`, for each property.
    pub scale: SVector<R, 10>,
    /// What is wanted.
    pub target: Target<R>,
    /// True when the data contradict the error budget: the intervals then promise too much.
    pub contradicted: bool,
}

/// The largest half widths of the 95 % intervals, in the units of a [`Target`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths<R> {
    /// Of the mass, relative to the mass.
    pub mass: R,
    /// Of the coordinates of the centre of mass, m.
    pub center: R,
    /// Of the elements of the inertia tensor, relative to `m L²`.
    pub inertia: R,
}

impl<R: Real> Precision<R> {
    /// The precision of the estimates of a test under a layout with the characteristic length `length`, m.
    /// `None` unless the best method has an answer: the intervals of the others do not cover the whole error
    /// budget.
    pub fn of(estimates: &[Estimate<R>], target: Target<R>, length: R) -> Option<Self> {
        let best = estimates.iter().find(|e| Some(e.method) == Method::of_mass_lines().next())?;
        let half_widths = best.half_widths()?;
        let contradicted =
            best.diagnostics.iter().any(|d| d.code == Code::DataInconsistentWithBudget);
        let scale = scale(best.body.mass, length);
        let usable = half_widths.iter().chain(scale.iter()).all(|v| v.finite() && *v > R::zero());
        usable.then_some(Self { half_widths, scale, target, contradicted })
    }

    /// The largest half widths.
    pub fn widths(&self) -> Widths<R> {
        let relative = self.half_widths.component_div(&self.scale);
        Widths {
            mass: relative[0],
            center: self.half_widths.fixed_rows::<3>(1).amax(),
            inertia: relative.fixed_rows::<6>(4).amax(),
        }
    }

    /// A half width of a property in the units of a [`Target`]: m for a coordinate of the centre of mass, relative
    /// to the property's scale for the others.
    pub fn in_target_units(&self, property: usize, half_width: R) -> R {
        match property {
            1..=3 => half_width,
            _ => half_width / self.scale[property],
        }
    }

    /// The half width wanted for a property, in its unit; the property's scale when there is no target at all.
    fn limit(&self, property: usize) -> Option<R> {
        let scale = self.scale[property];
        match property {
            _ if !self.target.is_set() => Some(scale),
            0 => self.target.mass.map(|share| share * scale),
            1..=3 => self.target.center,
            _ => self.target.inertia.map(|share| share * scale),
        }
    }

    /// The worst property, by its index in `theta`, and its half width over the limit. Without a target, the
    /// limits are the scales.
    pub fn worst(&self) -> (usize, R) {
        let mut worst = (0, R::zero());
        for property in 0..10 {
            let Some(limit) = self.limit(property) else { continue };
            let ratio = self.half_widths[property] / limit;
            if ratio > worst.1 {
                worst = (property, ratio);
            }
        }
        worst
    }

    /// True when every half width that is wanted is reached, and the data do not contradict the error budget.
    pub fn is_reached(&self) -> bool {
        self.target.is_set() && !self.contradicted && self.worst().1 <= R::one()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half widths of 1 % of the mass of 2 kg, 1 to 3 mm and 4 to 9 % of m L² with L = 0.1 m.
    fn precision(target: Target<f64>) -> Precision<f64> {
        let percents = [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        let scale = scale(2.0, 0.1);
        let half_widths = SVector::from(percents).component_mul(&scale) * 0.01;
        Precision { half_widths, scale, target, contradicted: false }
    }

    #[test]
    fn the_widths_are_the_largest_in_the_units_of_a_target() {
        let Widths { mass, center, inertia } = precision(Target::default()).widths();
        assert!((mass - 0.01).abs() < 1e-15, "{mass}");
        // 3 % of 0.1 m.
        assert!((center - 0.003).abs() < 1e-15, "{center}");
        assert!((inertia - 0.09).abs() < 1e-15, "{inertia}");
        let precision = precision(Target::default());
        let in_units = |k: usize| precision.in_target_units(k, precision.half_widths[k]);
        assert_eq!([in_units(0), in_units(3), in_units(9)], [mass, center, inertia]);
    }

    #[test]
    fn the_worst_property_is_the_farthest_from_its_limit() {
        let (property, ratio) = precision(Target::default()).worst();
        assert_eq!(property, 9);
        assert!((ratio - 0.09).abs() < 1e-15);
        // What is not wanted does not count.
        let target = Target { mass: Some(0.02), center: Some(0.0024), inertia: None };
        let (property, ratio) = precision(target).worst();
        assert_eq!(property, 3);
        assert!((ratio - 1.25).abs() < 1e-14);
    }

    #[test]
    fn a_target_is_reached_when_all_of_it_is_and_the_data_agree_with_the_budget() {
        let target = Target { mass: Some(0.02), center: Some(0.0031), inertia: None };
        let reached = precision(target);
        assert!(reached.is_reached());
        assert!(!Precision { contradicted: true, ..reached }.is_reached());
        assert!(!precision(Target { inertia: Some(0.08), ..target }).is_reached());
        assert!(!precision(Target::default()).is_reached(), "nothing is wanted");
    }
}
