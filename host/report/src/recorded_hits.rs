//! The graded hits of a recording, and what was understood of it, as text and as JSON.

use massline_analysis::hits::{Hit, Hits, Understanding};
use massline_files::recording::{LeftOutColumn, RateSource, Scale, Source, UnitSource, six_digits};
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};

use crate::document::{
    self, ColumnLeftOut, DecidingNumber, GradedHit, HitFinding, RecordedChannel, RecordingSummary,
};
use crate::table::{align_right, table};
use crate::words::{code_name, counted, message};

/// What was understood of a recording, in one line.
pub fn understanding_text(understanding: &Understanding) -> String {
    let Source { format, encoding, separator, decimal } = understanding.source;
    let mut file = vec![format.to_owned()];
    file.extend(encoding.map(str::to_owned));
    file.extend(separator.map(|name| format!("separated by {name}")));
    file.extend(decimal.map(|decimal| format!("decimal {}", decimal.name())));
    let channels: Vec<String> = understanding
        .channels
        .iter()
        .enumerate()
        .map(|(n, (name, scale))| channel_text(n, name, scale))
        .collect();
    let segments = if understanding.segments == 1 {
        String::new()
    } else {
        format!("{}, ", counted(understanding.segments, "segment"))
    };
    let duration = six_digits(understanding.samples as f64 / understanding.rate.hz);
    let mut text = format!(
        "{}; {}; {} Hz {}; {segments}{}, {duration} s",
        file.join(", "),
        channels.join(", "),
        six_digits(understanding.rate.hz),
        understanding.rate.origin(),
        counted(understanding.samples, "sample")
    );
    if !understanding.left_out.is_empty() {
        let left_out = understanding
            .left_out
            .iter()
            .map(|LeftOutColumn { name, reason }| format!("\"{name}\" ({reason})"));
        text += &format!("; left out: {}", left_out.collect::<Vec<_>>().join(", "));
    }
    text
}

/// The same as JSON.
pub fn understanding_json(understanding: &Understanding) -> RecordingSummary {
    let Source { format, encoding, separator, decimal } = understanding.source;
    let channel = |(n, (name, scale)): (usize, &(String, Scale))| RecordedChannel {
        name: name.clone(),
        role: if n == 0 { "force" } else { "response" },
        unit: scale.unit.clone(),
        unit_source: unit_source_name(scale.source),
        factor_to_si: scale.factor.abs(),
        reversed: scale.factor < 0.0,
    };
    let (time_column, time_unit, time_unit_assumed) = match &understanding.rate.source {
        RateSource::Column { name, unit, assumed } => {
            (Some(name.clone()), Some(unit.clone()), *assumed)
        }
        RateSource::Option | RateSource::Header(_) => (None, None, false),
    };
    RecordingSummary {
        format,
        encoding,
        separator,
        decimal: decimal.map(massline_files::recording::Decimal::name),
        channels: understanding.channels.iter().enumerate().map(channel).collect(),
        rate_hz: understanding.rate.hz,
        rate_source: match understanding.rate.source {
            RateSource::Option => "option",
            RateSource::Column { .. } => "time_column",
            RateSource::Header(_) => "header",
        },
        time_column,
        time_unit,
        time_unit_assumed,
        segments: understanding.segments,
        samples: understanding.samples,
        duration_s: understanding.samples as f64 / understanding.rate.hz,
        left_out: understanding
            .left_out
            .iter()
            .map(|LeftOutColumn { name, reason }| ColumnLeftOut {
                name: name.clone(),
                reason: reason.clone(),
            })
            .collect(),
    }
}

/// A channel as the line names it.
fn channel_text(n: usize, name: &str, scale: &Scale) -> String {
    let role = if n == 0 { "force" } else { "response" };
    let reversed = if scale.factor < 0.0 { ", reversed" } else { "" };
    let source = match scale.source {
        UnitSource::File => "",
        UnitSource::UnitSystem => " by dataset 164",
        UnitSource::Option => " by --unit",
        UnitSource::Sensitivity => " by --sensitivity",
    };
    format!("{role} \"{name}\" in {}{source}{reversed}", scale.unit)
}

/// The name in JSON.
fn unit_source_name(source: UnitSource) -> &'static str {
    match source {
        UnitSource::File => "file",
        UnitSource::UnitSystem => "unit_system",
        UnitSource::Option => "option",
        UnitSource::Sensitivity => "sensitivity",
    }
}

/// `rejected`, `warning` or `accepted`, by its most severe finding.
fn verdict(hit: &Hit) -> &'static str {
    match hit.report.findings.iter().map(|diagnostic| diagnostic.severity).max() {
        Some(Severity::Error) => "rejected",
        Some(Severity::Warning) => "warning",
        Some(Severity::Note) | None => "accepted",
    }
}

