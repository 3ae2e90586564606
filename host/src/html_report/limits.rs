//! What limits an answer, and what to do next time.

use massline_shared::body::RigidBody;
use massline_shared::design::{DEFAULT_NOISE, ErrorSource, Part};
use massline_shared::identify::Method;
use massline_shared::identify::maximum_likelihood::{BudgetScales, LearnedBudget, LearnedFrom};
use massline_shared::layout::{Hit, HostLayout, TestProfile};
use massline_shared::signal::ringing_s;
use massline_virtual::bench::Bench;
use massline_virtual::bench::suspension::RigidMode;
use nalgebra::Vector6;
use serde::Deserialize;

use super::values::{Sentence, list, words};
use crate::design::report::{advice_text, most};
use crate::design::{DesignReport, LayoutCriterion};
use crate::document::{self, Mode};
use crate::error::Result;
use crate::export::Exported;
use crate::report::{CALIBRATE_HAMMER, hardly_shown, not_shown};
use crate::result_file::{ResultFile, ShownDof, ShownMassLine, ShownModes};

/// Why there are no shares of the sources of error.
const NO_SHARES: &str = "how much of the uncertainty comes from each source of error is not known: it is computed for tests \
                         by a rig in the suspension profile, whose records are known, from six modes and the layout file";

/// Bench with the converter of a test whose archive is not known.
const BENCH: &str = "ideal";

/// The sources of error of an answer, by the Cramér-Rao bound for the body that was found, and advice.
#[derive(Default)]
pub(super) struct Limits {
    parts: Vec<Part<f64>>,
    /// What the uncertainty of the ten properties together comes from; empty where nothing is known of it.
    pub sources: Sentence,
    /// What would help most next time.
    pub advice: Vec<Sentence>,
}

impl Limits {
    /// The limits of an answer; from mass lines, none where the layout file is not known.
    ///
    /// # Errors
    /// When the mass lines or the suspension modes of the result are malformed.
    pub fn of(source: &ResultFile, answer: &Exported) -> Result<Self> {
        let by_mass_lines = Method::of_mass_lines().any(|method| method.name() == answer.method);
        Ok(match source.modes()? {
            Some(modes) if !by_mass_lines => Self::of_modes(source, &modes, answer.body)?,
            _ => Self::of_mass_lines(source, answer.body)?,
        })
    }

    /// # Errors
    /// When the mass lines of the result are malformed.
    fn of_mass_lines(source: &ResultFile, body: RigidBody<f64>) -> Result<Self> {
        let (Some(file), Some(mut layout)) = (source.layout_file(), measured_layout(source)?)
        else {
            return Ok(Self::default());
        };
        if let Some(learned) = learned(source) {
            learned.apply_to(&mut layout);
        }
        let measured = noise(&source.mass_lines()?, &layout).map(|noise| noise * body.mass);
        let relative = measured.unwrap_or(DEFAULT_NOISE);
        let criterion = LayoutCriterion::of_mass_lines(body, &layout, relative);
        let design = DesignReport::of_test(file, &layout, criterion);
        Ok(Self::of_design(&design, &layout, measured.is_some()))
    }

    /// What a prediction for the test that was made says; from its own noise where that is known.
    fn of_design(design: &DesignReport, layout: &HostLayout, noise_is_known: bool) -> Self {
        let shares = most(&design.parts, |part| part.share, usize::MAX);
        let given = match noise_is_known {
            true => "with these data".to_owned(),
            false => format!("with this layout, assuming noise of {} %", 100.0 * DEFAULT_NOISE),
        };
        let mut advice = Vec::new();
        if let (Some(predicted), Some(found)) = (design.predicted, &design.advice) {
            advice.push(format!(
                "the ten properties together are known to {:.3} % of scale (root mean square of 1 sd)",
                predicted.total_percent_of_scale
            ));
            advice.extend(advice_text(found, layout).lines().map(str::to_owned));
        }
        let largest = design.parts.iter().max_by(|a, b| a.share.total_cmp(&b.share));
        advice.extend(largest.map(|part| remedy(part.source, layout.test.profile)));
        let sources = match shares.is_empty() {
            true => String::new(),
            false => format!(
                "the uncertainty of all ten together comes from: {shares} (shares of the variance that any method must \
                 have {given})"
            ),
        };
        let advice = advice.into_iter().map(Sentence).collect();
        Self { parts: design.parts.clone(), sources: Sentence(sources), advice }
    }

    /// The limits of an answer from suspension modes: the bound for the modes that were found, where it can be computed, and
    /// their Norm Indicators.
    ///
    /// # Errors
    /// When the lines of the result are malformed.
    fn of_modes(source: &ResultFile, modes: &ShownModes, body: RigidBody<f64>) -> Result<Self> {
        let mut limits = Self::of_bound(source, modes, body)?
            .unwrap_or_else(|| Self { sources: Sentence(NO_SHARES.into()), ..Self::default() });
        limits.advice.extend(shown_poorly(modes).into_iter().map(Sentence));
        Ok(limits)
    }

