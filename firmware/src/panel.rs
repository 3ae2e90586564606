//! Screen, buttons and cues of the rig.
//!
//! | module | subject |
//! | --- | --- |
//! | [`menu`] | which screen is shown, and what a button does on it: pure, without pixels |
//! | [`mod@draw`] | the screens as pixels, on any `DrawTarget` |
//! | [`words`] | a short text for everything that the rig can report |
//! | `task` | the loop: waits for changes and buttons, and for the flash |
//! | `controller` | what the loop does between two waits |
//! | `layout_under` | the layout in use, under another profile |
//! | [`number`] | numbers as text, without the float formatter of `core`, which takes 20 KB |
//! | [`self_test`] | the self-test by buttons |
//! | [`summary`] | the part of a stored result that is shown |
//!
//! ```text
//! rig, store ─▶ PanelModel ─▶ Menu::follow ─▶ draw ─▶ Panel::screen, flush
//!                  │     Panel::button ─▶ Menu::press ─▶ Action ─▶ rig, store
//!                  └─▶ cues ─▶ Panel::cue
//! ```

pub mod calibration_wizard;
mod controller;
pub mod draw;
mod layout_under;
pub mod menu;
mod modal;
pub mod number;
mod pace;
pub mod refused;
pub mod self_test;
pub mod summary;
pub(crate) mod task;
pub mod words;

use core::convert::Infallible;

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::pixelcolor::BinaryColor;
use heapless::Vec;
use massline_protocol::message::{Battery, EstimatedMass};
use massline_shared::design::{Precision, Widths};
use massline_shared::diagnosis::{Diagnostic, Severity};
use massline_shared::layout::{Dof, RigLayout, TestProfile};
use massline_shared::measurement::campaign::{Campaign, Object, Outcome, Phase};
use massline_shared::measurement::{CampaignPrecision, GradedHit};
use massline_shared::signal::{CHANNELS, Swing};

use self::calibration_wizard::CalibrationWizard;
use self::self_test::SelfTestState;
use crate::rig::Rig;
use crate::screen_setting::ScreenSetting;

/// Everything that can be shown and that decides what a button does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelModel {
    /// What the campaign is doing.
    pub phase: Phase,
    /// Index and name of the current DOF; `None` without a layout.
    pub dof: Option<(u8, Dof)>,
    /// Number of armings since power-on.
    pub armings: u32,
    /// Accepted hits at the current DOF.
    pub accepted: u8,
    /// Accepted hits wanted at each DOF.
    pub wanted: u8,
    /// Number of DOFs of the layout.
    pub dofs: u8,
    /// Accepted hits of all DOFs.
    pub averaged: u16,
    /// Hits that are accepted or no longer needed, of all DOFs.
    pub hits_done: u16,
    /// Hits of the whole campaign.
    pub hits: u16,
    /// Hits rejected in this campaign.
    pub rejected: u16,
    /// Verdict on the last hit of this campaign.
    pub verdict: Option<HitVerdict>,
    /// Level of each channel over the last window: number of bits of the range of its codes.
    pub levels: [u8; CHANNELS],
    /// Estimated time until the end of the campaign, s; `None` before the first hit.
    pub seconds_left: Option<u16>,
    /// Time for which the object still rings in the record of a hit of the suspension profile, s; `None` outside of
    /// one.
    pub ringing_left: Option<u8>,
    /// What the layout measures.
    pub profile: TestProfile,
    /// True when the object is a block of known mass.
    pub block: bool,
    /// Number of the finished campaign's result, 0 when there is none.
    pub result: u32,
    /// Mass according to the best estimate of the last result, kg.
    pub mass: Option<EstimatedMass>,
    /// How precise the answer would be with the DOFs measured so far; `None` before the first is closed.
    pub precision: Option<PrecisionModel>,
    /// True when the target is reached and the operator has not decided yet.
    pub at_target: bool,
    /// True when the campaign was interrupted by the rig itself.
    pub interrupted: bool,
    /// True when nothing is being measured, so that layout and calibration may be changed.
    pub idle: bool,
    /// Number of diagnostics of the campaign or of a refused layout.
    pub findings: u8,
    /// Number of stored layouts.
    pub layouts: u8,
    /// Number of stored results.
    pub results: u8,
    /// Pages of the open result; 0 when none is open.
    pub pages: u8,
    /// State of the calibration.
    pub calibration_wizard: CalibrationWizard,
    /// Charge of the battery, where there is a gauge.
    pub battery: Option<Battery>,
    /// State of the self-test.
    pub self_test: SelfTestState,
}

impl PanelModel {
    /// The model of a rig that has just started.
    pub const START: Self = Self {
        phase: Phase::Idle,
        dof: None,
        armings: 0,
        accepted: 0,
        wanted: 0,
        dofs: 0,
        averaged: 0,
        hits_done: 0,
        hits: 0,
        rejected: 0,
        verdict: None,
        levels: [0; CHANNELS],
        seconds_left: None,
        ringing_left: None,
        profile: TestProfile::MassLine,
        block: false,
        result: 0,
        mass: None,
        precision: None,
        at_target: false,
        interrupted: false,
        idle: true,
        findings: 0,
        layouts: 0,
        results: 0,
        pages: 0,
        calibration_wizard: CalibrationWizard::Off,
        battery: None,
        self_test: SelfTestState::Off,
    };
}

