//! How precise the answer of a campaign would be so far, in words.

use massline_analysis::precision::PrecisionReport;
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::design::{FurtherHit, Widths};

use super::two_digits;

/// `4 of 12 DOFs`.
pub fn progress(report: &PrecisionReport<'_>) -> String {
    format!("{} of {} DOFs", report.measured, report.layout.hits.len())
}

/// The half widths of the intervals; empty when more DOFs are needed.
pub fn widths(report: &PrecisionReport<'_>) -> String {
    report.precision.as_ref().map_or_else(String::new, |known| in_words(&known.widths()))
}

/// The report: one or two lines.
pub fn text(report: &PrecisionReport<'_>) -> String {
    if report.precision.is_none() {
        return format!("after {}: {}", progress(report), advice(report));
    }
    let (widths, advice) = (widths(report), advice(report).replace('\n', "\n  "));
    format!("after {}, 95 % intervals: {widths}\n  {advice}", progress(report))
}

/// What is known worst and what helps, one or two lines.
pub fn advice(report: &PrecisionReport<'_>) -> String {
    let Some(precision) = &report.precision else {
        return "more DOFs are needed for the ten properties".into();
    };
    let mut text = String::new();
    if precision.contradicted {
        text += "the data contradict the error budget, so these intervals promise too much\n";
    }
    let (worst, _) = precision.worst();
    let now = precision.in_target_units(worst, precision.half_widths[worst]);
    let symbol = INERTIAL_PARAMETERS[worst].symbol;
    text += &format!("the worst is {symbol}, {}", width(worst, now));
    if let Some(FurtherHit { dof, property, half_width }) = report.further {
        text += &format!(
            "; a further hit helps most at {}: about {}",
            report.dof(dof),
            width(property, precision.in_target_units(property, half_width)),
        );
    } else if report.measured < report.layout.hits.len() {
        text += "; no further hit of the layout would narrow it by 1 %: what limits it is the same in every hit, such \
                 as the gain of the hammer";
    }
    text
}

/// `mass ±0.83 %, centre ±0.92 mm, inertia ±1.8 % of m L²`.
fn in_words(&Widths { mass, center, inertia }: &Widths<f64>) -> String {
    format!("mass {}, centre {}, inertia {}", width(0, mass), width(1, center), width(4, inertia))
}

/// The half width of a property, in the units of a target.
fn width(property: usize, half: f64) -> String {
    match property {
        1..=3 => format!("±{} mm", two_digits(1000.0 * half)),
        0 => format!("±{} %", two_digits(100.0 * half)),
        _ => format!("±{} % of m L²", two_digits(100.0 * half)),
    }
}

#[cfg(test)]
mod tests {
    use massline_shared::body::RigidBody;
    use massline_shared::design::Precision;
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::{Estimate, Method};
    use massline_shared::layout::{HostLayout, Target};
    use nalgebra::{SMatrix, SVector};

    use super::*;

    fn layout() -> HostLayout {
        let example = include_str!("../../../examples/three-bar-test-1.toml");
        massline_files::layout_file::LayoutFile::parse(example, "test").unwrap().layout
    }

    #[test]
    fn before_the_properties_are_determined_more_dofs_are_needed() {
        let layout = layout();
        let so_far = PrecisionReport {
            layout: &layout,
            measured: 2,
            precision: None,
            further: None,
            body: None,
        };
        assert_eq!(text(&so_far), "after 2 of 3 DOFs: more DOFs are needed for the ten properties");
        assert_eq!(widths(&so_far), "");
    }

    #[test]
    fn afterwards_the_intervals_and_the_best_further_hit_are_named() {
        let layout = layout();
        let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
        // Standard deviations of 0.01 kg, 1 mm and 1e-4 kg m²: half widths of 0.98 % and 1.96 mm.
        let sigma = SVector::<f64, 10>::from_fn(|k, _| match k {
            0 => 0.01,
            1..=3 => 1e-3,
            _ => 1e-4,
        });
        let estimate = Estimate {
            method: Method::MaximumLikelihood,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: Some(SMatrix::from_diagonal(&sigma.component_mul(&sigma))),
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        };
        let length = layout.characteristic_length();
        let precision = Precision::of(&[estimate], Target::default(), length);
        assert!(precision.is_some());
        let further = Some(FurtherHit { dof: 2, property: 0, half_width: 0.0042 });
        let so_far =
            PrecisionReport { layout: &layout, measured: 2, precision, further, body: None };
        let text = text(&so_far);
        let mass = "after 2 of 3 DOFs, 95 % intervals: mass ±0.98 %, centre ±2.0 mm, inertia ±";
        assert!(text.starts_with(mass), "{text}");
        let dof = layout.hits[2].dof;
        assert!(
            text.contains(&format!("; a further hit helps most at {dof}: about ±0.")),
            "{text}"
        );
    }
}
