//! The suspension modes of a result, checked for what a picture has room for.

use massline_shared::layout::HOST_HITS;

use crate::document::{Mode, Order};

/// Largest number of modes.
const MOST_MODES: usize = 24;
/// Largest number of orders, and of poles of one.
const MOST_POLES: usize = 64;
/// Highest frequency, Hz.
const HIGHEST: f64 = 1e6;

/// The suspension modes as pictures show them.
pub struct ShownModes {
    /// The suspension band.
    pub band_hz: [f64; 2],
    /// The modes.
    pub modes: Vec<Mode>,
    /// How many of six do not show.
    pub missing: usize,
    /// A hit unlike those of the test, where modes are missing.
    pub hit_for_missing: Option<String>,
    /// The modal assurance criterion, row by row.
    pub modal_assurance: Vec<Vec<f64>>,
    /// The fits of all orders.
    pub orders: Vec<Order>,
    /// Standard deviation of the noise of a reading, the mean of the hits at a DOF, (m/s²)/N, where it is known.
    pub noise: Option<f64>,
}

impl ShownModes {
    /// Their frequencies, Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.modes.iter().map(|mode| mode.frequency_hz.value).collect()
    }

    /// Checks that there are not more modes than an object can have on its suspension, each with what pictures show of it.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(super) fn check(&self) -> Result<(), String> {
        let [low, high] = self.band_hz;
        if !(0.0 <= low && low < high && high <= HIGHEST) {
            return Err(format!("band_hz: {low} to {high} Hz is no band"));
        }
        let count = self.modes.len();
        if count > MOST_MODES {
            return Err(format!(
                "modes: there are {count}, and no object has more than {MOST_MODES}"
            ));
        }
        let is_square = self.modal_assurance.len() == count
            && self.modal_assurance.iter().all(|row| row.len() == count);
        if !is_square {
            return Err(format!(
                "modal_assurance: it is not {count} by {count}, as there are modes"
            ));
        }
        if !self.modal_assurance.iter().flatten().all(|value| (0.0..=1.001).contains(value)) {
            return Err("modal_assurance: a value is not between 0 and 1".into());
        }
        if let Some(place) = self.modes.iter().position(|mode| !is_shown(mode)) {
            return Err(format!(
                "modes[{place}]: its frequency is none, or a norm_indicator is negative or one too many"
            ));
        }
        if self.orders.len() > MOST_POLES
            || self.orders.iter().any(|order| order.poles.len() > MOST_POLES)
        {
            return Err(format!(
                "orders: there are more than {MOST_POLES}, or more poles than that"
            ));
        }
        Ok(())
    }
}

/// True for a mode that a picture can show.
fn is_shown(mode: &Mode) -> bool {
    let indicators = &mode.norm_indicators;
    (0.0..=HIGHEST).contains(&mode.frequency_hz.value)
        && indicators.len() <= HOST_HITS
        && indicators.iter().all(|of| of.value >= 0.0 && of.value.is_finite())
}
