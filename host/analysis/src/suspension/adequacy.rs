//! Whether a body on its suspension explains the readings, and what is wrong if it does not.

use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use massline_shared::identify::Estimate;
use massline_shared::identify::global_fit::{Damping, GlobalFitSolution};

use super::alternatives::UnexplainedTest;
use super::explained::{MISFIT, SMALL};
use super::gravity::GravityTilt;
use massline_result::Doubt;

use super::{GlobalAnswer, HostFit};

/// What a global fit leaves, over the noise, from which its cause is looked for although it explains the readings.
const SUSPICIOUS: f64 = 1.004;

/// Pull of the direction of gravity, in standard deviations of the budget, from which a tilt is looked for.
const TILTED: f64 = 2.0;

/// How well a body on its suspension explains the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Adequacy {
    /// As well as their own modes.
    Fits,
    /// As well with a flexible mode above the band.
    Flexible,
    /// As well under another gravity than the layout's.
    Tilted(GravityTilt),
    /// Nearly as well: what is left besides noise is a small part of the readings, which this states.
    Roughly(Diagnostic),
    /// Less well, and this says why or how much.
    Misfit(Diagnostic),
    /// Nothing was fitted that would tell.
    Unknown,
}

impl Adequacy {
    /// The judgement of readings under tilted gravity.
    pub(super) fn under(self, tilted: GravityTilt) -> Self {
        match self {
            Self::Fits | Self::Flexible | Self::Tilted(_) | Self::Unknown => Self::Tilted(tilted),
            Self::Roughly(_) | Self::Misfit(_) => self,
        }
    }

    /// What there is to say of gravity, a hit or a misfit to every answer.
    pub(super) fn finding(self) -> Option<Diagnostic> {
        match self {
            Self::Tilted(tilted) => Some(tilted.warning()),
            Self::Roughly(reason) => Some(reason),
            Self::Misfit(reason) if reason.code != Code::NotConverged => Some(reason),
            _ => None,
        }
    }

    /// What there is to say of it with the modes.
    pub(super) fn finding_of_modes(self) -> Option<Diagnostic> {
        let shows = Diagnostic::whole(Code::FlexibleModeShows, Severity::Warning, 0.0);
        if self == Self::Flexible { Some(shows) } else { self.finding() }
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
            Self::Fits | Self::Tilted(_) | Self::Roughly(_) | Self::Unknown => None,
            Self::Flexible => Some(Doubt::FlexibleMode),
            Self::Misfit(_) => Some(Doubt::Misfit),
        }
    }
}

/// The judgement of a global fit.
pub(super) struct GlobalFitJudgement {
    pub(super) adequacy: Adequacy,
    /// Another form of the fit that explains the readings, where the one that was judged does not: with structural
    /// damping, or of fewer lines.
    pub(super) instead: Option<GlobalAnswer>,
}

/// Judges the global fit.
///
/// # Errors
/// `gravity_suspect`, `gravity_reversed` and `senses_gravity_suspect` when the fit is bad with the gravity of the
/// layout, and good with another.
pub(super) fn judge(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
    start: Option<&RigidBody<f64>>,
    global: &Result<GlobalAnswer, Diagnostics>,
) -> Result<GlobalFitJudgement, Diagnostics> {
    let solution = global.as_ref().map(|answer| &answer.solution);
    let judged = |adequacy: Adequacy| GlobalFitJudgement { adequacy, instead: None };
    let says = |code: Code| {
        move |reasons: &&Diagnostics| reasons.iter().any(|diagnostic| diagnostic.code == code)
    };
    let undetermined = solution.as_ref().err().is_some_and(says(Code::PropertyUndetermined));
    let was_tried = undetermined || solution.as_ref().err().is_none_or(says(Code::NotConverged));
    let Some(start) = start.filter(|_| was_tried) else {
        return Ok(judged(Adequacy::Unknown));
    };
    let explained = global.as_ref().is_ok_and(|answer| answer.explains(fit));
    let flexible = solution.is_ok_and(|solution| solution.extra_terms > 0);
    let fits =
        |answer: &GlobalAnswer| answer.left_over(fit) < SUSPICIOUS && !is_tilted(&answer.solution);
    if explained && !flexible && global.as_ref().is_ok_and(fits) {
        return Ok(judged(Adequacy::Fits));
    }
    let viscous = Damping::Viscous;
    let unexplained =
        UnexplainedTest { layout: fit.layout(), fit, readings, start, damping: viscous };
    // Few hits leave properties open, and so does gravity that makes a body out of a suspension.
    if undetermined {
        return match unexplained.gravity() {
            Some(reason) => Err(Diagnostics::from_array([reason])),
            None => Ok(judged(Adequacy::Unknown)),
        };
    }
    if (!explained || flexible)
        && let Some((better, tilted)) = unexplained.better()
    {
        let adequacy = tilted.map_or(Adequacy::Fits, Adequacy::Tilted);
        return Ok(GlobalFitJudgement { adequacy, instead: Some(better) });
    }
    // A fit that only gains of single modes explain may have taken another gravity for them.
    let hardly = |answer: &GlobalAnswer| answer.left_over(fit) > MISFIT;
    if (!explained || global.as_ref().is_ok_and(hardly))
        && let Some(reason) = unexplained.gravity()
    {
        return Err(Diagnostics::from_array([reason]));
    }
    Ok(judged(unexplained.cause(global.as_ref().ok(), explained)))
}

