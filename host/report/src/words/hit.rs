//! The verdict on one hit, for the person who has made it.

use massline_protocol::event::HitEvent;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::RigLayout;
use massline_shared::signal::Swing;

use super::digits::two_digits;
use super::message::by_code;
use crate::tone::Tone;

/// What a rig says of a hit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HitAssessment {
    /// The verdict in one word.
    pub verdict: &'static str,
    /// The tone of the verdict.
    pub tone: Tone,
    /// Why the hit was rejected, or what makes an accepted one doubtful; empty for a good one.
    pub why: String,
}

impl HitAssessment {
    /// A hit that the person has rejected.
    pub fn rejected_by_you() -> Self {
        Self { verdict: "rejected by you", tone: Tone::Warning, why: String::new() }
    }

    /// What the rig says of this hit; the layout names sensors and DOFs.
    pub fn of(hit: &HitEvent, layout: &RigLayout) -> Self {
        if hit.is_undone() {
            return Self { verdict: "undone", tone: Tone::Warning, why: String::new() };
        }
        let (verdict, tone) = match hit.good {
            false => ("rejected", Tone::Warning),
            // Hits before this one that were dropped are no doubt about it.
            true if doubts(hit).any(|diagnostic| diagnostic.code != Code::HitsDisagree) => {
                ("doubtful", Tone::Warning)
            }
            true => ("good", Tone::Good),
        };
        let diagnostics: Vec<_> = match hit.good {
            false => hit.findings.to_vec(),
            true => doubts(hit).copied().collect(),
        };
        let why = by_code(&diagnostics, layout).into_iter().map(|(_, message)| message);
        Self { verdict, tone, why: why.collect::<Vec<_>>().join("; ") }
    }
}

impl std::fmt::Display for HitAssessment {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { verdict, why, .. } = self;
        if why.is_empty() { f.write_str(verdict) } else { write!(f, "{verdict}: {why}") }
    }
}

/// What a hit in the suspension profile was judged by.
pub fn swing_words(swing: &Swing) -> String {
    let percent = |share: f32| two_digits(100.0 * f64::from(share));
    let before = match swing.rest {
        0.0 => "hung still".to_owned(),
        rest => format!("moved {} % before it", percent(rest)),
    };
    format!("{:.2} N s, {before}, {} % left", swing.impulse, percent(swing.remainder))
}

/// The warnings about a hit.
fn doubts(hit: &HitEvent) -> impl Iterator<Item = &Diagnostic> {
    hit.findings.iter().filter(|diagnostic| diagnostic.severity == Severity::Warning)
}

#[cfg(test)]
mod tests {
    use massline_shared::diagnosis::Subject;

    use super::*;
    use massline_files::layout_file::LayoutFile;

    fn assess_hit(good: bool, findings: &[(Code, Severity)]) -> HitAssessment {
        let about = |&(code, severity): &(Code, Severity)| {
            let subject = if code == Code::DoubleHit { Subject::Whole } else { Subject::Hit(0) };
            Diagnostic::about(code, severity, subject, 0.5)
        };
        let hit = HitEvent {
            number: 1,
            dof: 0,
            good,
            scan: 0,
            peak_force: 20.0,
            peak_acceleration: 30.0,
            swing: None,
            findings: findings.iter().map(about).collect(),
        };
        let toml = include_str!("../../../examples/three-bar-test-1.toml");
        HitAssessment::of(&hit, &LayoutFile::parse(toml, "test").unwrap().rig_layout().unwrap())
    }

    #[test]
    fn a_hit_that_differs_from_its_repeat_hits_is_not_simply_good() {
        let doubtful = assess_hit(true, &[(Code::HitInconsistent, Severity::Warning)]);
        assert_eq!((doubtful.verdict, doubtful.tone), ("doubtful", Tone::Warning));
        assert!(doubtful.why.starts_with("at hit 1 (1:+Y) one hit differs"), "{}", doubtful.why);
        let pair = assess_hit(true, &[(Code::HitsInDoubt, Severity::Warning)]);
        assert_eq!(pair.verdict, "doubtful");
        assert!(pair.why.contains("the first and the second hit differ by 50 %"), "{}", pair.why);
        let kept = assess_hit(true, &[(Code::HitInconsistent, Severity::Note)]);
        assert_eq!((kept.to_string().as_str(), kept.tone), ("good", Tone::Good));
    }

    #[test]
    fn a_hit_that_replaces_two_others_is_good_and_says_so() {
        let first = assess_hit(true, &[(Code::HitsDisagree, Severity::Warning)]);
        assert_eq!((first.verdict, first.tone), ("good", Tone::Good));
        assert!(first.why.contains("both are dropped"), "{}", first.why);
    }

    #[test]
    fn a_hit_that_is_out_says_why() {
        let rejected = assess_hit(false, &[(Code::DoubleHit, Severity::Error)]);
        assert!(rejected.to_string().starts_with("rejected: "), "{rejected}");
        let elsewhere = assess_hit(false, &[(Code::HitElsewhere, Severity::Error)]);
        assert!(elsewhere.to_string().contains("it may have landed elsewhere"), "{elsewhere}");
        let undone =
            [(Code::HitInconsistent, Severity::Warning), (Code::HitUndone, Severity::Error)];
        assert_eq!(assess_hit(false, &undone).to_string(), "undone");
    }
}
