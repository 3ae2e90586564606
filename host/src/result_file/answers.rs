//! The answers in a document, what it says about them together, and about their intervals.

use std::collections::BTreeMap;

use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::diagnosis::Code;
use serde::Deserialize;
use serde_json::Value;

use super::ResultFile;
use crate::error::{Error, Result};
use crate::export::{Exported, answers_of_value, best_entry};

/// The combined answer of several methods: the ten properties, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Combined {
    /// The values.
    pub theta: [f64; 10],
    /// Their standard deviations.
    pub sigma: [f64; 10],
    /// Half the widths of their 95 % intervals.
    pub half_widths: [f64; 10],
}

/// The same as a document has it: by the names of the properties.
#[derive(Deserialize)]
struct Stored {
    value: BTreeMap<String, f64>,
    sigma: BTreeMap<String, f64>,
    half_width95: BTreeMap<String, f64>,
}

impl Stored {
    fn in_order(&self) -> Option<Combined> {
        let ten = |of: &BTreeMap<String, f64>| {
            let values =
                INERTIAL_PARAMETERS.iter().map(|parameter| of.get(parameter.name).copied());
            values.collect::<Option<Vec<f64>>>()?.try_into().ok()
        };
        Some(Combined {
            theta: ten(&self.value)?,
            sigma: ten(&self.sigma)?,
            half_widths: ten(&self.half_width95)?,
        })
    }
}

impl ResultFile {
    /// The answers of all methods, the best first; none in the output of `massline modes`.
    ///
    /// # Errors
    /// When an answer is malformed.
    pub fn answers(&self) -> Result<Vec<Exported>> {
        if self.document.get("results").is_none() && self.modes()?.is_some() {
            return Ok(Vec::new());
        }
        answers_of_value(&self.document, &self.name)
    }

    /// The best answer; `None` without one.
    ///
    /// # Errors
    /// When an answer is malformed.
    pub fn best(&self) -> Result<Option<Exported>> {
        Ok(self.answers()?.into_iter().next())
    }

    /// The best answer as it stands in the document; null without one.
    pub fn best_entry(&self) -> &Value {
        best_entry(&self.document)
    }

    /// The combined answer of all methods, where the document has one.
    ///
    /// # Errors
    /// Exit 2 when it is malformed.
    pub fn combined(&self) -> Result<Option<Combined>> {
        let stored: Option<Stored> =
            self.part(&self.document["agreement"], "agreement", "combined")?;
        let Some(stored) = stored else { return Ok(None) };
        stored.in_order().map(Some).ok_or_else(|| {
            let text =
                format!("{}: combined of the agreement lacks one of the ten properties", self.name);
            Error::input("result_malformed", text)
        })
    }

    /// Whether the interval of a method's answer covers the scatter between hits only, as its findings say.
    pub fn covers_scatter_only(&self, method: &str) -> bool {
        let code = Code::SigmaCoversScatterOnly.name();
        let of_method = |entry: &&Value| entry["method"] == method;
        let says = |entry: &Value| {
            let found = entry["diagnostics"].as_array();
            found.is_some_and(|found| found.iter().any(|finding| finding["code"] == code))
        };
        // Where the host has solved the test again, its answers are shown.
        let lists = [&self.document["host"]["results"], &self.document["results"]];
        let entries = lists.into_iter().filter_map(Value::as_array).flatten();
        entries.filter(of_method).any(says)
    }
}
