//! Which hit shows a mode, and which would show it better.

use nalgebra::{Vector3, Vector6};

use super::norm_indicator_of_shape;
use crate::capacity::Capacity;
use crate::layout::{Axis, Dof, Layout, Sign, balanced_motion, unit_force};
use crate::real::Real;

/// Share of the largest possible Norm Indicator below which the hits hardly show a mode.
const HARDLY: f64 = 0.2;

/// How well the hits of a test show a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeVisibility<R> {
    /// The measured hit that shows it best, as a place in the layout.
    pub hit: usize,
    /// Its [Norm Indicator](norm_indicator_of_shape).
    pub indicator: R,
    /// The largest Norm Indicator of any hit along an axis of the body at a point of the layout.
    pub possible: R,
    /// That hit, along an axis of the body, which at a node with local axes is not the DOF of this name.
    pub better: Dof,
}

impl<R: Real> ModeVisibility<R> {
    /// How well these hits of the layout, as places in it, show the mode of this shape at the sensors' centroid. `None`
    /// without hits.
    pub fn of<C: Capacity>(
        shape: &Vector6<R>,
        layout: &Layout<R, C>,
        hits: impl IntoIterator<Item = usize>,
    ) -> Option<Self> {
        let reference = layout.sensor_centroid();
        let length = layout.characteristic_length();
        let of_hits = hits.into_iter().filter_map(|place| {
            let force = layout.hits.get(place)?.unit_force(&reference);
            Some((norm_indicator_of_shape(shape, &force, length), place))
        });
        let (indicator, hit) = largest(of_hits)?;
        let size = balanced_motion(shape, length).norm();
        let every = candidates(layout).map(|(dof, force)| (size * shape.dot(&force).abs(), dof));
        let (possible, better) = largest(every)?;
        Some(Self { hit, indicator, possible, better })
    }

    /// True when all hits hardly show the mode, so that [`Self::better`] is worth making.
    pub fn is_hardly_shown(&self) -> bool {
        self.indicator < self.possible * R::of(HARDLY)
    }

    /// What share of the possible the best hit shows.
    pub fn share(&self) -> R {
        self.indicator / self.possible
    }
}

fn largest<R: Real, T>(values: impl Iterator<Item = (R, T)>) -> Option<(R, T)> {
    values.reduce(|most, next| if next.0 > most.0 { next } else { most })
}

/// Hits along every axis of the body at every point of the layout, with force and torque of 1 N about the sensors'
/// centroid. The points of the hits come first, because beside a sensor it is hard to hit.
pub fn candidates<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
) -> impl Iterator<Item = (Dof, Vector6<R>)> + '_ {
    let sensors = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position));
    let points = layout.hits.iter().map(|hit| (hit.dof.node, hit.position)).chain(sensors);
    let reference = layout.sensor_centroid();
    points.flat_map(move |(node, point)| {
        Axis::ALL.into_iter().map(move |axis| {
            let direction = Vector3::ith(axis.index(), R::one());
            (
                Dof { node, sign: Sign::Plus, axis },
                unit_force(&point.into(), &direction, &reference),
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Rig;
    use crate::layout::tests::bar_layout;

    #[test]
    fn a_mode_that_no_hit_moves_names_a_hit_that_does() {
        let mut layout: Layout<f64, Rig> = bar_layout().cast().unwrap();
        layout.hits.iter_mut().for_each(|hit| hit.direction = [1.0, 0.0, 0.0]);
        let every_hit = || 0..layout.hits.len();
        let along = |k: usize| Vector6::ith(k, 1.0);
        let shown = ModeVisibility::of(&along(0), &layout, every_hit()).unwrap();
        // Every hit is along the motion, and the indicator is the square of the shape.
        assert_eq!((shown.indicator, shown.possible, shown.is_hardly_shown()), (1.0, 1.0, false));
        let shown = ModeVisibility::of(&along(1), &layout, every_hit()).unwrap();
        assert_eq!((shown.indicator, shown.possible, shown.is_hardly_shown()), (0.0, 1.0, true));
        assert_eq!(shown.better.axis, Axis::Y);
        assert_eq!(shown.share(), 0.0);
        assert_eq!(ModeVisibility::of(&along(1), &layout, []), None);
    }
}
