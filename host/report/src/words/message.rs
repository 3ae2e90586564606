//! The sentence of a diagnostic, which names the subject, gives the value with its unit, and says what to do.

use massline_protocol::object::MeasurementResult;
use massline_shared::Real;
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::capacity::Capacity;
use massline_shared::diagnosis::{Code, Diagnostic, Subject, SubjectKind, ValueUnit};
use massline_shared::layout::{AXIS_LETTERS, Layout, Prior};

use super::as_exact_as;

/// Looks up what is known of a subject besides its index: the node of a sensor, the DOF of a hit, the prior
/// of a property.
type SubjectNames<'k> = &'k dyn Fn(Subject) -> Option<String>;

/// The message of a diagnostic, with what to do; sensors and hits are counted from 1.
pub fn message(diagnostic: &Diagnostic) -> String {
    sentence(diagnostic, &|_| None)
}

/// The messages of several diagnostics. What is said of several subjects is said of the first of them; the others are
/// listed with their values.
pub fn messages(diagnostics: &[Diagnostic]) -> String {
    let each = grouped(diagnostics, &|_| None).into_iter();
    each.map(|(_, message)| message).collect::<Vec<_>>().join("; ")
}

/// As [`messages`], with the names of the layout: the first diagnostic of every code with the message of all that have
/// it.
pub fn by_code<'d, R: Real, C: Capacity>(
    diagnostics: &'d [Diagnostic],
    layout: &Layout<R, C>,
) -> Vec<(&'d Diagnostic, String)> {
    grouped(diagnostics, &|subject| name_in(subject, layout))
}

fn grouped<'d>(
    diagnostics: &'d [Diagnostic],
    known: SubjectNames<'_>,
) -> Vec<(&'d Diagnostic, String)> {
    let of_code = |code: Code| diagnostics.iter().filter(move |d| d.code == code);
    let is_first = |(place, d): &(usize, &Diagnostic)| {
        diagnostics[..*place].iter().all(|earlier| earlier.code != d.code)
    };
    let messages = diagnostics.iter().enumerate().filter(is_first).map(|(_, first)| {
        let others: Vec<_> = of_code(first.code)
            .skip(1)
            .map(|other| format!("{} {}", subject(other, known), value(other)))
            .collect();
        let message = sentence(first, known);
        match others.as_slice() {
            [] => (first, message),
            others => (first, format!("{message} (also {})", others.join(", "))),
        }
    });
    messages.collect()
}

/// As [`message`], with the node and DOF names of the layout.
pub fn message_in<R: Real, C: Capacity>(diagnostic: &Diagnostic, layout: &Layout<R, C>) -> String {
    sentence(diagnostic, &|subject| name_in(subject, layout))
}

/// What the layout says of a subject.
fn name_in<R: Real, C: Capacity>(subject: Subject, layout: &Layout<R, C>) -> Option<String> {
    match subject {
        Subject::Sensor(index) => {
            layout.sensors.get(usize::from(index)).map(|sensor| format!("on node {}", sensor.node))
        }
        Subject::Hit(index) => layout.hits.get(usize::from(index)).map(|hit| hit.dof.to_string()),
        Subject::Property(property) => {
            let prior = layout.priors.iter().find(|prior| prior.property == property);
            prior.map(|Prior { value, sigma, .. }| {
                let unit = ValueUnit::OfProperty.symbol(subject);
                let (value, sigma) = (value.to_f64(), sigma.to_f64());
                format!(
                    "{} = {value} {unit} (stated to {sigma} {unit}, 1 sd)",
                    property_name(property)
                )
            })
        }
        _ => None,
    }
}

/// As [`message`], with the DOF names of a result.
pub fn message_of_result(diagnostic: &Diagnostic, result: &MeasurementResult) -> String {
    sentence(diagnostic, &|subject| match subject {
        Subject::Hit(index) => result
            .measured()
            .find(|(_, measured_index, _)| *measured_index == index)
            .map(|(dof, ..)| dof.to_string()),
        _ => None,
    })
}

/// The stable name of a diagnostic's code; `code_n` for one that this program does not know.
pub fn code_name(diagnostic: &Diagnostic) -> String {
    diagnostic.code.to_string()
}

