//! Which findings of a rig stand beside the program's own answer.
//!
//! A rig finds two kinds of things: what it has seen while measuring, which stands, and what it concludes by solving
//! with the layout that it has. The program solves with the layout that it is given, perhaps one that was corrected
//! after the test, and comes to conclusions of its own; those of the rig would contradict them.

use massline_shared::diagnosis::{Code, Diagnostic};

/// The findings that stand beside an answer of the program.
pub fn of_measuring(findings: &[Diagnostic]) -> Vec<Diagnostic> {
    findings.iter().filter(|finding| !is_conclusion(finding.code)).copied().collect()
}

/// True for what a rig concludes from its layout and its readings.
fn is_conclusion(code: Code) -> bool {
    is_about_the_layout(code) || is_about_the_answer(code)
}

/// What layout and hits determine, and whether the readings fit it.
fn is_about_the_layout(code: Code) -> bool {
    matches!(
        code,
        Code::FewerThanThreeSensors
            | Code::SensorsCollinear
            | Code::ResponseRankDeficient
            | Code::FewerThanThreeHits
            | Code::HitsAllParallel
            | Code::HitsConcurrent
            | Code::HitsThroughCentreOfMass
            | Code::TenParametersNotIdentifiable
            | Code::TwoSensorsOnOneNode
            | Code::LayoutNotFinite
            | Code::GravityNotGiven
            | Code::MotionNotRigid
            | Code::NotReciprocal
    )
}

/// How the ten properties came out.
fn is_about_the_answer(code: Code) -> bool {
    matches!(
        code,
        Code::TooFewHitsForSigma
            | Code::SigmaCoversScatterOnly
            | Code::NotPhysicallyConsistent
            | Code::IllConditioned
            | Code::DataInconsistentWithBudget
            | Code::LargeSensorPull
            | Code::LargeHitPull
            | Code::HeldToConsistency
            | Code::NotConverged
            | Code::AttachedTooHeavy
            | Code::MassNotPositive
            | Code::PriorInconsistentWithData
            | Code::HitsScatterMuch
            | Code::ScatterNotLearned
            | Code::ScaleNotLearned
            | Code::MovesWithBand
            | Code::ChannelNotLinear
            | Code::HammerInResponse
            | Code::MultiplexerKeepsVoltage
    )
}

#[cfg(test)]
mod tests {
    use massline_shared::diagnosis::Severity;

    use super::*;

    #[test]
    fn what_was_measured_stands_and_what_was_concluded_does_not() {
        let warning = |code| Diagnostic::whole(code, Severity::Warning, 1.0);
        let measured =
            [Code::NoPlateau, Code::SuspensionInBand, Code::DofSkipped, Code::HitsDisagree];
        let concluded = [Code::MotionNotRigid, Code::NotConverged, Code::ScaleNotLearned];
        let warnings: Vec<_> = measured.into_iter().chain(concluded).map(warning).collect();
        assert_eq!(of_measuring(&warnings), measured.map(warning));
    }
}
