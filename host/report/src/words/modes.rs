//! The suspension modes, as part of a result and as tables.

use massline_result::{Mode, Modes, Order, Spread};
use massline_shared::diagnosis::Code;
use massline_shared::layout::{Hit, HostLayout};
use massline_shared::mass_line::{ABOVE_SUSPENSION, BELOW_ELASTIC};
use massline_shared::modes::SUSPENSION_MODES;

use super::digits::{as_exact_as, two_digits};
use super::known;
use super::where_to_hit::{hardly_shown, not_shown};
use crate::table::Table;
use crate::table::align_right;
use crate::table::table;
use massline_analysis::suspension::{ModeRow, OrderRow, PoleRow, SuspensionModes};
use massline_analysis::where_to_hit::{better_hit, new_direction};

/// Length of the longest bar, characters.
const BAR: f64 = 4.0;

/// Frequencies, damping ratios and Norm Indicators: one row per mode, then what follows from them; `flexible` where a
/// flexible mode shows above the band.
pub fn modes_text(modes: &Modes, flexible: bool) -> String {
    let mut of_modes = table();
    of_modes.set_header(["mode", "Hz", "± sd", "damping, %", "± sd", "complexity, %"]);
    align_right(&mut of_modes, 1..6);
    for (place, mode) in modes.modes.iter().enumerate() {
        let Mode { frequency_hz, damping_ratio, .. } = mode;
        let percent = damping_ratio.sigma.map(|sigma| 100.0 * sigma);
        of_modes.add_row([
            (place + 1).to_string(),
            as_exact_as(frequency_hz.value, frequency_hz.sigma),
            two_digits(frequency_hz.sigma.unwrap_or(f64::NAN)),
            as_exact_as(100.0 * damping_ratio.value, percent),
            two_digits(percent.unwrap_or(f64::NAN)),
            mode.complexity.map_or("-".into(), |complexity| format!("{:.2}", 100.0 * complexity)),
        ]);
    }
    let [low, high] = modes.band_hz;
    let mut text = format!("suspension modes from {low} to {high} Hz\n{of_modes}\n");
    text += &indicators_text(&modes.modes);
    if let Some(highest) = modes.modes.last().map(|mode| mode.frequency_hz.value) {
        let (which, begins) = match modes.modes.len() {
            SUSPENSION_MODES => ("the highest one lies", "begins"),
            _ => ("the highest one that shows lies", "begins no lower than"),
        };
        text += &if flexible {
            format!("{which} at {highest:.2} Hz\n")
        } else {
            format!(
                "{which} at {highest:.2} Hz: a mass line {begins} at {:.0} Hz, provided that no elastic mode lies \
                 below {:.0} Hz\n",
                ABOVE_SUSPENSION * highest,
                // The band is at least an octave wide.
                ABOVE_SUSPENSION * highest * 2.0 / BELOW_ELASTIC,
            )
        };
    }
    if let Some([x, y, z]) = modes.fitted_gravity_m_per_s2 {
        text += &format!("gravity as it fits: gravity = [{x:.2}, {y:.2}, {z:.2}] m/s²\n");
    }
    text + &remedies_text(modes).concat()
}

/// Whether a finding about the modes says that a flexible mode shows.
pub fn shows_flexible_mode<'f>(
    findings: impl IntoIterator<Item = &'f massline_result::Finding>,
) -> bool {
    findings.into_iter().any(|finding| finding.code == Code::FlexibleModeShows)
}

/// The Norm Indicators alone, one row per hit.
pub fn indicators_text(modes: &[Mode]) -> String {
    format!("Norm Indicator: how much of a mode a hit shows\n{}\n", indicators(modes))
}

/// Which hits would show the modes that the hits of the layout hardly show: a line each.
pub fn remedies_text(modes: &Modes) -> Vec<String> {
    let mut lines = better_hits_text(&modes.modes);
    if let (1.., Some(dof)) = (modes.modes_missing, &modes.hit_for_missing) {
        lines.push(not_shown(modes.modes_missing, dof) + "\n");
    }
    lines
}

/// Which hits would show the modes that are hardly shown: a line each.
pub fn better_hits_text(modes: &[Mode]) -> Vec<String> {
    let line = |(number, mode): (usize, &Mode)| {
        let better = mode.better_hit.as_ref()?;
        Some(hardly_shown(number, better.shown, &better.dof) + "\n")
    };
    (1..).zip(modes).filter_map(line).collect()
}

/// The mass-normalised shapes at the origin of the body frame, with their standard deviations.
pub fn shapes_text(modes: &[Mode]) -> String {
    let mut table = table();
    table.set_header(["mode", "x", "y", "z", "θx", "θy", "θz"]);
    align_right(&mut table, 1..7);
    for (place, Mode { shape, .. }) in modes.iter().enumerate() {
        let cells = shape.value.iter().enumerate().map(|(k, value)| {
            let exact = shape.sigma.map(|sigma| sigma[k]);
            let spread = exact.map_or("-".into(), |sigma| as_exact_as(sigma, exact));
            format!("{}\n± {spread}", as_exact_as(*value, exact))
        });
        table.add_row(std::iter::once((place + 1).to_string()).chain(cells));
    }
    format!("shapes at the origin, 1/√kg and 1/(m √kg)\n{table}\n")
}

