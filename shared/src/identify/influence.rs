//! Influence of each hit DOF and each sensor on the answer, from the fit without it.
//!
//! Look first at a subject that changes the answer by much more than its share, or without which the data
//! suddenly agree with their error budget.

use nalgebra::SVector;

use super::maximum_likelihood::{ErrorBudget, MaximumLikelihoodSolution, Start, solve};
use super::{Consistency, DofMassLines, ForceTrend, MassLines};
use crate::capacity::{Capacity, List};
use crate::layout::Layout;
use crate::real::Real;
use crate::responses::{ResponseSquare, Responses};

/// A hit DOF or sensor that is left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A hit DOF, by its index in the layout.
    Hit(usize),
    /// A sensor, by its index in the layout.
    Sensor(usize),
}

/// Effect of leaving a subject out.
#[derive(Clone, Debug, PartialEq)]
pub struct Influence<R> {
    /// What is left out.
    pub subject: Subject,
    /// The inertial parameters without it minus those with it, in standard deviations with it.
    pub shift: SVector<R, 10>,
    /// Largest ratio of a standard deviation without the subject to that with it: the benefit of the subject.
    pub sigma_ratio: R,
    /// Reduction of χ² and of the number of equations without the subject.
    pub share: Consistency<R>,
}

impl<R: Real> Influence<R> {
    /// Largest absolute shift of the ten properties, in standard deviations.
    pub fn largest_shift(&self) -> R {
        self.shift.amax()
    }
}

/// Calls `act` with the influence of every hit DOF and sensor on a maximum likelihood answer. Subjects
/// without which there is no answer are left out. `workspace` as for [`solve`].
///
/// With only three hits none can be left out (theory, section 4), so only the sensors are reported.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::influence::{Subject, influences};
/// # use massline_shared::identify::maximum_likelihood::{ErrorBudget, Start, solve, workspace};
/// let layout = frame::layout();
/// let dofs = frame::mass_lines(&layout);
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// let whole = solve(&layout, &dofs, Start::InertiaRestraint, ErrorBudget::Stated, &mut memory).unwrap();
/// let mut sensors = 0;
/// influences(&layout, &dofs, &whole, &mut memory, |influence| {
///     assert!(matches!(influence.subject, Subject::Sensor(_)));
///     // The data are exact, and every subject contributes.
///     assert!(influence.largest_shift() < 0.01 && influence.sigma_ratio > 1.0);
///     sensors += 1;
/// });
/// assert_eq!(sensors, 3);
/// ```
pub fn influences<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    whole: &MaximumLikelihoodSolution<R, C>,
    workspace: &mut [R],
    mut act: impl FnMut(Influence<R>),
) {
    let start = Start::At(&whole.estimate.body);
    for (index, _) in dofs {
        let others = dofs.iter().filter(|(other, _)| other != index).cloned();
        let others = C::Hits::truncated(others);
        if let Ok(without) = solve(layout, &others, start, ErrorBudget::Stated, workspace) {
            let equations = 3 * layout.sensors.len();
            act(compare(Subject::Hit(*index), whole, &without, equations));
        }
    }
    for sensor in 0..layout.sensors.len() {
        let mut fewer = layout.clone();
        fewer.sensors.remove(sensor);
        let others = dofs.iter().map(|(index, lines)| (*index, without_sensor(lines, sensor)));
        let others = C::Hits::truncated(others);
        if let Ok(without) = solve(&fewer, &others, start, ErrorBudget::Stated, workspace) {
            let equations = 3 * dofs.len();
            act(compare(Subject::Sensor(sensor), whole, &without, equations));
        }
    }
}

fn compare<R: Real, C: Capacity>(
    subject: Subject,
    whole: &MaximumLikelihoodSolution<R, C>,
    without: &MaximumLikelihoodSolution<R, C>,
    equations: usize,
) -> Influence<R> {
    let sigma = whole.estimate.sigma().unwrap_or_else(SVector::zeros);
    let wider = without.estimate.sigma().unwrap_or_else(SVector::zeros);
    let chi_squared = |solution: &MaximumLikelihoodSolution<R, C>| {
        solution.estimate.consistency.map_or(R::zero(), |c| c.chi_squared)
    };
    let share = (chi_squared(whole) - chi_squared(without)).max(R::zero());
    Influence {
        subject,
        shift: (without.estimate.theta() - whole.estimate.theta()).component_div(&sigma),
        sigma_ratio: wider.component_div(&sigma).max(),
        share: Consistency { chi_squared: share, degrees_of_freedom: equations as u16 },
    }
}

/// The mass lines of the other sensors.
fn without_sensor<R: Real, C: Capacity>(lines: &MassLines<R, C>, sensor: usize) -> MassLines<R, C> {
    let from = |channel: usize| if channel < 3 * sensor { channel } else { channel + 3 };
    let (sensors, last) = (lines.accelerance.sensors() - 1, lines.scatter.rows());
    let kept = |channel: usize| from(channel) < last;
    let pick =
        |vector: &Responses<R, C>| {
            Responses::from_fn(sensors, |channel| {
                if kept(channel) { vector[from(channel)] } else { R::zero() }
            })
        };
    MassLines {
        accelerance: pick(&lines.accelerance),
        noise: pick(&lines.noise),
        scatter: ResponseSquare::from_fn(sensors, |i, j| {
            if kept(i) && kept(j) { lines.scatter[(from(i), from(j))] } else { R::zero() }
        }),
        hits: lines.hits,
        trend: ForceTrend { products: pick(&lines.trend.products), ..lines.trend },
        band_shift: pick(&lines.band_shift),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Rig;
    use crate::identify::maximum_likelihood::{RIG_WORKSPACE, tests as fits};
    use std::vec::Vec;

    #[test]
    fn a_hit_at_a_wrong_place_stands_out() {
        let layout = fits::five_hits();
        let body = crate::layout::tests::bar_body();
        let mut displaced = layout.clone();
        displaced.hits[3].position[0] -= 0.05;
        let dofs = fits::exact(&displaced, &body);
        let whole = fits::fit(&layout, &dofs, None).unwrap();
        let mut influence_list = Vec::new();
        let mut workspace = [0.0; RIG_WORKSPACE];
        influences(&layout, &dofs, &whole, &mut workspace, |influence| {
            influence_list.push(influence)
        });
        assert_eq!(influence_list.len(), 8);
        let equivalent_z = |i: &Influence<f64>| i.share.equivalent_z();
        let most = influence_list
            .iter()
            .max_by(|a, b| equivalent_z(a).total_cmp(&equivalent_z(b)))
            .unwrap();
        assert_eq!(most.subject, Subject::Hit(3));
        assert!(most.largest_shift() > 1.0);
        assert!(
            influence_list.iter().all(|i| i.sigma_ratio > 0.99),
            "nothing is gained by leaving out"
        );
    }

    #[test]
    fn without_a_sensor_the_others_move_up() {
        let accelerance = Responses::from_fn(3, |k| k as f64);
        let lines = MassLines::<f64, Rig>::without_scatter(accelerance);
        let left = without_sensor(&lines, 1);
        assert_eq!(left.accelerance.as_slice(), [0.0, 1.0, 2.0, 6.0, 7.0, 8.0, 0.0, 0.0, 0.0]);
    }
}