impl PanelModel {
    /// The model from the rig's state. The panel itself fills in lists, pages and the calibration.
    pub(crate) fn of(rig: &Rig<'_>) -> Self {
        let measurement = rig.measurement.borrow();
        let campaign = measurement.campaign();
        let dofs = campaign.map_or(&[][..], Campaign::dofs);
        let (dof, wanted) = campaign.map_or((0, 0), |c| (c.dof(), c.hits_per_dof()));
        let layout = measurement.layout();
        let hit = layout.and_then(|layout| layout.hits.get(dof));
        let done = dofs.iter().map(|progress| match progress.outcome {
            Outcome::Open => u16::from(progress.accepted).min(wanted.into()),
            Outcome::Complete | Outcome::Early | Outcome::Skipped | Outcome::NotNeeded => {
                wanted.into()
            }
        });
        let object = campaign.map_or(Object::Unknown, |campaign| campaign.started().object);
        let diagnostics = measurement.diagnostics();
        Self {
            phase: measurement.phase(),
            dof: hit.map(|hit| (dof as u8, hit.dof)),
            armings: measurement.armings(),
            accepted: campaign.map_or(0, Campaign::accepted),
            wanted,
            dofs: layout.map_or(0, |layout| layout.hits.len() as u8),
            averaged: dofs.iter().map(|progress| u16::from(progress.accepted)).sum(),
            hits_done: done.sum(),
            hits: dofs.len() as u16 * u16::from(wanted),
            rejected: campaign.map_or(0, Campaign::rejected),
            verdict: measurement.last_hit().map(HitVerdict::from),
            levels: rig.levels.get(),
            block: matches!(object, Object::Block { .. }),
            result: campaign.map_or(0, Campaign::result),
            profile: measurement.profile(),
            mass: rig.last_mass.get(),
            precision: measurement.precision().map(|known| PrecisionModel::of(known, layout)),
            at_target: campaign.is_some_and(Campaign::is_at_target),
            interrupted: diagnostics.iter().any(|diagnostic| diagnostic.interrupts()),
            idle: measurement.is_idle(),
            findings: diagnostics.len() as u8,
            battery: rig.info.supply.charge(),
            ..Self::START
        }
    }
}

impl PanelModel {
    /// True when the program has something to solve.
    pub(crate) fn has_lines(&self) -> bool {
        self.profile == TestProfile::Suspension && self.averaged > 0
    }

    /// True when the lowest line says how the object swung at a hit about which something was found.
    pub(crate) fn is_swing_shown(&self) -> bool {
        self.verdict.is_some_and(|verdict| verdict.swing.is_some() && verdict.reason.is_some())
    }
}

impl From<&GradedHit> for HitVerdict {
    fn from(hit: &GradedHit) -> Self {
        let first = |severity| hit.findings.iter().find(|finding| finding.severity == severity);
        let reason = first(Severity::Error).or_else(|| first(Severity::Warning)).copied();
        Self { peak_force: hit.peak_force, swing: hit.swing, reason }
    }
}

/// How precise the answer would be with the DOFs measured so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrecisionModel {
    /// Number of DOFs with mass lines.
    pub dofs: u8,
    /// Largest half widths of the 95 % intervals; `None` when more DOFs are needed.
    pub widths: Option<Widths<f32>>,
    /// The hit that would narrow the worst interval most.
    pub further: Option<FurtherPlace>,
}

/// The hit that would narrow the worst interval most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FurtherPlace {
    /// The DOF.
    pub dof: Dof,
    /// Index of the worst property in `theta`.
    pub property: u8,
    /// Half width of its 95 % interval now, and expected with that hit, in the units of a target.
    pub half_widths: [f32; 2],
}

impl PrecisionModel {
    fn of(known: &CampaignPrecision<f32>, layout: Option<&RigLayout>) -> Self {
        let further = known.further.zip(known.precision).and_then(|(hit, precision)| {
            let dof = layout?.hits.get(hit.dof)?.dof;
            let now = precision.half_widths[hit.property];
            let half_widths =
                [now, hit.half_width].map(|half| precision.in_target_units(hit.property, half));
            Some(FurtherPlace { dof, property: hit.property as u8, half_widths })
        });
        let widths = known.precision.as_ref().map(Precision::widths);
        Self { dofs: known.dofs, widths, further }
    }
}

/// Verdict on a hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HitVerdict {
    /// Peak force, N.
    pub peak_force: f32,
    /// What a hit is judged by in the suspension profile; `None` in the other.
    pub swing: Option<Swing>,
    /// The error for which the hit was rejected, or what makes an accepted one doubtful; `None` for a good one.
    pub reason: Option<Diagnostic>,
}

