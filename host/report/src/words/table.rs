//! The ten properties as a table for people.

use crate::table as terminal;
use massline_result::Estimate;
use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter, scale};

use super::{as_exact_as, in_interval, two_digits, with_half_width};
use crate::table::Table;

/// What stands under every table of the ten properties. Books differ in the sign of a product of inertia.
pub const INERTIA_CONVENTION: &str = "J about the centre of mass, body axes; J_xy = −∫xy dm";

/// The values that are 100 % of the ten properties: m, L, L, L and m L² (six times), with the expected mass where one
/// is stated. `None` where L, m, is not known.
pub fn scale_of(
    estimate: &Estimate,
    expected: &[Option<f64>; 10],
    length: Option<f64>,
) -> Option<[f64; 10]> {
    let mass = expected[0].unwrap_or(estimate.mass_kg.value);
    length.filter(|length| *length > 0.0).map(|length| scale(mass, length).into())
}

/// The ten properties with half the widths of their 95 % intervals, in units and in % of scale, and beside them what is
/// expected and the error in % of scale. `length` is L, m.
pub fn table(estimate: &Estimate, expected: &[Option<f64>; 10], length: Option<f64>) -> Table {
    let scale = scale_of(estimate, expected, length);
    let has_expected = expected.iter().any(Option::is_some);
    let mut table = terminal::table();
    let mut header = vec!["", "value", "± 95 %", "unit"];
    if scale.is_some() {
        header.insert(3, "%");
    }
    if has_expected {
        header.push("expected");
        header.extend(scale.map(|_| "error, %"));
    }
    let columns = header.len();
    table.set_header(header);
    let (theta, half) = (estimate.theta(), estimate.half_widths());
    for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
        let &InertialParameter { symbol, table_unit: unit, table_factor: factor, .. } = parameter;
        let width = half.map(|half| half[k] * factor);
        let number = |si: f64| in_interval(si * factor, width);
        let percent = |si: f64| scale.map(|scale| 100.0 * si / scale[k]);
        let spread = half.map_or("-".to_owned(), |half| number(half[k]));
        let mut row = vec![symbol.to_owned(), number(theta[k]), spread];
        if scale.is_some() {
            let relative = half.and_then(|half| percent(half[k]));
            row.push(relative.map_or("-".into(), two_digits));
        }
        row.push(unit.into());
        if has_expected {
            row.push(expected[k].map_or("-".into(), number));
            if scale.is_some() {
                let error = expected[k].and_then(|value| percent(theta[k] - value));
                row.push(error.map_or("-".into(), error_percent));
            }
        }
        table.add_row(row);
    }
    let unit = if scale.is_some() { 4 } else { 3 };
    terminal::align_right(&mut table, (1..columns).filter(|column| *column != unit));
    table
}

/// An error in % of scale.
pub fn error_percent(error: f64) -> String {
    // Adding zero takes the sign from a negative zero.
    format!("{:+.2}", (100.0 * error).round() / 100.0 + 0.0)
}

/// What the per cent of a table are of; `expected` says whether the mass is the expected one.
pub fn scale_text(length: f64, is_expected: bool) -> String {
    let mass = if is_expected { "the expected m" } else { "m" };
    format!("%: of {mass}, L and m L²; L = {:.1} mm, rms distance of the sensors", 1e3 * length)
}

/// The principal moments with half the widths of their 95 % intervals; empty without real ones.
pub fn principal_text(estimate: &Estimate) -> String {
    let Some(moments) = estimate.principal_moments_kg_m2.value else { return String::new() };
    let half = estimate.principal_half_widths();
    let moment = |k: usize| {
        let value = moments[k] * 1e3;
        half.map_or_else(|| as_exact_as(value, None), |half| with_half_width(value, half[k] * 1e3))
    };
    format!("principal moments: {} g m²\n", [0, 1, 2].map(moment).join(", "))
}

#[cfg(test)]
mod tests {
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::{self, Method};
    use nalgebra::SVector;

    use super::*;
    use crate::words::{estimate_of, message};

    fn estimate() -> Estimate {
        let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
        let estimate = identify::Estimate {
            method: Method::InertiaRestraint,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: None,
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        };
        estimate_of(&estimate, message)
    }

    fn row(text: &str, symbol: &str) -> String {
        text.lines().find(|line| line.contains(symbol)).unwrap().to_owned()
    }

    #[test]
    fn errors_are_in_percent_of_mass_length_and_mass_times_length_squared() {
        let mut expected = estimate().theta().map(Some);
        // 1 % of 2 kg; 1 % of 0.5 m; 1 % of 2 kg (0.5 m)².
        expected[0] = Some(2.0 / 1.01);
        expected[1] = Some(0.095);
        expected[9] = None;
        let text = table(&estimate(), &expected, Some(0.5)).to_string();
        assert!(row(&text, " m ").contains("+1.00"), "{text}");
        assert!(row(&text, "c_x").contains("+1.00"), "{text}");
        assert!(row(&text, "c_y").contains("+0.00"), "{text}");
        assert!(row(&text, "J_yz").trim_end().ends_with('-'), "{text}");
    }

    #[test]
    fn values_are_shown_in_their_units() {
        let text = table(&estimate(), &[None; 10], None).to_string();
        assert!(row(&text, "c_x").contains("100.0 "), "{text}");
        assert!(row(&text, "J_xx").contains("30.00 "), "{text}");
        assert!(!text.contains('%') || text.contains("± 95 %"), "{text}");
    }
}
