//! The offline solver: computes the ten properties in double precision from a layout and the frequency
//! responses of a universal file.
//!
//! The file must hold one frequency response function for every sensor axis and hit of the layout. A mass
//! line is fitted to its accelerance with equal weights over the band and passed to [`identification`] as the
//! average of as many hits as `[test]` asks for. A function that is stored for the opposite direction is
//! negated.
//!
//! [`identification`]: crate::identification

mod frfs;

use std::path::Path;

use massline_shared::Responses;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics};
use massline_shared::identify::inertia_restraint;
use massline_shared::identify::{
    Applicability, DofMassLines, Estimate, IdentifySettings, MassLines, Method, Observable,
    Observations,
};
use massline_shared::layout::{HOST_SENSORS, HostLayout, assumed_body};
use nalgebra::{SVector, Vector3};
use serde_json::{Value, json};

use crate::identification::{Identification, Selection, identify};
use crate::layout_file::{LayoutFile, Reference};
use crate::report::{self, Truth, message_in};
use crate::single_fault::{Examination, NominalTest};
use crate::uff::{Quantity, UffFile};
use crate::{Error, Result};
use frfs::{FittedLines, LayoutResponses};

/// The point about which the equations are set up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReferencePoint {
    /// The mean of the sensor positions, which gives the least noise.
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// The point about which the equations are set up.
    pub reference_point: ReferencePoint,
    /// The quantity of the responses; overrides what the file states. `None` takes it from the file.
    pub quantity: Option<Quantity>,
    /// The selected methods.
    pub selection: Selection,
    /// σ of the exponential window that was applied to force and responses, 1/s; 0 for no window.
    pub decay: f64,
}

/// The answer of the offline solver.
#[derive(Clone, Debug, PartialEq)]
pub struct FrfSolution {
    /// The answers of all methods, and the nuisance parameters of the fit.
    pub identification: Identification,
    /// The search for a single mistake that explains data that contradict the layout.
    pub examination: Examination,
    /// Mass line accelerances, (m/s²)/N: hit by hit, channel by channel (sensor 1 x, y, z, …).
    pub mass_lines: Vec<Vec<f64>>,
    /// Standard deviations of the mass lines, estimated from the scatter of the bins about the model,
    /// (m/s²)/N, in the same order.
    pub noise: Vec<Vec<f64>>,
    /// The point about which the equations were set up.
    pub reference_point: ReferencePoint,
    /// Band of the mass lines, Hz.
    pub band_hz: [f64; 2],
    /// Diagnostics of the mass lines.
    pub diagnostics: Vec<Diagnostic>,
    /// Hash of the layout, when the layout fits a rig.
    pub layout_hash: Option<u32>,
    /// Expected values to compare with.
    pub truth: Option<Truth>,
    /// Which body the layout was checked with, and how the file was read.
    pub notes: Vec<String>,
    layout: HostLayout,
}

