//! The estimate between two DOFs of a campaign, as numbers with their units.

use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::design::Widths;

use massline_analysis::precision::PrecisionReport;
use massline_report::words::{as_exact_as, precision, two_digits};

/// What is known after some of the DOFs.
#[derive(Clone, Debug, PartialEq)]
pub struct InterimEstimate {
    /// DOFs with mass lines.
    pub measured: usize,
    /// `4 of 12 DOFs`.
    pub progress: String,
    /// The largest half widths of the 95 % intervals.
    pub widths: Option<Widths<f64>>,
    /// Name, value and half width of the 95 % interval of each property with its unit.
    pub properties: Vec<[String; 4]>,
    /// What to make of it.
    pub advice: String,
}

impl InterimEstimate {
    /// What there is to see of a report.
    pub(super) fn of(report: &PrecisionReport<'_>) -> Self {
        let properties = report.body.iter().zip(&report.precision).flat_map(|(body, precision)| {
            let halves = precision.half_widths.iter().copied();
            let values = body.theta();
            INERTIAL_PARAMETERS
                .iter()
                .zip(values.iter().copied().zip(halves))
                .map(|(parameter, (value, half))| {
                    let [value, half] = [value, half].map(|number| number * parameter.table_factor);
                    let number = as_exact_as(value, Some(half));
                    [parameter.symbol.into(), number, two_digits(half), parameter.table_unit.into()]
                })
                .collect::<Vec<_>>()
        });
        Self {
            measured: report.measured,
            progress: precision::progress(report),
            widths: report.precision.as_ref().map(|known| known.widths()),
            properties: properties.collect(),
            advice: precision::advice(report),
        }
    }
}
