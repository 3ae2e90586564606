//! A short text for everything that a rig can say: at most three lines of 21 characters.

use core::fmt::Write as _;

use massline_protocol::message::Reason;
use massline_shared::calibration::block::BlockError;
use massline_shared::calibration::tumble::TumbleProblem;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::layout::{PROPERTIES, RigLayout, Setting};

use super::number::{Text, decimals_for, fitting};
use super::trial::Problem;

/// Characters of a line.
pub const WIDTH: usize = 21;
/// Lines of a text.
pub const LINES: usize = 3;

/// What a code says, its lines parted by `\n`.
pub fn of_code(code: Code) -> &'static str {
    match code {
        Code::FewerThanThreeSensors => "Under 3 sensors: IRM\ncannot, ML has wider\nintervals.",
        Code::SensorsCollinear => "Sensors on one line:\nmove one away. IRM\ncannot, ML can.",
        Code::ResponseRankDeficient => "Sensors do not see\nall six motions:\nspread or turn them.",
        Code::FewerThanThreeHits => "Under 3 hit places:\nadd hits elsewhere,\nother directions.",
        Code::HitsAllParallel => "All hits parallel:\nadd one in another\ndirection.",
        Code::HitsConcurrent => "All hits meet in one\npoint: move one past\nit.",
        Code::HitsThroughCentreOfMass => {
            "All hits go through\nthe centre of mass:\nhit further out."
        }
        Code::TenParametersNotIdentifiable => {
            "Cannot find all ten:\nmore hit places or\nsensors needed."
        }
        Code::TwoSensorsOnOneNode => "Two sensors on one\nnode: give each its\nown.",
        Code::UnknownNode => "The layout lacks this\nnode: correct the\nlayout.",
        Code::AxesNotOrthonormal => "Axes not at right\nangles: correct the\nlayout.",
        Code::LayoutNotFinite => "A number of the\nlayout is not usable:\ncorrect the layout.",
        Code::SettingOutOfRange => "A setting is out of\nthe rig's range:\nchange [test].",
        Code::DataNotFinite => "A response is no\nnumber: measure it\nagain.",
        Code::FrfMissing => "This hit place was\nnot measured.",
        Code::BandTooNarrow => "Band too narrow:\nwiden test.band_hz.",
        Code::TooFewHitsForSigma => "Under 3 hits: no +-\nis known. Hit more\noften.",
        Code::SigmaCoversScatterOnly => {
            "+- covers the scatter\nof hits only, not\nplaces and gains."
        }
        Code::NotPhysicallyConsistent => "No body is like this:\ncheck places, signs;\nhit more.",
        Code::IllConditioned => "Nearly unsolvable:\nspread sensors and\nhits.",
        Code::DofSkipped => "This hit place was\nleft out.",
        Code::DofFinishedEarly => "This hit place has\nfewer hits than\nwanted.",
        Code::GravityNotGiven => "Layout gives no\ngravity: less exact\nbelow 20 Hz.",
        Code::ResultNotStored => "Flash kept no result:\ndelete an old one,\nthen go on.",
        Code::SamplerStopped => "The converter is\nsilent: switch off\nand on again.",
        Code::BlockTest => "A block of known mass\nwas hit: it only\ncalibrates.",
        Code::DataContradictBudget => "Data contradict the\nerrors stated: look\nfor a wrong axis.",
        Code::SensorStrainsBudget => "Suspect: check its\nnode, axes and cable.",
        Code::HitStrainsBudget => "Suspect: check node,\ndirection and sign.",
        Code::HeldToConsistency => "Best fit was no body:\nnearest body shown,\n+- is rough.",
        Code::NotConverged => "No fit: check nodes,\naxes and signs of all\nsensors and hits.",
        Code::AttachedTooHeavy => "Attached masses weigh\nmore than was found:\ncheck them.",
        Code::MassNotPositive => "Mass not positive:\ncheck signs and axes.",
        Code::PriorContradictsData => {
            "[prior] contradicts\nthe data (see value):\ncheck or widen it."
        }
        Code::NoPlateau => "Its mass line is not\nflat: narrow the band\nor hang softer.",
        Code::BandNotFound => "No clear band: 10 to\n120 Hz used. Hang the\nobject softer.",
        Code::Overload => "Too hard: a channel\nwas at its end. Hit\nmore gently.",
        Code::TooWeak => "Too weak: hit harder.",
        Code::ScansLost => "Samples were lost:\nhit again.",
        Code::TooHard => "Nearly too hard: hit\nmore gently.",
        Code::DoubleHit => "Hammer bounced: hold\nit loosely, hit once.",
        Code::ForceSpectrumLow => "Hit too soft at high\nfrequencies: take a\nharder tip.",
        Code::PreTriggerNotQuiet => "It was moving: wait\nuntil it hangs still.",
        Code::ClippedRecord => "It rang too long:\ntake the hammer away,\nhold nothing.",
        Code::TriggerTooEarly => "Hit too early: wait\na moment after the\nsignal.",
        Code::DuplicateHit => "Same record as the\nhit before: hit\nagain.",
        Code::HitInconsistent => "Unlike the others:\nsame point, same\ndirection each time.",
        Code::MotionNotRigid => "Moves unlike a rigid\nbody: check its axes,\ncable, glue.",
        Code::HitsDisagree => "First two hits differ\nboth dropped: hit the\nsame point.",
        Code::SensorAxesSuspect => "Its axes look turned,\nswapped or reversed.",
        Code::CablesSwapped => "Cables of two sensors\nlook swapped.",
        Code::HitAtWrongNode => "It seems to have been\nhit at another node.",
        Code::HitReversed => "It seems to have been\nhit from the other\nside.",
        Code::CommonScale => "All responses off by\none factor: check the\nhammer's gain.",
        Code::NoSingleFaultExplains => "No single mistake\nexplains these data.",
        Code::FaultsNotVisible => "Some mistakes would\nnot show in these\ndata.",
    }
}

