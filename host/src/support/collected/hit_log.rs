//! What became of every hit of a campaign.
//!
//! A rig reports each hit when it has graded it, and again when the comparison with its repeat hits has withdrawn it or
//! the operator has undone it. That the operator has rejected or discarded a hit, on the keyboard or on the panel,
//! shows only in the counters of the [`Status`], and so does an undo whose event was lost. The log puts both together:
//!
//! | counters, once the rig waits for the next hit | what became of the hits of the DOF |
//! | --- | --- |
//! | none of them is counted any more, and the DOF is the current one | redone |
//! | none of them is counted any more, and the campaign has moved on | skipped |
//! | the last one was counted, and is not any more | undone |
//! | the last one was never counted, and one more is rejected | rejected by the operator |
//! | the last one was never counted otherwise | dropped: there was a pause, or the DOF was finished |
//!
//! Without its event, an undo of the only hit of a DOF cannot be told from a DOF that is begun again: it is redone.

use std::collections::BTreeMap;

use massline_protocol::event::HitEvent;
use massline_protocol::message::Status;
use massline_protocol::object::MeasurementResult;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::layout::RigLayout;
use massline_shared::measurement::campaign::Phase;
use massline_shared::signal::Swing;

use massline_files::archive::MOST_LOGGED_HITS;
use massline_files::clock;
use massline_report::words::by_code;
use massline_result::{Finding, HitVerdict, LoggedHit};

/// The hits of the campaign that is followed.
#[derive(Clone, Debug, Default)]
pub struct HitLog {
    entries: Vec<Entry>,
    /// Accepted hits of each DOF that were made before the log began; `None` before the first status.
    before: Option<Vec<usize>>,
    /// Hits rejected in the campaign when the last one came up for its verdict.
    rejected: u16,
    /// The hits have no time of day.
    simulated: bool,
}

#[derive(Clone, Debug)]
struct Entry {
    event: HitEvent,
    verdict: HitVerdict,
    /// A status has counted it among the accepted ones.
    counted: bool,
    /// The latest status has taken it out, and its event may still say why.
    settled: bool,
    graded: Option<String>,
}

impl HitLog {
    /// The log of a simulated campaign, whose hits have no time of day.
    pub fn simulated() -> Self {
        Self { simulated: true, ..Self::default() }
    }

    /// Notes a hit that was graded, or withdrawn after it had been graded.
    pub fn hit(&mut self, event: &HitEvent) {
        // The number alone is not enough: it begins again when the rig is switched on.
        let key = |event: &HitEvent| (event.number, event.dof, event.scan);
        let last = self.entries.last_mut().filter(|last| key(&last.event) == key(event));
        if let Some(last) = last {
            last.event = event.clone();
            if !event.good {
                self.withdraw(event);
            } else if let Some(disagreement) = finding_of(event, Code::HitsDisagree) {
                // The hit is the first of its DOF again.
                self.drop_others(event.dof, disagreement);
            }
            return;
        }
        if self.entries.len() >= MOST_LOGGED_HITS {
            return;
        }
        self.entries.iter_mut().for_each(|entry| entry.settled = false);
        self.entries.push(Entry {
            event: event.clone(),
            verdict: if event.good { HitVerdict::Accepted } else { HitVerdict::Rejected },
            counted: false,
            settled: false,
            graded: (!self.simulated).then(clock::now),
        });
    }

    /// Takes the last hit out again; of the first two hits of a DOF that disagree, both.
    fn withdraw(&mut self, event: &HitEvent) {
        let codes = [Code::HitInconsistent, Code::HitElsewhere, Code::HitsDisagree];
        let is_outlier = codes.into_iter().any(|code| finding_of(event, code).is_some());
        if let Some(last) = self.entries.last_mut() {
            last.verdict = match () {
                () if event.is_undone() => HitVerdict::Undone,
                () if is_outlier => HitVerdict::OutlierRemoved,
                () => HitVerdict::Rejected,
            };
            last.settled = false;
        }
        if let Some(disagreement) = finding_of(event, Code::HitsDisagree) {
            self.drop_others(event.dof, disagreement);
        }
    }

    /// Takes the hits before the last one at its DOF out again.
    fn drop_others(&mut self, dof: u8, disagreement: Diagnostic) {
        let before = self.entries.len().saturating_sub(1);
        for other in &mut self.entries[..before] {
            if other.stands_at(dof) || (other.settled && other.event.dof == dof) {
                other.verdict = HitVerdict::OutlierRemoved;
                // A list of findings that is full says enough.
                let _ = other.event.findings.push(disagreement);
            }
        }
    }

    /// Compares the counters of the rig with the hits so far.
    pub fn status(&mut self, status: &Status) {
        let Ok(phase) = Phase::try_from(status.phase) else { return };
        // The last hit has not been averaged yet, or its verdict is to come.
        let is_open = matches!(phase, Phase::Busy | Phase::Confirming);
        for (dof, accepted) in (0_u8..).zip(self.accepted_since(status)) {
            let standing = self.entries.iter().filter(|entry| entry.stands_at(dof)).count();
            if standing > accepted && !(is_open && dof == status.dof) {
                let has_moved_on =
                    dof != status.dof || matches!(phase, Phase::Solving | Phase::Done);
                self.settle(dof, accepted, has_moved_on, status.rejected > self.rejected);
            }
            let counted =
                self.entries.iter_mut().filter(|entry| entry.stands_at(dof)).take(accepted);
            counted.for_each(|entry| entry.counted = true);
        }
        if phase != Phase::Busy {
            self.rejected = status.rejected;
        }
    }

