//! The offline solver: a layout and the frequency responses of a universal file give the ten
//! properties, in double precision.
//!
//! For every sensor axis and hit of the layout the file must hold one frequency response function.
//! Its accelerance is fitted by a mass line with equal weights over the band; the inertia restraint
//! method takes it from there. A function that is stored with an opposite direction is used negated.

mod frfs;

use std::path::Path;

use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::{Method, inertia_restraint};
use massline_shared::layout::{LayoutReport, assumed_body};
use massline_shared::real::Real;
use nalgebra::{SVector, Vector3};
use serde_json::{Value, json};

use crate::layout_file::{LayoutFile, Reference};
use crate::report::{self, Answer, Truth, diagnostics_json, message_in};
use crate::uff::{Quantity, UffFile};
use crate::{Error, Result};

/// The point about which the equations are set up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReferencePoint {
    /// The mean of the sensor positions: the least noise.
    #[default]
    Centroid,
    /// The origin of the body frame.
    Origin,
}

impl ReferencePoint {
    /// The name in options and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Centroid => "centroid",
            Self::Origin => "origin",
        }
    }
}

/// How to solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// The point about which the equations are set up.
    pub reference_point: ReferencePoint,
    /// What the responses are, when the file does not say so or is wrong.
    pub quantity: Option<Quantity>,
}

/// What the offline solver answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// The ten.
    pub answer: Answer,
    /// Mass line accelerances, (m/s²)/N: hit by hit, channel by channel (sensor 1 x, y, z, …).
    pub mass_lines: Vec<Vec<f64>>,
    /// The point about which the equations were set up.
    pub reference_point: ReferencePoint,
    /// Band of the mass lines, Hz.
    pub band_hz: [f64; 2],
    /// Hash of the layout, when it fits a rig.
    pub layout_hash: Option<u32>,
    /// Expected values to compare with.
    pub truth: Option<Truth>,
    /// What the layout was checked with and what the file was read with.
    pub notes: Vec<String>,
    hits: Vec<String>,
}

/// Solves a layout file with a universal file.
///
/// # Errors
/// As [`solve`], and exit 2 when a file cannot be read.
pub fn solve_files(layout: &Path, frfs: &Path, options: &Options) -> Result<Solution> {
    let file = LayoutFile::read(layout)?;
    let uff = UffFile::read(frfs)?;
    solve(&file, &uff, options).map_err(|error| match error {
        Error::Undetermined { .. } => error.within(layout.display()),
        other => other.within(frfs.display()),
    })
}

/// Solves a layout with frequency responses.
///
/// # Errors
/// Exit 2 for a function that is missing, doubled, not finite, or of wrong type or units; exit 3 when
/// layout or data cannot determine the ten.
pub fn solve(file: &LayoutFile, uff: &UffFile, options: &Options) -> Result<Solution> {
    let layout = &file.layout;
    let (body, about_body) = body_for_checks(file);
    let say = |d: &Diagnostic| message_in(d, layout);
    let checked = LayoutReport::new(layout, Some(&body));
    if let Some(error) = first_error(&checked.diagnostics, say) {
        return Err(match error {
            Error::Undetermined { code, message } => {
                Error::undetermined(code, format!("{message} ({about_body})"))
            }
            other => other,
        });
    }
    let lines = frfs::mass_lines(layout, uff, options.quantity)?;
    let reference = match options.reference_point {
        ReferencePoint::Centroid => inertia_restraint::ReferencePoint::Centroid,
        ReferencePoint::Origin => inertia_restraint::ReferencePoint::Origin,
    };
    let estimate = inertia_restraint::solve(layout, lines.iter().enumerate(), reference)
        .map_err(|found| first_error(&found, say).unwrap_or_else(undetermined))
        .map_err(blame_the_responses)?;
    let channels = 3 * layout.sensors.len();
    let truth = file.reference.map(|reference| Truth {
        properties: reference.properties(),
        length: layout.characteristic_length(),
    });
    let mut notes = uff.notes.clone();
    notes.push(about_body);
    Ok(Solution {
        answer: Answer {
            method: Method::InertiaRestraint.name(),
            body: estimate.body,
            covariance: estimate.covariance,
            condition: estimate.condition.to_f64(),
            diagnostics: estimate.diagnostics.to_vec(),
        },
        mass_lines: lines
            .iter()
            .map(|l| l.accelerance.iter().take(channels).copied().collect())
            .collect(),
        reference_point: options.reference_point,
        band_hz: layout.test.band_hz,
        layout_hash: file.hash(),
        truth,
        notes,
        hits: layout.hits.iter().map(|hit| hit.dof.to_string()).collect(),
    })
}

