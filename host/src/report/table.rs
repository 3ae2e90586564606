//! The ten properties as a table for people.

use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter, scale};
use massline_shared::identify::Estimate;
use nalgebra::SVector;

use crate::output;

use super::{as_exact_as, message, sentences, with_sigma};

/// What stands under every table of the ten properties. Books differ in the sign of a product of inertia.
pub const INERTIA_CONVENTION: &str = "J about the centre of mass, body axes; J_xy = −∫xy dm";

/// Expected values to compare an estimate with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The ten properties, each when known.
    pub properties: [Option<f64>; 10],
    /// Characteristic length of the layout, m: errors are in % of [m, L, L, L, m L² × 6].
    pub length: f64,
}

impl Truth {
    /// The values that correspond to 100 % of scale; the mass is the expected one, else that of the estimate.
    fn scale(&self, estimate: &Estimate<f64>) -> [f64; 10] {
        let [mass, ..] = self.properties;
        scale(mass.unwrap_or(estimate.body.mass), self.length).into()
    }
}

/// The ten properties with units, standard deviations and, beside expected values, errors in % of scale; then
/// the principal moments and the diagnostics.
pub fn table(estimate: &Estimate<f64>, truth: Option<&Truth>) -> String {
    let mut table = output::table();
    let mut header = vec!["", "value", "± sd", "± 95 %", "unit"];
    if truth.is_some() {
        header.extend(["expected", "error, % of scale"]);
    }
    table.set_header(header);
    let sigma = estimate.sigma();
    for (k, (parameter, value)) in INERTIAL_PARAMETERS.iter().zip(&estimate.theta()).enumerate() {
        let &InertialParameter { symbol, table_unit: unit, table_factor: factor, .. } = parameter;
        let exact = sigma.map(|sigma| sigma[k] * factor);
        let number = |si: f64| as_exact_as(si * factor, exact);
        let spread = |of_ten: Option<SVector<f64, 10>>| {
            of_ten.map_or("-".to_owned(), |of_ten| number(of_ten[k]))
        };
        let (sd, half) = (spread(sigma), spread(estimate.half_widths()));
        let mut row = vec![symbol.to_owned(), number(*value), sd, half, unit.into()];
        if let Some(truth) = truth {
            match truth.properties[k] {
                Some(expected) => {
                    let error = 100.0 * (value - expected) / truth.scale(estimate)[k];
                    row.extend([number(expected), format!("{error:+.3}")]);
                }
                None => row.extend(["-".to_owned(), "-".to_owned()]),
            }
        }
        table.add_row(row);
    }
    output::align_right(&mut table, [1, 2, 3, 5, 6]);
    let mut text = format!("{table}\n{INERTIA_CONVENTION}\n{}", principal_line(estimate));
    text += &format!("{}, condition {:.3}\n", estimate.method.name(), estimate.condition);
    if sigma.is_none() {
        text += "sd: not known from these data\n";
    }
    if !estimate.body.is_physically_consistent() {
        text += "not physically consistent: no real body has these properties\n";
    }
    text + &sentences(&estimate.diagnostics, message)
}

fn principal_line(estimate: &Estimate<f64>) -> String {
    let Some(principal) = estimate.body.principal() else { return String::new() };
    let sigma = estimate.principal_moment_sigmas();
    let moments: Vec<String> = (0..3)
        .map(|k| {
            let value = principal.moments[k] * 1e3;
            sigma.map_or_else(|| as_exact_as(value, None), |s| with_sigma(value, s[k] * 1e3))
        })
        .collect();
    format!("principal moments: {} g m²\n", moments.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::Method;

    fn estimate() -> Estimate<f64> {
        let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
        Estimate {
            method: Method::InertiaRestraint,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: None,
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        }
    }

    #[test]
    fn errors_are_in_percent_of_mass_length_and_mass_times_length_squared() {
        let mut properties = <[f64; 10]>::from(estimate().theta()).map(Some);
        // 1 % of 2 kg; 1 % of 0.5 m; 1 % of 2 kg (0.5 m)².
        properties[0] = Some(2.0 / 1.01);
        properties[1] = Some(0.095);
        properties[9] = None;
        let text = table(&estimate(), Some(&Truth { properties, length: 0.5 }));
        let row = |symbol: &str| text.lines().find(|l| l.contains(symbol)).unwrap().to_owned();
        assert!(row(" m ").contains("+1.000"), "{text}");
        assert!(row("c_x").contains("+1.000"), "{text}");
        assert!(row("c_y").contains("0.000"), "{text}");
        assert!(row("J_yz").trim_end().ends_with('-'), "{text}");
    }

    #[test]
    fn the_convention_of_the_inertia_stands_under_the_table() {
        let text = table(&estimate(), None);
        let (_, below) = text.split_once("J_yz").unwrap();
        assert!(
            below.contains("\nJ about the centre of mass, body axes; J_xy = −∫xy dm\n"),
            "{text}"
        );
    }

    #[test]
    fn values_are_shown_in_their_units() {
        let text = table(&estimate(), None);
        assert!(text.lines().any(|l| l.contains("c_x") && l.contains("100.0 ")), "{text}");
        assert!(text.lines().any(|l| l.contains("J_xx") && l.contains("30.00 ")), "{text}");
        assert!(text.contains("sd: not known"), "{text}");
    }
}