/// The sentence of the code with its placeholders filled in.
fn sentence(d: &Diagnostic, known: SubjectNames<'_>) -> String {
    let (hit, response) = match d.subject {
        Subject::Response { hit, response } => {
            let sensor = counted("sensor", Subject::Sensor(response / 3), response / 3, known);
            let response = format!("{sensor}, axis {}", axis(response.into()));
            (counted("hit", Subject::Hit(hit), hit, known), response)
        }
        _ => ("a hit".into(), "a response".into()),
    };
    d.code
        .sentence()
        .replace("{value}", &value(d))
        .replace("{code}", &d.code.number().to_string())
        .replace("{severity}", d.severity.name())
        .replace("{hit}", &hit)
        .replace("{response}", &response)
        .replace("{subject}", &subject(d, known))
}

/// The subject of a diagnostic; a general term when the diagnostic does not name one.
fn subject(d: &Diagnostic, known: SubjectNames<'_>) -> String {
    match d.subject {
        Subject::Sensor(index) => counted("sensor", d.subject, index, known),
        Subject::Hit(index) => counted("hit", d.subject, index, known),
        Subject::Channel(channel) => channel_name(channel.into()),
        Subject::Mode(index) => format!("mode {}", u16::from(index) + 1),
        Subject::Hits { first, second } => {
            let hit = |index: u8| counted("hit", Subject::Hit(index), index, known);
            format!("{} and {}", hit(first), hit(second))
        }
        Subject::Property(property) if d.code == Code::PriorInconsistentWithData => {
            known(d.subject).map_or_else(
                || format!("the [prior] of {}", property_name(property)),
                |prior| format!("the [prior] {prior}"),
            )
        }
        Subject::Property(property) => property_name(property).into(),
        Subject::Setting(setting) => setting.name().into(),
        Subject::Whole | Subject::Response { .. } => one_of(d.code.subject_kind()).into(),
    }
}

/// `hit 2 (2:+Z)`, or `hit 2` when the DOF is not known.
fn counted(noun: &str, subject: Subject, index: u8, known: SubjectNames<'_>) -> String {
    let number = u16::from(index) + 1;
    known(subject)
        .map_or_else(|| format!("{noun} {number}"), |name| format!("{noun} {number} ({name})"))
}

fn one_of(kind: SubjectKind) -> &'static str {
    match kind {
        SubjectKind::Sensor => "a sensor",
        SubjectKind::Hit => "a hit",
        SubjectKind::SensorOrHit => "a sensor or a hit",
        SubjectKind::Channel => "a channel",
        SubjectKind::Property => "a property",
        SubjectKind::Setting => "a setting",
        SubjectKind::Mode => "a mode",
        SubjectKind::HitPair => "two hits",
        SubjectKind::Response => "a response",
        SubjectKind::Whole => "the test",
    }
}

fn property_name(property: u8) -> &'static str {
    let parameter = INERTIAL_PARAMETERS.get(usize::from(property));
    parameter.map_or("a property", |parameter| parameter.symbol)
}

/// `the hammer`, or `sensor 2 x`.
pub fn channel_name(channel: usize) -> String {
    match channel.checked_sub(1) {
        None => "the hammer".into(),
        Some(response) => format!("sensor {} {}", response / 3 + 1, axis(response)),
    }
}

fn axis(response: usize) -> char {
    AXIS_LETTERS[response % 3]
}

/// The value in significant digits, with its unit.
fn value(d: &Diagnostic) -> String {
    let (value, unit) = (d.value, d.code.value_unit());
    let number = match unit {
        ValueUnit::Share(decimals) => format!("{:.*}", usize::from(decimals), 100.0 * value),
        ValueUnit::Count
        | ValueUnit::Node
        | ValueUnit::Decibels
        | ValueUnit::Milliradians
        | ValueUnit::Degrees => {
            format!("{value:.0}")
        }
        ValueUnit::Newtons
        | ValueUnit::OfChannel
        | ValueUnit::ChiSquared
        | ValueUnit::Hertz
        | ValueUnit::Times => {
            format!("{value:.1}")
        }
        ValueUnit::Volts if value.abs() < 0.1 => return format!("{:.2} mV", 1e3 * value),
        ValueUnit::Volts => format!("{value:.2}"),
        ValueUnit::NewtonSeconds => format!("{value:.2}"),
        ValueUnit::Kilograms | ValueUnit::Factor => format!("{value:.3}"),
        ValueUnit::SignedKilograms | ValueUnit::Accelerance => format!("{value:+.3}"),
        // A change of a property, not its value.
        ValueUnit::OfProperty if d.code == Code::MovesWithBand => {
            as_exact_as(value.into(), Some(value.abs().into()))
        }
        ValueUnit::KilogramSquareMeters | ValueUnit::OfProperty => five_digits(value),
        ValueUnit::Condition => format!("{value:.3e}"),
        ValueUnit::SignedAxis => signed_axis(value),
        ValueUnit::None | ValueUnit::OfSetting => value.to_string(),
    };
    match unit.symbol(d.subject) {
        "" => number,
        symbol => format!("{number} {symbol}"),
    }
}

