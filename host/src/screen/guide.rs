//! What a person sees of a campaign: where to hit, what the last hit was, and how well the answer is known.

use std::time::Duration;

use crossterm::event::KeyCode;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Levels, Status};
use massline_shared::layout::{AXIS_LETTERS, Hit, RigLayout};
use massline_shared::measurement::campaign::Phase;

use super::interim::InterimEstimate;
use super::pace::Pace;
pub use super::pages::AnswerSoFar;
use super::pages::Pages;
use massline_analysis::precision::PrecisionReport;
use massline_files::dof_spectra::DofSpectra;
use massline_report::readings::Readings;
use massline_report::words::HitAssessment;
use massline_result::ModesSoFar;

/// Characters of a title that are kept: more than any terminal shows in a line.
const TITLE: usize = 300;

/// The guide of a campaign.
#[derive(Clone, Debug)]
pub struct Guide {
    /// What is measured.
    pub(super) title: String,
    /// `measurement` or `block test`.
    pub(super) kind: &'static str,
    pub(super) layout: RigLayout,
    /// Bits of the converter's codes.
    pub(super) bits: u8,
    pub(super) status: Option<Status>,
    pub(super) levels: Option<Levels>,
    /// The last hit.
    pub(super) hit: Option<HitEvent>,
    /// The person has rejected it.
    rejected_by_person: bool,
    pub(super) readings: Option<HitReadings>,
    pub(super) spectra: Option<DofSpectra>,
    /// Hits and spectra of this DOF are not read, because the link is slow.
    pub(super) slow: bool,
    /// Seconds for which the object rings yet in its record.
    pub(super) rings_s: Option<u64>,
    pub(super) precision: Vec<InterimEstimate>,
    /// The modes after the last closed DOF, in the suspension profile.
    pub(super) modes: Option<ModesSoFar>,
    pub(super) question: Option<String>,
    /// The last note, until something else happens.
    pub(super) note: Option<String>,
    pub(super) pages: Pages,
    pub(super) wanted: GuideOptions,
    pub(super) pace: Pace,
}

/// What there is to see of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GuideOptions {
    /// What is followed of the answer: a block test has none.
    pub answer: Option<AnswerSoFar>,
    /// Whether the person gives a verdict on each hit.
    pub verdicts: bool,
}

/// The readings of a hit.
#[derive(Clone, Debug, PartialEq)]
pub struct HitReadings {
    /// Number of the hit.
    pub number: u32,
    /// The hit in physical units.
    pub readings: Readings,
    /// Time between two scans, s.
    pub scan_interval_s: f64,
    /// Time from the first scan to the trigger, s.
    pub pre_trigger_s: f64,
}

impl Guide {
    /// A guide of a campaign that has not begun.
    pub fn new(
        title: &str,
        kind: &'static str,
        layout: &RigLayout,
        bits: u8,
        wanted: GuideOptions,
    ) -> Self {
        Self {
            title: title.chars().take(TITLE).collect(),
            kind,
            layout: layout.clone(),
            bits,
            status: None,
            levels: None,
            hit: None,
            rejected_by_person: false,
            readings: None,
            spectra: None,
            slow: false,
            rings_s: None,
            precision: Vec::new(),
            modes: None,
            question: None,
            note: None,
            pages: Pages::new(wanted.answer),
            wanted,
            pace: Pace::default(),
        }
    }

    /// Takes a new status, at a time since any moment.
    pub fn status(&mut self, status: &Status, at: Duration) {
        self.pace.take(accepted(status), at);
        if let Some(before) = self.status.replace(status.clone()) {
            self.discarded(&before, status);
        }
        if self.phase() != Some(Phase::TargetReached) {
            self.question = None;
        }
        let spectra = self.spectra.take();
        self.spectra = spectra.filter(|spectra| spectra.dof == status.dof && self.hits_here() > 0);
    }

    /// Says what became of hits that are not counted any more, unless their events say so.
    fn discarded(&mut self, before: &Status, now: &Status) {
        for (dof, (&had, &has)) in (0_u8..).zip(before.accepted.iter().zip(&now.accepted)) {
            let undone = self.hit.as_ref().is_some_and(|hit| hit.is_undone() && hit.dof == dof);
            if had == 0 || has > 0 || undone {
                continue;
            }
            let hits = if had == 1 { "its hit is" } else { "its hits are" };
            let action = if dof == now.dof { "measured again" } else { "skipped" };
            self.note = Some(format!("{} is {action}: {hits} discarded", self.name(dof)));
            if self.hit.as_ref().is_some_and(|hit| hit.good && hit.dof == dof) {
                self.hit = None;
                self.readings = None;
            }
        }
        let waited = Phase::try_from(before.phase).ok() == Some(Phase::Confirming);
        self.rejected_by_person |= waited && now.rejected > before.rejected;
    }

