//! A sentence for every diagnostic: what it is, and what to do.

use massline_shared::Real;
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::{Layout, PROPERTIES, Prior, Setting};

/// What a diagnostic says, with what to do; sensors and hits are counted from 1.
pub fn message(diagnostic: &Diagnostic) -> String {
    sentence(diagnostic, &|what, index| match what {
        "prior" => format!("the [prior] of {}", PROPERTIES.get(index).unwrap_or(&"a property")),
        _ => format!("{what} {}", index + 1),
    })
}

/// As [`message`], with the names of nodes and DOFs that the layout knows.
pub fn message_in<R: Real, const S: usize, const H: usize>(
    diagnostic: &Diagnostic,
    layout: &Layout<R, S, H>,
) -> String {
    sentence(diagnostic, &|what, index| {
        if what == "prior" {
            return prior_name(index, &layout.priors);
        }
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

/// `the [prior] mass = 1.23 ± 0.001 kg`.
fn prior_name<R: Real>(property: usize, priors: &[Prior<R>]) -> String {
    let name = PROPERTIES.get(property).unwrap_or(&"a property");
    let prior = priors.iter().find(|prior| usize::from(prior.property) == property);
    prior.map_or_else(
        || format!("the [prior] of {name}"),
        |Prior { value, sigma, .. }| {
            let (value, sigma) = (value.to_f64(), sigma.to_f64());
            format!("the [prior] {name} = {value} ± {sigma} {}", si_unit(property))
        },
    )
}

fn si_unit(property: usize) -> &'static str {
    INERTIAL_PARAMETERS.get(property).map_or("", |parameter| parameter.unit)
}

/// A number with five digits that count.
fn five_digits(value: f32) -> String {
    let first = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    format!("{value:.*}", (4.0 - first).clamp(0.0, 12.0) as usize)
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
            motions of the body, which the inertia restraint method needs; put three on nodes that \
            are not on one line, or rely on maximum likelihood with its wider intervals"
            .into(),
        Code::SensorsCollinear => "the sensors stand on one line (within 2 %), so the rotation \
            about that line is not seen, which the inertia restraint method needs; move one sensor \
            away from the line, or rely on maximum likelihood with its wider intervals"
            .into(),
        Code::ResponseRankDeficient => {
            "the sensors do not tell all six motions of the body, which the inertia restraint method \
            needs; check their positions and axes, or spread them"
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
            properties; two sensors at least are needed, and hits at other points in other directions"
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
        Code::NoPlateau => {
            let (dof, response) = d.response();
            let (sensor, axis) = (name("sensor", response / 3), ["x", "y", "z"][response % 3]);
            format!(
                "due to {}, the mass line of {sensor}, axis {axis}, moves by {percent:.1} % of the motion \
                 when the ends of the band are left out: it is no plateau; let test.band_hz stay farther \
                 from suspension and elastic modes, or be \"auto\"",
                name("hit", dof)
            )
        }
        Code::BandNotFound => format!(
            "the data of {} show no band between suspension and elastic modes; 10 to 120 Hz is used: \
             hang the object softer, or set test.band_hz",
            hit()
        ),
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
        Code::BlockTest => "a block of known mass was hit: this calibrates, and has no ten \
            properties; see `massline calibrate`"
            .into(),
        Code::SamplerStopped => "the converter of the rig does not answer; switch the rig off and \
            on again"
            .into(),
        Code::DataContradictBudget => format!(
            "the data contradict the stated uncertainties (χ² is {value:.1} times what it should be): \
             something is wrong by more than [uncertainty] says; look for a wrong node, axis or sign"
        ),
        Code::SensorStrainsBudget => format!(
            "{} would have to be off by {value:.1} times its stated uncertainties; check its node, \
             axes and cable",
            sensor()
        ),
        Code::HitStrainsBudget => format!(
            "{} would have to be off by {value:.1} times its stated uncertainties; check its node, \
             direction and sign",
            hit()
        ),
        Code::PriorContradictsData => format!(
            "{} contradicts the data, which say {} {} without it: correct it, or widen its sigma; if \
             it is right, all accelerances or a mark are wrong",
            name("prior", subject),
            five_digits(value),
            si_unit(subject)
        ),
        Code::HeldToConsistency => "the best fit was no physical body; the best physical one is \
            given, at the edge of what a body can be: its standard deviations are rough"
            .into(),
        Code::NotConverged => "the fit did not settle, so there is no number: the data contradict the \
            layout, its uncertainties or its [prior]; check nodes, axes and signs of sensors and hits"
            .into(),
        Code::AttachedTooHeavy => format!(
            "what hangs on the object weighs more than was measured ({value:+.3} kg would be left); check \
             the attached masses of the sensors and [[attached]]"
        ),
        Code::MassNotPositive => format!(
            "the identified mass is {value:.3} kg, so the data belong to no body; check signs and axes of \
             sensors and hits, and what the responses are"
        ),
        Code::Overload => {
            let (channel, unit) = channel(d.subject);
            format!("{channel} reached the end of its range ({value:.1} {unit}); hit more gently")
        }
        Code::TooWeak => {
            format!("the peak force of {value:.1} N is too small for a clear response; hit harder")
        }
        Code::ScansLost => "scans were lost while the record was taken; hit again".into(),
        Code::TooHard => format!(
            "{} came to {percent:.0} % of its range, so the next hit may clip; hit more gently",
            channel(d.subject).0
        ),
        Code::DoubleHit => format!(
            "the hammer touched twice (a second peak of {percent:.0} % of the first); hold it \
             loosely and hit again"
        ),
        Code::ForceSpectrumLow => format!(
            "the force hardly excites the top of the band ({value:.0} dB against 0 Hz); take a \
             harder tip or lower test.band_hz"
        ),
        Code::PreTriggerNotQuiet => format!(
            "{} moved before the hit ({percent:.1} % of the peak); wait until the object hangs \
             still",
            channel(d.subject).0
        ),
        Code::ClippedRecord => format!(
            "the record ends before {} is over ({percent:.0} % of the peak are left); take the \
             hammer away after the hit, or record for longer",
            channel(d.subject).0
        ),
        Code::TriggerTooEarly => format!(
            "only {value:.0} scans lie before the hit, too few to know what rest is; record with a \
             longer pre-trigger"
        ),
        Code::DuplicateHit => "this is the record of the hit before once more; hit again".into(),
        Code::HitInconsistent => format!(
            "at {} one hit differs from the others by {percent:.0} %; hit the same point in the same \
             direction every time",
            hit()
        ),
        Code::HitsDisagree => format!(
            "at {} the first two hits differ by {percent:.0} % and nothing tells which is wrong: both \
             are dropped; hit the same point in the same direction every time",
            hit()
        ),
        Code::MotionNotRigid => format!(
            "{} does not move with the others as a rigid body ({percent:.0} % of the readings are \
             left over); check its axes, cable, gain and glue",
            sensor()
        ),
        Code::SensorAxesSuspect => {
            format!("{} has its axes reversed, swapped or turned (χ² {value:.1})", sensor())
        }
        Code::CablesSwapped => format!("the cables of two sensors are swapped (χ² {value:.1})"),
        Code::HitAtWrongNode => format!("{} landed on another node (χ² {value:.1})", hit()),
        Code::HitReversed => format!("{} came from the other side (χ² {value:.1})", hit()),
        Code::CommonScale => format!(
            "all accelerances are {value:.3} times what they should be; hammer and sensors cannot be \
             told apart"
        ),
        Code::NoSingleFaultExplains => format!(
            "the data contradict the budget and no single mistake explains them (χ² {value:.1})"
        ),
        Code::FaultsNotVisible => {
            format!("{value:.0} single mistakes would not show in these data")
        }
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
    fn five_digits_of_a_number_count() {
        let shown = [1.23, -0.001_234_567, 123_456.0, 0.0].map(five_digits);
        assert_eq!(shown, ["1.2300", "-0.0012346", "123456", "0.0000"]);
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
