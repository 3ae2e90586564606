//! What is asked of a prediction: its cost, the benefit of one more sensor or hit, and the cost of leaving one out.

use nalgebra::SVector;

use super::cost::{relative_variance, total};
use crate::capacity::{Capacity, List};
use crate::layout::{Hit, Layout, Sensor};
use crate::real::Real;

/// A standard deviation of this many times the scale comes from rounding in a singular information matrix:
/// the layout does not determine the inertial parameters.
const UNDETERMINED: f64 = 100.0;

/// Predicts how uncertain the ten properties will be that a layout yields.
pub trait Predict<R: Real> {
    /// Scale of each inertial parameter.
    fn scale(&self) -> &SVector<R, 10>;

    /// The predicted variances of `theta`, SI units; `None` when the layout does not determine the ten properties. What
    /// the workspace is for depends on the prediction.
    fn variances<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        workspace: &mut [R],
    ) -> Option<SVector<R, 10>>;

    /// The same prediction with this factor on the standard deviation of the noise.
    #[must_use]
    fn with_noise(&self, factor: R) -> Self;

    /// Sum of the ten relative variances predicted for a layout; `None` as for [`Self::variances`].
    fn cost<C: Capacity>(&self, layout: &Layout<R, C>, workspace: &mut [R]) -> Option<R> {
        let cost = relative_variance(&self.variances(layout, workspace)?, self.scale());
        (cost.finite() && total(cost) < R::of(UNDETERMINED)).then_some(cost)
    }

    /// The candidate for one more sensor that lowers the cost most, and the resulting cost. `None` when there
    /// is no room, or when no layout with one more sensor determines the ten properties.
    fn best_further_sensor<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        candidates: impl IntoIterator<Item = Sensor<R>>,
        workspace: &mut [R],
    ) -> Option<(Sensor<R>, R)> {
        let costs = candidates.into_iter().filter_map(|sensor| {
            let mut more = layout.clone();
            more.sensors.push(sensor).ok()?;
            Some((sensor, self.cost(&more, workspace)?))
        });
        least(costs)
    }

    /// As [`Self::best_further_sensor`], for one more hit.
    fn best_further_hit<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        candidates: impl IntoIterator<Item = Hit<R>>,
        workspace: &mut [R],
    ) -> Option<(Hit<R>, R)> {
        let costs = candidates.into_iter().filter_map(|hit| {
            let mut more = layout.clone();
            more.hits.push(hit).ok()?;
            Some((hit, self.cost(&more, workspace)?))
        });
        least(costs)
    }

    /// The cost when the DOF with this index is hit as often again: what scatters from hit to hit is halved in
    /// variance there. The noise of the sensors is not, so the cost is rather too large. `None` when the layout
    /// does not have that DOF or does not determine the ten properties.
    fn cost_with_repeated_hit<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        index: usize,
        workspace: &mut [R],
    ) -> Option<R> {
        let mut more = layout.clone();
        let scatter = &mut more.hits.get_mut(index)?.uncertainty;
        let part = R::of(core::f64::consts::FRAC_1_SQRT_2);
        (scatter.position, scatter.direction) = (scatter.position * part, scatter.direction * part);
        self.cost(&more, workspace)
    }

    /// The cost without each of the sensors in turn; `None` where the ten properties cannot be determined
    /// without it.
    fn costs_without_sensors<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        workspace: &mut [R],
    ) -> C::Sensors<Option<R>> {
        let less = (0..layout.sensors.len()).map(|index| {
            let mut less = layout.clone();
            less.sensors.remove(index);
            self.cost(&less, workspace)
        });
        less.collect()
    }

    /// As [`Self::costs_without_sensors`], for the hits.
    fn costs_without_hits<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        workspace: &mut [R],
    ) -> C::Hits<Option<R>> {
        let less = (0..layout.hits.len()).map(|index| {
            let mut less = layout.clone();
            less.hits.remove(index);
            self.cost(&less, workspace)
        });
        less.collect()
    }
}

fn least<T, R: Real>(costs: impl Iterator<Item = (T, R)>) -> Option<(T, R)> {
    costs.reduce(|best, next| if next.1 < best.1 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Unbounded;
    use crate::design::{Criterion, DEFAULT_NOISE};
    use crate::identify::maximum_likelihood::workspace;
    use crate::layout::tests::{bar_body, bar_layout, sensor};

    const WORKSPACE: usize = workspace(4, 8);

    /// Test 1 of the three-bar frame with room for one more sensor.
    fn bar() -> (Criterion<f64>, Layout<f64, Unbounded>) {
        let layout: Layout<f64, Unbounded> = bar_layout().cast().unwrap();
        (Criterion::new(bar_body(), layout.characteristic_length(), DEFAULT_NOISE), layout)
    }

    #[test]
    fn one_more_helps_and_the_far_one_more_than_the_near_one() {
        let (criterion, layout) = bar();
        let memory = &mut [0.0; WORKSPACE];
        let present = criterion.cost(&layout, memory).unwrap();
        let near = sensor(8, [0.2, 0.0, 0.01]);
        let far = sensor(9, [0.2, -0.2, 0.15]);
        let (best, cost) = criterion.best_further_sensor(&layout, [near, far], memory).unwrap();
        assert_eq!(best.node, 9);
        assert!(cost < present);
        let copies = layout.hits.iter().map(|hit| Hit { direction: [0.0, 0.6, 0.8], ..*hit });
        let (_, cost) = criterion.best_further_hit(&layout, copies, memory).unwrap();
        assert!(cost < present);
        let none = criterion.best_further_hit(&layout, [], memory);
        assert_eq!(none, None);
    }

    #[test]
    fn hitting_again_helps_and_every_dof_again_as_twice_the_hits() {
        let (criterion, layout) = bar();
        let memory = &mut [0.0; WORKSPACE];
        let present = criterion.cost(&layout, memory).unwrap();
        let again =
            |index, memory: &mut _| criterion.cost_with_repeated_hit(&layout, index, memory);
        let mut twice = layout.clone();
        twice.test.hits_per_dof *= 2;
        let least = criterion.cost(&twice, memory).unwrap();
        for index in 0..3 {
            let cost = again(index, memory).unwrap();
            assert!(least < cost && cost < present, "{least} {cost} {present}");
        }
        assert_eq!(again(3, memory), None);
    }

    #[test]
    fn an_indispensable_sensor_or_hit_has_no_cost_without_it() {
        let (criterion, layout) = bar();
        let memory = &mut [0.0; WORKSPACE];
        let present = criterion.cost(&layout, memory).unwrap();
        let hits = criterion.costs_without_hits(&layout, memory);
        assert_eq!(hits[..], [None; 3]);
        let sensors = criterion.costs_without_sensors(&layout, memory);
        // Two triaxial sensors still determine all ten properties (theory, section 4).
        assert!(sensors.iter().all(|cost| cost.unwrap() > present), "{sensors:?}");
    }
}
