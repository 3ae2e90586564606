//! One estimate of the ten properties as part of a result.

use std::array::from_fn;

use massline_result::{Properties, Spread};
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::Estimate;
use nalgebra::Matrix3;

use super::budget::learned_budget;
use super::{findings, known};

/// An entry of `results`.
pub fn estimate_of(
    estimate: &Estimate<f64>,
    message_of: impl Fn(&Diagnostic) -> String,
) -> massline_result::Estimate {
    let Estimate { body, covariance, .. } = estimate;
    let sigma: Option<[f64; 10]> = estimate.sigma().map(Into::into);
    let principal = body.principal();
    let sigma_tensor = sigma.map(|s| {
        let [.., xx, yy, zz, xy, xz, yz] = s;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    });
    massline_result::Estimate {
        method: estimate.method.into(),
        mass_kg: Spread { value: body.mass, sigma: sigma.map(|s| s[0]) },
        center_of_mass_m: Spread {
            value: body.center_of_mass.into(),
            sigma: sigma.map(|s| [s[1], s[2], s[3]]),
        },
        inertia_kg_m2: Spread { value: rows(&body.inertia), sigma: sigma_tensor },
        interval95: intervals(estimate),
        covariance: covariance.map(|c| from_fn(|i| from_fn(|j| c[(i, j)]))),
        principal_moments_kg_m2: massline_result::PrincipalMoments {
            value: principal.map(|p| p.moments.into()),
            sigma: estimate.principal_moment_sigmas().map(Into::into),
        },
        principal_axes: principal.map(|p| rows(&p.axes)),
        physically_consistent: body.is_physically_consistent(),
        condition: known(estimate.condition),
        chi_squared: estimate.consistency.map(|c| massline_result::ChiSquared {
            value: c.chi_squared,
            degrees_of_freedom: c.degrees_of_freedom,
            reduced: c.reduced(),
        }),
        learned_budget: estimate.learned.as_ref().map(learned_budget),
        diagnostics: findings(&estimate.diagnostics, message_of),
    }
}

/// The bounds of the 95 % interval of each of the ten properties; `None` where the scatter between hits is all that is
/// known.
fn intervals(estimate: &Estimate<f64>) -> Option<Properties<[f64; 2]>> {
    let widths = estimate.half_widths().filter(|_| estimate.has_complete_uncertainty())?;
    let values = estimate.theta();
    Some(Properties::of(from_fn(|k| [values[k] - widths[k], values[k] + widths[k]])))
}

/// A matrix row by row.
fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::message;
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::{HALF_WIDTH_95, Method};
    use nalgebra::{SMatrix, SVector};
    use serde_json::{Value, json};

    fn estimate() -> Estimate<f64> {
        // A body with the principal moments 2, 3, 4 about the axes y, x, z.
        let theta = [2.0, 0.5, 0.25, -0.125, 3.0, 2.0, 4.0, 0.0, 0.0, 0.0];
        let variances = SVector::<f64, 10>::from_fn(|k, _| ((k + 1) as f64).powi(2));
        Estimate {
            method: Method::InertiaRestraint,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: Some(SMatrix::from_diagonal(&variances)),
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        }
    }

    #[test]
    fn principal_moments_ascend_and_axes_are_columns() {
        let json: Value = json!(estimate_of(&estimate(), message));
        let moments = &json["principal_moments_kg_m2"];
        for (k, (value, sigma)) in [(2.0, 6.0), (3.0, 5.0), (4.0, 7.0)].into_iter().enumerate() {
            // The tolerance covers the rounding of an eigenvalue problem in double precision.
            assert!((moments["value"][k].as_f64().unwrap() - value).abs() < 1e-12);
            assert!((moments["sigma"][k].as_f64().unwrap() - sigma).abs() < 1e-12);
        }
        let element = |i: usize, j: usize| json["principal_axes"][i][j].as_f64().unwrap().abs();
        // The first axis is y: the first column has its one in the second row.
        assert!((element(1, 0) - 1.0).abs() < 1e-12 && element(0, 0) < 1e-12);
    }

    #[test]
    fn intervals_are_about_the_value_of_their_name() {
        let json: Value = json!(estimate_of(&estimate(), message));
        let [low, high] = [0, 1].map(|k| json["interval95"]["c_z"][k].as_f64().unwrap());
        assert!((low + high + 0.25).abs() < 1e-12, "{json}");
        assert!((high - low - 8.0 * HALF_WIDTH_95).abs() < 1e-12, "{json}");
    }

    #[test]
    fn without_covariance_there_is_no_sigma() {
        let json: Value = json!(estimate_of(&Estimate { covariance: None, ..estimate() }, message));
        assert!(json["covariance"].is_null() && json["interval95"].is_null());
        assert!(json["mass_kg"]["sigma"].is_null());
        assert!(json["principal_moments_kg_m2"]["sigma"].is_null());
        assert_eq!(json["mass_kg"]["value"], 2.0);
    }
}
