//! An examination as part of a result, and in sentences.

use massline_shared::diagnosis::{Code, Severity};
use massline_shared::identify::Consistency;
use massline_shared::identify::maximum_likelihood::BudgetScales;
use massline_shared::identify::single_fault::SingleFault;
use massline_shared::layout::{AXIS_LETTERS, HostLayout};

use massline_analysis::single_fault::{
    Examination, FaultSize, Mistake, Outcome, SizedFault, Suspect,
};
use massline_result::{Fault, FaultOutcome, Finding, Spread};

use super::suspects as words;
use super::{estimate_of, message_in};

/// Largest number of mistakes of a kind that a text names; the JSON names all.
const MAX_LISTED: usize = 6;

/// The suspected mistakes with their χ², the runner-up, and the mistakes that the data would not reveal.
pub fn single_faults_in(
    examination: &Examination,
    layout: &HostLayout,
) -> massline_result::SingleFaults {
    let suspect = |s: &Suspect| suspect_in(s, layout);
    massline_result::SingleFaults {
        outcome: match examination.outcome {
            Outcome::NothingSuspicious => FaultOutcome::NothingSuspicious,
            Outcome::Suspected(_) => FaultOutcome::Suspected,
            Outcome::LargerErrors(_) => FaultOutcome::LargerErrors,
            Outcome::Unexplained => FaultOutcome::Unexplained,
        },
        chi_squared: examination.plain.map(|c| c.chi_squared),
        degrees_of_freedom: examination.plain.map(|c| c.degrees_of_freedom),
        tested: examination.tested,
        suspects: examination.suspects().iter().map(suspect).collect(),
        runner_up: examination.runner_up.as_ref().map(suspect),
        errors_over_stated: match &examination.outcome {
            Outcome::LargerErrors(scales) => Some(massline_result::ErrorsOverStated {
                hit_position: scales.hit_position,
                hit_direction: scales.hit_direction,
                constant: scales.constant,
            }),
            _ => None,
        },
        not_tried: examination.untried.iter().map(|fault| fault_in(fault, layout)).collect(),
        not_visible: examination
            .hidden
            .as_ref()
            .map(|hidden| hidden.iter().map(|fault| fault_in(fault, layout)).collect()),
    }
}

/// Entries for the diagnostics of a result.
pub fn findings_in(examination: &Examination, layout: &HostLayout) -> Vec<Finding> {
    let entry = |(code, severity, message): (Code, Severity, String)| Finding {
        code: code.into(),
        severity: severity.into(),
        message,
    };
    coded_sentences(examination, layout).into_iter().map(entry).collect()
}

fn coded_sentences(
    examination: &Examination,
    layout: &HostLayout,
) -> Vec<(Code, Severity, String)> {
    let mut sentences = Vec::new();
    if let [best, tied @ ..] = examination.suspects() {
        let message = suspicion(examination, best, tied, layout);
        sentences.push((words::code(&best.mistake), Severity::Warning, message));
    }
    if let Outcome::LargerErrors(scales) = &examination.outcome {
        let message = format!(
            "the data contradict the stated errors ({}), and no single mistake that was tried explains them; {}",
            plain_text(examination),
            larger_errors_text(scales)
        );
        sentences.push((Code::ErrorsLargerThanStated, Severity::Warning, message));
    }
    if examination.outcome == Outcome::Unexplained {
        let best = examination.runner_up.as_ref().map_or(String::new(), |best| {
            format!("; the best of them: {}", with_chi_squared(best, layout))
        });
        let message = format!(
            "the data contradict the layout and its budget ({}) and no single mistake that was tried explains \
             them{best}{}; look for several mistakes, or widen [uncertainty]",
            plain_text(examination),
            untried_text(&examination.untried, layout)
        );
        sentences.push((Code::NoSingleFaultExplains, Severity::Warning, message));
    }
    if let Some(hidden) = examination.hidden.as_ref().filter(|hidden| !hidden.is_empty()) {
        let message = hidden_text(hidden, layout);
        sentences.push((Code::FaultsNotVisible, Severity::Note, message));
    }
    sentences
}

fn suspicion(
    examination: &Examination,
    best: &Suspect,
    tied: &[Suspect],
    layout: &HostLayout,
) -> String {
    let mut text = format!(
        "{}: that explains the data, {} instead of {}",
        words::suspect_clause(best, layout),
        chi_squared_text(&best.consistency),
        plain_text(examination)
    );
    for other in tied.iter().take(MAX_LISTED) {
        text += &format!("; indistinguishable from it: {}", with_chi_squared(other, layout));
    }
    text += &more_than_listed(tied.len());
    if let Some(next) = &examination.runner_up {
        text += &format!("; next best: {}", with_chi_squared(next, layout));
    }
    text += advice_on(examination.suspects());
    text
}

fn plain_text(examination: &Examination) -> String {
    examination.plain.as_ref().map_or("no fit at all".into(), chi_squared_text)
}

/// What to do about one of these mistakes, as a further clause.
pub fn advice_on(suspects: &[Suspect]) -> &'static str {
    // Names of sensors and hits are those of the recorded data, so that a layout with others does not go with them.
    let is_of_positions = |suspect: &Suspect| match suspect.mistake {
        // The axes of a layout are right-handed.
        Mistake::Listed(SingleFault::SensorAxes { reads, .. }) => reads.is_turn(),
        Mistake::Listed(fault) => matches!(fault, SingleFault::NodesSwapped { .. }),
        Mistake::Sized(sized) => matches!(
            sized.fault,
            SizedFault::NodeCoordinate { .. } | SizedFault::HitDisplaced { .. }
        ),
    };
    match suspects.iter().any(is_of_positions) {
        true => "; put it right and measure again, or correct the layout",
        false => "; put it right and measure again",
    }
}