/// Solves a layout file with a universal file.
///
/// # Errors
/// As [`solve`], and exit 2 when a file cannot be read.
pub fn solve_files(layout: &Path, frfs: &Path, options: &Options) -> Result<FrfSolution> {
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
/// Exit 2 for a function that is missing, duplicated, not finite, or of wrong type or units; exit 3 when
/// layout or data cannot determine the ten properties.
pub fn solve(file: &LayoutFile, uff: &UffFile, options: &Options) -> Result<FrfSolution> {
    let layout = &file.layout;
    let (body, about_body) = body_for_checks(file);
    let message_of = |d: &Diagnostic| message_in(d, layout);
    let checked = Applicability::new(layout, &body, &options.selection.methods());
    if let Some(error) = first_error(&checked.diagnostics, message_of) {
        return Err(match error {
            Error::Undetermined { code, message } => {
                Error::undetermined(code, format!("{message} ({about_body})"))
            }
            other => other,
        });
    }
    let responses = LayoutResponses::of(layout, uff, options.quantity)?;
    let FittedLines { lines, band_hz, diagnostics } =
        responses.mass_lines(layout, options.decay)?;
    let reference = match options.reference_point {
        ReferencePoint::Centroid => inertia_restraint::ReferencePoint::Centroid,
        ReferencePoint::Origin => inertia_restraint::ReferencePoint::Origin,
    };
    let settings =
        IdentifySettings { inertia_restraint: reference.into(), ..IdentifySettings::default() };
    let nominal = NominalTest::of_file(file);
    let examination = nominal.examine(&lines);
    let said = |found: Diagnostics| {
        let error = first_error(&found, message_of).unwrap_or_else(undetermined);
        blame_the_responses(error, &examination, layout)
    };
    let observed = Observations::of_mass_lines(layout, &lines);
    let identification = if wants_spectral_lines(options.selection) {
        let bins_of_band = responses.spectrum_bins(layout, band_hz, options.decay)?;
        let spectrum_bins = bins_of_band.responses()?;
        let observed = Observations { layout, mass_lines: &lines, spectrum_bins };
        identify(&observed, options.selection, &settings)
    } else {
        identify(&observed, options.selection, &settings)
    };
    let identification = identification
        .answered()
        .map_err(|found| not_settled(options.selection, &found).unwrap_or_else(|| said(found)))?;
    let channels = 3 * layout.sensors.len();
    let truth = file.reference.map(|reference| Truth {
        properties: reference.properties(),
        length: layout.characteristic_length(),
    });
    let mut notes = uff.notes.clone();
    notes.push(about_body);
    Ok(FrfSolution {
        identification,
        examination,
        mass_lines: by_hit(&lines, channels, |lines| &lines.accelerance),
        noise: by_hit(&lines, channels, |lines| &lines.noise),
        reference_point: options.reference_point,
        band_hz,
        diagnostics,
        layout_hash: file.hash(),
        truth,
        notes,
        layout: layout.clone(),
    })
}

/// True when a selected method works on bins rather than on mass lines.
fn wants_spectral_lines(selection: Selection) -> bool {
    selection.methods().iter().any(|method| method.entry().observes == Observable::SpectrumBins)
}

/// The body that a layout is checked with, and a sentence that names its origin: what `[reference]` states,
/// for the rest the mass of `[prior]` or 1 kg, near the centroid of the nodes, with the inertia `m L² I`.
pub fn body_for_checks(file: &LayoutFile) -> (RigidBody<f64>, String) {
    let none = Reference { mass_kg: None, center_of_mass_m: None, inertia_kg_m2: None };
    let reference = file.reference.unwrap_or(none);
    if let Some(ten) = reference.complete() {
        let body = RigidBody::from_theta(&SVector::from(ten));
        return (body, "the layout was checked with the body of [reference]".into());
    }
    let prior = file.layout.priors.iter().find(|p| p.property == 0).map(|known| known.value);
    let mass = reference.mass_kg.or(prior);
    let nodes = file.nodes.iter().map(|node| node.position);
    let mut body = assumed_body(mass, nodes);
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
        None => "an assumed centre of mass near the centroid of the nodes",
    };
    let text = format!(
        "the layout was checked with {mass_from}, {center_from} and an assumed inertia m L² I, L being the \
         extent of the nodes; give [reference] to check it with the body itself"
    );
    (body, text)
}

/// The errors among `found` as one error with the messages that `say` returns and the code of the first;
/// `None` when there is none.
pub(crate) fn first_error(
    found: &[Diagnostic],
    message_of: impl Fn(&Diagnostic) -> String,
) -> Option<Error> {
    let errors: Vec<&Diagnostic> = found.iter().filter(|d| d.is_error()).collect();
    let first = errors.first()?;
    let text = errors.iter().map(|d| message_of(d)).collect::<Vec<_>>().join("; ");
    let code = report::code_name(first);
    Some(match first.code {
        Code::TwoSensorsOnOneNode
        | Code::UnknownNode
        | Code::AxesNotOrthonormal
        | Code::LayoutNotFinite
        | Code::SettingOutOfRange
        | Code::HitNotInLayout
        | Code::DataNotFinite
        | Code::FrfMissing
        | Code::BandTooNarrow => Error::input(code, text),
        _ => Error::undetermined(code, text),
    })
}

