//! What a person sees of a campaign: where to hit, what the last hit was, and how well the answer is known.

use std::time::Duration;

use crossterm::event::KeyCode;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Levels, Status};
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::design::Widths;
use massline_shared::layout::{AXIS_LETTERS, Hit, RigLayout};
use massline_shared::measurement::campaign::Phase;

use super::pace::Pace;
use crate::client::DofSpectra;
use crate::precision::PrecisionReport;
use crate::readings::Readings;
use crate::report::{HitSaid, as_exact_as, two_digits};

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
    pub(super) precision: Vec<Step>,
    pub(super) question: Option<String>,
    /// The last note, until something else happens.
    pub(super) note: Option<String>,
    pub(super) page: Page,
    pub(super) help: bool,
    pub(super) wanted: Wanted,
    pub(super) pace: Pace,
}

/// What there is to see of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Whether the intervals are followed: a block test has none.
    pub estimates: bool,
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
    /// Time between scans, and time before the trigger, s.
    pub step: f64,
    pub before: f64,
}

/// What is known after some of the DOFs.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// DOFs with mass lines.
    pub measured: usize,
    /// `4 of 12 DOFs`.
    pub progress: String,
    /// The largest half widths of the 95 % intervals.
    pub widths: Option<Widths<f64>>,
    /// Name, value and half width of the 95 % interval of each property with its unit.
    pub properties: Vec<[String; 4]>,
    /// What to make of it.
    pub advice: String,
}

/// What a small terminal shows beside the DOF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// The last hit over time.
    Hit,
    /// Frequency responses and coherence.
    Spectra,
    /// The ten properties so far.
    Estimate,
}

impl Page {
    const ALL: [Self; 3] = [Self::Hit, Self::Spectra, Self::Estimate];
}

impl Guide {
    /// A guide of a campaign that has not begun.
    pub fn new(
        title: &str,
        kind: &'static str,
        layout: &RigLayout,
        bits: u8,
        wanted: Wanted,
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
            precision: Vec::new(),
            question: None,
            note: None,
            page: Page::Hit,
            help: false,
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
        self.spectra = spectra.filter(|of| of.dof == status.dof && self.hits_here() > 0);
    }

    /// Says what became of hits that are not counted any more, unless their events say so.
    fn discarded(&mut self, before: &Status, now: &Status) {
        for (dof, (&had, &has)) in (0_u8..).zip(before.accepted.iter().zip(&now.accepted)) {
            let undone = self.hit.as_ref().is_some_and(|hit| hit.is_undone() && hit.dof == dof);
            if had == 0 || has > 0 || undone {
                continue;
            }
            let hits = if had == 1 { "its hit is" } else { "its hits are" };
            let what = if dof == now.dof { "measured again" } else { "skipped" };
            self.note = Some(format!("{} is {what}: {hits} discarded", self.name(dof)));
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
            self.readings = self.readings.take().filter(|of| of.number != hit.number);
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
        self.precision.retain(|step| step.measured <= measured);
    }

    /// Takes the levels of the channels.
    pub fn levels(&mut self, levels: Levels) {
        self.levels = Some(levels);
    }

    /// Takes the readings of a hit.
    pub fn readings(&mut self, of: HitReadings) {
        self.readings = Some(of);
    }

    /// Takes the averaged spectra of the DOF in hand.
    pub fn spectra(&mut self, spectra: DofSpectra) {
        self.spectra = Some(spectra);
    }

    /// Takes the precision after a further DOF, or after one that was opened again and is closed again.
    pub fn precision(&mut self, report: &PrecisionReport<'_>) {
        self.precision.retain(|step| step.measured < report.measured);
        self.precision.push(Step::of(report));
    }

    /// Asks a question that a key answers.
    pub fn question(&mut self, question: String) {
        self.question = Some(question);
    }

    /// Takes a key that only changes what is shown; false for any other key.
    pub fn key(&mut self, key: KeyCode) -> bool {
        if self.help {
            return self.key_of_help(key);
        }
        let pages: Vec<Page> = self.pages().collect();
        let here = pages.iter().position(|page| *page == self.page).unwrap_or(0);
        let turned = match key {
            KeyCode::Tab | KeyCode::Right => here + 1,
            KeyCode::BackTab | KeyCode::Left => here + pages.len() - 1,
            KeyCode::Char('?' | 'h') | KeyCode::F(1) => {
                self.help = true;
                return true;
            }
            _ => return false,
        };
        self.page = pages[turned % pages.len()];
        true
    }

    /// While the keys are explained, none of them does anything but leave.
    fn key_of_help(&mut self, key: KeyCode) -> bool {
        if matches!(key, KeyCode::Char('?' | 'h') | KeyCode::F(1) | KeyCode::Esc) {
            self.help = false;
        }
        key != KeyCode::Char('p')
    }

    /// The pages that there are, in their order.
    pub(super) fn pages(&self) -> impl Iterator<Item = Page> {
        Page::ALL.into_iter().filter(|page| self.wanted.estimates || *page != Page::Estimate)
    }

    /// What is said of the last hit; nothing before the first.
    pub(super) fn verdict(&self) -> Option<HitSaid> {
        let hit = self.hit.as_ref()?;
        let said = HitSaid::of(hit, &self.layout);
        // One that the rig has withdrawn has its reasons.
        let by_person = hit.good && self.rejected_by_person;
        Some(if by_person { HitSaid::rejected_by_you() } else { said })
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
        let all = self.layout.hits.len() * per_dof;
        let Some(status) = &self.status else { return [0, all] };
        let is_closed = |dof: usize| dof < usize::from(status.dof);
        let of = |(dof, &hits): (usize, &u8)| {
            if is_closed(dof) { usize::from(hits) } else { per_dof.max(hits.into()) }
        };
        let wanted = status.accepted.iter().enumerate().map(of).sum();
        [accepted(status), wanted]
    }
}

fn accepted(status: &Status) -> usize {
    status.accepted.iter().map(|&hits| usize::from(hits)).sum()
}

impl Step {
    fn of(report: &PrecisionReport<'_>) -> Self {
        let properties = report.body.iter().zip(&report.precision).flat_map(|(body, precision)| {
            let halves = precision.half_widths.iter().copied();
            let values = body.theta();
            INERTIAL_PARAMETERS
                .iter()
                .zip(values.iter().copied().zip(halves))
                .map(|(of, (value, half))| {
                    let [value, half] = [value, half].map(|number| number * of.table_factor);
                    let number = as_exact_as(value, Some(half));
                    [of.name.into(), number, two_digits(half), of.table_unit.into()]
                })
                .collect::<Vec<_>>()
        });
        Self {
            measured: report.measured,
            progress: report.progress(),
            widths: report.precision.as_ref().map(|precision| precision.widths()),
            properties: properties.collect(),
            advice: report.advice(),
        }
    }
}

#[cfg(test)]
mod tests {
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::layout::HostLayout;
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;
    use crate::layout_file::LayoutFile;
    use crate::output::harmless;
    use crate::screen::{Theme, View};

