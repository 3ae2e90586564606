//! The verdict and the ten properties.

use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter};
use massline_shared::diagnosis::Code;
use massline_shared::identify::Method;
use massline_shared::identify::agreement::Outcome;
use serde_json::Value;

use super::limits::Limits;
use super::values::{Sentence, list, words};
use crate::error::Result;
use crate::export::{Exported, refused_by_host};
use crate::judgement::NO_ANSWER_HERE;
use crate::report::{as_exact_as, two_digits, with_sigma};
use crate::result_file::ResultFile;
use crate::suspension::Doubt;

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
    ///
    /// # Errors
    /// When the scale is needed and the layout is not known.
    pub fn all(source: &ResultFile, answer: &Exported, limits: &Limits) -> Result<Vec<Self>> {
        let (theta, sigma, half) = (answer.theta(), answer.sigma(), answer.half_widths);
        let length = source.characteristic_length();
        let expected = source.expected();
        // The scale of all commands that print errors.
        let mass = expected[0].unwrap_or(answer.body.mass);
        let scale = length.map(|_| source.scale(mass)).transpose()?;
        let row = |(k, parameter): (usize, &InertialParameter)| {
            let number = |si: f64| number(k, si, sigma.map(|sigma| sigma[k]));
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
                    .and_then(|of| percent(theta[k] - of))
                    // Adding zero takes the sign from a negative zero.
                    .map_or(String::new(), |error| {
                        format!("{:+.2}", (100.0 * error).round() / 100.0 + 0.0)
                    }),
            }
        };
        Ok(INERTIAL_PARAMETERS.iter().enumerate().map(row).collect())
    }
}

/// The symbol of a property without its index, and the index.
pub(super) fn symbol(parameter: &InertialParameter) -> (&'static str, &'static str) {
    parameter.symbol.split_once('_').unwrap_or((parameter.symbol, ""))
}

/// A value of a property in the unit of tables, with the digits that its standard deviation allows; both in SI units.
pub(super) fn number(k: usize, si: f64, sigma: Option<f64>) -> String {
    let factor = INERTIAL_PARAMETERS[k].table_factor;
    as_exact_as(si * factor, sigma.map(|sigma| sigma * factor))
}

/// What relative numbers refer to; empty where the layout is not known.
pub(super) fn scale_text(source: &ResultFile) -> String {
    source.characteristic_length().map_or(String::new(), |length| {
        format!(
            "Scale: m for the mass, L for the centre of mass, m L² for the inertia, with {}L = {:.1} mm, the root mean square \
             distance of the sensors from their centre.",
            if source.expected()[0].is_some() { "m the expected mass and " } else { "" },
            1e3 * length
        )
    })
}

/// Principal moments with their 95 % intervals, largest last, and the axes, in a sentence each; empty without real ones.
pub(super) fn principal(source: &ResultFile, answer: &Exported) -> Vec<String> {
    let Some(principal) = answer.body.principal() else { return Vec::new() };
    let sigmas: Option<[f64; 3]> =
        serde_json::from_value(source.best_entry()["principal_moments_kg_m2"]["sigma"].clone())
            .ok();
    // The same for all properties of an answer.
    let factor = match (answer.sigma(), answer.half_widths) {
        (Some(sigma), Some(half)) if sigma[0] > 0.0 => half[0] / sigma[0],
        _ => f64::NAN,
    };
    let sigmas = sigmas.filter(|_| factor.is_finite());
    let line = |k: usize| {
        let moment = principal.moments[k] * 1e3;
        let moment = sigmas
            .map_or_else(|| as_exact_as(moment, None), |s| with_sigma(moment, factor * s[k] * 1e3));
        let axis: Vec<String> =
            principal.axes.column(k).iter().map(|x| format!("{x:.3}")).collect();
        format!("{moment} g m² about the axis ({})", axis.join(", "))
    };
    (0..3).map(line).collect()
}

