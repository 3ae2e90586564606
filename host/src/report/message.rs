//! A sentence for every diagnostic: what it is, and what to do.

use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::{Layout, Setting};

/// What a diagnostic says, with what to do; sensors and hits are counted from 1.
pub fn message(diagnostic: &Diagnostic) -> String {
    sentence(diagnostic, &|what, index| format!("{what} {}", index + 1))
}

/// As [`message`], with the names of nodes and DOFs that the layout knows.
pub fn message_in<R, const S: usize, const H: usize>(
    diagnostic: &Diagnostic,
    layout: &Layout<R, S, H>,
) -> String {
    sentence(diagnostic, &|what, index| {
        let name = match what {
            "hit" => layout.hits.get(index).map(|h| h.dof.to_string()),
            _ => layout.sensors.get(index).map(|s| format!("on node {}", s.node)),
        };
        match name {
            Some(name) => format!("{what} {} ({name})", index + 1),
            None => format!("{what} {}", index + 1),
        }
    })
}

/// The stable name of a diagnostic's code; `code_n` for one that this program does not know.
pub fn code_name(diagnostic: &Diagnostic) -> String {
    let known = diagnostic.known_code().map(|code| code.name().to_owned());
    known.unwrap_or_else(|| format!("code_{}", diagnostic.code))
}

fn sentence(d: &Diagnostic, name: &dyn Fn(&str, usize) -> String) -> String {
    let whole = d.subject == Diagnostic::WHOLE;
    let subject = usize::from(d.subject);
    let value = d.value;
    let percent = 100.0 * value;
    let hit = || if whole { "a hit".to_owned() } else { name("hit", subject) };
    let sensor = || if whole { "a sensor".to_owned() } else { name("sensor", subject) };
    let Some(code) = d.known_code() else {
        let severity = Severity::from_raw(d.severity).name();
        return format!(
            "the rig reports code {} ({severity}, {value}), which this program does not know; update it",
            d.code
        );
    };
    match code {
        Code::FewerThanThreeSensors => "fewer than three triaxial sensors cannot tell the six \
            motions of the body; put three on nodes that are not on one line"
            .into(),
        Code::SensorsCollinear => "the sensors stand on one line (within 2 %), so the rotation \
            about that line is not seen; move one sensor away from the line"
            .into(),
        Code::ResponseRankDeficient => {
            "the sensors do not tell all six motions of the body; check \
            their positions and axes, or spread them"
                .into()
        }
        Code::FewerThanThreeHits => "fewer than three hit DOFs leave some of the ten properties \
            undetermined; add hits at other points in other directions"
            .into(),
        Code::HitsAllParallel => {
            "all hits are parallel, so some of the ten properties do not show; \
            add a hit in another direction"
                .into()
        }
        Code::HitsConcurrent => format!(
            "the lines of all hits meet in one point (within {percent:.1} % of L), so one \
             combination of the inertias does not show; move one hit so that its line passes by \
             that point"
        ),
        Code::HitsThroughCentreOfMass => format!(
            "the lines of all hits pass the centre of mass (within {percent:.1} % of L), so they \
             hardly turn the body and the inertia does not show; hit further out"
        ),
        Code::TenParametersNotIdentifiable => "these hits and sensors do not determine all ten \
            properties; add a hit at another point in another direction"
            .into(),
        Code::TwoSensorsOnOneNode => {
            format!("{} shares its place with another; give it a node of its own", sensor())
        }
        Code::UnknownNode => format!(
            "{} names a node that the layout does not have; add the node or name another",
            sensor()
        ),
        Code::AxesNotOrthonormal => format!(
            "local axes are off unit length or right angles by {percent:.2} %; give orthogonal \
             unit vectors"
        ),
        Code::LayoutNotFinite => {
            "a number of the layout is NaN or infinite; write decimal numbers in SI units".into()
        }
        Code::SettingOutOfRange => {
            let setting = Setting::from_subject(d.subject).map_or("a setting", Setting::name);
            format!("test.{setting} = {value} is out of the rig's range; change it in [test]")
        }
        Code::DataNotFinite => {
            "a frequency response is NaN or infinite; measure it again or export \
            it again"
                .into()
        }
        Code::FrfMissing => {
            format!("{} has no frequency response; measure it or take it out of the layout", hit())
        }
        Code::BandTooNarrow => format!(
            "the band holds {value:.0} spectral lines, too few for the mass line; widen \
             test.band_hz or take more lines"
        ),
        Code::TooFewHitsForSigma => format!(
            "the scatter of at least three hits is not known for {}, so no standard deviation is \
             given; hit at least three times",
            if whole { "every DOF".to_owned() } else { name("hit", subject) }
        ),
        Code::SigmaCoversScatterOnly => "the standard deviations cover the scatter between hits \
            only, not errors that stay the same during a test (placement, rotation, gain)"
            .into(),
        Code::NotPhysicallyConsistent => {
            "no body has these ten properties: the mass or a principal \
            moment is negative, or one moment exceeds the sum of the others; check positions, \
            directions and signs, and hit more often"
                .into()
        }
        Code::IllConditioned => format!(
            "the equations are nearly singular (condition {value:.3e}): small errors become large; \
             spread sensors and hits"
        ),
        Code::DofSkipped => format!("{} was left out", hit()),
        Code::DofFinishedEarly => {
            format!("{} has {value:.0} accepted hits, fewer than wanted", hit())
        }
        Code::GravityNotGiven => {
            "the layout gives no gravity vector; its effect on the sensors is \
            left to the B/s² term of the mass line"
                .into()
        }
        Code::ResultNotStored => {
            "the flash of the rig did not keep the result; delete old results \
            (massline results delete) and resume"
                .into()
        }
        Code::SamplerStopped => "the converter of the rig does not answer; switch the rig off and \
            on again"
            .into(),
        Code::Overload => {
            let (channel, unit) = channel(d.subject);
            format!("{channel} reached the end of its range ({value:.1} {unit}); hit more gently")
        }
        Code::TooWeak => {
            format!("the peak force of {value:.1} N is too small for a clear response; hit harder")
        }
        Code::ScansLost => "scans were lost while the record was taken; hit again".into(),
    }
}

