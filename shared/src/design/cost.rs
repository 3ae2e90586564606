//! Costs by which a choice of sensors and hits can be judged.
//!
//! The usual score in experimental design is `ln det` of the information under white noise. It works poorly
//! here: under the whole error budget, such a design is three times worse than one chosen by the sum of the
//! relative variances (theory, section 8).

use nalgebra::SVector;

use crate::identify::maximum_likelihood::Bound;
use crate::real::Real;

/// `−ln det` of the information about `phi / [1, L, L, L, L² × 6]`, for a length L in m that is the same for
/// all layouts compared. The bound itself is scaled by the characteristic length of its own sensors.
pub fn minus_log_det<R: Real>(bound: &Bound<R>, own_length: R, length: R) -> R {
    // Each of the ten scales enters the determinant twice: 2 (3 + 6 · 2) powers of the length.
    -(bound.log_det_information + R::of(30.0) * (length / own_length).ln())
}

/// Sum of the ten variances, each over the square of its scale, see [`scale`](crate::body::scale).
pub fn relative_variance<R: Real>(variances: &SVector<R, 10>, scale: &SVector<R, 10>) -> R {
    variances.component_div(&scale.component_mul(scale)).sum()
}

/// Root mean square of the ten relative standard deviations; `cost` is the sum of their squares.
pub fn total<R: Real>(cost: R) -> R {
    (cost / R::of(10.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::scale;
    use crate::capacity::Rig;
    use crate::identify::maximum_likelihood::{RIG_WORKSPACE, bound};
    use crate::layout::tests::{bar_body, bar_layout};

    fn bar_bound() -> (Bound<f64>, f64) {
        let layout = bar_layout();
        let noise = |_| crate::responses::Responses::<f64, Rig>::repeat(3, 0.01);
        let bound = bound(&layout, &bar_body(), noise, 5, &mut [0.0; RIG_WORKSPACE]).unwrap();
        (bound, layout.characteristic_length())
    }

    #[test]
    fn the_length_scales_the_determinant() {
        let (bound, own) = bar_bound();
        let here = minus_log_det(&bound, own, own);
        assert_eq!(here, -bound.log_det_information);
        // Fifteen powers of the length, squared.
        let scaled_cost = minus_log_det(&bound, own, own * 1_f64.exp());
        assert!((scaled_cost - (here - 30.0)).abs() < 1e-12);
    }

    #[test]
    fn variances_count_over_their_scale() {
        let (bound, own) = bar_bound();
        let variances = bound.sigma().component_mul(&bound.sigma());
        let of_sigma = relative_variance(&variances, &bound.sigma());
        assert!((of_sigma - 10.0).abs() < 1e-13);
        let scale = scale(1.23, own);
        let sum = relative_variance(&variances, &scale);
        // Tenfold scales divide the sum by a hundred.
        assert!((relative_variance(&variances, &(scale * 10.0)) * 100.0 - sum).abs() < 1e-15);
    }
}
