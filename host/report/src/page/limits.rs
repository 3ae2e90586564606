//! What limits an answer, and what to do next time.

use massline_physics::Bench;
use massline_result::{Estimate, Modes, ScoreTest, TestResult};
use massline_shared::design::{DEFAULT_NOISE, Part};
use massline_shared::identify::Method;
use massline_shared::layout::{ErrorSource, HostLayout, TestProfile};
use massline_shared::signal::ringing_s;

use super::values::Sentence;
use crate::result_file::ResultFile;
use crate::words::layout_check::{advice_text, most};
use crate::words::{
    BEGINS_TO_SHOW, calibrate_hammer, fault_name, hammer_limit, hardly_shown, in_unit, not_shown,
    two_digits,
};
use massline_analysis::design::DesignReport;
use massline_analysis::limits::BoundedTest;

/// Why there are no shares of the sources of error.
const NO_SHARES: &str = "how much of the uncertainty comes from each source of error is not known: it is computed for \
                         tests by a rig in the suspension profile, whose records are known, from six modes and the \
                         layout file";

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
    /// The limits of an answer; none where the layout file is not known.
    pub fn of(source: &ResultFile, answer: &Estimate) -> Self {
        let result = source.result();
        let layout = source.layout_in_force();
        let test = layout
            .as_ref()
            .and_then(|layout| BoundedTest::of(result, layout, record_s(source, layout)));
        let limits = test.zip(source.layout_file()).map(|(test, file)| {
            let BoundedTest { layout, criterion, noise_is_known } = test;
            Self::of_design(
                &DesignReport::of_test(file, &layout, criterion),
                &layout,
                (noise_is_known, result.firmware.is_some()),
            )
        });
        let by_mass_lines = Method::of_mass_lines().any(|method| answer.method == method);
        let Some(modes) = result.suspension.as_ref().filter(|_| !by_mass_lines) else {
            return limits.unwrap_or_default();
        };
        // Without six modes of a rig's test the bound cannot be computed, and their Norm Indicators are all there is.
        let known = limits.filter(|limits| !limits.parts.is_empty());
        let mut limits = known.unwrap_or_else(|| Self {
            sources: Sentence(hammer_limit(result).unwrap_or(NO_SHARES).into()),
            ..Self::default()
        });
        limits.advice.extend(shown_poorly(modes).into_iter().map(Sentence));
        limits
    }

    /// What a prediction for the test that was made says; from its own noise where that is known.
    fn of_design(
        design: &DesignReport,
        layout: &HostLayout,
        (noise_is_known, by_rig): (bool, bool),
    ) -> Self {
        let shares = most(&design.parts, |part| part.share, usize::MAX);
        let given = match noise_is_known {
            true => "with these data".to_owned(),
            false => format!("with this layout, assuming noise of {} %", 100.0 * DEFAULT_NOISE),
        };
        let mut advice = Vec::new();
        if let (Some(predicted), Some(design_advice)) = (design.predicted, &design.advice) {
            advice.push(format!(
                "the ten properties together are known to {:.3} % of scale (root mean square of 1 sd)",
                predicted.total_percent_of_scale
            ));
            advice.extend(advice_text(design_advice, layout, by_rig).lines().map(str::to_owned));
        }
        let largest = design.parts.iter().max_by(|a, b| a.share.total_cmp(&b.share));
        advice.extend(largest.map(|part| remedy(part.source, layout.test.profile, by_rig)));
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

    /// True where nothing is known.
    pub fn is_empty(&self) -> bool {
        self.sources.0.is_empty() && self.advice.is_empty()
    }

    /// The two largest sources of a property's uncertainty.
    pub fn mostly(&self, property: usize) -> String {
        most(&self.parts, |part| part.shares[property], 2).replace(" %", "\u{a0}%")
    }
}

/// How long the object has rung in a record, s: under the converter that the archive names, else under that of a bench,
/// which has the rate of every board.
fn record_s(source: &ResultFile, layout: &HostLayout) -> Option<f64> {
    let of_archive = source.archive().map(|archive| archive.rig.sampler.adc);
    let of_bench = || Some(Bench::named(BENCH).ok()?.converter(layout.sensors.len()));
    Some(ringing_s(&of_archive.or_else(of_bench)?))
}

/// The modes that the hits hardly show, and which hit would show them.
fn shown_poorly(modes: &Modes) -> Vec<String> {
    let better = (1..).zip(&modes.modes).filter_map(|(number, mode)| {
        let better = mode.better_hit.as_ref()?;
        Some(hardly_shown(number, better.shown, &better.dof))
    });
    let mut advice: Vec<String> = better.collect();
    if let (1.., Some(dof)) = (modes.modes_missing, &modes.hit_for_missing) {
        advice.push(not_shown(modes.modes_missing, dof));
    }
    if advice.is_empty() {
        advice.extend(least_shown(modes));
    }
    advice
}

/// The mode whose largest Norm Indicator is the least, where no other hit is worth making.
fn least_shown(modes: &Modes) -> Option<String> {
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

/// What to do against a source of error; the program calibrates its own rigs only.
fn remedy(source: ErrorSource, profile: TestProfile, by_rig: bool) -> String {
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
        ErrorSource::Gain if !by_rig => {
            "The gains of the sensors limit most: calibrate them, and state gain in [uncertainty]."
        }
        ErrorSource::CrossAxis if !by_rig => {
            "Cross-axis sensitivities limit most: calibrate them, and state cross_axis in [uncertainty]."
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
            return format!("The hammer's gain limits most: {}.", calibrate_hammer(by_rig));
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
pub(super) fn cannot_see(result: &TestResult) -> Vec<Sentence> {
    result.cannot_see.iter().map(|error| Sentence(error.message.clone())).collect()
}

/// A small fault that the answer was tested for, as a row.
pub(super) fn tested(test: &ScoreTest) -> [String; 5] {
    [
        fault_name(&test.fault),
        format!("{:.1} of {:.1}", test.significance.max(0.0), test.limit),
        in_unit(test.unit, test.sigma),
        in_unit(test.unit, BEGINS_TO_SHOW * test.sigma),
        two_digits(test.shift_sigma),
    ]
}

/// Whether a small fault shows, in a sentence.
pub(super) fn tested_text(result: &TestResult) -> Sentence {
    let shown = result.score_tests.iter().filter(|test| test.shown).count();
    let count = result.score_tests.len();
    Sentence(match shown {
        0 => format!("Of {count} small faults that the answer was tested for none shows."),
        1 => format!("Of {count} small faults that the answer was tested for one shows."),
        _ => format!("Of {count} small faults that the answer was tested for {shown} show."),
    })
}