/// The name of a channel and its unit.
fn channel(subject: u16) -> (String, &'static str) {
    match subject {
        Diagnostic::WHOLE => ("a channel".into(), "m/s²"),
        0 => ("the hammer".into(), "N"),
        k => {
            let axis = ["x", "y", "z"][usize::from(k - 1) % 3];
            (format!("sensor {} {axis}", (k - 1) / 3 + 1), "m/s²")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_sentence_of_its_own() {
        let mut sentences: Vec<String> = Code::ALL
            .iter()
            .map(|&code| message(&Diagnostic::about(code, Severity::Warning, 1, 0.25)))
            .collect();
        for (sentence, code) in sentences.iter().zip(Code::ALL) {
            assert!(sentence.len() > 20 || *code == Code::DofSkipped, "{sentence}");
            assert!(!sentence.contains('_') || sentence.contains("test."), "{sentence}");
        }
        sentences.sort();
        sentences.dedup();
        assert_eq!(sentences.len(), Code::ALL.len());
    }

    #[test]
    fn an_unknown_code_is_passed_on() {
        let d = Diagnostic { code: 999, severity: 1, subject: 0, value: 2.0 };
        assert!(message(&d).contains("999"));
        assert_eq!(code_name(&d), "code_999");
    }

    #[test]
    fn channels_are_named() {
        let overload = |k| message(&Diagnostic::about(Code::Overload, Severity::Error, k, 170.0));
        assert!(overload(0).starts_with("the hammer") && overload(0).contains(" N"));
        assert!(overload(5).starts_with("sensor 2 y"));
    }

    #[test]
    fn names_of_the_layout_are_used() {
        let file = crate::layout_file::LayoutFile::parse(
            include_str!("../../examples/three-bar-test-1.toml"),
            "t",
        )
        .unwrap();
        let d = Diagnostic::about(Code::DofSkipped, Severity::Warning, 1, 0.0);
        assert_eq!(message_in(&d, &file.layout), "hit 2 (2:+Z) was left out");
        assert_eq!(message(&d), "hit 2 was left out");
        let d = Diagnostic::about(Code::TwoSensorsOnOneNode, Severity::Error, 2, 3.0);
        assert!(message_in(&d, &file.layout).starts_with("sensor 3 (on node 3) "));
    }
}