/// What a diagnostic says; a code that this program does not know goes by its number.
pub fn of_diagnostic(diagnostic: &Diagnostic) -> &'static str {
    diagnostic.known_code().map_or("Update this rig: it\ndoes not know this\ncode.", of_code)
}

/// What a diagnostic is about, and the number that decided where the line has room for it.
pub fn subject(diagnostic: &Diagnostic, layout: Option<&RigLayout>) -> Text {
    let mut text = Text::new();
    // A text has room for every subject and a number.
    let _ = write_subject(&mut text, diagnostic, layout);
    let value = fitting(diagnostic.value, decimals_for(diagnostic.value, 3), 7);
    let spaces = WIDTH.saturating_sub(text.len() + value.len());
    if diagnostic.value != 0.0 && spaces > 0 {
        let _ = write!(text, "{:spaces$}{value}", "");
    }
    text
}

fn write_subject(text: &mut Text, d: &Diagnostic, layout: Option<&RigLayout>) -> core::fmt::Result {
    let index = usize::from(d.subject);
    let Some(code) = d.known_code() else { return write!(text, "code {}", d.code) };
    match about(code) {
        _ if d.subject == Diagnostic::WHOLE => Ok(()),
        About::Whole => Ok(()),
        About::Hit => match layout.and_then(|layout| layout.hits.get(index)) {
            Some(hit) => write!(text, "hit {}", hit.dof),
            None => write!(text, "hit no. {}", index + 1),
        },
        About::Property => text.write_str(PROPERTIES.get(index).unwrap_or(&"property")),
        About::Sensor => write!(text, "sensor {}", index + 1),
        About::Channel => write_channel(text, index),
        About::Setting => {
            let name = Setting::from_subject(d.subject).map_or("setting", Setting::name);
            text.write_str(name.get(..WIDTH.min(name.len())).unwrap_or(name))
        }
        About::Response => {
            let (dof, response) = d.response();
            write!(text, "hit {}, ", dof + 1)?;
            write_channel(text, response + 1)
        }
    }
}

fn write_channel(text: &mut Text, channel: usize) -> core::fmt::Result {
    let Some(response) = channel.checked_sub(1) else { return text.write_str("hammer") };
    let axis = ['x', 'y', 'z'][response % 3];
    write!(text, "sensor {} {axis}", response / 3 + 1)
}

/// What the subject of a diagnostic counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum About {
    Whole,
    Hit,
    Sensor,
    Property,
    Channel,
    Setting,
    Response,
}

fn about(code: Code) -> About {
    match code {
        Code::TwoSensorsOnOneNode
        | Code::UnknownNode
        | Code::SensorStrainsBudget
        | Code::MotionNotRigid
        | Code::SensorAxesSuspect => About::Sensor,
        Code::FrfMissing
        | Code::BandTooNarrow
        | Code::TooFewHitsForSigma
        | Code::DofSkipped
        | Code::DofFinishedEarly
        | Code::HitStrainsBudget
        | Code::BandNotFound
        | Code::DataNotFinite
        | Code::HitInconsistent
        | Code::HitsDisagree
        | Code::HitAtWrongNode
        | Code::HitReversed => About::Hit,
        Code::Overload | Code::TooHard | Code::PreTriggerNotQuiet | Code::ClippedRecord => {
            About::Channel
        }
        Code::SettingOutOfRange => About::Setting,
        Code::PriorContradictsData => About::Property,
        Code::NoPlateau => About::Response,
        _ => About::Whole,
    }
}

/// Why the rig does not do what was asked for.
pub fn of_reason(reason: Reason) -> &'static str {
    match reason {
        Reason::UnknownMessage | Reason::Malformed => "This request is not\nunderstood.",
        Reason::NotFound => "It is there no\nlonger.",
        Reason::WrongPhase => "Not now: the rig is\nbusy. End or finish\nwhat runs first.",
        Reason::NoLayout => "No layout is kept:\nsend one from a PC\n(massline measure).",
        Reason::LayoutRefused => "This layout cannot\ngive an answer.",
        Reason::StoreFull => "The store is full:\ndelete a result\n(Results).",
        Reason::StoreFailed => "The flash did not\nkeep it: try again.",
        Reason::OutOfRange => "It ends before that.",
        Reason::Busy => "The flash is busy:\ntry again.",
        Reason::SamplerStopped => of_code(Code::SamplerStopped),
    }
}

