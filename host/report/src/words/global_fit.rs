//! What the global fit finds besides the ten properties, as part of a result and as text.

use massline_shared::identify::REJECTION_Z;
use massline_shared::identify::global_fit::GlobalFitSolution;
use nalgebra::Matrix6;

use massline_result::GlobalFit;

/// How many terms the suspension needed; empty for stiffness and damping alone.
pub fn global_fit_text(fit: &GlobalFit) -> String {
    let z = fit.extra_terms_z.iter().flatten().next().copied().unwrap_or_default();
    let terms = match fit.extra_terms {
        0 => return String::new(),
        1 => "s⁴ R",
        _ => "s⁴ R and s⁶ Q",
    };
    format!(
        "global fit: a flexible mode above the band shows (z = {z:.1}, {REJECTION_Z} is the limit); the fit includes \
         {terms}\n"
    )
}

/// Stiffness and damping about the origin of the body frame, extra terms and noise.
pub fn global_fit(solution: &GlobalFitSolution<f64>) -> GlobalFit {
    GlobalFit {
        stiffness: rows(&solution.stiffness),
        damping: solution.damping.as_ref().map(rows),
        extra_terms: solution.extra_terms,
        extra_terms_z: solution.extra_terms_z.to_vec(),
        // Of a complex number, as that of the modes.
        noise_m_per_s2_per_n: solution.noise * std::f64::consts::SQRT_2,
    }
}

fn rows(matrix: &Matrix6<f64>) -> Vec<[f64; 6]> {
    matrix.row_iter().map(|row| row.transpose().into()).collect()
}