impl Verdict {
    /// The verdict on a result and its best answer.
    pub fn of(source: &ResultFile, answer: Option<&Exported>) -> Self {
        let Some(answer) = answer else { return Self::without_answer(source) };
        let grave = grave_about(source, answer);
        let refused = refused_by_host(source.document());
        if let Some(condition) = answer.violated_condition() {
            let mut reasons = vec![Sentence(condition)];
            reasons.extend(grave);
            return Self::bad("No real body has these properties", reasons);
        }
        if answer.verdict == Some(crate::verdict::Verdict::DoNotUse) && refused.is_empty() {
            let reasons = answer.doubts.iter().cloned().map(Sentence).collect();
            return Self::bad("Do not use this answer", reasons);
        }
        if !refused.is_empty() {
            let said = |reason: &&str| Sentence(format!("{NO_ANSWER_HERE}: {reason}"));
            let mut reasons: Vec<_> = refused.iter().map(said).collect();
            let is_new = |said: &Sentence| !refused.iter().any(|reason| said.0.contains(reason));
            reasons.extend(grave.into_iter().filter(is_new));
            let headline = "The answer is in doubt: the rig has it, and no method here confirms it";
            return Self { tone: "warning", headline: headline.into(), reasons };
        }
        let agreement = &source.document()["agreement"];
        let verdict = agreement["verdict"].as_str().unwrap_or_default().to_owned();
        let relies_on = relies_on(source, answer);
        let is_off = list(&agreement["off"]).iter().any(|method| *method == answer.method);
        let differ = agreement["outcome"] == Outcome::Differ.name();
        if (agreement["doubt"].is_string() && !relies_on) || differ || is_off {
            let mut reasons = vec![Sentence(verdict)];
            reasons.extend(grave);
            return Self { tone: "warning", headline: "The answer is in doubt".into(), reasons };
        }
        let contradicts = Code::DataInconsistentWithBudget.name();
        if findings(source).iter().any(|found| found.code == contradicts) {
            let headline =
                "The answer is in doubt: the data contradict the stated uncertainties".into();
            return Self { tone: "warning", headline, reasons: grave };
        }
        let (tone, headline) = match grave.len() {
            0 => ("good", "Good: nothing was found that puts the answer in doubt".to_owned()),
            1 => ("warning", "Use with care: there is one warning".into()),
            count => ("warning", format!("Use with care: there are {count} warnings")),
        };
        let note = relies_on.then(|| Sentence(format!("note: {verdict}")));
        Self { tone, headline, reasons: grave.into_iter().chain(note).collect() }
    }

    /// Every reason once: what is said of a method is not repeated as a finding.
    fn without_answer(source: &ResultFile) -> Self {
        let refusals = Refusal::all(source);
        let is_new = |finding: &Sentence| {
            !refusals.iter().any(|refusal| refusal.message.0.contains(&finding.0))
        };
        let mut reasons: Vec<Sentence> = grave(source).into_iter().filter(is_new).collect();
        let said = |refusal: &Refusal| {
            let wider = refusals.iter().find(|of| of.includes(refusal));
            Sentence(match wider {
                Some(wider) => {
                    format!("{}: one of the reasons of {}", refusal.methods, wider.methods)
                }
                None => format!("{}: {}", refusal.methods, refusal.message.0),
            })
        };
        reasons.extend(refusals.iter().map(said));
        Self::bad("No answer: the data do not determine the ten properties", reasons)
    }

    fn bad(headline: &str, reasons: Vec<Sentence>) -> Self {
        Self { tone: "bad", headline: headline.into(), reasons }
    }
}

/// Why methods have no answer.
pub(super) struct Refusal {
    /// Their names.
    pub methods: String,
    /// What they all say.
    pub message: Sentence,
}

