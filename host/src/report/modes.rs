//! The suspension modes as tables and JSON.

use comfy_table::Table;
use massline_shared::layout::HostLayout;
use nalgebra::{Vector3, Vector6};
use serde_json::{Value, json};

use crate::output::{align_right, table};
use crate::suspension::{ModeRow, OrderRow, PoleRow, SuspensionModes};

/// The mass line of a body begins this much above its highest suspension mode (theory, section 5).
const ABOVE_SUSPENSION: f64 = 3.0;
/// Length of the longest bar, characters.
const BAR: f64 = 5.0;
/// Share of the largest possible Norm Indicator below which the hits hardly show a mode.
const HARDLY: f64 = 0.2;

/// Frequencies, damping ratios and Norm Indicators: one row per mode, then what follows from them.
pub fn modes_text(modes: &SuspensionModes, band_hz: [f64; 2], layout: &HostLayout) -> String {
    let mut of_modes = table();
    of_modes.set_header(["mode", "Hz", "± sd", "damping, %", "± sd", "complexity, %"]);
    align_right(&mut of_modes, 1..6);
    for (place, row) in modes.rows.iter().enumerate() {
        of_modes.add_row([
            (place + 1).to_string(),
            format!("{:.5}", row.frequency_hz[0]),
            spread(row.frequency_hz[1], 5),
            format!("{:.4}", 100.0 * row.damping_ratio[0]),
            spread(100.0 * row.damping_ratio[1], 4),
            format!("{:.2}", 100.0 * row.complexity),
        ]);
    }
    let [low, high] = band_hz;
    let mut text = format!("suspension modes from {low} to {high} Hz\n{of_modes}\n");
    text +=
        &format!("Norm Indicator: how much of a mode a hit shows\n{}\n", indicators(modes, layout));
    if let Some(highest) = modes.rows.last() {
        let highest = highest.frequency_hz[0];
        text += &format!(
            "the highest one lies at {highest:.2} Hz: a mass line begins at {:.0} Hz, if no elastic mode is below {:.0} Hz\n",
            ABOVE_SUSPENSION * highest,
            // The band ends at 0.4 of the first elastic mode and is at least twice as wide as it is high.
            ABOVE_SUSPENSION * highest * 2.0 / 0.4,
        );
    }
    for (place, row) in modes.rows.iter().enumerate() {
        text += &remedy(place, row, layout);
    }
    text
}

/// A standard deviation; a dash where none is known.
fn spread(sigma: f64, digits: usize) -> String {
    if sigma.is_finite() { format!("{sigma:.digits$}") } else { "-".into() }
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

/// The poles of every order: `●` for one that the next smaller order also has.
pub fn orders_text(modes: &SuspensionModes) -> String {
    let mut all = table();
    all.set_header(["order", "poles, Hz; ● returns from the order above it, ○ does not"]);
    for (place, OrderRow { used, poles }) in modes.orders.iter().enumerate() {
        let pole = |pole: &PoleRow| {
            format!("{:.3} {}", pole.frequency_hz, if pole.stable { '●' } else { '○' })
        };
        let poles: Vec<String> = poles.iter().map(pole).collect();
        let mark = if *used { "used" } else { "" };
        all.add_row([format!("{} {mark}", place + 1), poles.join("   ")]);
    }
    format!("stabilisation\n{all}\n")
}

/// Norm Indicators with bars, one row per hit and one column per mode.
fn indicators(modes: &SuspensionModes, layout: &HostLayout) -> Table {
    let mut all = table();
    let header = (1..=modes.rows.len()).map(|mode| format!("mode {mode}"));
    all.set_header(std::iter::once("hit".to_owned()).chain(header));
    let every = || modes.rows.iter().flat_map(|row| &row.norm_indicators);
    let largest = every().copied().fold(f64::MIN_POSITIVE, f64::max);
    for (place, hit) in layout.hits.iter().enumerate() {
        let cells = modes.rows.iter().map(|row| {
            let indicator = row.norm_indicators.get(place).copied().unwrap_or(0.0);
            let length = (BAR * indicator / largest).round() as usize;
            format!("{indicator:.3} {}", "█".repeat(length))
        });
        all.add_row(std::iter::once(hit.dof.to_string()).chain(cells));
    }
    all
}

/// Where to hit for a mode that no hit shows well: a point of the layout and an axis along which it moves.
fn remedy(place: usize, row: &ModeRow, layout: &HostLayout) -> String {
    let shown = row.norm_indicators.iter().copied().fold(0.0, f64::max);
    let nodes = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position));
    let nodes = nodes.chain(layout.hits.iter().map(|hit| (hit.dof.node, hit.position)));
    let size = balanced_norm(&row.shape, layout.characteristic_length());
    let along = |(node, point): (u16, [f64; 3])| {
        let turned = row.shape.fixed_rows::<3>(3).cross(&Vector3::from(point));
        let motion = row.shape.fixed_rows::<3>(0) + turned;
        let axis = motion.iamax();
        (size * motion[axis].abs(), format!("{node}:+{}", ["X", "Y", "Z"][axis]))
    };
    let best = nodes.map(along).max_by(|a, b| a.0.total_cmp(&b.0));
    match best {
        Some((possible, dof)) if shown < HARDLY * possible => format!(
            "mode {} hardly shows under any hit ({:.0} % of what is possible): hit {dof}\n",
            place + 1,
            100.0 * shown / possible
        ),
        _ => String::new(),
    }
}

fn balanced_norm(shape: &Vector6<f64>, length: f64) -> f64 {
    let square = |(i, v): (usize, &f64)| if i < 3 { v * v } else { (v * length).powi(2) };
    shape.iter().enumerate().map(square).sum::<f64>().sqrt()
}

/// The modes as JSON.
pub fn modes_json(modes: &SuspensionModes, band_hz: [f64; 2], layout: &HostLayout) -> Value {
    let row = |row: &ModeRow| {
        let indicators = layout.hits.iter().zip(&row.norm_indicators);
        json!({
            "frequency_hz": { "value": row.frequency_hz[0], "sigma": row.frequency_hz[1] },
            "damping_ratio": { "value": row.damping_ratio[0], "sigma": row.damping_ratio[1] },
            "shape": {
                "value": <[f64; 6]>::from(row.shape),
                "sigma": <[f64; 6]>::from(row.shape_sigma),
            },
            "complexity": row.complexity,
            "norm_indicators": indicators
                .map(|(hit, indicator)| json!({ "dof": hit.dof.to_string(), "value": indicator }))
                .collect::<Vec<_>>(),
        })
    };
    let order = |OrderRow { used, poles }: &OrderRow| {
        let poles = poles.iter().map(|pole| {
            json!({
                "frequency_hz": pole.frequency_hz,
                "damping_ratio": pole.damping_ratio,
                "stable": pole.stable,
            })
        });
        json!({ "used": used, "poles": poles.collect::<Vec<_>>() })
    };
    json!({
        "band_hz": band_hz,
        "modes": modes.rows.iter().map(row).collect::<Vec<_>>(),
        "modal_assurance": modes.assurance,
        "orders": modes.orders.iter().map(order).collect::<Vec<_>>(),
        "noise_m_per_s2_per_n": modes.noise,
    })
}