    /// The bound of six modes; `None` for fewer, for responses that no rig measured under the suspension profile, and where
    /// the layout file is not known.
    ///
    /// # Errors
    /// When the lines of the result are malformed.
    fn of_bound(
        source: &ResultFile,
        modes: &ShownModes,
        body: RigidBody<f64>,
    ) -> Result<Option<Self>> {
        let (Some(file), Some(layout)) = (source.layout_file(), measured_layout(source)?) else {
            return Ok(None);
        };
        // Of responses from a file, neither the window nor the length of the records is known.
        let is_of_rig = !list(&source.document()["lines"]).is_empty();
        let noise = modes.noise.filter(|noise| is_of_rig && noise.is_finite() && *noise > 0.0);
        let (Some(six), Some(noise), Some(record_s), TestProfile::Suspension) =
            (six_modes(modes), noise, record_s(source, &layout), layout.test.profile)
        else {
            return Ok(None);
        };
        let of_one_hit = noise * f64::from(layout.test.hits_per_dof.max(1)).sqrt();
        let relative = of_one_hit * body.mass;
        let criterion = LayoutCriterion::of_modes(body, &layout, relative, &six, record_s);
        let design = DesignReport::of_test(file, &layout, criterion);
        let limits = Self::of_design(&design, &layout, true);
        Ok((!limits.parts.is_empty()).then_some(limits))
    }

    /// True where nothing is known.
    pub fn is_empty(&self) -> bool {
        self.sources.0.is_empty() && self.advice.is_empty()
    }

    /// The two largest sources of a property's uncertainty.
    pub fn mostly(&self, property: usize) -> String {
        most(&self.parts, |part| part.shares[property], 2).replace(" %", "\u{a0}%")
    }
}

/// The layout in force with the hits that are in the answers; `None` where it is not known.
///
/// # Errors
/// When the lines of the result are malformed.
fn measured_layout(source: &ResultFile) -> Result<Option<HostLayout>> {
    let Some(layout) = source.layout_in_force() else { return Ok(None) };
    Ok(Some(as_measured(&layout, &source.measured_dofs()?)))
}

/// The layout with the hits that are in the answer, made as often as they were: what scatters from hit to hit is that of
/// so many. The whole layout where the measured DOFs are not known.
fn as_measured(layout: &HostLayout, measured: &[ShownDof]) -> HostLayout {
    let mut layout = layout.clone();
    if measured.is_empty() {
        return layout;
    }
    let wanted = f64::from(layout.test.hits_per_dof.max(1));
    layout.hits.retain_mut(|hit: &mut Hit<f64>| {
        let dof = hit.dof.to_string();
        let Some(of) = measured.iter().find(|of| of.dof == dof) else { return false };
        if let Some(hits) = of.hits {
            let factor = (wanted / f64::from(hits.max(1))).sqrt();
            hit.uncertainty.position *= factor;
            hit.uncertainty.direction *= factor;
        }
        true
    });
    layout
}

/// What the answer has learned about its error budget.
fn learned(source: &ResultFile) -> Option<LearnedBudget<f64>> {
    let of = &source.best_entry()["learned_budget"];
    let from = document::LearnedFrom::deserialize(&of["learned_from"]).unwrap_or_default();
    Some(LearnedBudget {
        scales: BudgetScales {
            hit_position: of["hit_position_scale"].as_f64()?,
            hit_direction: of["hit_direction_scale"].as_f64()?,
            constant: of["constant_scale"].as_f64()?,
        },
        learned_from: match from {
            document::LearnedFrom::RepeatHits => LearnedFrom::RepeatHits,
            document::LearnedFrom::Residuals => LearnedFrom::Residuals,
        },
        // Only the intervals of the answer depend on how certain this is.
        scatter_degrees_of_freedom: 0,
        constant_log_variance: 0.0,
        widening: [1.0; 10],
    })
}

