//! Every hit of a test with its verdict, DOF by DOF.

use super::for_people;
use super::values::Sentence;
use crate::document::{HitVerdict, LoggedHit};
use crate::result_file::ResultFile;

/// A table of more hits than this is folded.
const MOST_SHOWN: usize = 12;

/// The hits of a test.
#[derive(Default)]
pub(super) struct HitTable {
    pub dofs: Vec<HitsOfDof>,
    /// How many there are, and how many of them are in the answer.
    pub summary: String,
}

/// The hits at one DOF, in the order in which they were made.
pub(super) struct HitsOfDof {
    pub dof: String,
    pub rows: Vec<HitRow>,
    /// Accepted hits that nobody has followed.
    pub unseen: usize,
}

/// A hit.
pub(super) struct HitRow {
    pub number: u32,
    pub verdict: &'static str,
    pub is_in_answer: bool,
    pub reasons: Vec<Sentence>,
    pub peak_force: String,
    pub peak_acceleration: String,
    pub time: String,
}

impl HitTable {
    /// The hits of a result; none where it has no log of them.
    pub fn of(source: &ResultFile) -> Self {
        let log = source.hit_log();
        let mut dofs: Vec<HitsOfDof> = Vec::new();
        for hit in &log {
            let row = HitRow::of(hit);
            match dofs.iter_mut().find(|of| of.dof == hit.dof) {
                Some(of) => of.rows.push(row),
                None => {
                    dofs.push(HitsOfDof { dof: hit.dof.clone(), rows: vec![row], unseen: 0 });
                }
            }
        }
        let in_result = source.archive().map_or(&[][..], |archive| &archive.result.dofs);
        for of in &mut dofs {
            let measured = in_result.iter().find(|dof| dof.dof.to_string() == of.dof);
            let averaged = measured.map_or(0, |dof| usize::from(dof.hits));
            let accepted = of.rows.iter().filter(|row| row.is_in_answer).count();
            of.unseen = averaged.saturating_sub(accepted);
        }
        let accepted = log.iter().filter(|hit| hit.verdict == HitVerdict::Accepted).count();
        let summary = match log.len() - accepted {
            0 => format!("All {accepted} hits are in the answer."),
            other => format!(
                "{} hits, of which {accepted} are in the answer and {other} are not.",
                log.len()
            ),
        };
        Self { dofs, summary }
    }

    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// True for a table that is folded.
    pub fn is_long(&self) -> bool {
        self.dofs.iter().map(|of| of.rows.len()).sum::<usize>() > MOST_SHOWN
    }

    /// True when the hits have times.
    pub fn has_times(&self) -> bool {
        self.dofs.iter().flat_map(|of| &of.rows).any(|row| !row.time.is_empty())
    }
}

impl HitRow {
    fn of(hit: &LoggedHit) -> Self {
        let number = |value: Option<f32>| value.map_or(String::new(), |of| format!("{of:.1}"));
        let mut reasons: Vec<Sentence> =
            hit.findings.iter().map(|of| Sentence(of.message.clone())).collect();
        if reasons.is_empty() && hit.verdict == HitVerdict::Rejected {
            reasons.push(Sentence("the operator has rejected it".into()));
        }
        Self {
            number: hit.hit,
            verdict: match hit.verdict {
                HitVerdict::Accepted => "accepted",
                HitVerdict::Rejected => "rejected",
                HitVerdict::OutlierRemoved => "outlier, removed",
                HitVerdict::Redone => "not used: the DOF was begun again",
                HitVerdict::Undone => "not used: taken back by the operator",
                HitVerdict::Skipped => "not used: the DOF was skipped",
                HitVerdict::Dropped => "not used: paused or finished before its verdict",
                HitVerdict::Unknown => "not known: the test went on without the program",
            },
            is_in_answer: hit.verdict == HitVerdict::Accepted,
            reasons,
            peak_force: number(hit.peak_force_n),
            peak_acceleration: number(hit.peak_acceleration_m_per_s2),
            time: hit.graded.as_deref().map_or(String::new(), for_people_to_the_second),
        }
    }
}

/// A time of day, RFC 3339 in UTC, as people write it.
fn for_people_to_the_second(time: &str) -> String {
    match time.get(11..19).filter(|_| time.len() == 20 && time.ends_with('Z')) {
        Some(of_day) => of_day.to_owned(),
        None => for_people(time),
    }
}
