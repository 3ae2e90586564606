//! What acts on the object although nobody declares it: the boards of the sensors and cables that pull.
//!
//! Both change the rigid modes. The elastic modes stay those of the bare object.

use massline_shared::layout::HostLayout;
use nalgebra::Vector3;

use super::body::{compose, point};
use super::errors::TestErrors;
use super::faults;
use super::suspension::{RigidMode, SuspensionError, rigid_modes_with_springs};
use crate::bench::Bench;

/// The rigid modes of the object with its boards and cables: six, or twelve with a part on springs of its own.
pub(super) fn loaded_modes(
    bench: &Bench,
    layout: &HostLayout,
    errors: &TestErrors,
) -> Result<Vec<RigidMode>, SuspensionError> {
    let mass = bench.sensor.board_mass_kg + faults::board_mass(bench);
    let body = if mass > 0.0 {
        // What does not sense gravity, such as a laser, stands beside the object.
        let sensors = layout.sensors.iter().zip(&errors.sensors);
        let boards = sensors
            .filter(|(sensor, _)| sensor.senses_gravity)
            .map(|(sensor, error)| point(mass, Vector3::from(sensor.position) + error.position));
        compose(&std::iter::once(bench.body).chain(boards).collect::<Vec<_>>())
    } else {
        bench.body
    };
    let cables = faults::cables(bench, layout);
    let modes = rigid_modes_with_springs(&body, &bench.suspension, &bench.gravity, &cables)?;
    match &bench.sprung_part {
        Some(part) => part.modes(&body.mass_matrix(), &modes, &bench.body.mass_matrix()),
        None => Ok(modes.to_vec()),
    }
}
