//! `a_irm_`: the inertia restraint method about the origin, step by step and as a whole.

use massline_shared::Real;
use massline_shared::identify::inertia_restraint::{ReferencePoint, Regression, solve};
use massline_shared::identify::{MassLines, ResponseInverse};
use nalgebra::Vector3;

use crate::Check;
use crate::layout::{GoldenDofs, GoldenResponses, SENSORS};

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    let origin = Vector3::zeros();
    let lines = |hit: usize| column(check, "H", layout.hits.len(), hit);
    let response = layout.response_matrix(&origin);
    let length = layout.characteristic_length();
    let inverse = ResponseInverse::new(&response, length)?;
    let mut regression = Regression::new(length);
    let mut forces = heapless::Vec::<R, 24>::new();
    let mut motions = heapless::Vec::<R, 24>::new();
    for (j, hit) in layout.hits.iter().enumerate() {
        let force = hit.unit_force(&origin);
        let motion = inverse.motion(&lines(j)?);
        regression.add(&motion, &force);
        forces.extend_from_slice(force.as_slice()).ok()?;
        motions.extend_from_slice(motion.as_slice()).ok()?;
    }
    let solution = regression.solve().ok()?;
    let mut dofs = GoldenDofs::new();
    for j in 0..layout.hits.len() {
        dofs.push((j, MassLines::without_scatter(lines(j)?))).ok()?;
    }
    let estimate = solve(&layout, &dofs, ReferencePoint::Origin).ok()?;

    check.response_rows("G", &response);
    check.numbers("F0", &row_major(&forces));
    check.numbers("X0", &row_major(&motions));
    check.numbers("phi", solution.phi.as_slice());
    check.numbers("theta", solution.body.theta().as_slice());
    check.numbers("rank", &[R::of(solution.rank as f64)]);
    check.numbers("cond", &[solution.condition]);
    check.numbers("rms", &[solution.rms]);
    check.numbers("principal_moments", solution.body.principal()?.moments.as_slice());
    // The complete method takes the same steps.
    check.numbers("theta", estimate.theta().as_slice());
    check.numbers("cond", &[estimate.condition]);
    Some(())
}

/// Column `index` of a matrix of accelerances `[channel][force]` of the inputs.
pub(crate) fn column<R: Real>(
    check: &Check<'_, '_, R>,
    name: &str,
    columns: usize,
    index: usize,
) -> Option<GoldenResponses<R>> {
    let mut values = check.input(name)?.skip(index).step_by(columns);
    let mut column = GoldenResponses::zeros(SENSORS);
    for to in column.iter_mut() {
        *to = values.next()?;
    }
    Some(column)
}

/// Six rows from columns of six.
pub(crate) fn row_major<R: Real>(columns: &[R]) -> heapless::Vec<R, 24> {
    (0..6).flat_map(|row| columns.iter().copied().skip(row).step_by(6)).take(24).collect()
}