    /// The accepted hits of each DOF that were made after the log began.
    fn accepted_since(&mut self, status: &Status) -> Vec<usize> {
        let accepted: Vec<usize> = status.accepted.iter().map(|&hits| hits.into()).collect();
        let standing = |dof: u8| self.entries.iter().filter(|entry| entry.stands_at(dof)).count();
        let first = (0..).zip(&accepted).map(|(dof, hits)| hits.saturating_sub(standing(dof)));
        let mut before = self.before.take().unwrap_or_else(|| first.collect());
        before.resize(accepted.len(), 0);
        // Those of a DOF that was begun again are gone.
        before.iter_mut().zip(&accepted).for_each(|(before, &now)| *before = now.min(*before));
        let since = accepted.iter().zip(&before).map(|(now, before)| now - before).collect();
        self.before = Some(before);
        since
    }

    /// Says what became of the hits of a DOF that are not among the accepted ones any more.
    fn settle(&mut self, dof: u8, accepted: usize, has_moved_on: bool, is_rejected: bool) {
        let was_counted = self.entries.iter().any(|entry| entry.stands_at(dof) && entry.counted);
        let all_gone = accepted == 0 && was_counted;
        for gone in self.entries.iter_mut().filter(|entry| entry.stands_at(dof)).skip(accepted) {
            gone.settled = true;
            gone.verdict = match gone.counted {
                _ if all_gone && has_moved_on => HitVerdict::Skipped,
                _ if all_gone => HitVerdict::Redone,
                true => HitVerdict::Undone,
                false if is_rejected => HitVerdict::Rejected,
                false => HitVerdict::Dropped,
            };
        }
    }

    /// All hits, in the order in which they were made, with the names of this layout.
    pub fn logged(&self, layout: &RigLayout) -> Vec<LoggedHit> {
        self.entries.iter().filter_map(|entry| entry.logged(layout)).collect()
    }
}

/// Corrects what became of hits that were made before an interruption: a result has this many hits of each DOF, the
/// later ones.
pub fn settle_with(hits: &mut [LoggedHit], result: &MeasurementResult) {
    let in_result = |name: &str| {
        let dof = result.measured().find(|(dof, ..)| dof.to_string() == name);
        dof.map_or(0, |(.., hits)| usize::from(hits))
    };
    let mut left: BTreeMap<String, usize> = BTreeMap::new();
    for hit in hits.iter_mut().rev().filter(|hit| hit.verdict == HitVerdict::Accepted) {
        let of_result = in_result(&hit.dof);
        let left = left.entry(hit.dof.clone()).or_insert(of_result);
        if *left > 0 {
            *left -= 1;
        } else if of_result > 0 {
            hit.verdict = HitVerdict::Redone;
        } else {
            hit.verdict = HitVerdict::Skipped;
        }
    }
}

/// The hits of a DOF have changed while the program did not follow the campaign: nothing is known of the accepted ones.
pub fn forget(hits: &mut [LoggedHit], dof: &str) {
    let accepted = hits.iter_mut().filter(|hit| hit.verdict == HitVerdict::Accepted);
    accepted.filter(|hit| hit.dof == dof).for_each(|hit| hit.verdict = HitVerdict::Unknown);
}

impl Entry {
    fn stands_at(&self, dof: u8) -> bool {
        self.verdict == HitVerdict::Accepted && self.event.dof == dof
    }

    /// `None` for a hit at a DOF that the layout does not have.
    fn logged(&self, layout: &RigLayout) -> Option<LoggedHit> {
        let event = &self.event;
        // A record that was lost has no peaks.
        let known = |peak: f32| (peak.is_finite() && peak > 0.0).then_some(peak);
        let share =
            |part: fn(&Swing) -> f32| event.swing.as_ref().map(part).filter(|v| v.is_finite());
        let remark = |(diagnostic, message): (&Diagnostic, String)| Finding {
            code: diagnostic.code.into(),
            severity: diagnostic.severity.into(),
            message,
        };
        Some(LoggedHit {
            dof: layout.hits.get(usize::from(event.dof))?.dof.to_string(),
            hit: event.number,
            verdict: self.verdict,
            findings: by_code(&event.findings, layout).into_iter().map(remark).collect(),
            peak_force_n: known(event.peak_force),
            peak_acceleration_m_per_s2: known(event.peak_acceleration),
            impulse_n_s: event.swing.and_then(|swing| known(swing.impulse)),
            rest: share(|swing| swing.rest),
            remainder: share(|swing| swing.remainder),
            graded: self.graded.clone(),
        })
    }
}

/// The finding of a hit with this code.
fn finding_of(event: &HitEvent, code: Code) -> Option<Diagnostic> {
    event.findings.iter().find(|finding| finding.code == code).copied()
}

#[cfg(test)]
mod tests;