/// True for a fit that pulls the direction of gravity.
fn is_tilted(solution: &GlobalFitSolution<f64>) -> bool {
    solution.gravity.is_some_and(|gravity| gravity.pull > TILTED)
}

impl UnexplainedTest<'_, '_> {
    /// Another form of the fit that explains the readings, and the tilt of gravity where it shows in that form.
    fn better(&self) -> Option<(GlobalAnswer, Option<GravityTilt>)> {
        if let Some(answer) = self.structural() {
            let structural = Self { damping: Damping::Structural, ..*self };
            let tilted = is_tilted(&answer.solution).then(|| structural.tilted()).flatten();
            return Some((answer, tilted));
        }
        let answer = self.undisturbed()?;
        let part = self.lines(&answer.lines);
        let responses = part.responses()?;
        let undisturbed = UnexplainedTest { readings: &responses, ..*self };
        let tilted = is_tilted(&answer.solution).then(|| undisturbed.tilted()).flatten();
        Some((answer, tilted))
    }

    /// Why the readings want an explanation. A tilt, a hit and a flexible mode each take up some of what another has
    /// caused; the cause leaves least.
    fn cause(&self, answer: Option<&GlobalAnswer>, explained: bool) -> Adequacy {
        let flexible = answer.is_some_and(|answer| answer.solution.extra_terms > 0);
        let present = answer.map_or(f64::INFINITY, |answer| answer.left_over(self.fit));
        let pulled = answer.and_then(|answer| pulled_hit(&answer.solution.estimate));
        let hit = match (explained, flexible) {
            // What extra terms explain may be a hit that nothing pulls, as under a budget without errors.
            (true, true) => self
                .hit(pulled, false)
                .filter(|(of_hit, _)| pulled.is_some() || self.is_much_less(*of_hit, present)),
            (true, false) => None,
            (false, _) => self.hit(pulled, answer.is_some()),
        };
        let least = hit.map_or(present, |(of_hit, _)| of_hit.min(present));
        if let Some(tilted) = self.tilted().filter(|tilted| tilted.left < least) {
            return Adequacy::Tilted(tilted);
        }
        match (hit, answer) {
            (Some((_, reason)), _) => Adequacy::Misfit(reason),
            (None, Some(_)) if explained && flexible => Adequacy::Flexible,
            (None, Some(_)) if explained => Adequacy::Fits,
            (None, Some(answer)) => self.misfit(answer),
            (None, None) => {
                Adequacy::Misfit(Diagnostic::whole(Code::NotConverged, Severity::Error, 0.0))
            }
        }
    }

    /// How much a fit misses the readings for which there is no cause.
    fn misfit(&self, answer: &GlobalAnswer) -> Adequacy {
        let share = answer.share_left(self.fit, self.readings);
        if share < SMALL && answer.solution.extra_terms == 0 && !answer.is_pulled() {
            let code = Code::ModelFitsRoughly;
            return Adequacy::Roughly(Diagnostic::whole(code, Severity::Warning, share as f32));
        }
        let (code, left) = (Code::ModelDoesNotFit, answer.left_over(self.fit) as f32);
        Adequacy::Misfit(Diagnostic::whole(code, Severity::Error, left))
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
    let (Ok(answer), Adequacy::Misfit(reason)) = (&*global, adequacy) else { return };
    if answer.solution.extra_terms == 0 && reason.code == Code::ModelDoesNotFit {
        return;
    }
    let mut reasons = Diagnostics::from_array([reason]);
    reasons.extend(answer.solution.estimate.diagnostics.iter().copied());
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
