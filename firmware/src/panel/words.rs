//! A short text for everything that the rig can report: at most three lines of 21 characters.

use core::fmt::Write as _;

use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::calibration::block::BlockError;
use massline_shared::calibration::tumble::TumbleProblem;
use massline_shared::diagnosis::{Code, Diagnostic, Subject};
use massline_shared::identify::Method;
use massline_shared::layout::{AXIS_LETTERS, Dof, RigLayout};

use super::calibration_wizard::WizardProblem;
use super::number::{Text, decimals_for, fitting};
use super::refused::RefusalReason;

/// Characters of a line.
pub const WIDTH: usize = 21;
/// Lines of a text.
pub const LINES: usize = 3;

/// Node and direction of a DOF.
pub fn place(dof: Dof) -> Text {
    let mut place = Text::new();
    // There is room: `65535:+X`.
    let _ = write!(place, "{dof}");
    place.chars().map(|c| if c == ':' { ' ' } else { c }).collect()
}

/// The subject of a diagnostic, and the number that triggered it if the line has room.
pub fn subject(diagnostic: &Diagnostic, layout: Option<&RigLayout>) -> Text {
    let mut text = Text::new();
    // The text has room for every subject and a number.
    let _ = write_subject(&mut text, diagnostic, layout);
    let value = fitting(diagnostic.value, decimals_for(diagnostic.value, 3), 7);
    let spaces = WIDTH.saturating_sub(text.len() + value.len());
    if diagnostic.value != 0.0 && spaces > 0 {
        let _ = write!(text, "{:spaces$}{value}", "");
    }
    text
}

fn write_subject(text: &mut Text, d: &Diagnostic, layout: Option<&RigLayout>) -> core::fmt::Result {
    if let Code::Unknown(number) = d.code {
        return write!(text, "code {number}");
    }
    match d.subject {
        Subject::Whole => Ok(()),
        Subject::Hit(index) => {
            match layout.and_then(|layout| layout.hits.get(usize::from(index))) {
                Some(hit) => write!(text, "hit {}", hit.dof),
                None => write!(text, "hit no. {}", u16::from(index) + 1),
            }
        }
        Subject::Property(index) => {
            let known = INERTIAL_PARAMETERS.get(usize::from(index));
            text.write_str(known.map_or("property", |parameter| parameter.symbol))
        }
        Subject::Sensor(index) => write!(text, "sensor {}", u16::from(index) + 1),
        Subject::Channel(channel) => write_channel(text, channel.into()),
        Subject::Hits { first, second } => {
            write!(text, "hits {} and {}", u16::from(first) + 1, u16::from(second) + 1)
        }
        Subject::Mode(index) => write!(text, "mode {}", u16::from(index) + 1),
        Subject::Setting(setting) => text.write_str(setting.words()),
        Subject::Response { hit, response } => {
            write!(text, "hit {}, ", u16::from(hit) + 1)?;
            write_channel(text, usize::from(response) + 1)
        }
    }
}

fn write_channel(text: &mut Text, channel: usize) -> core::fmt::Result {
    let Some(response) = channel.checked_sub(1) else { return text.write_str("hammer") };
    let axis = AXIS_LETTERS[response % 3];
    write!(text, "sensor {} {axis}", response / 3 + 1)
}

/// The hammer as `H`, and x of sensor 1 as `1x`.
pub fn short_channel(channel: usize) -> Text {
    let mut text = Text::new();
    let _ = match channel.checked_sub(1) {
        None => text.write_str("H"),
        Some(response) => write!(text, "{}{}", response / 3 + 1, AXIS_LETTERS[response % 3]),
    };
    text
}

/// The method with this number, in at most six characters.
pub fn method(number: u8) -> &'static str {
    match Method::from_number(number) {
        Some(Method::ToivolaNuutila) => "TN",
        Some(Method::ContiBretl) => "CB",
        Some(Method::Dppim) => "DPPIM",
        Some(Method::DppimStructural) => "DPPIMs",
        Some(Method::ModalConstant) => "MC",
        Some(Method::MaximumLikelihood) => "ML",
        Some(Method::InertiaRestraint) => "IRM",
        Some(Method::GlobalFit) => "fit",
        None => "?",
    }
}