fn hit_json(hit: &Hit) -> GradedHit {
    GradedHit {
        segment: hit.segment,
        verdict: verdict(hit),
        codes: hit.report.findings.iter().map(code_name).collect(),
        findings: hit.report.findings.iter().map(finding_json).collect(),
        start_s: hit.start_s,
        peak_force_n: hit.report.peak_force.0.into(),
        peak_response_m_per_s2: hit.report.peak_acceleration.0.into(),
        distance_relative: hit.distance,
        kept: hit.kept,
    }
}

/// A finding as JSON, with the decisive number under a key that names its unit.
fn finding_json(diagnostic: &Diagnostic) -> HitFinding {
    let mut decided = DecidingNumber::default();
    let number = match diagnostic.code {
        Code::Overload if diagnostic.subject == Subject::Channel(0) => &mut decided.extreme_n,
        Code::Overload => &mut decided.extreme_m_per_s2,
        Code::TooWeak => &mut decided.peak_force_n,
        Code::ForceSpectrumLow => &mut decided.level_db,
        Code::TriggerTooEarly => &mut decided.pre_trigger_scans,
        code if is_of_distance(code) => &mut decided.distance_relative,
        Code::DoubleHit => &mut decided.second_peak_relative,
        _ => &mut decided.share_relative,
    };
    *number = Some(diagnostic.value.into());
    // A finding about no particular response concerns the force.
    let channel = if let Subject::Channel(channel) = diagnostic.subject { channel } else { 0 };
    HitFinding {
        code: code_name(diagnostic),
        severity: diagnostic.severity.name(),
        channel: (!is_of_distance(diagnostic.code)).then_some(channel),
        decided,
    }
}

/// True for codes of hits that differ from each other.
fn is_of_distance(code: Code) -> bool {
    matches!(code, Code::HitInconsistent | Code::HitElsewhere | Code::HitsInDoubt)
}

/// All hits as JSON.
pub fn hits_json(hits: &Hits) -> document::Hits {
    document::Hits {
        recording: understanding_json(&hits.understanding),
        hits: hits.hits.iter().map(hit_json).collect(),
        notes: hits.warnings.clone(),
    }
}

/// A table of the hits, and a sentence for each finding.
pub fn hits_text(hits: &Hits) -> String {
    let mut table = table();
    table.set_header(["segment", "start, s", "force, N", "response, m/s²", "distance", "verdict"]);
    let mut sentences = String::new();
    for hit in &hits.hits {
        table.add_row([
            hit.segment.to_string(),
            format!("{:.4}", hit.start_s),
            format!("{:.1}", hit.report.peak_force.0),
            format!("{:.1}", hit.report.peak_acceleration.0),
            hit.distance.map_or("-".into(), |d| format!("{:.1} %", 100.0 * d)),
            verdict(hit).into(),
        ]);
        for diagnostic in &hit.report.findings {
            sentences += &format!(
                "segment {}: {}: {}\n",
                hit.segment,
                code_name(diagnostic),
                sentence(hits, diagnostic)
            );
        }
    }
    let kept = hits.hits.iter().filter(|hit| hit.kept).map(|hit| hit.segment.to_string());
    let kept: Vec<String> = kept.collect();
    let kept = if kept.is_empty() { "none".to_owned() } else { kept.join(", ") };
    align_right(&mut table, 0..5);
    format!("{table}\n{sentences}best consistent set: {kept}")
}

/// The sentence of a finding, with the channels of this recording.
fn sentence(hits: &Hits, diagnostic: &Diagnostic) -> String {
    let name = match diagnostic.subject {
        Subject::Channel(response @ 1..) => hits.channels.get(usize::from(response)),
        _ => None,
    }
    .map(|channel| &channel.name);
    match (diagnostic.code, name) {
        (Code::HitInconsistent, _) => format!(
            "its responses per force are {:.0} % away from those of the other hits; hit the \
             same point in the same direction every time",
            100.0 * diagnostic.value
        ),
        (Code::HitElsewhere, _) => format!(
            "its responses per force are {:.0} % away from those of the other hits: it may have landed elsewhere; \
             hit the marked point",
            100.0 * diagnostic.value
        ),
        (Code::HitsInDoubt, _) => format!(
            "its responses per force are {:.0} % away from those of the only other hit, so one of the two may have \
             landed elsewhere; hit once more",
            100.0 * diagnostic.value
        ),
        (Code::ForceSpectrumLow, _) => format!(
            "the force hardly excites the top of the band ({:.0} dB against 0 Hz); take a harder tip, \
             or lower the HIGH of --band-hz",
            diagnostic.value
        ),
        (Code::Overload | Code::PreTriggerNotQuiet | Code::ClippedRecord, Some(name))
            if !name.is_empty() =>
        {
            format!("\"{name}\": {}", message(diagnostic))
        }
        _ => message(diagnostic),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn programs_read_the_number_and_the_channel_of_a_finding() {
        let json = |code, subject| {
            let diagnostic = Diagnostic::about(code, Severity::Error, subject, 0.5);
            serde_json::json!(finding_json(&diagnostic)).to_string()
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
