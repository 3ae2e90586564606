//! How the methods agree.

use serde::{Deserialize, Serialize};

use massline_shared::diagnosis::Code;
use massline_shared::identify::Method;
use massline_shared::identify::agreement::Outcome;

use crate::named::NamedValue;
use crate::properties::Properties;

/// What all methods say together on the same data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Agreement {
    /// `agree`; `some_off` where the others agree without a few methods; `differ`; `null` where that cannot be said.
    pub outcome: Option<NamedValue<Outcome>>,
    /// What puts all of them in doubt.
    pub doubt: Option<Doubt>,
    /// The methods that are off.
    pub off: Vec<NamedValue<Method>>,
    /// All of this as a sentence.
    #[serde(rename = "verdict")]
    pub sentence: String,
    /// The methods and their standard deviations from the changes that all of them share.
    pub methods: Vec<MethodSigma>,
    /// The combined answer.
    pub combined: Option<CombinedAnswer>,
    /// For every two methods the property in which they differ most.
    pub pairs: Vec<Pair>,
}

/// What puts answers off by more than they say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Doubt {
    /// A flexible mode above the band, which only the global fit takes into account.
    #[serde(rename = "flexible_mode_above_band")]
    FlexibleMode,
    /// No body on a suspension fits the responses.
    #[serde(rename = "model_does_not_fit")]
    Misfit,
}

impl Doubt {
    /// The code of the finding that it follows from.
    pub fn code(self) -> Code {
        match self {
            Self::FlexibleMode => Code::FlexibleModeAboveBand,
            Self::Misfit => Code::ModelDoesNotFit,
        }
    }
}

/// A method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MethodSigma {
    /// The method.
    pub method: NamedValue<Method>,
    /// Standard deviations of its answer.
    pub sigma: Option<Properties<f64>>,
}

/// The combined answer, by generalised least squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CombinedAnswer {
    /// The ten properties.
    pub value: Properties<f64>,
    /// Their standard deviations.
    pub sigma: Properties<f64>,
    /// Half the widths of their 95 % intervals.
    pub half_width95: Properties<f64>,
    /// Standard deviations between the methods that these contain.
    pub between_methods: Properties<f64>,
}

/// Two methods and the property in which they differ most.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Pair {
    /// The methods.
    pub methods: [Option<NamedValue<Method>>; 2],
    /// The property.
    pub property: String,
    /// The difference, in its SI unit.
    pub difference: f64,
    /// Standard deviation of the difference.
    pub sigma: f64,
    /// Whether noise alone would hardly make it.
    pub significant: bool,
}