/// The body that a layout is checked with, and a sentence that says where it comes from: `[reference]`
/// as far as it is given, else the mass of `[prior]` or 1 kg, the centroid of the nodes, `m L² I`.
pub fn body_for_checks(file: &LayoutFile) -> (RigidBody<f64>, String) {
    let none = Reference { mass_kg: None, center_of_mass_m: None, inertia_kg_m2: None };
    let reference = file.reference.unwrap_or(none);
    if let Some(ten) = reference.complete() {
        let body = RigidBody::from_theta(&SVector::from(ten));
        return (body, "the layout was checked with the body of [reference]".into());
    }
    let prior = file.prior_mass_kg.map(|known| known.value);
    let mass = reference.mass_kg.or(prior);
    let nodes = file.nodes.iter().map(|node| node.position);
    let mut body = assumed_body(&file.layout, mass, nodes);
    let mass_from = match (reference.mass_kg, prior) {
        (Some(_), _) => "the mass of [reference]",
        (None, Some(_)) => "the mass of [prior]",
        (None, None) => "an assumed mass of 1 kg",
    };
    let center_from = match reference.center_of_mass_m {
        Some(center) => {
            body.center_of_mass = Vector3::from(center);
            "the centre of mass of [reference]"
        }
        None => "an assumed centre of mass at the centroid of the nodes",
    };
    let text = format!(
        "the layout was checked with {mass_from}, {center_from} and an assumed inertia m L² I; give \
         [reference] to check it with the body itself"
    );
    (body, text)
}

/// The errors among `found` as one, in the words of `say`; the first says the code. `None` when
/// there is none.
pub(crate) fn first_error(
    found: &[Diagnostic],
    say: impl Fn(&Diagnostic) -> String,
) -> Option<Error> {
    let errors: Vec<&Diagnostic> = found.iter().filter(|d| d.is_error()).collect();
    let first = errors.first()?;
    let text = errors.iter().map(|d| say(d)).collect::<Vec<_>>().join("; ");
    let code = report::code_name(first);
    Some(match first.known_code() {
        Some(
            Code::TwoSensorsOnOneNode
            | Code::UnknownNode
            | Code::AxesNotOrthonormal
            | Code::LayoutNotFinite
            | Code::SettingOutOfRange
            | Code::DataNotFinite
            | Code::FrfMissing
            | Code::BandTooNarrow,
        ) => Error::input(code, text),
        _ => Error::undetermined(code, text),
    })
}

fn undetermined() -> Error {
    Error::undetermined("no_answer", "the data do not determine the ten properties")
}

impl Solution {
    /// One object, as all results are printed.
    pub fn to_json(&self) -> Value {
        json!({
            "results": [self.answer.to_json()],
            "layout_hash": self.layout_hash,
            "calibration": null,
            "firmware": null,
            "reference_point": self.reference_point.name(),
            "band_hz": self.band_hz,
            "mass_lines": self.hits.iter().zip(&self.mass_lines).map(|(dof, lines)| json!({
                "dof": dof,
                "accelerance_m_per_s2_per_n": lines,
            })).collect::<Vec<_>>(),
            "notes": self.notes,
            "diagnostics": diagnostics_json(&[], report::message),
        })
    }

    /// For people.
    pub fn to_text(&self) -> String {
        let [low, high] = self.band_hz;
        let mut text = report::table(&self.answer, self.truth.as_ref());
        text += &format!(
            "mass lines over {low} to {high} Hz, equal weights; equations about the {}\n",
            self.reference_point.name()
        );
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }
}

/// The layout alone is good: what is missing is missing in the frequency responses.
fn blame_the_responses(error: Error) -> Error {
    match error {
        Error::Undetermined { code, message } => Error::undetermined(
            code,
            format!(
                "the layout is good but its frequency responses are not: {message}; check that the \
                 file holds this object's responses and what quantity they are (--quantity)"
            ),
        ),
        other => other,
    }
}

#[cfg(test)]
mod tests;
