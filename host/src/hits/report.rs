//! Graded hits as JSON and as a table.

use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};

use super::{Hit, Hits};
use crate::output;
use massline_report::document::{self, Decided, GradedHit, HitFinding};
use massline_report::words::{code_name, message};

impl Hit {
    /// `rejected`, `warning` or `accepted`, by its most severe finding.
    pub fn verdict(&self) -> &'static str {
        match self.report.findings.iter().map(|found| found.severity).max() {
            Some(Severity::Error) => "rejected",
            Some(Severity::Warning) => "warning",
            Some(Severity::Note) | None => "accepted",
        }
    }

    fn to_json(&self) -> GradedHit {
        GradedHit {
            segment: self.segment,
            verdict: self.verdict(),
            codes: self.report.findings.iter().map(code_name).collect(),
            findings: self.report.findings.iter().map(finding_json).collect(),
            start_s: self.start_s,
            peak_force_n: self.report.peak_force.0.into(),
            peak_response_m_per_s2: self.report.peak_acceleration.0.into(),
            distance_relative: self.distance,
            kept: self.kept,
        }
    }
}

/// A finding as JSON, with the decisive number under a key that names its unit.
fn finding_json(found: &Diagnostic) -> HitFinding {
    let mut decided = Decided::default();
    let number = match found.code {
        Code::Overload if found.subject == Subject::Channel(0) => &mut decided.extreme_n,
        Code::Overload => &mut decided.extreme_m_per_s2,
        Code::TooWeak => &mut decided.peak_force_n,
        Code::ForceSpectrumLow => &mut decided.level_db,
        Code::TriggerTooEarly => &mut decided.pre_trigger_scans,
        code if is_of_distance(code) => &mut decided.distance_relative,
        Code::DoubleHit => &mut decided.second_peak_relative,
        _ => &mut decided.share_relative,
    };
    *number = Some(found.value.into());
    // A finding about no particular response concerns the force.
    let channel = if let Subject::Channel(channel) = found.subject { channel } else { 0 };
    HitFinding {
        code: code_name(found),
        severity: found.severity.name(),
        channel: (!is_of_distance(found.code)).then_some(channel),
        decided,
    }
}

/// True for codes of hits that differ from each other.
fn is_of_distance(code: Code) -> bool {
    matches!(code, Code::HitInconsistent | Code::HitElsewhere | Code::HitsInDoubt)
}

impl Hits {
    /// All of them as JSON.
    pub fn to_json(&self) -> document::Hits {
        document::Hits {
            recording: self.understanding.to_json(),
            hits: self.hits.iter().map(Hit::to_json).collect(),
            notes: self.warnings.clone(),
        }
    }

    /// A table of the hits, and a sentence for each finding.
    pub fn to_text(&self) -> String {
        let mut table = output::table();
        table.set_header([
            "segment",
            "start, s",
            "force, N",
            "response, m/s²",
            "distance",
            "verdict",
        ]);
        let mut sentences = String::new();
        for hit in &self.hits {
            table.add_row([
                hit.segment.to_string(),
                format!("{:.4}", hit.start_s),
                format!("{:.1}", hit.report.peak_force.0),
                format!("{:.1}", hit.report.peak_acceleration.0),
                hit.distance.map_or("-".into(), |d| format!("{:.1} %", 100.0 * d)),
                hit.verdict().into(),
            ]);
            for found in &hit.report.findings {
                sentences += &format!(
                    "segment {}: {}: {}\n",
                    hit.segment,
                    code_name(found),
                    self.sentence(found)
                );
            }
        }
        let kept = self.hits.iter().filter(|hit| hit.kept).map(|hit| hit.segment.to_string());
        let kept: Vec<String> = kept.collect();
        let kept = if kept.is_empty() { "none".to_owned() } else { kept.join(", ") };
        output::align_right(&mut table, 0..5);
        format!("{table}\n{sentences}best consistent set: {kept}")
    }

    /// The sentence of a finding, with the channels of this recording.
    fn sentence(&self, found: &Diagnostic) -> String {
        let name = match found.subject {
            Subject::Channel(response @ 1..) => self.channels.get(usize::from(response)),
            _ => None,
        }
        .map(|channel| &channel.name);
        match (found.code, name) {
            (Code::HitInconsistent, _) => format!(
                "its responses per force are {:.0} % away from those of the other hits; hit the \
                 same point in the same direction every time",
                100.0 * found.value
            ),
            (Code::HitElsewhere, _) => format!(
                "its responses per force are {:.0} % away from those of the other hits: it may have landed elsewhere; \
                 hit the marked point",
                100.0 * found.value
            ),
            (Code::HitsInDoubt, _) => format!(
                "its responses per force are {:.0} % away from those of the only other hit, so one of the two may have \
                 landed elsewhere; hit once more",
                100.0 * found.value
            ),
            (Code::ForceSpectrumLow, _) => format!(
                "the force hardly excites the top of the band ({:.0} dB against 0 Hz); take a harder tip, \
                 or lower the HIGH of --band-hz",
                found.value
            ),
            (Code::Overload | Code::PreTriggerNotQuiet | Code::ClippedRecord, Some(name))
                if !name.is_empty() =>
            {
                format!("\"{name}\": {}", message(found))
            }
            _ => message(found),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_read_the_number_and_the_channel_of_a_finding() {
        let json = |code, subject| {
            let found = Diagnostic::about(code, Severity::Error, subject, 0.5);
            serde_json::json!(finding_json(&found)).to_string()
        };
        let overload = json(Code::Overload, Subject::Channel(5));
        let expected = r#""channel":5,"code":"overload","extreme_m_per_s2":0.5,"severity":"error""#;
        assert_eq!(overload, format!("{{{expected}}}"));
        assert!(json(Code::Overload, Subject::Channel(0)).contains(r#""extreme_n":0.5"#));
        // A finding about the force has the force's channel.
        assert!(json(Code::DoubleHit, Subject::Whole).contains(r#""channel":0"#));
        assert!(!json(Code::HitInconsistent, Subject::Whole).contains("channel"));
    }
}
