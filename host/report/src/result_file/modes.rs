//! The suspension modes of a result, checked for what a picture has room for.

use massline_shared::layout::HOST_HITS;

use massline_result::{Mode, Modes};

/// Largest number of modes.
const MOST_MODES: usize = 24;
/// Largest number of orders, and of poles of one.
const MOST_POLES: usize = 64;
/// Highest frequency, Hz.
const HIGHEST: f64 = 1e6;

/// Checks that there are not more modes than an object can have on its suspension, each with what pictures show of it.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn check_modes(modes: &Modes) -> Result<(), String> {
    let [low, high] = modes.band_hz;
    if !(0.0 <= low && low < high && high <= HIGHEST) {
        return Err(format!("band_hz: {low} to {high} Hz is no band"));
    }
    let count = modes.modes.len();
    if count > MOST_MODES {
        return Err(format!("modes: there are {count}, and no object has more than {MOST_MODES}"));
    }
    let is_square = modes.modal_assurance.len() == count
        && modes.modal_assurance.iter().all(|row| row.len() == count);
    if !is_square {
        return Err(format!("modal_assurance: it is not {count} by {count}, as there are modes"));
    }
    if !modes.modal_assurance.iter().flatten().all(|value| (0.0..=1.001).contains(value)) {
        return Err("modal_assurance: a value is not between 0 and 1".into());
    }
    if let Some(place) = modes.modes.iter().position(|mode| !is_shown(mode)) {
        return Err(format!(
            "modes[{place}]: its frequency is none, or a norm_indicator is negative or one too many"
        ));
    }
    if modes.orders.len() > MOST_POLES
        || modes.orders.iter().any(|order| order.poles.len() > MOST_POLES)
    {
        return Err(format!("orders: there are more than {MOST_POLES}, or more poles than that"));
    }
    Ok(())
}

/// True for a mode that a picture can show.
fn is_shown(mode: &Mode) -> bool {
    let indicators = &mode.norm_indicators;
    (0.0..=HIGHEST).contains(&mode.frequency_hz.value)
        && indicators.len() <= HOST_HITS
        && indicators.iter().all(|indicator| indicator.value >= 0.0 && indicator.value.is_finite())
}
