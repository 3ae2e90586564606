//! The suspension modes as tables and JSON.

use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::layout::{Hit, HostLayout};
use massline_shared::mass_line::{ABOVE_SUSPENSION, BELOW_ELASTIC};
use massline_shared::modes::SUSPENSION_MODES;

use super::digits::{as_exact_as, two_digits};
use super::where_to_hit::{better_hit, hardly_shown, new_direction, not_shown};
use crate::document::{self, Spread};
use crate::output::{Table, align_right, table};
use crate::suspension::{ModeRow, OrderRow, PoleRow, SuspensionModes};

/// Length of the longest bar, characters.
const BAR: f64 = 4.0;

/// Frequencies, damping ratios and Norm Indicators: one row per mode, then what follows from them.
pub fn modes_text(modes: &SuspensionModes, band_hz: [f64; 2], layout: &HostLayout) -> String {
    let mut of_modes = table();
    of_modes.set_header(["mode", "Hz", "± sd", "damping, %", "± sd", "complexity, %"]);
    align_right(&mut of_modes, 1..6);
    for (place, row) in modes.rows.iter().enumerate() {
        of_modes.add_row([
            (place + 1).to_string(),
            as_exact_as(row.frequency_hz[0], Some(row.frequency_hz[1])),
            two_digits(row.frequency_hz[1]),
            as_exact_as(100.0 * row.damping_ratio[0], Some(100.0 * row.damping_ratio[1])),
            two_digits(100.0 * row.damping_ratio[1]),
            format!("{:.2}", 100.0 * row.complexity),
        ]);
    }
    let [low, high] = band_hz;
    let mut text = format!("suspension modes from {low} to {high} Hz\n{of_modes}\n");
    text += &indicators_text(&modes.rows, layout);
    if let Some(highest) = modes.rows.last().map(|row| row.frequency_hz[0]) {
        let (which, begins) = match modes.rows.len() {
            SUSPENSION_MODES => ("the highest one lies", "begins"),
            _ => ("the highest one that shows lies", "begins no lower than"),
        };
        let is_flexible = |d: &Diagnostic| d.code == Code::FlexibleModeShows;
        text += &if modes.diagnostics.iter().any(is_flexible) {
            format!("{which} at {highest:.2} Hz\n")
        } else {
            format!(
                "{which} at {highest:.2} Hz: a mass line {begins} at {:.0} Hz, provided that no elastic mode lies below \
                 {:.0} Hz\n",
                ABOVE_SUSPENSION * highest,
                // The band is at least an octave wide.
                ABOVE_SUSPENSION * highest * 2.0 / BELOW_ELASTIC,
            )
        };
    }
    if let Some([x, y, z]) = modes.fitted_gravity {
        text += &format!("gravity as it fits: gravity = [{x:.2}, {y:.2}, {z:.2}] m/s²\n");
    }
    text + &remedies_text(&modes.rows, layout)
}

/// The Norm Indicators alone, one row per hit.
pub fn indicators_text(modes: &[ModeRow], layout: &HostLayout) -> String {
    format!("Norm Indicator: how much of a mode a hit shows\n{}\n", indicators(modes, layout))
}

/// Which hits would show the modes that the hits of the layout hardly show: a line each.
pub fn remedies_text(modes: &[ModeRow], layout: &HostLayout) -> String {
    let mut text = String::new();
    for (place, row) in modes.iter().enumerate() {
        if let Some((share, dof)) = better_hit(row, layout) {
            text += &(hardly_shown(place + 1, share, &dof) + "\n");
        }
    }
    let missing = SUSPENSION_MODES.saturating_sub(modes.len());
    if let (1.., Some(dof)) = (missing, new_direction(layout)) {
        text += &(not_shown(missing, &dof) + "\n");
    }
    text
}

/// The mass-normalised shapes at the origin of the body frame, with their standard deviations.
pub fn shapes_text(modes: &SuspensionModes) -> String {
    let mut all = table();
    all.set_header(["mode", "x", "y", "z", "θx", "θy", "θz"]);
    align_right(&mut all, 1..7);
    for (place, row) in modes.rows.iter().enumerate() {
        let cells = row.shape.iter().zip(&row.shape_sigma).map(|(value, sigma)| {
            let exact = sigma.is_finite().then_some(*sigma);
            let spread = exact.map_or("-".into(), |sigma| as_exact_as(sigma, exact));
            format!("{}\n± {spread}", as_exact_as(*value, exact))
        });
        all.add_row(std::iter::once((place + 1).to_string()).chain(cells));
    }
    format!("shapes at the origin, 1/√kg and 1/(m √kg)\n{all}\n")
}

