//! The nuisance parameters of a fit, and the influence of sensors and hits on the answer.

use massline_shared::Estimated;
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::identify::influence::{Influence, Subject};
use massline_shared::identify::maximum_likelihood::{
    HitNuisances, NuisanceEstimates, SensorNuisances,
};
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout, Sensor};

use super::digits::{deviation, signed_as_exact_as, two_digits};
use crate::document::{self, Spread};
use crate::output;

/// An influence of more than this many standard deviations on a property is reported.
const MIN_INFLUENCE: f64 = 1.0;

/// All details of a fit.
pub fn details_json(
    nuisances: &NuisanceEstimates<f64, HOST_SENSORS, HOST_HITS>,
    influences: &[Influence<f64>],
    layout: &HostLayout,
) -> document::Details {
    let sensor = |(found, sensor): (&SensorNuisances<f64>, &Sensor<f64>)| document::SensorDetails {
        node: sensor.node,
        sensitivity: found.sensitivity.map(|row| row.map(Spread::from)),
        rotation_rad: found.rotation.map(Spread::from),
        position_m: found.position.map(Spread::from),
        pull: found.pull,
    };
    let hit = |found: &HitNuisances<f64>| document::HitDetails {
        dof: hit_name(layout, found.index),
        position_m: found.position.map(Spread::from),
        direction_rad: found.direction.map(Spread::from),
        pull: found.pull,
        normalized_residual: found.normalized_residual,
    };
    document::Details {
        hammer_gain: nuisances.hammer_gain.into(),
        sensors: nuisances.sensors.iter().zip(&layout.sensors).map(sensor).collect(),
        hits: nuisances.hits.iter().map(hit).collect(),
        influence: influences.iter().map(|of| influence_json(of, layout)).collect(),
        error_budget: None,
    }
}

fn influence_json(influence: &Influence<f64>, layout: &HostLayout) -> document::Influence {
    let (hit, sensor) = match influence.subject {
        Subject::Hit(index) => (Some(hit_name(layout, index)), None),
        Subject::Sensor(index) => (None, Some(sensor_node(layout, index))),
    };
    document::Influence {
        hit,
        sensor,
        shift_sigma: influence.shift.into(),
        sigma_ratio_without: influence.sigma_ratio,
        chi_squared: influence.share.chi_squared,
        equations: influence.share.degrees_of_freedom,
    }
}

/// The details as text: a table of the sensors, one of the hits, and the subjects with the largest influence.
pub fn details_text(
    nuisances: &NuisanceEstimates<f64, HOST_SENSORS, HOST_HITS>,
    influences: &[Influence<f64>],
    layout: &HostLayout,
) -> String {
    let mut sensors = output::table();
    sensors.set_header(["sensor", "gain, %", "rotation, mrad", "position, mm", "pull"]);
    for (found, sensor) in nuisances.sensors.iter().zip(&layout.sensors) {
        sensors.add_row(sensor_row(found, sensor.node));
    }
    let mut hits = output::table();
    hits.set_header(["hit", "position error, mm", "direction error, mrad", "pull", "residual"]);
    for found in &nuisances.hits {
        hits.add_row(hit_row(found, &hit_name(layout, found.index)));
    }
    let hammer = nuisances.hammer_gain;
    let mut text = format!(
        "Estimated nuisance parameters (± posterior standard deviation; pull in units of the \
         uncertainty in use, residual in units of the noise)\n\
         {sensors}\n{hits}\nhammer gain: {} %\n",
        deviation(100.0 * hammer.value, 100.0 * hammer.sigma)
    );
    for influence in influences.iter().filter(|i| i.largest_shift() > MIN_INFLUENCE) {
        text += &influence_line(influence, layout);
    }
    text
}

fn sensor_row(found: &SensorNuisances<f64>, node: u16) -> [String; 5] {
    let gains = [0, 1, 2].map(|k| found.sensitivity[k][k]);
    [
        node.to_string(),
        triple(&gains, 100.0),
        triple(&found.rotation, 1e3),
        triple(&found.position, 1e3),
        format!("{:.2}", found.pull),
    ]
}

fn hit_row(found: &HitNuisances<f64>, name: &str) -> [String; 5] {
    [
        name.into(),
        triple(&found.position, 1e3),
        triple(&found.direction, 1e3),
        format!("{:.2}", found.pull),
        format!("{:.2}", found.normalized_residual),
    ]
}

/// Three values and the largest of their standard deviations.
fn triple(estimated: &[Estimated<f64>; 3], factor: f64) -> String {
    let sigma = estimated.iter().map(|l| l.sigma * factor).fold(0.0, f64::max);
    let [x, y, z] = estimated.map(|l| signed_as_exact_as(l.value * factor, sigma));
    format!("{x} {y} {z} ± {}", two_digits(sigma))
}

fn influence_line(influence: &Influence<f64>, layout: &HostLayout) -> String {
    let name = match influence.subject {
        Subject::Hit(index) => format!("hit {}", hit_name(layout, index)),
        Subject::Sensor(index) => format!("the sensor on node {}", sensor_node(layout, index)),
    };
    let (property, shift) = INERTIAL_PARAMETERS.iter().zip(influence.shift.iter()).fold(
        ("", 0.0_f64),
        |most, (p, s)| if s.abs() > most.1.abs() { (p.symbol, *s) } else { most },
    );
    format!("without {name}, {property} would move by {shift:+.1} sd\n")
}

fn hit_name(layout: &HostLayout, index: usize) -> String {
    layout.hits.get(index).map_or_else(String::new, |hit| hit.dof.to_string())
}

fn sensor_node(layout: &HostLayout, index: usize) -> u16 {
    layout.sensors.get(index).map_or(0, |sensor| sensor.node)
}
