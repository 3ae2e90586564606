//! The scatter of the directions of hits that the readings of the suspension band show (theory, section 12): three
//! scales of the error budget, learned from the pulls of the global fit and their covariance as maximum likelihood
//! learns them from mass lines without repeat hits. The global fit takes that of the directions.

use massline_shared::Progress;
use massline_shared::identify::global_fit::nuisances;
use massline_shared::identify::maximum_likelihood::without_repeats::{
    DIRECTION, Evidence, GROUPS, POSITION, SENSORS, Scales,
};
use massline_shared::layout::{GRAVITY_QUANTITIES, HIT_QUANTITIES, HostLayout, SENSOR_QUANTITIES};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};

/// Learned over stated standard deviation of the directions, from pulls and their covariance under the stated budget;
/// `None` where the covariance has no inverse.
pub(super) fn direction_scale(
    layout: &HostLayout,
    pulls: &[f64],
    posterior: &[f64],
) -> Option<f64> {
    let count = pulls.len();
    let precision = DMatrix::from_row_slice(count, count, posterior).cholesky()?.inverse();
    let right = &precision * DVector::from_column_slice(pulls);
    let groups = groups(layout);
    let mut scales = Scales::stated();
    loop {
        let learned = scales.learned().scales;
        let factors = [learned.hit_position, learned.hit_direction, learned.constant];
        let factor = |place: usize| -> f64 { groups[place].map_or(1.0, |group| factors[group]) };
        let mut scaled = precision.clone();
        for place in 0..count {
            // The prior of a parameter in standard deviations has a precision of one.
            scaled[(place, place)] += factor(place).powi(-2) - 1.0;
        }
        let covariance = scaled.cholesky()?.inverse();
        let values = &covariance * &right;
        let mut evidence = Evidence {
            pulls: SVector::zeros(),
            traces: SVector::zeros(),
            squares: SMatrix::<f64, GROUPS, GROUPS>::zeros(),
        };
        let grouped = |place: usize| groups[place].map(|group| (place, group));
        for (a, of_a) in (0..count).filter_map(grouped) {
            evidence.pulls[of_a] += (values[a] / factor(a)).powi(2);
            for (b, of_b) in (0..count).filter_map(grouped) {
                let own = if a == b { 1.0 } else { 0.0 };
                let element = own - covariance[(a, b)] / (factor(a) * factor(b));
                evidence.squares[(of_a, of_b)] += element * element;
                if a == b {
                    evidence.traces[of_a] += element;
                }
            }
        }
        if scales.improve(&evidence)? == Progress::Done {
            return Some(scales.learned().scales.hit_direction);
        }
    }
}

/// The group of each nuisance parameter of the global fit, in its order.
fn groups(layout: &HostLayout) -> Vec<Option<usize>> {
    let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
    let mut groups = vec![Some(SENSORS); SENSOR_QUANTITIES * sensors];
    groups.extend([None; GRAVITY_QUANTITIES]);
    for _ in 0..hits {
        let mut of_hit = [None; HIT_QUANTITIES];
        of_hit[..2].fill(Some(POSITION));
        of_hit[2..4].fill(Some(DIRECTION));
        groups.extend(of_hit);
    }
    // The hammer and the attached bodies.
    groups.resize(nuisances(sensors, hits, layout.attached.len()), None);
    groups
}