/// A quantity of the channels in use, grouped by hit.
fn by_hit(
    lines: &[DofMassLines<f64, HOST_SENSORS>],
    channels: usize,
    quantity: fn(&MassLines<f64, HOST_SENSORS>) -> &Responses<f64, HOST_SENSORS>,
) -> Vec<Vec<f64>> {
    lines.iter().map(|(_, hit)| quantity(hit).iter().take(channels).copied().collect()).collect()
}

fn undetermined() -> Error {
    Error::undetermined("no_answer", "the data do not determine the ten properties")
}

impl FrfSolution {
    /// The best method's answer.
    pub fn answer(&self) -> Option<&Estimate<f64>> {
        self.identification.estimates.first()
    }

    /// The JSON object of the solution, in the form of all results.
    pub fn to_json(&self) -> Value {
        let lines = self.layout.hits.iter().zip(&self.mass_lines).zip(&self.noise);
        let said = [self.identification.warnings(), self.diagnostics.clone()].concat();
        let mut value = json!({
            "results": self.identification.results_json(),
            "not_applicable": self.identification.not_applicable_json(&self.layout),
            "details": self.identification.details_json(&self.layout),
            "layout_hash": self.layout_hash,
            "calibration": null,
            "firmware": null,
            "reference_point": self.reference_point.name(),
            "band_hz": self.band_hz,
            "band_automatic": self.layout.test.band_hz.is_none(),
            // `null`, because the file already holds frequency responses.
            "frf_estimator": null,
            "terms": self.layout.test.terms.name(),
            "mass_lines": lines.map(|((hit, lines), noise)| json!({
                "dof": hit.dof.to_string(),
                "accelerance_m_per_s2_per_n": lines,
                "noise_m_per_s2_per_n": noise,
            })).collect::<Vec<_>>(),
            "notes": self.notes,
            "diagnostics": report::diagnostics_json(&said, |d| message_in(d, &self.layout)),
        });
        self.examination.add_to(&mut value, &self.layout);
        value["cannot_see"] = report::cannot_see_json(&self.cannot_see());
        value
    }

    /// The solution as text.
    pub fn to_text(&self) -> String {
        let [low, high] = self.band_hz.map(|end| (end * 10.0).round() / 10.0);
        let mut text = self.identification.to_text(&self.layout, self.truth.as_ref());
        text += &self.examination.to_text(&self.layout);
        text += &format!(
            "mass lines ({}) over {low} to {high} Hz{}, equal weights; linear equations about the {}\n",
            self.layout.test.terms.name(),
            if self.layout.test.band_hz.is_none() { ", found from the responses" } else { "" },
            self.reference_point.name()
        );
        text += &report::sentences(&self.diagnostics, |d| message_in(d, &self.layout));
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text + &report::cannot_see_text(&self.cannot_see())
    }

    fn cannot_see(&self) -> Vec<report::Unseen> {
        report::cannot_see(&self.layout, self.answer().map(|answer| &answer.body))
    }
}

/// The error of a global fit whose suspension parameters diverge. This is not evidence against the responses:
/// they may hardly show the suspension, or contain placement and gain errors, which that model does not have.
fn not_settled(selection: Selection, found: &[Diagnostic]) -> Option<Error> {
    let code = Code::NotConverged;
    let ran_away = found.iter().any(|d| d.code == code);
    (selection == Selection::Only(Method::GlobalFit) && ran_away).then(|| {
        let text = "the global fit did not converge: the stiffness of its suspension diverged, because \
                    these responses hardly show a suspension or are wrong by more than noise \
                    (placement, gains), which this method does not know; leave out --method, then \
                    maximum likelihood answers, or let test.band_hz begin nearer to the suspension modes";
        Error::undetermined(code.name(), text)
    })
}

/// Adds to `error` that the layout alone is sound, so that frequency responses must be missing or wrong.
fn blame_the_responses(error: Error, examination: &Examination, layout: &HostLayout) -> Error {
    match error {
        Error::Undetermined { code, message } => {
            let mistakes = examination.to_text(layout);
            let mistakes = mistakes.trim_end().replace('\n', "; ");
            Error::undetermined(
                code,
                format!(
                    "the layout is good but its frequency responses are not: {message}; check that \
                     the file holds this object's responses and what quantity they are \
                     (--quantity); {mistakes}"
                ),
            )
        }
        other => other,
    }
}

#[cfg(test)]
mod tests;
