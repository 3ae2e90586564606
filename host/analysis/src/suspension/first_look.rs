//! A first look at the readings: which modes they show, and whether the records are long enough.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Subject};
use massline_shared::identify::suspension::FEWEST_MODES;
use massline_shared::identify::suspension::{mode_findings, truncated_mode};
use massline_shared::layout::HostLayout;
use massline_shared::modes::Reduction;

use super::HostFit;
use super::rigidity::swapped_cables;

/// What a first look at the readings shows.
#[derive(Clone, Debug)]
pub struct FirstLook {
    /// Frequencies, Hz, and damping ratios of the suspension modes.
    pub modes: Vec<(f64, f64)>,
    /// The frequency of the highest of them that the hits excite well, Hz, when there are enough for an answer.
    pub highest_hz: Option<f64>,
    /// A warning about records that end too early.
    pub diagnostics: Vec<Diagnostic>,
}

/// Looks for suspension modes in readings whose records are taken to be this long, s.
///
/// # Errors
/// Those of [`SuspensionFit::new`](massline_shared::identify::suspension::SuspensionFit::new), and
/// `record_too_short_for_damping`.
pub fn find_modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    record_s: f64,
) -> Result<FirstLook, Diagnostics> {
    let mut memory = Box::new(Reduction::new());
    let fit = modal_fit(layout, readings, &mut memory)?;
    let truncated = truncated_mode(fit.modes(), record_s, readings.decay);
    if let Some(error) = truncated.filter(Diagnostic::is_error) {
        return Err(Diagnostics::from_array([error]));
    }
    let fitted_modes = fit.modes().modes.iter();
    let modes: Vec<_> = fitted_modes.map(|mode| (mode.frequency_hz, mode.damping_ratio)).collect();
    let findings = mode_findings(fit.modes(), &memory.responses());
    let poor = |place: usize| {
        let subject = Subject::mode(place);
        findings.iter().any(|d| d.code == Code::ModePoorlyExcited && d.subject == subject)
    };
    let excited: Vec<f64> = modes
        .iter()
        .enumerate()
        .filter(|(place, _)| !poor(*place))
        .map(|(_, (frequency, _))| *frequency)
        .collect();
    let highest_hz = excited.last().copied().filter(|_| excited.len() >= FEWEST_MODES);
    Ok(FirstLook { modes, highest_hz, diagnostics: truncated.into_iter().collect() })
}

/// The modes of the readings.
///
/// # Errors
/// Those of [`SuspensionFit::new`](massline_shared::identify::suspension::SuspensionFit::new); where the cables of two
/// sensors are swapped, that.
pub(super) fn modal_fit<'a>(
    layout: &'a HostLayout,
    readings: &'a FrequencyResponses<'a, f64>,
    memory: &mut Reduction<f64>,
) -> Result<HostFit<'a>, Diagnostics> {
    let is_of_sensors =
        |code: Code| matches!(code, Code::DrivingPointReversed | Code::SuspensionModesMissing);
    HostFit::new(layout, readings, memory).map_err(|reasons| {
        let swapped = reasons
            .iter()
            .any(|reason| is_of_sensors(reason.code))
            .then(|| swapped_cables(layout, readings, memory));
        swapped.flatten().map_or(reasons, |swapped| Diagnostics::from_array([swapped]))
    })
}
