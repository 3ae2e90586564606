//! The verdict and the ten properties.

use massline_result::{Estimate, Finding, Refusal, TestResult};
use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter};
use massline_shared::diagnosis::Severity;

use super::limits::Limits;
use super::values::Sentence;
use crate::result_file::ResultFile;
use crate::typography::with_minus_signs;
use crate::words::{
    as_exact_as, error_percent, headline, in_interval, reason_text, scale_of, two_digits,
    with_half_width,
};

/// Whether a result can be used, and why.
pub(super) struct Verdict {
    /// `good`, `warning` or `bad`: the class of the page's element.
    pub tone: &'static str,
    /// In a few words.
    pub headline: String,
    /// What is behind it.
    pub reasons: Vec<Sentence>,
}

/// One of the ten properties, in the unit of tables.
pub(super) struct Row {
    /// The symbol without its index, and the index.
    pub symbol: (&'static str, &'static str),
    pub name: &'static str,
    pub value: String,
    /// Half width and ends of the 95 % interval; empty where it is not known.
    pub half_width: String,
    pub low: String,
    pub high: String,
    pub unit: &'static str,
    /// Half width in % of the scale.
    pub percent: String,
    /// What the uncertainty is mostly from.
    pub mostly: String,
    /// The expected value and the error in % of scale; empty where none is stated.
    pub expected: String,
    pub error: String,
}

/// Names of the ten properties.
const NAMES: [&str; 10] = [
    "mass",
    "centre of mass, x",
    "centre of mass, y",
    "centre of mass, z",
    "moment of inertia about x",
    "moment of inertia about y",
    "moment of inertia about z",
    "product of inertia xy",
    "product of inertia xz",
    "product of inertia yz",
];

impl Row {
    /// The ten rows of an answer.
    pub fn all(source: &ResultFile, answer: &Estimate, limits: &Limits) -> Vec<Self> {
        let (theta, half) = (answer.theta(), answer.half_widths());
        let expected = source.expected();
        // The scale of all commands that print errors.
        let scale = scale_of(answer, &expected, source.characteristic_length());
        let row = |(k, parameter): (usize, &InertialParameter)| {
            let number = |si: f64| number(k, si, half.map(|half| half[k]));
            let of_half =
                |text: &dyn Fn(f64) -> String| half.map_or(String::new(), |half| text(half[k]));
            let percent = |si: f64| scale.map(|scale| 100.0 * si / scale[k]);
            Self {
                symbol: symbol(parameter),
                name: NAMES[k],
                value: number(theta[k]),
                half_width: of_half(&number),
                low: of_half(&|half| number(theta[k] - half)),
                high: of_half(&|half| number(theta[k] + half)),
                unit: parameter.table_unit,
                percent: of_half(&|half| percent(half).map_or(String::new(), two_digits)),
                mostly: limits.mostly(k),
                expected: expected[k].map_or(String::new(), number),
                error: expected[k]
                    .and_then(|value| percent(theta[k] - value))
                    .map_or(String::new(), |error| with_minus_signs(&error_percent(error))),
            }
        };
        INERTIAL_PARAMETERS.iter().enumerate().map(row).collect()
    }
}

/// The symbol of a property without its index, and the index.
pub(super) fn symbol(parameter: &InertialParameter) -> (&'static str, &'static str) {
    parameter.symbol.split_once('_').unwrap_or((parameter.symbol, ""))
}

/// A value of a property in the unit of tables, with the digits that its 95 % interval of this half width allows; both
/// in SI units.
pub(super) fn number(k: usize, si: f64, half_width: Option<f64>) -> String {
    let factor = INERTIAL_PARAMETERS[k].table_factor;
    with_minus_signs(&in_interval(si * factor, half_width.map(|half| half * factor)))
}

/// What relative numbers refer to; empty where the layout is not known.
pub(super) fn scale_text(source: &ResultFile) -> String {
    source.characteristic_length().map_or(String::new(), |length| {
        format!(
            "Scale: m for the mass, L for the centre of mass, m L² for the inertia, with {}L = {:.1} mm, the root mean \
             square distance of the sensors from their centre.",
            if source.expected()[0].is_some() { "m the expected mass and " } else { "" },
            1e3 * length
        )
    })
}

