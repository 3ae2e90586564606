//! Whether a body on its suspension explains the readings, and what is wrong if it does not.

use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use massline_shared::identify::Estimate;

use super::alternatives::Unexplained;
use super::explained::{explains, left};
use super::gravity::Tilted;
use super::{Doubt, GlobalAnswer, HostFit};

/// What a global fit leaves, over the noise, from which its cause is looked for although it explains the readings.
const SUSPICIOUS: f64 = 1.004;

/// How well a body on its suspension explains the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Adequacy {
    /// As well as their own modes.
    Fits,
    /// As well with a flexible mode above the band.
    Flexible,
    /// As well under another gravity than the layout's.
    Tilted(Tilted),
    /// Less well, and this says why or how much.
    Misfit(Diagnostic),
    /// Nothing was fitted that would tell.
    Unknown,
}

impl Adequacy {
    /// What there is to say of gravity, a hit or a misfit.
    pub(super) fn finding(self) -> Option<Diagnostic> {
        match self {
            Self::Tilted(tilted) => Some(tilted.warning()),
            Self::Misfit(reason) if reason.code != Code::NotConverged => Some(reason),
            _ => None,
        }
    }

    /// Gravity as the readings have it, m/s², where that is not the layout's.
    pub(super) fn fitted_gravity(self) -> Option<[f64; 3]> {
        match self {
            Self::Tilted(tilted) => Some(tilted.gravity),
            _ => None,
        }
    }

    /// What it says against the answers.
    pub(super) fn doubt(self) -> Option<Doubt> {
        match self {
            Self::Fits | Self::Tilted(_) | Self::Unknown => None,
            Self::Flexible => Some(Doubt::FlexibleMode),
            Self::Misfit(_) => Some(Doubt::Misfit),
        }
    }
}

/// Judges the global fit. Where another form of it explains the readings better (structural damping, fewer lines), that takes
/// its place.
///
/// # Errors
/// `gravity_suspect`, `gravity_reversed` and `senses_gravity_suspect` when the fit is bad with the gravity of the layout, and good with another.
pub(super) fn judge(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    start: Option<&RigidBody<f64>>,
    global: &mut Result<GlobalAnswer, Diagnostics>,
) -> Result<Adequacy, Diagnostics> {
    let found = global.as_ref().map(|found| &found.solution);
    let was_tried = |reasons: &&Diagnostics| reasons.iter().any(|d| d.code == Code::NotConverged);
    let Some(start) = start.filter(|_| found.as_ref().err().is_none_or(was_tried)) else {
        return Ok(Adequacy::Unknown);
    };
    let explained = found.is_ok_and(|found| explains(found, fit));
    let flexible = found.is_ok_and(|found| found.extra_terms > 0);
    if found.is_ok_and(|found| found.extra_terms == 0 && left(found, fit) < SUSPICIOUS) {
        return Ok(Adequacy::Fits);
    }
    let unexplained = Unexplained { layout: fit.layout(), fit, readings, start };
    let better = || unexplained.structural().or_else(|| unexplained.undisturbed());
    if (!explained || flexible)
        && let Some(better) = better()
    {
        *global = Ok(better);
        return Ok(Adequacy::Fits);
    }
    if !explained && let Some(reason) = unexplained.gravity() {
        return Err(Diagnostics::from_array([reason]));
    }
    let found = global.as_ref().map(|found| &found.solution);
    // Each of the three takes up some of what another has caused; the cause leaves least.
    let present = found.map_or(f64::INFINITY, |found| left(found, fit));
    let pulled = found.ok().and_then(|found| pulled_hit(&found.estimate));
    let hit = match (explained, flexible) {
        // What extra terms explain may be a hit that nothing pulls, such as one with another gain.
        (true, true) => unexplained
            .hit(pulled, false)
            .filter(|(of_hit, _)| pulled.is_some() || unexplained.is_much_less(*of_hit, present)),
        (true, false) => None,
        (false, _) => unexplained.hit(pulled, found.is_ok()),
    };
    let least = hit.map_or(present, |(of_hit, _)| of_hit.min(present));
    if let Some(tilted) = unexplained.tilted().filter(|tilted| tilted.left < least) {
        return Ok(Adequacy::Tilted(tilted));
    }
    match (hit, found) {
        (Some((_, reason)), _) => Ok(Adequacy::Misfit(reason)),
        (None, Ok(_)) if explained && flexible => Ok(Adequacy::Flexible),
        (None, Ok(_)) if explained => Ok(Adequacy::Fits),
        (None, Ok(found)) => {
            let (code, left) = (Code::ModelDoesNotFit, left(found, fit) as f32);
            Ok(Adequacy::Misfit(Diagnostic::whole(code, Severity::Error, left)))
        }
        (None, Err(_)) => {
            let code = Code::NotConverged;
            Ok(Adequacy::Misfit(Diagnostic::whole(code, Severity::Error, 0.0)))
        }
    }
}

/// The hit that the fit pulls most.
fn pulled_hit(estimate: &Estimate<f64>) -> Option<usize> {
    estimate.diagnostics.iter().find_map(|d| match (d.code, d.subject) {
        (Code::LargeHitPull, Subject::Hit(hit)) => Some(usize::from(hit)),
        _ => None,
    })
}

/// Refuses a global fit of readings that no body explains: its extra terms have taken up what is wrong elsewhere.
pub(super) fn refuse_misfit(global: &mut Result<GlobalAnswer, Diagnostics>, adequacy: Adequacy) {
    let (Ok(found), Adequacy::Misfit(reason)) = (&*global, adequacy) else { return };
    if found.solution.extra_terms == 0 && reason.code == Code::ModelDoesNotFit {
        return;
    }
    let mut reasons = Diagnostics::from_array([reason]);
    reasons.extend(found.solution.estimate.diagnostics.iter().copied());
    *global = Err(reasons);
}

/// Warns of a misfit or of tilted gravity.
pub(super) fn warn_of_misfit(estimates: &mut [Estimate<f64>], adequacy: Adequacy) {
    let Some(reason) = adequacy.finding() else { return };
    for estimate in estimates {
        let warning = Diagnostic { severity: Severity::Warning, ..reason };
        // There is room for sixteen diagnostics; any others are dropped.
        let _ = estimate.diagnostics.push(warning);
    }
}
