//! The verdict on a result.

use massline_shared::identify;
use serde::{Deserialize, Serialize};

/// Whether a result can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing puts the answer in doubt.
    Good,
    /// The answer can be used by somebody who has read the concerns.
    UseWithCare,
    /// The answer is contradicted, or belongs to no body.
    DoNotUse,
}

impl Verdict {
    /// Every verdict, the best first.
    pub const ALL: [Self; 3] = [Self::Good, Self::UseWithCare, Self::DoNotUse];

    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::UseWithCare => "use_with_care",
            Self::DoNotUse => "do_not_use",
        }
    }

    /// Its name for people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::UseWithCare => "use with care",
            Self::DoNotUse => "do not use",
        }
    }

    /// The verdict of this name in JSON.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| verdict.name() == name)
    }
}

impl From<identify::Verdict> for Verdict {
    fn from(verdict: identify::Verdict) -> Self {
        match verdict {
            identify::Verdict::Good => Self::Good,
            identify::Verdict::UseWithCare => Self::UseWithCare,
            identify::Verdict::DoNotUse => Self::DoNotUse,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_verdict_has_its_name_in_json() {
        for verdict in Verdict::ALL {
            assert_eq!(serde_json::json!(verdict), verdict.name());
            assert_eq!(Verdict::from_name(verdict.name()), Some(verdict));
        }
    }
}