/// Principal moments with their 95 % intervals, largest last, and the axes, in a sentence each; empty without real
/// ones.
pub(super) fn principal(answer: &Estimate) -> Vec<String> {
    let (Some(moments), Some(axes)) = (answer.principal_moments_kg_m2.value, answer.principal_axes)
    else {
        return Vec::new();
    };
    let half = answer.principal_half_widths();
    let line = |k: usize| {
        let moment = moments[k] * 1e3;
        let moment = half.map_or_else(
            || as_exact_as(moment, None),
            |half| with_half_width(moment, half[k] * 1e3),
        );
        let axis: Vec<String> = axes.iter().map(|row| format!("{:.3}", row[k])).collect();
        with_minus_signs(&format!("{moment} g m² about the axis ({})", axis.join(", ")))
    };
    (0..3).map(line).collect()
}

impl Verdict {
    /// The verdict on a result.
    pub fn of(result: &TestResult) -> Self {
        use massline_result::Verdict;
        let reasons: Vec<Sentence> =
            result.verdict_reasons.iter().map(|reason| Sentence(reason_text(reason))).collect();
        let Some(verdict) = result.verdict else { return Self::without_answer(result) };
        let tone = match verdict {
            Verdict::Good => "good",
            Verdict::UseWithCare => "warning",
            Verdict::DoNotUse => "bad",
        };
        Self { tone, headline: headline(verdict, &[]), reasons }
    }

    /// Every reason once: what is said of a method is not repeated as a finding.
    fn without_answer(result: &TestResult) -> Self {
        let refused = refused(&result.not_applicable);
        let grave = result.findings().into_iter().filter(|finding| finding.is_grave());
        let is_new = |finding: &&Finding| {
            let code = finding.code.to_string();
            !result.not_applicable.iter().any(|refusal| refusal.codes.contains(&code))
        };
        let sentences = grave.filter(is_new).map(|finding| Sentence(finding.message.clone()));
        let sentence = |refusal: &SharedRefusal| {
            let wider = refused.iter().find(|other| other.includes(refusal));
            Sentence(match wider {
                Some(wider) => {
                    format!("{}: one of the reasons of {}", refusal.methods, wider.methods)
                }
                None => format!("{}: {}", refusal.methods, refusal.message.0),
            })
        };
        let reasons = sentences.chain(refused.iter().map(sentence)).collect();
        let headline = "No answer: the data do not determine the ten properties".into();
        Self { tone: "bad", headline, reasons }
    }
}

/// Why methods have no answer.
pub(super) struct SharedRefusal {
    /// Their names.
    pub methods: String,
    /// What they all say.
    pub message: Sentence,
    codes: Vec<String>,
}

impl SharedRefusal {
    /// True where another one says less of the same.
    fn includes(&self, other: &Self) -> bool {
        self.codes != other.codes && other.codes.iter().all(|code| self.codes.contains(code))
    }
}

/// The refusals of a result; methods with the same reasons share one.
pub(super) fn refused(refusals: &[Refusal]) -> Vec<SharedRefusal> {
    let mut shared_refusals: Vec<SharedRefusal> = Vec::new();
    for Refusal { method, message, codes, .. } in refusals {
        let message = Sentence(message.clone());
        match shared_refusals.iter_mut().find(|shared| shared.message == message) {
            Some(shared) => shared.methods = format!("{}, {method}", shared.methods),
            None => {
                shared_refusals.push(SharedRefusal {
                    methods: method.to_string(),
                    message,
                    codes: codes.clone(),
                });
            }
        }
    }
    shared_refusals
}

/// What was found besides the reasons of the verdict, and the notes.
pub(super) fn notes(result: &TestResult) -> Vec<Sentence> {
    let is_reason =
        |finding: &Finding| result.verdict_reasons.iter().any(|reason| reason.says(finding));
    // Without an answer, what is more than a note is a reason for that.
    let is_shown = |finding: &&Finding| {
        finding.severity == Severity::Note || result.verdict.is_some() && !is_reason(finding)
    };
    let findings = result.findings().into_iter().filter(is_shown);
    let sentences = findings.map(|finding| Sentence(finding.message.clone()));
    sentences.chain(result.notes.iter().cloned().map(Sentence)).collect()
}
