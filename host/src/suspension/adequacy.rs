//! Whether a body on its suspension explains the readings, or whether gravity, a gain or a position is wrong.

use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use massline_shared::identify::Estimate;
use massline_shared::identify::global_fit::{
    self, GlobalFitSettings, GlobalFitSolution, workspace,
};
use massline_shared::layout::HostLayout;
use massline_shared::{FrequencyResponses, STANDARD_GRAVITY};

use super::{Doubt, GlobalAnswer, HostFit};

/// What the global fit leaves, over the noise that the fit of the modes leaves, from which the body does not fit: that fit
/// assumes nothing of the body. Extra terms of a flexible mode at twice the end of the band leave 1.01; a gain, a position
/// or gravity that is wrong by a noticeable part leaves more than 1.1 or has large pulls.
const MISFIT: f64 = 1.05;
/// Root mean square of the pulls of a sensor or hit, in its standard deviations, from which the body does not fit.
const TOO_FAR: f32 = 4.0;

/// How well a body on its suspension explains the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Adequacy {
    /// As well as their own modes.
    Fits,
    /// As well with a flexible mode above the band.
    Flexible,
    /// Less well: what it leaves is so many times the noise.
    Misfit(f64),
    /// There is no global fit that would tell.
    Unknown,
}

impl Adequacy {
    /// What it says against the answers.
    pub(super) fn doubt(self) -> Option<Doubt> {
        match self {
            Self::Fits | Self::Unknown => None,
            Self::Flexible => Some(Doubt::FlexibleMode),
            Self::Misfit(_) => Some(Doubt::Misfit),
        }
    }
}

/// Judges the global fit.
///
/// # Errors
/// `gravity_suspect` when the fit is bad with the gravity of the layout, and good with another one.
pub(super) fn judge(
    layout: &HostLayout,
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    start: Option<&RigidBody<f64>>,
    global: &Result<GlobalAnswer, Diagnostics>,
) -> Result<Adequacy, Diagnostics> {
    let found = global.as_ref().map(|found| &found.solution);
    let adequate = found.is_ok_and(|found| explains(found, fit));
    let gave_up = |reasons: &&Diagnostics| reasons.iter().all(|d| d.code != Code::NotConverged);
    if adequate || found.as_ref().err().is_some_and(gave_up) {
        return Ok(match found {
            Ok(found) if found.extra_terms > 0 => Adequacy::Flexible,
            Ok(_) => Adequacy::Fits,
            Err(_) => Adequacy::Unknown,
        });
    }
    if let Some(axis) = start.and_then(|start| other_gravity(layout, fit, readings, start)) {
        let reason = Diagnostic::whole(Code::GravitySuspect, Severity::Error, axis);
        return Err(Diagnostics::from_array([reason]));
    }
    Ok(found.map_or(Adequacy::Unknown, |found| Adequacy::Misfit(left(found, fit))))
}

/// What a global fit leaves, over the noise.
fn left(found: &GlobalFitSolution<f64>, fit: &HostFit<'_>) -> f64 {
    // That of the real part, and that of a complex number.
    found.noise * std::f64::consts::SQRT_2 / fit.noise()
}

fn explains(found: &GlobalFitSolution<f64>, fit: &HostFit<'_>) -> bool {
    let pulled = |d: &Diagnostic| {
        matches!(d.code, Code::LargeSensorPull | Code::LargeHitPull) && d.value > TOO_FAR
    };
    left(found, fit) <= MISFIT && !found.estimate.diagnostics.iter().any(pulled)
}

/// The direction of gravity with which the readings are explained without extra terms, as a signed axis from 1 to 3, or 0
/// for sensors that do not sense it.
fn other_gravity(
    layout: &HostLayout,
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    start: &RigidBody<f64>,
) -> Option<f32> {
    let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
    let settings = GlobalFitSettings { most_extra_terms: 0, ..GlobalFitSettings::default() };
    let mut left_with = |axis: i8| {
        let mut changed = layout.clone();
        let mut gravity = [0.0; 3];
        if let Some(component) = gravity.get_mut(usize::from(axis.unsigned_abs()).wrapping_sub(1)) {
            *component = STANDARD_GRAVITY * f64::from(axis.signum());
        }
        changed.gravity = Some(gravity);
        changed.sensors.iter_mut().for_each(|sensor| sensor.senses_gravity = true);
        let found = global_fit::solve(&changed, readings, start, &settings, &mut memory).ok()?;
        explains(&found, fit).then(|| (f32::from(axis), left(&found, fit)))
    };
    let all = (-3..=3).filter_map(&mut left_with);
    all.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(axis, _)| axis)
}

/// Warns of a misfit.
pub(super) fn warn_of_misfit(estimates: &mut [Estimate<f64>], left: f64) {
    for estimate in estimates {
        // There is room for sixteen diagnostics; any others are dropped.
        let _ = estimate.diagnostics.push(misfit(Severity::Warning, left));
    }
}

/// The finding of a misfit.
pub(super) fn misfit(severity: Severity, left: f64) -> Diagnostic {
    Diagnostic::whole(Code::ModelDoesNotFit, severity, left as f32)
}