/// How alike the shapes are: the modal assurance criterion.
pub fn assurance_text(modes: &SuspensionModes) -> String {
    let mut all = table();
    let header = (1..=modes.assurance.len()).map(|mode| mode.to_string());
    all.set_header(std::iter::once("mode".to_owned()).chain(header));
    align_right(&mut all, 1..=modes.assurance.len());
    for (place, row) in modes.assurance.iter().enumerate() {
        let cells = row.iter().map(|value| format!("{value:.3}"));
        all.add_row(std::iter::once((place + 1).to_string()).chain(cells));
    }
    format!("modal assurance criterion\n{all}\n")
}

/// The poles of every order, marked where the next smaller order also has them.
pub fn orders_text(modes: &SuspensionModes) -> String {
    let mut all = table();
    all.set_header(["order", "poles, Hz; ● is also in the row above"]);
    for (place, OrderRow { used, poles }) in modes.orders.iter().enumerate() {
        let pole = |pole: &PoleRow| {
            format!("{:.3}{}", pole.frequency_hz, if pole.stable { " ●" } else { "" })
        };
        let poles: Vec<String> = poles.iter().map(pole).collect();
        let mark = if *used { "used" } else { "" };
        all.add_row([format!("{} {mark}", place + 1), poles.join("  ")]);
    }
    format!("stabilisation\n{all}\n")
}

/// Norm Indicators with bars, one row per hit and one column per mode.
fn indicators(modes: &[ModeRow], layout: &HostLayout) -> Table {
    let mut all = table();
    let header = (1..=modes.len()).map(|mode| mode.to_string());
    all.set_header(std::iter::once("hit \\ mode".to_owned()).chain(header));
    let every = || modes.iter().flat_map(|row| &row.norm_indicators);
    let largest = every().copied().fold(f64::MIN_POSITIVE, f64::max);
    for (place, hit) in layout.hits.iter().enumerate() {
        let cells = modes.iter().map(|row| {
            let indicator = row.norm_indicators.get(place).copied().unwrap_or(0.0);
            let length = (BAR * indicator / largest).round() as usize;
            format!("{indicator:.3} {}", "█".repeat(length))
        });
        all.add_row(std::iter::once(hit.dof.to_string()).chain(cells));
    }
    all
}

/// The modes as JSON.
pub fn modes_json(
    modes: &SuspensionModes,
    band_hz: [f64; 2],
    layout: &HostLayout,
) -> document::Modes {
    let missing = SUSPENSION_MODES.saturating_sub(modes.rows.len());
    document::Modes {
        band_hz,
        modes: modes.rows.iter().map(|row| mode_json(row, layout)).collect(),
        modes_missing: missing,
        hit_for_missing: new_direction(layout).filter(|_| missing > 0).map(|place| place.dof()),
        modal_assurance: modes.assurance.clone(),
        orders: modes.orders.iter().map(order_json).collect(),
        noise_m_per_s2_per_n: modes.noise,
        fitted_gravity_m_per_s2: modes.fitted_gravity,
        diagnostics: None,
    }
}

/// A mode as JSON.
pub fn mode_json(row: &ModeRow, layout: &HostLayout) -> document::Mode {
    // What is not known is NaN.
    let spread =
        |[value, sigma]: [f64; 2]| Spread { value, sigma: Some(sigma).filter(|s| s.is_finite()) };
    let sigma: [f64; 6] = row.shape_sigma.into();
    let indicators = layout.hits.iter().zip(&row.norm_indicators);
    let indicator = |(hit, value): (&Hit<f64>, &f64)| document::Indicator {
        dof: hit.dof.to_string(),
        value: *value,
    };
    document::Mode {
        frequency_hz: spread(row.frequency_hz),
        damping_ratio: spread(row.damping_ratio),
        shape: Spread {
            value: row.shape.into(),
            sigma: Some(sigma).filter(|all| all.iter().all(|s| s.is_finite())),
        },
        complexity: row.complexity,
        norm_indicators: indicators.map(indicator).collect(),
        better_hit: better_hit(row, layout)
            .map(|(shown, place)| document::BetterHit { dof: place.dof(), shown }),
    }
}

fn order_json(OrderRow { used, poles }: &OrderRow) -> document::Order {
    let pole = |pole: &PoleRow| document::Pole {
        frequency_hz: pole.frequency_hz,
        damping_ratio: pole.damping_ratio,
        stable: pole.stable,
    };
    document::Order { used: *used, poles: poles.iter().map(pole).collect() }
}