/// χ² and its degrees of freedom.
pub fn chi_squared_text(consistency: &Consistency<f64>) -> String {
    format!("χ² {:.1} of {}", consistency.chi_squared, consistency.degrees_of_freedom)
}

fn with_chi_squared(suspect: &Suspect, layout: &HostLayout) -> String {
    let clause = words::suspect_clause(suspect, layout);
    format!("{clause} ({})", chi_squared_text(&suspect.consistency))
}

/// What larger errors explain the data.
fn larger_errors_text(scales: &BudgetScales<f64>) -> String {
    format!(
        "errors of the stated kinds explain them that are larger: positions of the hits {:.1} times, directions of the \
         hits {:.1} times, sensors and marks {:.1} times those stated; hit more carefully, check how the sensors are \
         mounted, or state the larger errors in [uncertainty]",
        scales.hit_position, scales.hit_direction, scales.constant
    )
}

/// The mistakes that were not tried.
fn untried_text(untried: &[SingleFault<f64>], layout: &HostLayout) -> String {
    if untried.is_empty() {
        return String::new();
    }
    let named: Vec<_> =
        untried.iter().take(MAX_LISTED).map(|fault| words::clause(fault, layout)).collect();
    let more = more_than_listed(untried.len());
    format!(
        "; not tried, because hits and sensors do not determine the ten properties then: {}{more}",
        named.join("; ")
    )
}

fn hidden_text(hidden: &[SingleFault<f64>], layout: &HostLayout) -> String {
    let named: Vec<String> =
        hidden.iter().take(MAX_LISTED).map(|fault| words::clause(fault, layout)).collect();
    let more = more_than_listed(hidden.len());
    format!("these data would not show it if {}{more}", named.join("; if "))
}

/// The number of mistakes that are not named.
fn more_than_listed(count: usize) -> String {
    match count.saturating_sub(MAX_LISTED) {
        0 => String::new(),
        more => format!("; and {more} more"),
    }
}

fn suspect_in(suspect: &Suspect, layout: &HostLayout) -> massline_result::Suspect {
    let fault = match &suspect.mistake {
        Mistake::Listed(fault) => fault_in(fault, layout),
        Mistake::Sized(sized) => sized_fault(sized.fault, words::code(&suspect.mistake)),
    };
    let sized = match &suspect.mistake {
        Mistake::Sized(sized) => Some(sized),
        Mistake::Listed(_) => None,
    };
    let size = sized.map(|sized| sized.size);
    massline_result::Suspect {
        fault: Fault { message: words::suspect_clause(suspect, layout), ..fault },
        chi_squared: suspect.consistency.chi_squared,
        degrees_of_freedom: suspect.consistency.degrees_of_freedom,
        gain: match size {
            Some(FaultSize::Gain(gain)) => Some(gain.into()),
            _ => None,
        },
        displacement_m: match size {
            Some(FaultSize::Displacement(moved)) => Some(moved.into()),
            _ => None,
        },
        displacements_m: match size {
            Some(FaultSize::Displacements(moved)) => Some(moved.map(Spread::from)),
            _ => None,
        },
        meaning: sized.and_then(|sized| words::meaning(sized, layout)).map(str::to_owned),
        corrected: suspect
            .corrected
            .as_ref()
            .map(|estimate| estimate_of(estimate, |diagnostic| message_in(diagnostic, layout))),
    }
}

/// A mistake of a size as part of a result, without its words.
fn sized_fault(fault: SizedFault, code: Code) -> Fault {
    let plain = Fault::of(code);
    let letter = |axis: massline_shared::layout::Axis| AXIS_LETTERS[axis.index()];
    match fault {
        SizedFault::ChannelGain { sensor, axis } => {
            Fault { sensor: Some(sensor + 1), axis: Some(letter(axis)), ..plain }
        }
        SizedFault::CommonGain => plain,
        SizedFault::SensorGain { sensor } => Fault { sensor: Some(sensor + 1), ..plain },
        SizedFault::HitGain { hit } | SizedFault::HitDisplaced { hit } => {
            Fault { hit: Some(hit + 1), ..plain }
        }
        SizedFault::NodeCoordinate { node, axis } => {
            Fault { node: Some(node), axis: Some(letter(axis)), ..plain }
        }
    }
}

/// A mistake as part of a result. Sensors and hits are counted from 1, as in the layout's messages.
fn fault_in(fault: &SingleFault<f64>, layout: &HostLayout) -> Fault {
    let plain =
        Fault { message: words::clause(fault, layout), ..Fault::of(words::code_of_listed(fault)) };
    match fault {
        SingleFault::SensorAxes { sensor, .. } => Fault { sensor: Some(sensor + 1), ..plain },
        SingleFault::CablesSwapped { sensors } => {
            Fault { sensors: Some(sensors.map(|sensor| sensor + 1)), ..plain }
        }
        SingleFault::NodesSwapped { nodes, .. } => Fault { nodes: Some(*nodes), ..plain },
        SingleFault::HitAtNode { hit, node, .. } => {
            Fault { hit: Some(hit + 1), node: Some(*node), ..plain }
        }
        SingleFault::HitReversed { hit } => Fault { hit: Some(hit + 1), ..plain },
    }
}
