//! Things of the solvers by their stable names.

use std::borrow::Cow;
use std::fmt;
use std::ops::Deref;

use massline_shared::diagnosis::Severity;
use massline_shared::identify::Method;
use massline_shared::identify::agreement::Outcome;
use massline_shared::layout::{FrfEstimator, TestProfile};
use massline_shared::mass_line::Terms;
use serde::de::{self, Deserialize, Deserializer};
use serde::{Serialize, Serializer};

/// One of a few things, written as its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NamedValue<T>(pub T);

/// A type whose values all have a name.
pub trait HasNames: Copy + 'static {
    /// What one of them is, for an error.
    const WHAT: &'static str;
    /// All of them.
    const ALL: &'static [Self];
    /// The name of one.
    fn name_of(self) -> &'static str;
}

macro_rules! has_names {
    ($($type:ty: $kind:literal, $values:expr;)*) => {
        $(impl HasNames for $type {
            const WHAT: &'static str = $kind;
            const ALL: &'static [Self] = &$values;

            fn name_of(self) -> &'static str {
                self.name()
            }
        })*
    };
}

has_names! {
    Method: "method", Method::ALL;
    Severity: "severity", [Severity::Note, Severity::Warning, Severity::Error];
    Outcome: "agreement_outcome", Outcome::ALL;
    TestProfile: "test_profile", TestProfile::ALL;
    Terms: "mass_line_terms", Terms::ALL;
    FrfEstimator: "frf_estimator", FrfEstimator::ALL;
}

impl<T> From<T> for NamedValue<T> {
    fn from(value: T) -> Self {
        Self(value)
    }
}

impl<T> Deref for NamedValue<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: PartialEq> PartialEq<T> for NamedValue<T> {
    fn eq(&self, other: &T) -> bool {
        self.0 == *other
    }
}

impl<T: HasNames> fmt::Display for NamedValue<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.0.name_of())
    }
}

impl<T: HasNames> Serialize for NamedValue<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.name_of())
    }
}

impl<'de, T: HasNames> Deserialize<'de> for NamedValue<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = Cow::<str>::deserialize(deserializer)?;
        let value = T::ALL.iter().find(|value| value.name_of() == name);
        value.copied().map(Self).ok_or_else(|| {
            let names: Vec<&str> = T::ALL.iter().map(|value| value.name_of()).collect();
            de::Error::custom(format_args!("\"{name}\" is not one of {}", names.join(", ")))
        })
    }
}