    const ALL: Wanted = Wanted { estimates: true, verdicts: true };

    fn layout() -> HostLayout {
        let text = include_str!("../../examples/three-bar-test-1.toml");
        LayoutFile::parse(text, "test").unwrap().layout
    }

    /// What is on a terminal of this size.
    fn shown(guide: &Guide, [width, height]: [u16; 2]) -> String {
        let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
        terminal.draw(|frame| guide.draw(frame, Theme { color: true })).unwrap();
        terminal.backend().to_string()
    }

    #[test]
    fn titles_are_text_at_every_size() {
        let layout = layout().cast().unwrap();
        let long = "long ".repeat(820);
        for title in ["<script>alert(1)</script>", "\u{202e}abc\u{1b}[2J", &long] {
            let title = harmless(title);
            let mut guide = Guide::new(&title, "measurement", &layout, 12, ALL);
            for size in [[1, 1], [40, 10], [60, 18], [80, 24], [200, 40], [200, 60]] {
                for help in [false, true] {
                    guide.help = help;
                    let screen = shown(&guide, size);
                    assert!(!screen.contains(['\u{202e}', '\u{1b}']), "{screen}");
                    let begin: String = title.chars().take(8).collect();
                    assert!(size[0] < 60 || screen.contains(&begin), "{screen}");
                }
            }
        }
    }

    /// A status with these accepted hits at DOF `dof`.
    fn status(dof: u8, accepted: &[u8]) -> Status {
        Status {
            phase: Phase::Armed.into(),
            dof,
            armings: 1,
            accepted: accepted.iter().copied().collect(),
            hits_per_dof: 5,
            rejected: 0,
            last_hit: 3,
            layout_hash: 1,
            result: 0,
            started_unix_s: 1,
            diagnostics: Diagnostics::new(),
        }
    }

    fn guide() -> Guide {
        Guide::new("frame", "measurement", &layout().cast().unwrap(), 12, ALL)
    }

    #[test]
    fn while_the_keys_are_explained_no_other_key_reaches_the_campaign() {
        let mut guide = guide();
        assert!(guide.key(KeyCode::Char('?')));
        for key in ['d', 's', 'u', 'q', 'f', 'a'] {
            assert!(guide.key(KeyCode::Char(key)) && guide.help, "{key}");
        }
        assert!(guide.key(KeyCode::Tab));
        assert_eq!(guide.page, Page::Hit);
        assert!(!guide.key(KeyCode::Char('p')), "a pause is always possible");
        assert!(guide.key(KeyCode::Esc) && !guide.help);
        assert!(!guide.key(KeyCode::Char('d')));
    }

    #[test]
    fn hits_of_a_dof_that_is_redone_or_skipped_are_said_to_be_discarded_and_not_counted_on() {
        for (dof, what, hits) in [(0, "measured again", [0, 15]), (1, "skipped", [0, 10])] {
            let mut guide = guide();
            guide.status(&status(0, &[3, 0, 0]), Duration::ZERO);
            assert_eq!(guide.hits(), [3, 15]);
            guide.status(&status(dof, &[0, 0, 0]), Duration::ZERO);
            let note = guide.note.clone().unwrap();
            assert!(note.contains(what) && note.contains("1:+Y"), "{note}");
            assert_eq!(guide.hits(), hits);
            guide.acted();
            assert_eq!(guide.note, None);
        }
    }

    #[test]
    fn a_block_test_has_no_page_of_its_estimate() {
        let wanted = Wanted { estimates: false, ..ALL };
        let mut guide = Guide::new("block", "block test", &layout().cast().unwrap(), 12, wanted);
        for page in [Page::Spectra, Page::Hit, Page::Spectra] {
            assert!(guide.key(KeyCode::Tab));
            assert_eq!(guide.page, page);
        }
        assert!(!guide.key(KeyCode::Char('d')), "a key of the campaign");
    }
}