/// A screen of 128 × 64 pixels, three buttons, a sound or light.
pub trait Panel {
    /// Framebuffer of the board: 128 × 64 pixels (1 KiB).
    type Screen: DrawTarget<Color = BinaryColor, Error = Infallible>;

    /// The framebuffer. Every picture is drawn as a whole.
    fn screen(&mut self) -> &mut Self::Screen;

    /// Transfers the framebuffer to the screen; returns at once when no screen is connected. Cancel-safe.
    ///
    /// Latency: other tasks run while it waits. A screen of 1 KiB takes 24 ms over I²C at 400 kHz, nine
    /// bits a byte; a single transfer is at most a page of 128 bytes, 3 ms.
    fn flush(&mut self) -> impl Future<Output = ()>;

    /// Waits until a button is pressed. Cancel-safe.
    fn button(&mut self) -> impl Future<Output = Button>;

    /// Says which controller the screen has, for a board whose screen may have several.
    fn use_screen(&mut self, _setting: ScreenSetting) {}

    /// Starts a cue of sound or light and returns.
    fn cue(&mut self, cue: Cue);

    /// Receives the model of the next picture, for a board whose screen is read by a program.
    fn report(&mut self, _model: &PanelModel) {}
}

/// A button of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Confirm, or enter.
    Ok,
    /// Leave, towards home.
    Back,
    /// Next entry, page or digit; pause.
    Next,
}

/// A sound or light for an operator whose hands are busy with the hammer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cue {
    /// The rig waits for a hit.
    Armed,
    /// The hit counts.
    Accepted,
    /// The hit does not count.
    Rejected,
    /// There is a result, or the target is reached.
    Done,
    /// The rig cannot go on, or the result has no answer.
    Failed,
}

/// The cues to be played, in this order, when the model changes from `before` to `after`.
pub fn cues(before: &PanelModel, after: &PanelModel) -> Vec<Cue, 3> {
    let mut cues = Vec::new();
    let mut play = |cue, when: bool| {
        if when {
            // There are three at most: a campaign that has ended is neither armed nor interrupted.
            let _ = cues.push(cue);
        }
    };
    let entered = |phase| after.phase == phase && before.phase != phase;
    let answered = after.mass.is_some() || after.block || after.has_lines();
    play(Cue::Rejected, after.rejected > before.rejected);
    play(Cue::Accepted, after.averaged > before.averaged && after.rejected <= before.rejected);
    play(Cue::Armed, after.phase == Phase::Armed && after.armings != before.armings);
    play(Cue::Done, entered(Phase::Done) && answered);
    play(Cue::Done, entered(Phase::TargetReached));
    play(Cue::Failed, entered(Phase::Done) && !answered);
    play(Cue::Failed, entered(Phase::Paused) && after.interrupted);
    cues
}

#[cfg(test)]
mod tests {
    use super::*;

    const ARMED: PanelModel =
        PanelModel { phase: Phase::Armed, armings: 1, hits: 15, ..PanelModel::START };

    #[test]
    fn each_event_of_a_campaign_is_heard_once() {
        assert_eq!(cues(&PanelModel::START, &ARMED), [Cue::Armed]);
        assert_eq!(cues(&ARMED, &ARMED), []);
        let accepted = PanelModel { armings: 2, averaged: 1, hits_done: 1, ..ARMED };
        assert_eq!(cues(&ARMED, &accepted), [Cue::Accepted, Cue::Armed]);
        let rejected = PanelModel { armings: 3, rejected: 1, ..accepted };
        assert_eq!(cues(&accepted, &rejected), [Cue::Rejected, Cue::Armed]);
        // The DOF is skipped: its hits are no longer needed, and none was accepted.
        let skipped = PanelModel { armings: 4, hits_done: 5, ..rejected };
        assert_eq!(cues(&rejected, &skipped), [Cue::Armed]);
    }

    #[test]
    fn an_end_without_an_answer_is_a_failure() {
        let done = PanelModel { phase: Phase::Done, ..ARMED };
        assert_eq!(cues(&ARMED, &done), [Cue::Failed]);
        let mass = Some(EstimatedMass { value: 1.0, sigma: None });
        assert_eq!(cues(&ARMED, &PanelModel { mass, ..done }), [Cue::Done]);
        assert_eq!(cues(&ARMED, &PanelModel { block: true, ..done }), [Cue::Done]);
        // The program gives the answer, where there is something to solve.
        let nothing = PanelModel { profile: TestProfile::Suspension, ..done };
        assert_eq!(cues(&ARMED, &nothing), [Cue::Failed]);
        let measured = PanelModel { averaged: 1, ..nothing };
        assert_eq!(cues(&PanelModel { averaged: 1, ..ARMED }, &measured), [Cue::Done]);
    }

    #[test]
    fn only_an_interruption_by_the_rig_itself_is_a_failure() {
        let paused = PanelModel { phase: Phase::Paused, ..ARMED };
        assert_eq!(cues(&ARMED, &paused), []);
        assert_eq!(cues(&ARMED, &PanelModel { interrupted: true, ..paused }), [Cue::Failed]);
    }
}