/// The standard deviation of the accelerance of one hit, (m/s²)/N, that leaves the noise of the mass lines after as many
/// hits as the layout wants; `None` where no noise is known.
fn noise(lines: &[ShownMassLine], layout: &HostLayout) -> Option<f64> {
    let responses = 3 * layout.sensors.len();
    let averaged = lines.iter().flat_map(|line| line.noise.iter().take(responses)).flatten();
    let squares: Vec<f64> = averaged.map(|noise| noise.powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    let noise = (mean * f64::from(layout.test.hits_per_dof.max(1))).sqrt();
    (noise.is_finite() && noise > 0.0).then_some(noise)
}

/// The six modes of a test; `None` when there are others.
fn six_modes(modes: &ShownModes) -> Option<[RigidMode; 6]> {
    let mode = |of: &Mode| RigidMode {
        omega: std::f64::consts::TAU * of.frequency_hz.value,
        damping_ratio: of.damping_ratio.value.max(0.0),
        shape: Vector6::from(of.shape.value),
    };
    let all: Vec<RigidMode> = modes.modes.iter().map(mode).collect();
    all.try_into().ok()
}

/// How long the object has rung in a record, s: under the converter that the archive names, else under that of a bench, which
/// has the rate of every board.
fn record_s(source: &ResultFile, layout: &HostLayout) -> Option<f64> {
    let of_archive = source.archive().map(|archive| archive.rig.sampler.adc);
    let of_bench = || Some(Bench::named(BENCH).ok()?.converter(layout.sensors.len()));
    Some(ringing_s(&of_archive.or_else(of_bench)?))
}

/// The modes that the hits hardly show, and which hit would show them.
fn shown_poorly(modes: &ShownModes) -> Vec<String> {
    let better = (1..).zip(&modes.modes).filter_map(|(number, mode)| {
        let better = mode.better_hit.as_ref()?;
        Some(hardly_shown(number, better.shown, &better.dof))
    });
    let mut advice: Vec<String> = better.collect();
    if let (1.., Some(dof)) = (modes.missing, &modes.hit_for_missing) {
        advice.push(not_shown(modes.missing, dof));
    }
    if advice.is_empty() {
        advice.extend(least_shown(modes));
    }
    advice
}

/// The mode whose largest Norm Indicator is the least, where no other hit is worth making.
fn least_shown(modes: &ShownModes) -> Option<String> {
    let largest = modes.modes.iter().filter_map(|mode| {
        let shown = mode.norm_indicators.iter().max_by(|a, b| a.value.total_cmp(&b.value))?;
        Some((mode.frequency_hz.value, shown))
    });
    let (frequency, shown) = largest.min_by(|a, b| a.1.value.total_cmp(&b.1.value))?;
    Some(format!(
        "no other hit would show a mode much better; the mode that shows least is the one at {frequency:.2} Hz, whose \
         largest Norm Indicator is {:.3}, under hit {}",
        shown.value, shown.dof
    ))
}

/// What to do against a source of error.
fn remedy(source: ErrorSource, profile: TestProfile) -> String {
    let text = match source {
        ErrorSource::Noise if profile == TestProfile::Suspension => {
            "Noise limits most: hit with a larger impulse, or more often."
        }
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
            return format!("The hammer's gain limits most: {CALIBRATE_HAMMER}.");
        }
        ErrorSource::Converter => {
            "The nonlinearity of the converter limits most: hit harder, so that responses pass over more of its codes."
        }
        ErrorSource::Attached => "The mass of attached bodies limits most: weigh them again.",
        ErrorSource::HitGain => {
            "The force of the hits at one mark against another limits most: hit more often, and with one hammer tip."
        }
        ErrorSource::GravityDirection => {
            "How the object hangs limits most: level it, or state gravity as measured."
        }
        ErrorSource::Priors => {
            "What was known before limits most: state [prior] more precisely, or leave it out."
        }
    };
    text.to_owned()
}

/// What the test cannot see, in sentences.
pub(super) fn cannot_see(source: &ResultFile) -> Vec<Sentence> {
    let all = list(&source.document()["cannot_see"]);
    all.iter().map(|of| Sentence(words(&of["message"]))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout_file::LayoutFile;

    fn line(dof: &str, hits: Option<u8>, noise: f64) -> ShownMassLine {
        let noise = vec![Some(noise); 9];
        ShownMassLine { dof: dof.into(), hits, band_hz: None, coherence: None, noise }
    }

    #[test]
    fn hits_count_as_often_as_they_were_made_and_skipped_ones_not_at_all() {
        let text = include_str!("../../examples/three-bar-test-1.toml");
        let layout = LayoutFile::parse(text, "test-1.toml").unwrap().layout;
        let lines = [line("1:+Y", Some(20), 0.001), line("2:+Z", None, 0.001)];
        let made =
            |dof: &str, hits| ShownDof { dof: dof.into(), hits, band_hz: None, coherence: None };
        let measured = as_measured(&layout, &[made("1:+Y", Some(20)), made("2:+Z", None)]);
        let dofs: Vec<String> = measured.hits.iter().map(|hit| hit.dof.to_string()).collect();
        assert_eq!(dofs, ["1:+Y", "2:+Z"]);
        // The layout wants 5 hits: 20 halve what scatters.
        let ratio = |k: usize| {
            let [now, then] = [&measured, &layout].map(|of| of.hits[k].uncertainty.position);
            now / then
        };
        assert_eq!([ratio(0), ratio(1)], [0.5, 1.0]);
        // Of one hit, the noise is √5 of that of five.
        assert!((noise(&lines, &layout).unwrap() / (0.001 * 5.0_f64.sqrt()) - 1.0).abs() < 1e-12);
        assert_eq!(noise(&[line("1:+Y", None, 0.0)], &layout), None);
        assert_eq!(noise(&[], &layout), None);
    }
}