/// What is wrong with a calibration.
pub fn of_problem(problem: &Problem) -> &'static str {
    match problem {
        Problem::Tumble { problem, .. } => match problem {
            TumbleProblem::Missing(_) | TumbleProblem::Repeated(_) => {
                "Position missing:\nbegin anew."
            }
            TumbleProblem::NotFinite(_) => "The reading is no\nnumber: read again.",
            TumbleProblem::NotAtRest { .. } => "Not at rest: lay it\ndown, hands off, read\nagain.",
            TumbleProblem::ReadsAs { .. } => {
                "Turned otherwise, or\ntwo wires swapped:\nbegin anew."
            }
            TumbleProblem::WrongLength { .. } => {
                "Far from 1 g: cable\noff or other sensor.\nBegin anew."
            }
        },
        Problem::Block(error) => match error {
            BlockError::TooFewHits => "Under 2 hits along a\ndirection: take 5.",
            BlockError::DirectionsMissing => "Hit along x, y and z:\nthree directions are\nneeded.",
            BlockError::NotFinite => "A mass line is no\nnumber: measure\nagain.",
            BlockError::Dead { .. } => "A sensor does not\nanswer to the hits:\ncheck its cable.",
        },
        Problem::NoMass => "The mass was not\ngiven here: ask the\nhost for the result.",
        Problem::NotUsable => "The numbers make no\nusable calibration:\nbegin anew.",
        Problem::SensorsUnknown => "First calibrate the\nsensors by gravity,\nthen hit the block.",
        Problem::Refused(reason) => of_reason(*reason),
    }
}

/// Why the rig started.
pub fn of_boot(reason: u8) -> &'static str {
    match reason {
        1 => "power on",
        2 => "reset pin",
        3 => "watchdog",
        4 => "panic",
        _ => "unknown",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    fn fits(text: &str) -> bool {
        let lines: std::vec::Vec<_> = text.split('\n').collect();
        let printable = |line: &str| line.bytes().all(|b| (b' '..=b'~').contains(&b));
        !text.is_empty()
            && lines.len() <= LINES
            && lines.iter().all(|line| !line.is_empty() && line.len() <= WIDTH && printable(line))
    }

    #[test]
    fn every_code_has_words_of_its_own_that_fit() {
        for (i, &code) in Code::ALL.iter().enumerate() {
            assert!(fits(of_code(code)), "{code:?}: {}", of_code(code));
            assert!(Code::ALL[i + 1..].iter().all(|&other| of_code(other) != of_code(code)));
        }
        assert!(fits(of_diagnostic(&Diagnostic {
            code: 999,
            severity: 2,
            subject: 0,
            value: 0.0
        })));
    }

    #[test]
    fn every_reason_fits() {
        for raw in 1..=11 {
            let reason = Reason::from_raw(raw).unwrap();
            assert!(fits(of_reason(reason)), "{reason:?}");
        }
        assert_eq!(Reason::from_raw(12), None);
    }

    #[test]
    fn every_problem_of_a_calibration_fits() {
        use massline_shared::calibration::tumble::{Position, TumbleProblem as T};
        let position = Position::ALL[0];
        let tumble = [
            T::Missing(position),
            T::Repeated(position),
            T::NotFinite(position),
            T::NotAtRest { position, deviation: 1.0 },
            T::ReadsAs { position, like: Position::ALL[1] },
            T::WrongLength { position, length: 0.1 },
        ];
        let block = [
            BlockError::TooFewHits,
            BlockError::DirectionsMissing,
            BlockError::NotFinite,
            BlockError::Dead { sensor: 0 },
        ];
        let tumble = tumble.into_iter().map(|problem| Problem::Tumble { sensor: 0, problem });
        let others = [
            Problem::NotUsable,
            Problem::NoMass,
            Problem::SensorsUnknown,
            Problem::Refused(Reason::Busy),
        ];
        for problem in tumble.chain(block.map(Problem::Block)).chain(others) {
            assert!(fits(of_problem(&problem)), "{problem:?}");
        }
    }

    #[test]
    fn subjects_are_named_and_fit_a_line_for_every_code() {
        use massline_shared::diagnosis::Severity;
        for &code in Code::ALL {
            for (subject_of, value) in [(0, 0.0), (8, -12345.678), (363, 1e-5), (u16::MAX, 1e20)] {
                let d = Diagnostic::about(code, Severity::Error, subject_of, value);
                assert!(subject(&d, None).len() <= WIDTH, "{code:?}");
            }
        }
        let channel =
            |k| subject(&Diagnostic::about(Code::Overload, Severity::Error, k, 0.0), None);
        assert_eq!(channel(0), "hammer");
        assert_eq!(channel(5), "sensor 2 y");
        let hit = Diagnostic::about(Code::DofSkipped, Severity::Warning, 1, 3.5);
        assert_eq!(subject(&hit, None).to_string(), "hit no. 2        3.50");
    }
}
