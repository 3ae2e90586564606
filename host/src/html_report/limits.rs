//! What limits an answer, and what to do next time.

use massline_shared::body::RigidBody;
use massline_shared::design::{ErrorSource, Part};
use massline_shared::identify::maximum_likelihood::BudgetScales;

use super::answer::words;
use crate::design::DesignReport;
use crate::export::Exported;
use crate::picture::Source;

/// Sources of error with a smaller share are not named.
const MIN_SHARE: f64 = 0.1;
/// An improvement by less than this share of the whole is not worth a sentence.
const WORTH: f64 = 0.05;

/// The sources of error of an answer, by the Cramér-Rao bound for the body that was found, and advice.
#[derive(Default)]
pub(super) struct Limits {
    parts: Vec<Part<f64>>,
    /// What the uncertainty of the ten properties together comes from.
    pub sources: Vec<String>,
    /// What would help most next time.
    pub advice: Vec<String>,
}

impl Limits {
    /// The limits of an answer from mass lines; nothing where the layout file is not known, or where the answer comes from
    /// suspension modes, whose bound is another.
    pub fn of(source: &Source, answer: &Exported) -> Self {
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
        let share = |part: &Part<f64>| (part.source, part.share);
        let sources = largest(design.parts.iter().map(share), usize::MAX);
        let now = design.predicted.map(|predicted| predicted.total_percent_of_scale);
        let mut advice = Vec::new();
        if let (Some(now), Some(found)) = (now, &design.advice) {
            let worth = |then: f64| then < now * (1.0 - WORTH);
            if let Some((dof, then)) = found.further_hit.filter(|(_, then)| worth(*then)) {
                advice.push(format!(
                    "A further hit DOF helps most at {dof}: {now:.2} % of scale over all ten becomes {then:.2} %."
                ));
            }
            if let Some((node, then)) = found.further_sensor.filter(|(_, then)| worth(*then)) {
                advice.push(format!(
                    "A further sensor helps most at node {node}: {now:.2} % becomes {then:.2} %."
                ));
            }
        }
        if let Some((source, _)) = design.parts.iter().map(share).max_by(|a, b| a.1.total_cmp(&b.1))
        {
            advice.push(remedy(source).into());
        }
        Self { parts: design.parts, sources, advice }
    }

    /// The two largest sources of a property's uncertainty.
    pub fn mostly(&self, property: usize) -> String {
        largest(self.parts.iter().map(|part| (part.source, part.shares[property])), 2).join(", ")
    }
}

/// What the answer has learned about its error budget.
fn learned(source: &Source) -> Option<BudgetScales<f64>> {
    let of = &source.best_entry()["learned_budget"];
    Some(BudgetScales {
        hit_position: of["hit_position_scale"].as_f64()?,
        hit_direction: of["hit_direction_scale"].as_f64()?,
        constant: of["constant_scale"].as_f64()?,
    })
}

/// The sources with the largest shares, in words.
fn largest(shares: impl Iterator<Item = (ErrorSource, f64)>, count: usize) -> Vec<String> {
    let mut shares: Vec<_> = shares.filter(|(_, share)| *share >= MIN_SHARE).collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1));
    let sentence = |(source, share): &(ErrorSource, f64)| {
        format!("{} {:.0} %", source.name().replace('_', " "), 100.0 * share)
    };
    shares.iter().take(count).map(sentence).collect()
}

/// The standard deviation of an accelerance of one hit relative to 1/m, as measured.
fn noise(source: &Source, body: &RigidBody<f64>) -> f64 {
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
pub(super) fn unseen(source: &Source) -> Vec<String> {
    let all = super::answer::list(&source.document()["cannot_see"]);
    all.iter().map(|of| words(&of["message"])).collect()
}
