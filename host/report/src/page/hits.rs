//! Every hit of a test with its verdict, DOF by DOF.

use super::for_people;
use super::values::Sentence;
use crate::result_file::ResultFile;
use massline_result::{HitVerdict, LoggedHit};

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
    /// Hits in the answer that no program has followed.
    pub unlogged: usize,
}

/// A hit.
pub(super) struct HitRow {
    pub number: u32,
    pub verdict: &'static str,
    pub is_in_answer: bool,
    pub reasons: Vec<Sentence>,
    pub peak_force: String,
    /// N s; empty in the mass-line profile.
    pub impulse: String,
    pub peak_acceleration: String,
    pub time: String,
}

impl HitTable {
    /// The hits of a result, at the DOFs that are in it and then at others; none where it has no log of them.
    pub fn of(source: &ResultFile) -> Self {
        let log = source.hit_log();
        if log.is_empty() {
            return Self::default();
        }
        let measured = source.result().measured_dofs();
        let at = |dof: &str| HitsOfDof { dof: dof.to_owned(), rows: Vec::new(), unlogged: 0 };
        let mut dofs: Vec<HitsOfDof> = measured.iter().map(|dof| at(&dof.dof)).collect();
        for hit in log {
            let place =
                dofs.iter().position(|dof_hits| dof_hits.dof == hit.dof).unwrap_or_else(|| {
                    dofs.push(at(&hit.dof));
                    dofs.len() - 1
                });
            dofs[place].rows.push(HitRow::of(hit));
        }
        for (dof_hits, counted) in dofs.iter_mut().zip(&measured) {
            let logged = dof_hits.rows.iter().filter(|row| row.is_in_answer).count();
            dof_hits.unlogged = counted.hits.map_or(0, usize::from).saturating_sub(logged);
        }
        let unlogged = dofs.iter().map(|dof_hits| dof_hits.unlogged).sum();
        let accepted = log.iter().filter(|hit| hit.verdict == HitVerdict::Accepted).count();
        let summary = summary(accepted, log.len() - accepted, unlogged);
        Self { dofs, summary }
    }

    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// True for a table that is folded.
    pub fn is_long(&self) -> bool {
        self.dofs.iter().map(|dof_hits| dof_hits.rows.len()).sum::<usize>() > MOST_SHOWN
    }

    /// True when the impulses of the hits are known.
    pub fn has_impulses(&self) -> bool {
        self.dofs.iter().flat_map(|dof_hits| &dof_hits.rows).any(|row| !row.impulse.is_empty())
    }

    /// True when the hits have times.
    pub fn has_times(&self) -> bool {
        self.dofs.iter().flat_map(|dof_hits| &dof_hits.rows).any(|row| !row.time.is_empty())
    }
}

/// How many hits are in the answer, and how many are not: of the log, and besides it.
fn summary(accepted: usize, others: usize, unlogged: usize) -> String {
    let (logged, in_answer) = (accepted + others, accepted + unlogged);
    let are = |count: usize| if count == 1 { "is" } else { "are" };
    match (unlogged, others) {
        (0, 0) => format!("All {accepted} hits are in the answer."),
        (0, _) => format!(
            "{logged} hits, of which {accepted} {} in the answer and {others} {} not.",
            are(accepted),
            are(others)
        ),
        _ => {
            let mut text = format!(
                "{in_answer} hits are in the answer; {unlogged} of them {} not in this log, because no program \
                 followed the test then.",
                are(unlogged)
            );
            if others > 0 {
                text += &format!(" {others} hits of the log {} not in the answer.", are(others));
            }
            text
        }
    }
}

impl HitRow {
    fn of(hit: &LoggedHit) -> Self {
        let number =
            |value: Option<f32>| value.map_or(String::new(), |value| format!("{value:.1}"));
        let mut reasons: Vec<Sentence> =
            hit.findings.iter().map(|finding| Sentence(finding.message.clone())).collect();
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
            impulse: hit.impulse_n_s.map_or(String::new(), |impulse| format!("{impulse:.2}")),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hits_that_nobody_has_followed_are_counted() {
        assert_eq!(summary(9, 0, 0), "All 9 hits are in the answer.");
        assert_eq!(summary(9, 1, 0), "10 hits, of which 9 are in the answer and 1 is not.");
        let part = summary(2, 0, 7);
        assert!(
            part.starts_with("9 hits are in the answer; 7 of them are not in this log"),
            "{part}"
        );
        assert!(summary(2, 3, 7).ends_with("3 hits of the log are not in the answer."));
    }
}