/// `+X` for 1 to `-Z` for −3.
fn signed_axis(value: f32) -> String {
    let sign = if value < 0.0 { '-' } else { '+' };
    let letter = (value.abs() as usize).checked_sub(1).and_then(|k| AXIS_LETTERS.get(k));
    letter.map_or("no axis".into(), |letter| format!("{sign}{}", letter.to_ascii_uppercase()))
}

/// A number with five significant digits.
fn five_digits(value: f32) -> String {
    let first = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    format!("{value:.*}", (4.0 - first).clamp(0.0, 12.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::diagnosis::Severity;

    fn diagnostic_of(code: Code, subject: Subject, value: f32) -> Diagnostic {
        Diagnostic::about(code, Severity::Warning, subject, value)
    }

    #[test]
    fn every_sentence_is_filled_in() {
        for &code in Code::ALL {
            for subject in [code.subject_kind().at(1), Subject::Whole] {
                let sentence = message(&diagnostic_of(code, subject, 0.25));
                assert!(!sentence.contains(['{', '}']), "{sentence}");
                // Keys of the layout and symbols of properties may have underscores.
                let words = sentence.replace("senses_gravity", "").replace("c_x", "");
                assert!(!words.contains('_') || words.contains("test."), "{sentence}");
            }
        }
    }

    #[test]
    fn an_unknown_code_is_passed_on() {
        let d = Diagnostic::whole(Code::Unknown(999), Severity::Warning, 2.0);
        assert_eq!(
            message(&d),
            "the rig reports code 999 (warning, 2), which this program does not know; update it"
        );
        assert_eq!(code_name(&d), "code_999");
    }

    #[test]
    fn five_digits_of_a_number_count() {
        let shown = [1.23, -0.001_234_567, 123_456.0, 0.0].map(five_digits);
        assert_eq!(shown, ["1.2300", "-0.0012346", "123456", "0.0000"]);
    }

    #[test]
    fn channels_are_named() {
        let overload = |k| message(&diagnostic_of(Code::Overload, Subject::Channel(k), 170.0));
        assert!(overload(0).starts_with("the hammer") && overload(0).contains(" N"));
        assert!(overload(5).starts_with("sensor 2 y"));
    }

    #[test]
    fn what_is_said_of_several_channels_is_said_once() {
        let overload = |k, value| diagnostic_of(Code::Overload, Subject::Channel(k), value);
        let weak = diagnostic_of(Code::TooWeak, Subject::Whole, 2.0);
        let one = messages(&[overload(0, 128.4)]);
        assert_eq!(one, message(&overload(0, 128.4)));
        let text = messages(&[overload(0, 128.4), weak, overload(2, -153.6), overload(3, 147.3)]);
        let others = "(also sensor 1 y -153.6 m/s², sensor 1 z 147.3 m/s²)";
        assert_eq!(text, format!("{one} {others}; {}", message(&weak)));
        assert_eq!(messages(&[]), "");
    }

    #[test]
    fn data_of_a_hit_that_is_not_there_do_not_blame_a_sensor() {
        let text = message(&diagnostic_of(Code::HitNotInLayout, Subject::Hit(8), 0.0));
        assert!(
            text.starts_with("there are data of hit 9, which the layout does not have"),
            "{text}"
        );
    }

    #[test]
    fn names_of_the_layout_are_used() {
        let file = massline_files::layout_file::LayoutFile::parse(
            include_str!("../../../examples/three-bar-test-1.toml"),
            "t",
        )
        .unwrap();
        let d = diagnostic_of(Code::DofSkipped, Subject::Hit(1), 0.0);
        assert_eq!(message_in(&d, &file.layout), "hit 2 (2:+Z) was left out");
        assert_eq!(message(&d), "hit 2 was left out");
        let d = diagnostic_of(Code::TwoSensorsOnOneNode, Subject::Sensor(2), 3.0);
        assert!(message_in(&d, &file.layout).starts_with("sensor 3 (on node 3) "));
    }
}
