//! The ten properties as a table for people.

use comfy_table::{CellAlignment, LineStyle, Table, presets};

use super::{Answer, HALF_WIDTH_95, message, sentences};

/// Symbol, unit and factor to that unit, in the order of the ten.
pub(crate) const ROWS: [(&str, &str, f64); 10] = [
    ("m", "kg", 1.0),
    ("c_x", "mm", 1e3),
    ("c_y", "mm", 1e3),
    ("c_z", "mm", 1e3),
    ("J_xx", "g m²", 1e3),
    ("J_yy", "g m²", 1e3),
    ("J_zz", "g m²", 1e3),
    ("J_xy", "g m²", 1e3),
    ("J_xz", "g m²", 1e3),
    ("J_yz", "g m²", 1e3),
];

/// What an answer is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truth {
    /// The ten, each when known.
    pub properties: [Option<f64>; 10],
    /// Characteristic length of the layout, m: errors are in % of [m, L, L, L, m L² × 6].
    pub length: f64,
}

impl Truth {
    /// What 100 % of the ten are; the mass is the expected one, else that of the answer.
    fn scale(&self, answer: &Answer) -> [f64; 10] {
        let [mass, ..] = self.properties;
        scale_of(mass.unwrap_or(answer.body.mass), self.length)
    }
}

/// The scale of errors, [m, L, L, L, m L² × 6].
pub fn scale_of(mass: f64, length: f64) -> [f64; 10] {
    let mut scale = [mass * length * length; 10];
    scale[0] = mass;
    scale[1..4].fill(length);
    scale
}

/// The ten with units, standard deviations and, beside expected values, errors in % of scale; then
/// the principal moments and what is to be said.
pub fn table(answer: &Answer, truth: Option<&Truth>) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none()));
    let mut header = vec!["", "value", "± sd", "± 95 %", "unit"];
    if truth.is_some() {
        header.extend(["expected", "error, % of scale"]);
    }
    table.set_header(header);
    let sigma = answer.sigma();
    for (k, ((symbol, unit, factor), value)) in
        ROWS.into_iter().zip(answer.properties()).enumerate()
    {
        let spread = |widths: f64| {
            sigma.map_or("-".to_owned(), |s| format!("{:.4}", widths * s[k] * factor))
        };
        let (sd, half) = (spread(1.0), spread(HALF_WIDTH_95));
        let mut row =
            vec![symbol.to_owned(), format!("{:.4}", value * factor), sd, half, unit.into()];
        if let Some(truth) = truth {
            match truth.properties[k] {
                Some(expected) => {
                    let error = 100.0 * (value - expected) / truth.scale(answer)[k];
                    row.extend([format!("{:.4}", expected * factor), format!("{error:+.3}")]);
                }
                None => row.extend(["-".to_owned(), "-".to_owned()]),
            }
        }
        table.add_row(row);
    }
    for column in [1, 2, 3, 5, 6] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let mut text = format!("{table}\n{}", principal_line(answer));
    text += &format!("{}, condition {:.3}\n", answer.method, answer.condition);
    if sigma.is_none() {
        text += "sd: not known from these data\n";
    }
    if !answer.body.is_physically_consistent() {
        text += "not physically consistent: no body has these ten\n";
    }
    text + &sentences(&answer.diagnostics, message)
}

fn principal_line(answer: &Answer) -> String {
    let Some(principal) = answer.principal() else { return String::new() };
    let sigma = answer.covariance.as_ref().map(|c| principal.moment_sigmas(c));
    let moments: Vec<String> = (0..3)
        .map(|k| {
            let value = principal.moments[k] * 1e3;
            sigma.map_or(format!("{value:.4}"), |s| format!("{value:.4} ± {:.4}", s[k] * 1e3))
        })
        .collect();
    format!("principal moments: {} g m²\n", moments.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::body::RigidBody;
    use nalgebra::SVector;

    fn answer() -> Answer {
        let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
        Answer {
            method: "inertia-restraint",
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: None,
            condition: 8.0,
            consistency: None,
            diagnostics: Vec::new(),
        }
    }

    #[test]
    fn errors_are_in_percent_of_mass_length_and_mass_times_length_squared() {
        let mut properties = answer().properties().map(Some);
        // 1 % of 2 kg; 1 % of 0.5 m; 1 % of 2 kg (0.5 m)².
        properties[0] = Some(2.0 / 1.01);
        properties[1] = Some(0.095);
        properties[9] = None;
        let text = table(&answer(), Some(&Truth { properties, length: 0.5 }));
        let row = |symbol: &str| text.lines().find(|l| l.contains(symbol)).unwrap().to_owned();
        assert!(row(" m ").contains("+1.000"), "{text}");
        assert!(row("c_x").contains("+1.000"), "{text}");
        assert!(row("c_y").contains("0.000"), "{text}");
        assert!(row("J_yz").trim_end().ends_with('-'), "{text}");
    }

    #[test]
    fn values_are_shown_in_their_units() {
        let text = table(&answer(), None);
        assert!(text.lines().any(|l| l.contains("c_x") && l.contains("100.0000")), "{text}");
        assert!(text.lines().any(|l| l.contains("J_xx") && l.contains("30.0000")), "{text}");
        assert!(text.contains("sd: not known"), "{text}");
    }
}