    /// Takes a hit that was graded, withdrawn or undone.
    pub fn hit(&mut self, hit: &HitEvent) {
        if hit.is_undone() {
            self.readings = self.readings.take().filter(|readings| readings.number != hit.number);
        }
        self.rejected_by_person = false;
        self.note = None;
        self.hit = Some(hit.clone());
    }

    /// Takes a note.
    pub(super) fn keep_note(&mut self, text: &str) {
        self.note = Some(text.into());
    }

    /// A key has given the rig a command.
    pub fn acted(&mut self) {
        self.note = None;
    }

    /// The hit that closed a DOF was undone: the estimates with that DOF hold no more.
    pub fn reopened(&mut self, measured: usize) {
        self.precision.retain(|estimate| estimate.measured <= measured);
        self.modes = self.modes.take().filter(|modes| modes.dofs_measured <= measured);
    }

    /// Whether the link is too slow to read hits and spectra at this DOF.
    pub fn link_is_slow(&mut self, slow: bool) {
        self.slow = slow;
    }

    /// The object rings for so many seconds yet, or not any more; true when that is new.
    pub fn rings(&mut self, left_s: Option<u64>) -> bool {
        std::mem::replace(&mut self.rings_s, left_s) != left_s
    }

    /// Takes the levels of the channels.
    pub fn levels(&mut self, levels: Levels) {
        self.levels = Some(levels);
    }

    /// Takes the readings of a hit.
    pub fn readings(&mut self, readings: HitReadings) {
        self.readings = Some(readings);
    }

    /// Takes the averaged spectra of the DOF in hand.
    pub fn spectra(&mut self, spectra: DofSpectra) {
        self.spectra = Some(spectra);
    }

    /// Takes the precision after a further DOF, or after one that was opened again and is closed again.
    pub fn precision(&mut self, report: &PrecisionReport<'_>) {
        self.precision.retain(|estimate| estimate.measured < report.measured);
        self.precision.push(InterimEstimate::of(report));
    }

    /// Takes the modes that show after a further DOF.
    pub fn modes(&mut self, report: &ModesSoFar) {
        self.modes = Some(report.clone());
    }

    /// Asks a question that a key answers.
    pub fn question(&mut self, question: String) {
        self.question = Some(question);
    }

    /// Takes a key that only changes what is shown; false for any other key.
    pub fn key(&mut self, key: KeyCode) -> bool {
        self.pages.key(key)
    }

    /// What is said of the last hit; nothing before the first.
    pub(super) fn verdict(&self) -> Option<HitAssessment> {
        let hit = self.hit.as_ref()?;
        let verdict = HitAssessment::of(hit, &self.layout);
        // One that the rig has withdrawn has its reasons.
        let by_person = hit.good && self.rejected_by_person;
        Some(if by_person { HitAssessment::rejected_by_you() } else { verdict })
    }

    /// The name of a response: node and axis of its sensor.
    pub(super) fn response(&self, index: usize) -> String {
        let node = self.layout.sensors.get(index / 3).map_or(0, |sensor| sensor.node);
        format!("{node}{}", AXIS_LETTERS[index % 3])
    }

    /// The phase of the campaign.
    pub(super) fn phase(&self) -> Option<Phase> {
        Phase::try_from(self.status.as_ref()?.phase).ok()
    }

    /// The DOF in hand.
    pub(super) fn dof(&self) -> Option<&Hit<f32>> {
        self.layout.hits.get(usize::from(self.status.as_ref()?.dof))
    }

    /// The name of the DOF with this index.
    pub(super) fn name(&self, index: u8) -> String {
        self.layout
            .hits
            .get(usize::from(index))
            .map_or_else(|| "?".into(), |hit| hit.dof.to_string())
    }

    /// Accepted hits of the DOF in hand.
    pub(super) fn hits_here(&self) -> u8 {
        let accepted = |status: &Status| status.accepted.get(usize::from(status.dof)).copied();
        self.status.as_ref().and_then(accepted).unwrap_or(0)
    }

    /// Accepted hits, and as many as there will be: those of DOFs that are closed, and those that the others want.
    pub(super) fn hits(&self) -> [usize; 2] {
        let per_dof = usize::from(self.layout.test.hits_per_dof);
        let planned = self.layout.hits.len() * per_dof;
        let Some(status) = &self.status else { return [0, planned] };
        // From the target on, there are no hits to come unless the person goes on.
        let is_over =
            matches!(self.phase(), Some(Phase::TargetReached | Phase::Solving | Phase::Done));
        let is_closed = |dof: usize| is_over || dof < usize::from(status.dof);
        let expected = |(dof, &hits): (usize, &u8)| {
            if is_closed(dof) { usize::from(hits) } else { per_dof.max(hits.into()) }
        };
        let wanted = status.accepted.iter().enumerate().map(expected).sum();
        [accepted(status), wanted]
    }
}

fn accepted(status: &Status) -> usize {
    status.accepted.iter().map(|&hits| usize::from(hits)).sum()
}

#[cfg(test)]
pub(super) mod tests;