/// Why the rig has refused an action.
pub fn of_reason(reason: RefusalReason) -> &'static str {
    match reason {
        RefusalReason::NotFound => "It no longer\nexists.",
        RefusalReason::WrongPhase => "Not now: the rig is\nbusy. End or finish\nwhat runs first.",
        RefusalReason::NoLayout => "No layout stored:\nsend one from a PC\n(massline measure).",
        RefusalReason::LayoutRefused => "This layout cannot\ngive an answer.",
        RefusalReason::StoreFull => "The store is full:\ndelete a result\n(Results).",
        RefusalReason::TooLittleRoom(0) => {
            "Too little room: take\nfewer hit places.\nSix always fit."
        }
        RefusalReason::TooLittleRoom(_) => "Too little room.\nFirst delete under\nResults:",
        RefusalReason::BlockNeedsMassLines => {
            "A block is weighed by\nmass lines: choose\nthem under Measure."
        }
        RefusalReason::SupplyLow => "Supply too low to\nwrite: charge, or try\nanother cable.",
        RefusalReason::StoreFailed => "Writing the flash\nfailed: try again.",
        RefusalReason::Busy => "The flash is busy:\ntry again.",
        RefusalReason::SamplerStopped => Code::SamplerStopped.words(),
        RefusalReason::NothingToUndo => {
            "No hit to undo: only\nthe last one can be,\nand only once."
        }
        RefusalReason::HitOverwritten => {
            "Too late to undo: a\nlater hit took its\nplace in memory."
        }
    }
}

/// Why a calibration has failed.
pub fn of_problem(problem: &WizardProblem) -> &'static str {
    match problem {
        WizardProblem::Tumble { problem, .. } => match problem {
            TumbleProblem::Missing(_) | TumbleProblem::Repeated(_) => {
                "Position missing:\nstart again."
            }
            TumbleProblem::NotFinite(_) => "The reading is not\na number: read again.",
            TumbleProblem::NotAtRest { .. } => "It moved: lay it\ndown, hands off, read\nagain.",
            TumbleProblem::ReadsAs { .. } => "Wrong position, or\ntwo wires swapped:\nstart again.",
            TumbleProblem::WrongLength { .. } => {
                "Not 1 g: cable loose\nor wrong sensor type.\nStart again."
            }
        },
        WizardProblem::Block(error) => match error {
            BlockError::TooFewHits => "Fewer than 2 hits in\na direction: take 5.",
            BlockError::DirectionsMissing => "Hit along x, y and z:\nthree directions are\nneeded.",
            BlockError::NotFinite => "A mass line is not\na number: measure\nagain.",
            BlockError::Dead { .. } => "A sensor does not\nanswer to the hits:\ncheck its cable.",
        },
        WizardProblem::NoMass => "The mass was not\ngiven here: ask the\nhost for the result.",
        WizardProblem::NotUsable => "The numbers make no\nusable calibration:\nstart again.",
        WizardProblem::SensorsUnknown => {
            "First calibrate the\nsensors by gravity,\nthen hit the block."
        }
        WizardProblem::Refused(reason) => of_reason(*reason),
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
    fn the_words_of_every_code_fit() {
        for code in Code::ALL.iter().copied().chain([Code::Unknown(999)]) {
            assert!(fits(code.words()), "{code:?}: {}", code.words());
        }
    }

    #[test]
    fn every_reason_fits() {
        for reason in RefusalReason::ALL {
            assert!(fits(of_reason(reason)), "{reason:?}");
        }
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
        let tumble = tumble.into_iter().map(|problem| WizardProblem::Tumble { sensor: 0, problem });
        let others = [
            WizardProblem::NotUsable,
            WizardProblem::NoMass,
            WizardProblem::SensorsUnknown,
            WizardProblem::Refused(RefusalReason::Busy),
        ];
        for problem in tumble.chain(block.map(WizardProblem::Block)).chain(others) {
            assert!(fits(of_problem(&problem)), "{problem:?}");
        }
    }

    #[test]
    fn subjects_are_named_and_fit_a_line_for_every_code() {
        use massline_shared::diagnosis::Severity;
        for code in Code::ALL.iter().copied().chain([Code::Unknown(u16::MAX)]) {
            for (index, value) in [(0, 0.0), (8, -12345.678), (u8::MAX, 1e20)] {
                let of_index = code.subject_kind().at(index);
                for subject_of in [of_index, Subject::Whole] {
                    let d = Diagnostic::about(code, Severity::Error, subject_of, value);
                    assert!(subject(&d, None).len() <= WIDTH, "{code:?}");
                }
            }
        }
        let subject_text = |code, subject_of, value| {
            subject(&Diagnostic::about(code, Severity::Error, subject_of, value), None).to_string()
        };
        assert_eq!(subject_text(Code::Overload, Subject::Channel(0), 0.0), "hammer");
        assert_eq!(subject_text(Code::Overload, Subject::Channel(5), 0.0), "sensor 2 y");
        assert_eq!(subject_text(Code::DofSkipped, Subject::Hit(1), 3.5), "hit no. 2        3.50");
        assert_eq!(subject_text(Code::AxesNotOrthonormal, Subject::Hit(1), 0.0), "hit no. 2");
        assert_eq!(subject_text(Code::AxesNotOrthonormal, Subject::Sensor(1), 0.0), "sensor 2");
        assert_eq!(subject_text(Code::Unknown(999), Subject::Whole, 0.0), "code 999");
    }
}
