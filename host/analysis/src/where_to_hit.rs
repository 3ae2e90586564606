//! Which hits would show what the hits of a test do not show.

use std::fmt;

use massline_shared::layout::{Dof, HostLayout, balanced_force, motion_at};
use massline_shared::modes::{ModeVisibility, candidates};
use nalgebra::{Matrix6xX, Vector6};

use crate::suspension::ModeRow;

/// Singular value of the unit forces, relative to the largest, below which a direction is not hit.
const NOT_HIT: f64 = 0.05;
/// Share of a force that must lie outside those of the hits for it to be new.
pub const NEW: f64 = 0.2;

/// A hit that is worth making.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    dof: Dof,
    /// A sensor stands there, so that only the point beside it can be hit.
    at_sensor: bool,
}

impl Place {
    /// The point, and the direction along an axis of the body, which a node with local axes may call otherwise.
    pub fn dof(&self) -> String {
        self.dof.to_string()
    }

    fn of(dof: Dof, layout: &HostLayout) -> Self {
        Self { dof, at_sensor: layout.sensors.iter().any(|sensor| sensor.node == dof.node) }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let beside = if self.at_sensor { ", beside the sensor" } else { "" };
        write!(f, "{} (axes of the body{beside})", self.dof)
    }
}

/// For a mode that no hit shows well, what share of the possible the best one shows, and a hit that shows most.
pub fn better_hit(row: &ModeRow, layout: &HostLayout) -> Option<(f64, Place)> {
    let shape = motion_at(&row.shape, &layout.sensor_centroid());
    let shown = ModeVisibility::of(&shape, layout, 0..layout.hits.len())?;
    shown.is_hardly_shown().then(|| (shown.share(), Place::of(shown.better, layout)))
}

/// A hit whose force and torque are least like those of all hits so far; `None` when these span all six directions.
pub fn new_direction(layout: &HostLayout) -> Option<Place> {
    HitDirections::of(layout)?.newest(layout)
}

/// The directions of force and torque, about the sensors' centroid and in balanced variables, that the hits of a layout
/// span.
pub struct HitDirections {
    /// Orthonormal.
    directions: Vec<Vector6<f64>>,
    length: f64,
}

impl HitDirections {
    /// Those of all hits of this layout; `None` for numbers that are not finite.
    pub fn of(layout: &HostLayout) -> Option<Self> {
        let length = layout.characteristic_length();
        let forces: Vec<_> = layout
            .hits
            .iter()
            .map(|hit| balanced_force(&hit.unit_force(&layout.sensor_centroid()), length))
            .collect();
        if forces.is_empty() {
            return Some(Self { directions: Vec::new(), length });
        }
        let decomposed = Matrix6xX::from_columns(&forces).svd(true, false);
        let (vectors, values) = (decomposed.u?, decomposed.singular_values);
        let is_hit = |value: f64| value > NOT_HIT * values.max();
        let hit = vectors.column_iter().zip(&values).filter(|(_, value)| is_hit(**value));
        let directions = hit.map(|(vector, _)| vector.into_owned()).collect();
        Some(Self { directions, length })
    }

    /// The share of a force and torque that lies outside of them.
    pub fn share_outside(&self, force: &Vector6<f64>) -> f64 {
        let force = balanced_force(force, self.length);
        let directions = self.directions.iter();
        let left = directions.fold(force, |left, vector| left - vector * vector.dot(&force));
        left.norm() / force.norm()
    }

    /// The hit along an axis of the body, at a point of this layout, of which most lies outside; `None` where it is
    /// little.
    pub fn newest(&self, layout: &HostLayout) -> Option<Place> {
        let (share, dof) = candidates(layout)
            .map(|(dof, force)| (self.share_outside(&force), dof))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        (share > NEW).then(|| Place::of(dof, layout))
    }
}
