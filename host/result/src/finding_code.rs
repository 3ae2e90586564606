//! Stable names of what is found about a test.

use std::borrow::Cow;
use std::fmt;
use std::str::FromStr;

use massline_shared::diagnosis::Code;
use serde::de::{self, Deserialize, Deserializer};
use serde::{Serialize, Serializer};

/// How the name of a code begins that this program does not know; its number follows.
pub(crate) const UNKNOWN_PREFIX: &str = "code_";

macro_rules! finding_codes {
    ($($(#[$doc:meta])* $variant:ident = $name:literal;)*) => {
        /// What a finding is about: a code of the table that rigs and program share, or a fact that only the program
        /// knows. Written as its stable name.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum FindingCode {
            /// A code of the table.
            Diagnosed(Code),
            $($(#[$doc])* $variant,)*
        }

        impl FindingCode {
            /// The facts that only the program knows.
            pub(crate) const OF_PROGRAM: &[(Self, &str)] = &[$((Self::$variant, $name)),*];
        }
    };
}

finding_codes! {
    /// A better method has no answer from the same data.
    PreferredMethodFailed = "preferred_method_failed";
    /// The data contradict the layout and its error budget.
    Contradicted = "contradicted";
    /// One mistake explains the data.
    SingleMistake = "single_mistake";
    /// Methods differ by more than their uncertainties.
    MethodsDiffer = "methods_differ";
    /// One method differs from the others.
    MethodOff = "method_off";
    /// The uncertainty is not known.
    UncertaintyUnknown = "uncertainty_unknown";
    /// Responses of the file do not have the lines of the mass lines.
    LinesMissing = "lines_missing";
    /// The gain of the hammer limits the answer.
    HammerGainLimits = "hammer_gain_limits";
    /// The file states no unit; SI is assumed.
    UnitAssumed = "unit_assumed";
    /// The file states the unit of some responses only; SI is assumed for the others.
    UnitOfSomeResponses = "unit_of_some_responses";
    /// Two statements of the file about its units contradict each other.
    UnitContradicted = "unit_contradicted";
    /// The responses differ from what is expected by the factor between two units.
    UnitOfResponses = "unit_of_responses_suspected";
    /// Lengths, masses or inertias of the layout do not fit each other.
    UnitOfLayout = "unit_of_layout_suspected";
    /// A node lies elsewhere than the layout says, by a little.
    NodeMisplaced = "node_misplaced";
    /// The gain of the hammer drifts over the test.
    HammerDrifts = "hammer_drifts";
    /// The gain of a channel drifts over the test.
    ChannelDrifts = "channel_drifts";
    /// All hits at a DOF lean the same way.
    HitLeans = "hit_leans";
    /// All hits of the test are turned alike.
    HitsTurned = "hits_turned";
    /// The chips of the sensors lie above their marks.
    ChipsAboveMarks = "chips_above_marks";
    /// Each mark carries a mass while it is hit.
    MarksLoaded = "marks_loaded";
    /// The gain of a channel is another than the layout says.
    ChannelGainOff = "channel_gain_off";
    /// The axes of a sensor are turned.
    SensorTurned = "sensor_turned";
    /// The force at a DOF is another than the hammer says.
    HitForceOff = "hit_force_off";
    /// All forces are other than the hammer says.
    HammerGainOff = "hammer_gain_off";
    /// Products of inertia are expected with the opposite signs.
    SignsOfProducts = "signs_of_products_suspected";
}

impl From<Code> for FindingCode {
    fn from(code: Code) -> Self {
        Self::Diagnosed(code)
    }
}

impl PartialEq<Code> for FindingCode {
    fn eq(&self, code: &Code) -> bool {
        *self == Self::Diagnosed(*code)
    }
}

impl fmt::Display for FindingCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Diagnosed(code) => code.fmt(f),
            other => {
                let named = Self::OF_PROGRAM.iter().find(|(code, _)| code == other);
                f.pad(named.map_or("", |(_, name)| name))
            }
        }
    }
}

impl FromStr for FindingCode {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let of_table = || Code::ALL.iter().find(|code| code.name() == name).copied();
        let of_program = || {
            Self::OF_PROGRAM.iter().find(|(_, code_name)| *code_name == name).map(|(code, _)| *code)
        };
        let unknown = || {
            let number = name.strip_prefix(UNKNOWN_PREFIX)?.parse().ok()?;
            matches!(Code::from_number(number), Code::Unknown(_)).then_some(Code::Unknown(number))
        };
        of_table()
            .or_else(unknown)
            .map(Self::Diagnosed)
            .or_else(of_program)
            .ok_or_else(|| format!("\"{name}\" is no code of a finding that this program knows"))
    }
}

impl Serialize for FindingCode {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for FindingCode {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Cow::<str>::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_back_as_its_code() {
        let of_table = Code::ALL.iter().chain(&[Code::Unknown(999)]).map(|code| (*code).into());
        let of_program = FindingCode::OF_PROGRAM.iter().map(|(code, _)| *code);
        for code in of_table.chain(of_program) {
            assert_eq!(code.to_string().parse(), Ok(code), "{code}");
        }
    }

    #[test]
    fn a_name_that_is_none_is_refused() {
        for name in ["", "code_", "code_70000", "code_1", "Contradicted"] {
            assert!(name.parse::<FindingCode>().is_err(), "{name}");
        }
    }
}
