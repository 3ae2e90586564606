//! What a layout can reach: the Cramér-Rao bound of the ten properties.

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3};

use super::{Hit, Layout};
use crate::Real;
use crate::body::{RigidBody, regressor};
use crate::linalg::{LeastSquares, cholesky, forward_substitute, skew};

/// The random errors of a test, all standard deviations of a single hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget<R> {
    /// Of every accelerance, (m/s²)/N.
    pub accelerance: R,
    /// Of the point of action across the direction, m.
    pub hit_position: R,
    /// Of the direction, rad.
    pub hit_direction: R,
    /// Hits averaged at each DOF.
    pub hits: u16,
}

/// The smallest uncertainty that any unbiased method can reach.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction<R> {
    /// Covariance of `theta`.
    pub covariance: SMatrix<R, 10, 10>,
    /// `ln det` of the information about `phi / [1, L, L, L, L² × 6]`.
    pub log_det_information: R,
}

impl<R: Real> Prediction<R> {
    /// Standard deviations of `theta`.
    pub fn sigma(&self) -> SVector<R, 10> {
        self.covariance.diagonal().map(|v| v.max(R::zero()).sqrt())
    }
}

/// Bound of the covariance of the ten properties of `body` under a layout and an error budget
/// (theory, section 4): information `Σⱼ Jⱼᵀ Sⱼ⁻¹ Jⱼ` over the hits, with
/// `∂H/∂phiₖ = −G M₀⁻¹ Eₖ M₀⁻¹ f₀` and `Sⱼ` the noise and the errors of point and direction of the hit
/// over the number of hits. `None` when the layout does not determine all ten, when `Sⱼ` is not
/// positive definite (no noise at all), or when the body has no inertia.
pub fn predict<R: Real, const S: usize, const H: usize, const CH: usize>(
    layout: &Layout<R, S, H>,
    body: &RigidBody<R>,
    budget: &Budget<R>,
) -> Option<Prediction<R>> {
    let length = layout.characteristic_length();
    let scale = body_scale(length);
    // Through M₀⁻¹, rows of the readings over the forces: [a; α] = M₀⁻¹ f₀.
    let readings: SMatrix<R, CH, 6> =
        layout.response_matrix::<CH>(&Vector3::zeros()) * body.inverse_mass_matrix()?;
    let mut information = LeastSquares::<R, 10>::new();
    for hit in &layout.hits {
        let covariance = readings_covariance(&readings, hit, budget);
        let whitener = cholesky(&covariance)?;
        let motion = body.acceleration(&hit.unit_force(&Vector3::zeros()))?;
        let by_phi = SMatrix::<R, 6, 10>::from_fn({
            let rows = regressor(&motion);
            move |i, k| -rows[i][k] / scale[k]
        });
        let mut slope = readings * by_phi;
        for mut column in slope.column_iter_mut() {
            let mut white = column.clone_owned();
            forward_substitute(&whitener, &mut white);
            column.copy_from(&white);
        }
        // Beyond the last sensor there is neither a reading nor a row.
        for i in 0..3 * layout.sensors.len() {
            information.push(core::array::from_fn(|k| slope[(i, k)]), R::zero());
        }
    }
    if information.spectrum()?.rank < 10 {
        return None;
    }
    let mut covariance = SMatrix::<R, 10, 10>::identity();
    let to_theta = body.dtheta_dphi();
    if !information.solve_normal(&mut covariance.data.0) {
        return None;
    }
    for (k, mut column) in covariance.column_iter_mut().enumerate() {
        column.component_div_assign(&scale);
        column.unscale_mut(scale[k]);
    }
    let covariance = to_theta * covariance * to_theta.transpose();
    let log_det_information = information.log_det_normal();
    (log_det_information.finite() && covariance.iter().all(|v| v.finite()))
        .then_some(Prediction { covariance, log_det_information })
}

/// `[1, 1/L, 1/L, 1/L, 1/L² × 6]`, by which `phi` becomes comparable.
fn body_scale<R: Real>(length: R) -> SVector<R, 10> {
    SVector::from_fn(|k, _| match k {
        0 => R::one(),
        1..4 => R::one() / length,
        _ => R::one() / (length * length),
    })
}

/// `(σ² I + G M₀⁻¹ (s_q² F_q F_qᵀ + s_d² F_d F_dᵀ) M₀⁻ᵀ Gᵀ) / n` with `F_q = [0; −[d]ₓ] P`,
/// `F_d = [I; [q]ₓ] P`, `P = I − d dᵀ`.
fn readings_covariance<R: Real, const CH: usize>(
    readings: &SMatrix<R, CH, 6>,
    hit: &Hit<R>,
    budget: &Budget<R>,
) -> SMatrix<R, CH, CH> {
    let d = Vector3::from(hit.direction);
    let across = Matrix3::identity() - d * d.transpose();
    let by_point = -(skew(&d) * across) * budget.hit_position;
    let by_direction = across * budget.hit_direction;
    let torque = skew(&Vector3::from(hit.position)) * by_direction;
    let mut causes = Matrix6::zeros();
    causes.fixed_view_mut::<3, 3>(3, 0).copy_from(&by_point);
    causes.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_direction);
    causes.fixed_view_mut::<3, 3>(3, 3).copy_from(&torque);
    let spread: SMatrix<R, CH, 6> = readings * causes;
    let noise = budget.accelerance * budget.accelerance;
    let hits = R::of(f64::from(budget.hits.max(1)));
    (SMatrix::<R, CH, CH>::from_diagonal_element(noise) + spread * spread.transpose()) / hits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{bar_body, bar_layout};

    const BUDGET: Budget<f64> =
        Budget { accelerance: 0.01, hit_position: 0.002, hit_direction: 0.03, hits: 5 };

    #[test]
    fn four_times_the_hits_halve_the_deviations() {
        let (layout, body) = (bar_layout(), bar_body());
        let few = predict::<f64, 3, 4, 9>(&layout, &body, &BUDGET).unwrap();
        let many = Budget { hits: 20, ..BUDGET };
        let many = predict::<f64, 3, 4, 9>(&layout, &body, &many).unwrap();
        // Rounding times the condition of the information, 2e4.
        assert!((few.sigma() - many.sigma() * 2.0).norm() < 1e-11);
        let gain = many.log_det_information - few.log_det_information;
        assert!((gain - 10.0 * 4.0_f64.ln()).abs() < 1e-9);
    }

    #[test]
    fn rows_beyond_the_last_sensor_add_nothing() {
        let (layout, body) = (bar_layout(), bar_body());
        let wide: Layout<f64, 8, 24> = layout.cast().unwrap();
        let tight = predict::<f64, 3, 4, 9>(&layout, &body, &BUDGET).unwrap();
        let wide = predict::<f64, 8, 24, 24>(&wide, &body, &BUDGET).unwrap();
        assert!((tight.sigma() - wide.sigma()).norm() < 1e-11);
    }

    #[test]
    fn what_cannot_be_determined_has_no_bound() {
        let (mut layout, body) = (bar_layout(), bar_body());
        assert!(
            predict::<f64, 3, 4, 9>(&layout, &body, &Budget { accelerance: 0.0, ..BUDGET })
                .is_none()
        );
        layout.hits.truncate(1);
        assert!(predict::<f64, 3, 4, 9>(&layout, &body, &BUDGET).is_none());
    }
}
