//! What limits an answer, and what to do next time.

use massline_shared::body::RigidBody;
use massline_shared::design::{ErrorSource, Part};
use massline_shared::identify::maximum_likelihood::BudgetScales;

use super::values::{Sentence, list, words};
use crate::design::DesignReport;
use crate::design::report::{advice_text, most};
use crate::export::Exported;
use crate::result_file::ResultFile;

/// The sources of error of an answer, by the Cramér-Rao bound for the body that was found, and advice.
#[derive(Default)]
pub(super) struct Limits {
    parts: Vec<Part<f64>>,
    /// What the uncertainty of the ten properties together comes from.
    pub sources: String,
    /// What would help most next time.
    pub advice: Vec<Sentence>,
}

impl Limits {
    /// The limits of an answer from mass lines; nothing where the layout file is not known, or where the answer comes from
    /// suspension modes, whose bound is another.
    pub fn of(source: &ResultFile, answer: &Exported) -> Self {
        let Some(file) = source.layout_file() else { return Self::default() };
        if source.document()["suspension"].is_object() {
            return Self::default();
        }
        let body: RigidBody<f64> = answer.body;
        let mut file = file.clone();
        if let Some(scales) = learned(source) {
            scales.apply_to(&mut file.layout);
        }
        let file = &file;
        let design = DesignReport::of_body(
            file,
            body,
            "the body that was found".into(),
            noise(source, &body),
        );
        let most_of_all = most(&design.parts, |part| part.share, usize::MAX);
        let mut advice = Vec::new();
        if let (Some(predicted), Some(found)) = (design.predicted, &design.advice) {
            advice.push(format!(
                "the ten properties together are known to {:.3} % of scale (root mean square of 1 sd)",
                predicted.total_percent_of_scale
            ));
            advice.extend(advice_text(found, file).lines().map(str::to_owned));
        }
        let largest = design.parts.iter().max_by(|a, b| a.share.total_cmp(&b.share));
        advice.extend(largest.map(|part| remedy(part.source).to_owned()));
        let advice = advice.into_iter().map(Sentence).collect();
        Self { parts: design.parts, sources: most_of_all, advice }
    }

    /// The two largest sources of a property's uncertainty.
    pub fn mostly(&self, property: usize) -> String {
        most(&self.parts, |part| part.shares[property], 2).replace(" %", "\u{a0}%")
    }
}

/// What the answer has learned about its error budget.
fn learned(source: &ResultFile) -> Option<BudgetScales<f64>> {
    let of = &source.best_entry()["learned_budget"];
    Some(BudgetScales {
        hit_position: of["hit_position_scale"].as_f64()?,
        hit_direction: of["hit_direction_scale"].as_f64()?,
        constant: of["constant_scale"].as_f64()?,
    })
}

/// The standard deviation of an accelerance of one hit relative to 1/m, as measured.
fn noise(source: &ResultFile, body: &RigidBody<f64>) -> f64 {
    let Some(archive) = source.archive() else { return massline_shared::design::DEFAULT_NOISE };
    let sensors = archive.layout.resolved.sensors.len();
    let squares = archive.result.dofs.iter().flat_map(|dof| {
        let responses = dof.noise.iter().take(3 * sensors);
        responses.map(|noise| f64::from(*noise).powi(2) * f64::from(dof.hits))
    });
    let squares: Vec<f64> = squares.collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    mean.sqrt() * body.mass
}

/// What to do against a source of error.
fn remedy(source: ErrorSource) -> &'static str {
    match source {
        ErrorSource::Noise => "Noise limits most: hit harder, more often, or with a wider band.",
        ErrorSource::HitPosition => {
            "Where the hammer lands limits most: mark the points, hit more often, or guide the hammer."
        }
        ErrorSource::HitDirection => {
            "The tilt of the hammer limits most: hit faces that are square to the direction, and more often."
        }
        ErrorSource::Marks => {
            "The marks limit most: measure where they are, and state node_position_m."
        }
        ErrorSource::Gain => {
            "The gains of the sensors limit most: calibrate them with `massline calibrate`."
        }
        ErrorSource::CrossAxis => {
            "Cross-axis sensitivities limit most: calibrate the sensors with `massline calibrate tumble`."
        }
        ErrorSource::SensorRotation => {
            "How the sensors are turned limits most: mount them against an edge, and state sensor_rotation_rad."
        }
        ErrorSource::SensorPosition => {
            "Where the sensors sit limits most: measure it, and state sensor_position_m."
        }
        ErrorSource::HammerGain => {
            "The hammer's gain limits most: calibrate it with a block of known mass (`massline calibrate block`), or weigh \
             the object and state the mass in [prior]."
        }
        ErrorSource::Attached => "The mass of attached bodies limits most: weigh them again.",
        ErrorSource::Priors => {
            "What was known before limits most: state [prior] more precisely, or leave it out."
        }
    }
}

/// What the test cannot see, in sentences.
pub(super) fn unseen(source: &ResultFile) -> Vec<Sentence> {
    let all = list(&source.document()["cannot_see"]);
    all.iter().map(|of| Sentence(words(&of["message"]))).collect()
}