/// How alike the shapes are: the modal assurance criterion.
pub fn assurance_text(assurance: &[Vec<f64>]) -> String {
    let mut table = table();
    let header = (1..=assurance.len()).map(|mode| mode.to_string());
    table.set_header(std::iter::once("mode".to_owned()).chain(header));
    align_right(&mut table, 1..=assurance.len());
    for (place, row) in assurance.iter().enumerate() {
        let cells = row.iter().map(|value| format!("{value:.3}"));
        table.add_row(std::iter::once((place + 1).to_string()).chain(cells));
    }
    format!("modal assurance criterion\n{table}\n")
}

/// The poles of every order, marked where the next smaller order also has them.
pub fn orders_text(orders: &[Order]) -> String {
    let mut table = table();
    table.set_header(["order", "poles, Hz; ● is also in the row above"]);
    for (place, Order { used, poles }) in orders.iter().enumerate() {
        let poles = poles
            .iter()
            .map(|pole| format!("{:.3}{}", pole.frequency_hz, if pole.stable { " ●" } else { "" }));
        let mark = if *used { "used" } else { "" };
        table.add_row([format!("{} {mark}", place + 1), poles.collect::<Vec<_>>().join("  ")]);
    }
    format!("stabilisation\n{table}\n")
}

/// Norm Indicators with bars, one row per hit and one column per mode.
fn indicators(modes: &[Mode]) -> Table {
    let mut table = table();
    let header = (1..=modes.len()).map(|mode| mode.to_string());
    table.set_header(std::iter::once("hit \\ mode".to_owned()).chain(header));
    let every = modes.iter().flat_map(|mode| &mode.norm_indicators);
    let largest = every.map(|indicator| indicator.value).fold(f64::MIN_POSITIVE, f64::max);
    let hits = modes.first().map_or(&[][..], |mode| &mode.norm_indicators);
    for (place, hit) in hits.iter().enumerate() {
        let cells = modes.iter().map(|mode| {
            let indicator =
                mode.norm_indicators.get(place).map_or(0.0, |indicator| indicator.value);
            let length = (BAR * indicator / largest).round() as usize;
            format!("{indicator:.3} {}", "█".repeat(length))
        });
        table.add_row(std::iter::once(hit.dof.clone()).chain(cells));
    }
    table
}

/// The modes as part of a result.
pub fn suspension_modes(
    modes: &SuspensionModes,
    band_hz: [f64; 2],
    layout: &HostLayout,
) -> massline_result::Modes {
    let missing = SUSPENSION_MODES.saturating_sub(modes.rows.len());
    massline_result::Modes {
        band_hz,
        modes: modes.rows.iter().map(|row| suspension_mode(row, layout)).collect(),
        modes_missing: missing,
        hit_for_missing: new_direction(layout).filter(|_| missing > 0).map(|place| place.dof()),
        modal_assurance: modes.assurance.clone(),
        orders: modes.orders.iter().map(order).collect(),
        noise_m_per_s2_per_n: known(modes.noise),
        fitted_gravity_m_per_s2: modes.fitted_gravity,
        diagnostics: None,
    }
}

/// A mode as part of a result.
pub fn suspension_mode(row: &ModeRow, layout: &HostLayout) -> massline_result::Mode {
    // What is not known is NaN.
    let spread =
        |[value, sigma]: [f64; 2]| Spread { value, sigma: Some(sigma).filter(|s| s.is_finite()) };
    let sigma: [f64; 6] = row.shape_sigma.into();
    let indicators = layout.hits.iter().zip(&row.norm_indicators);
    let indicator = |(hit, value): (&Hit<f64>, &f64)| massline_result::Indicator {
        dof: hit.dof.to_string(),
        value: *value,
    };
    massline_result::Mode {
        frequency_hz: spread(row.frequency_hz),
        damping_ratio: spread(row.damping_ratio),
        shape: Spread {
            value: row.shape.into(),
            sigma: Some(sigma).filter(|sigma| sigma.iter().all(|s| s.is_finite())),
        },
        complexity: known(row.complexity),
        norm_indicators: indicators.map(indicator).collect(),
        better_hit: better_hit(row, layout)
            .map(|(shown, place)| massline_result::BetterHit { dof: place.dof(), shown }),
    }
}

fn order(OrderRow { used, poles }: &OrderRow) -> massline_result::Order {
    let pole = |pole: &PoleRow| massline_result::Pole {
        frequency_hz: pole.frequency_hz,
        damping_ratio: pole.damping_ratio,
        stable: pole.stable,
    };
    massline_result::Order { used: *used, poles: poles.iter().map(pole).collect() }
}
