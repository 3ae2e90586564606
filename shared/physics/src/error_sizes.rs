//! How large the errors are that a test on the bench has: as the bench says, or as the error budget of the layout says.

use massline_shared::layout::{
    ApparatusUncertainty, HitUncertainty, HostLayout, SensorUncertainty,
};

use crate::bench::Bench;
use crate::settings::ErrorsFrom;

/// Standard deviations of the errors of sensors, hits, hammer and gravity that a test on the bench has.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSizes {
    /// Of each sensor.
    pub sensors: Vec<SensorUncertainty<f64>>,
    /// Of the hits at each DOF.
    pub hits: Vec<HitUncertainty<f64>>,
    /// Of hammer and gravity; the converter of a bench has its own model.
    pub apparatus: ApparatusUncertainty<f64>,
}

impl ErrorSizes {
    /// Those of a test with this layout.
    pub fn of(bench: &Bench, layout: &HostLayout) -> Self {
        match bench.errors {
            ErrorsFrom::Bench => Self::of_bench(bench, layout.sensors.len(), layout.hits.len()),
            ErrorsFrom::Layout => Self {
                sensors: layout.sensors.iter().map(|sensor| sensor.uncertainty).collect(),
                hits: layout.hits.iter().map(|hit| hit.uncertainty).collect(),
                apparatus: layout.apparatus,
            },
        }
    }

    /// Those that the bench file states.
    pub(super) fn of_bench(bench: &Bench, sensors: usize, hits: usize) -> Self {
        let (sensor, hammer, tap) = (&bench.sensor, &bench.hammer, &bench.tap);
        let of_sensor = SensorUncertainty {
            position: sensor.position_sigma_m,
            rotation: sensor.rotation_sigma_rad,
            gain: sensor.gain_sigma,
            cross_axis: sensor.cross_axis_sigma,
        };
        let of_hit = HitUncertainty {
            position: tap.point_sigma_m,
            direction: tap.direction_sigma_rad,
            node_position: tap.mark_position_sigma_m,
            node_direction: tap.mark_direction_sigma_rad,
        };
        let apparatus = ApparatusUncertainty {
            hammer_gain: hammer.gain_sigma,
            hit_gain: hammer.hit_gain_sigma,
            gravity_direction: bench.gravity_tilt_sigma_rad,
            ..ApparatusUncertainty::none()
        };
        Self { sensors: vec![of_sensor; sensors], hits: vec![of_hit; hits], apparatus }
    }
}