impl Refusal {
    /// The refusals of a result; methods with the same reasons share one. Where rig and host refuse a method, the reason is
    /// that of the host, as the answers are.
    pub fn all(source: &ResultFile) -> Vec<Self> {
        let document = source.document();
        let of_host = list(&document["host"]["not_applicable"]);
        let mut all: Vec<Self> = Vec::new();
        for refusal in list(&document["not_applicable"]) {
            let again = of_host.iter().find(|of| of["method"] == refusal["method"]);
            let refusal = again.unwrap_or(refusal);
            let (method, message) =
                (words(&refusal["method"]), Sentence(words(&refusal["message"])));
            match all.iter_mut().find(|of| of.message == message) {
                Some(of) => of.methods = format!("{}, {method}", of.methods),
                None => all.push(Self { methods: method, message }),
            }
        }
        all
    }

    /// True where another one says less of the same.
    fn includes(&self, other: &Self) -> bool {
        self.message != other.message && self.message.0.contains(&other.message.0)
    }
}

/// A finding about a result.
#[derive(PartialEq)]
pub(super) struct Finding {
    code: String,
    severity: String,
    pub sentence: Sentence,
}

impl Finding {
    /// True where it says which form of damping does not fit: the method with that form is refused.
    fn is_of_other_form(&self) -> bool {
        let forms = [Code::DampingNotStructural, Code::DampingNotViscous];
        forms.iter().any(|form| form.name() == self.code)
    }

    /// True for what does not put the answer in doubt.
    pub fn is_note(&self) -> bool {
        self.severity == "note"
    }
}

/// Every finding about a result and its best answer, each once.
pub(super) fn findings(source: &ResultFile) -> Vec<Finding> {
    let document = source.document();
    let all = [&document["diagnostics"], &source.best_entry()["diagnostics"]];
    let mut found: Vec<Finding> = Vec::new();
    for finding in all.into_iter().flat_map(list) {
        let [code, severity, sentence] =
            ["code", "severity", "message"].map(|key| words(&finding[key]));
        let entry = Finding { code, severity, sentence: Sentence(sentence) };
        if !found.contains(&entry) {
            found.push(entry);
        }
    }
    found
}

/// True where the methods are known to be off, and this answer is by the one method to rely on then.
pub(super) fn relies_on(source: &ResultFile, answer: &Exported) -> bool {
    source.document()["agreement"]["doubt"] == Doubt::FlexibleMode.name()
        && answer.method == Method::GlobalFit.name()
}

/// The sentences of warnings and errors about an answer. Why another method has none is its own affair, unless that method
/// would have been preferred.
fn grave_about(source: &ResultFile, answer: &Exported) -> Vec<Sentence> {
    let document = source.document();
    let of_host = document["host"]["not_applicable"].as_array();
    let refusals = of_host.map_or_else(|| list(&document["not_applicable"]), Vec::as_slice);
    let place = |method: &str| Method::ALL.iter().position(|of| of.name() == method);
    let is_better = |refusal: &&Value| place(&words(&refusal["method"])) < place(&answer.method);
    let is_said_anyway =
        |found: &Finding| relies_on(source, answer) && found.code == Code::FlexibleModeShows.name();
    let about = |found: Finding| {
        let is_reason = |refusal: &&Value| {
            list(&refusal["codes"]).iter().any(|code| *code == found.code.as_str())
                && words(&refusal["message"]).contains(&found.sentence.0)
        };
        let mut of = refusals.iter().filter(is_reason).peekable();
        if of.peek().is_none() {
            return Some(found.sentence);
        }
        let better = of.find(is_better)?;
        let method = words(&better["method"]);
        Some(Sentence(format!("no answer by {method}: {}", found.sentence.0)))
    };
    grave_findings(source).filter(|found| !is_said_anyway(found)).filter_map(about).collect()
}

/// The sentences of warnings and errors about the test.
fn grave(source: &ResultFile) -> Vec<Sentence> {
    grave_findings(source).map(|of| of.sentence).collect()
}

fn grave_findings(source: &ResultFile) -> impl Iterator<Item = Finding> {
    findings(source).into_iter().filter(|of| !of.is_note() && !of.is_of_other_form())
}
