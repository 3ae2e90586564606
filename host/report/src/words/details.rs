//! The nuisance parameters of a fit, and the influence of sensors and hits on the answer.

use crate::table::table;
use massline_result::{Details, Spread};
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::capacity::Unbounded;
use massline_shared::identify::influence::{Influence, Subject};
use massline_shared::identify::maximum_likelihood::{
    HitNuisances, NuisanceEstimates, SensorNuisances,
};
use massline_shared::layout::{HostLayout, Sensor};

use super::digits::{deviation, signed_as_exact_as, two_digits};
use super::known;

/// An influence of more than this many standard deviations on a property is reported.
const MIN_INFLUENCE: f64 = 1.0;

/// All details of a fit.
pub fn fit_details(
    nuisances: &NuisanceEstimates<f64, Unbounded>,
    influences: &[Influence<f64>],
    layout: &HostLayout,
) -> massline_result::Details {
    let sensor = |(correction, sensor): (&SensorNuisances<f64>, &Sensor<f64>)| {
        massline_result::SensorDetails {
            node: sensor.node,
            sensitivity: correction.sensitivity.map(|row| row.map(Spread::from)),
            rotation_rad: correction.rotation.map(Spread::from),
            position_m: correction.position.map(Spread::from),
            pull: known(correction.pull),
        }
    };
    let hit = |correction: &HitNuisances<f64>| massline_result::HitDetails {
        dof: hit_name(layout, correction.index),
        position_m: correction.position.map(Spread::from),
        direction_rad: correction.direction.map(Spread::from),
        pull: known(correction.pull),
        normalized_residual: known(correction.normalized_residual),
    };
    massline_result::Details {
        hammer_gain: nuisances.hammer_gain.into(),
        sensors: nuisances.sensors.iter().zip(&layout.sensors).map(sensor).collect(),
        hits: nuisances.hits.iter().map(hit).collect(),
        influence: influences.iter().map(|influence| influence_in(influence, layout)).collect(),
        error_budget: None,
    }
}

fn influence_in(influence: &Influence<f64>, layout: &HostLayout) -> massline_result::Influence {
    let (hit, sensor) = match influence.subject {
        Subject::Hit(index) => (Some(hit_name(layout, index)), None),
        Subject::Sensor(index) => (None, Some(sensor_node(layout, index))),
    };
    massline_result::Influence {
        hit,
        sensor,
        shift_sigma: <[f64; 10]>::from(influence.shift).map(known),
        sigma_ratio_without: known(influence.sigma_ratio),
        chi_squared: influence.share.chi_squared,
        equations: influence.share.degrees_of_freedom,
    }
}

/// The details as text: a table of the sensors, one of the hits, and the subjects with the largest influence.
pub fn details_text(details: &Details) -> String {
    let mut sensors = table();
    sensors.set_header(["sensor", "gain, %", "rotation, mrad", "position, mm", "pull"]);
    for sensor in &details.sensors {
        let gains = [0, 1, 2].map(|k| sensor.sensitivity[k][k]);
        sensors.add_row([
            sensor.node.to_string(),
            triple(&gains, 100.0),
            triple(&sensor.rotation_rad, 1e3),
            triple(&sensor.position_m, 1e3),
            hundredths(sensor.pull),
        ]);
    }
    let mut hits = table();
    hits.set_header(["hit", "position error, mm", "direction error, mrad", "pull", "residual"]);
    for hit in &details.hits {
        hits.add_row([
            hit.dof.clone(),
            triple(&hit.position_m, 1e3),
            triple(&hit.direction_rad, 1e3),
            hundredths(hit.pull),
            hundredths(hit.normalized_residual),
        ]);
    }
    let hammer = details.hammer_gain;
    let mut text = format!(
        "corrections that the fit made (± posterior standard deviation; pull in units of the uncertainty in use, \
         residual in units of the noise)\n{sensors}\n{hits}\nhammer gain: {} %\n",
        deviation(100.0 * hammer.value, 100.0 * hammer.sigma.unwrap_or(f64::NAN))
    );
    for influence in
        details.influence.iter().filter(|influence| influence.largest_shift().1 > MIN_INFLUENCE)
    {
        text += &influence_line(influence);
    }
    text
}

/// A number with two decimals; a dash where it is not known.
fn hundredths(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.2}"))
}

/// Three values and the largest of their standard deviations.
fn triple(spread: &[Spread<f64>; 3], factor: f64) -> String {
    let sigma =
        spread.iter().map(|axis| axis.sigma.unwrap_or(f64::NAN) * factor).fold(0.0, f64::max);
    let [x, y, z] = spread.map(|axis| signed_as_exact_as(axis.value * factor, sigma));
    format!("{x} {y} {z} ± {}", two_digits(sigma))
}

fn influence_line(influence: &massline_result::Influence) -> String {
    let name = match (&influence.hit, influence.sensor) {
        (Some(dof), _) => format!("hit {dof}"),
        (None, Some(node)) => format!("the sensor on node {node}"),
        (None, None) => "one of them".into(),
    };
    let (property, _) = influence.largest_shift();
    let (symbol, shift) =
        (INERTIAL_PARAMETERS[property].symbol, influence.shift_sigma[property].unwrap_or_default());
    format!("without {name}, {symbol} would move by {shift:+.1} sd\n")
}

fn hit_name(layout: &HostLayout, index: usize) -> String {
    layout.hits.get(index).map_or_else(String::new, |hit| hit.dof.to_string())
}

fn sensor_node(layout: &HostLayout, index: usize) -> u16 {
    layout.sensors.get(index).map_or(0, |sensor| sensor.node)
}
