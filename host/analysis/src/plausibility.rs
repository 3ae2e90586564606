//! What in an answer looks like another unit or another convention than the file states. It never changes the answer.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::diagnosis::Severity;
use massline_shared::identify::Estimate;

use crate::single_fault::NominalTest;
use massline_files::layout_file::{Reference, size_suspicions};
use massline_files::units::{FOOT, INCH, POUND, POUND_FORCE};
use massline_result::{Finding, FindingCode};

/// The relative difference to a factor at which it is named.
const NEAR: f64 = 0.04;
/// Products of inertia are the opposite of the expected ones up to this part of their size.
const OPPOSITE: f64 = 0.2;

/// By how many times accelerances are too large when a unit is another than the file states, and what it then is.
const FACTORS: [(f64, &str); 20] = [
    (1.0 / STANDARD_GRAVITY, "are the accelerations in g, not in m/s^2?"),
    (STANDARD_GRAVITY, "are the accelerations in m/s^2, not in g, or the forces in kgf, not in N?"),
    (1e3, "are the accelerations in mm/s^2, not in m/s^2, or the forces in kN, not in N?"),
    (1e-3, "are the accelerations in m/s^2, not in mm/s^2, or the forces in N, not in kN?"),
    (1e6, "are the responses in micrometres, not in metres, or in mm per kN?"),
    (1e-6, "are the responses in metres, not in micrometres?"),
    (100.0, "are the accelerations in cm/s^2, not in m/s^2?"),
    (0.01, "are the accelerations in m/s^2, not in cm/s^2?"),
    (POUND_FORCE, "are the forces in lbf, not in N?"),
    (1.0 / POUND_FORCE, "are the forces in N, not in lbf?"),
    (POUND, "are the accelerations in g and the forces in lbf?"),
    (1.0 / POUND, "are the accelerations in m/s^2 and the forces in N, not in g and lbf?"),
    (1.0 / INCH, "are the accelerations in in/s^2, not in m/s^2?"),
    (INCH, "are the accelerations in m/s^2, not in in/s^2?"),
    (25.4, "are the accelerations in mm/s^2, not in in/s^2?"),
    (POUND_FORCE / INCH, "are the accelerations in in/s^2 and the forces in lbf?"),
    (STANDARD_GRAVITY / INCH, "are the accelerations in in/s^2, not in g?"),
    (INCH / STANDARD_GRAVITY, "are the accelerations in g, not in in/s^2?"),
    (1.0 / FOOT, "are the accelerations in ft/s^2, not in m/s^2?"),
    (POUND_FORCE / FOOT, "are the accelerations in ft/s^2 and the forces in lbf?"),
];

/// What of the input looks wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The file states no unit; SI is assumed.
    UnitAssumed,
    /// The file states the unit of some responses only; SI is assumed for the others.
    UnitOfSomeResponses,
    /// Two statements of the file about its units contradict each other.
    UnitContradicted,
    /// The responses differ from what is expected by the factor between two units.
    UnitOfResponses,
    /// Lengths, masses or inertias do not fit each other.
    UnitOfLayout,
    /// Products of inertia are expected with the opposite signs.
    SignsOfProducts,
}

impl Doubt {
    /// The stable name in JSON.
    pub fn code(self) -> FindingCode {
        match self {
            Self::UnitAssumed => FindingCode::UnitAssumed,
            Self::UnitOfSomeResponses => FindingCode::UnitOfSomeResponses,
            Self::UnitContradicted => FindingCode::UnitContradicted,
            Self::UnitOfResponses => FindingCode::UnitOfResponses,
            Self::UnitOfLayout => FindingCode::UnitOfLayout,
            Self::SignsOfProducts => FindingCode::SignsOfProducts,
        }
    }

    /// How much it weighs.
    pub fn severity(self) -> Severity {
        match self {
            Self::UnitAssumed | Self::SignsOfProducts => Severity::Note,
            Self::UnitOfSomeResponses
            | Self::UnitContradicted
            | Self::UnitOfResponses
            | Self::UnitOfLayout => Severity::Warning,
        }
    }
}

/// What of the input looks wrong, as a sentence. It changes no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Suspicion {
    /// What it is.
    pub doubt: Doubt,
    /// The sentence.
    pub message: String,
}

impl Suspicion {
    /// A suspicion with its sentence.
    pub fn new(doubt: Doubt, message: String) -> Self {
        Self { doubt, message }
    }

    /// The code and the sentence of what is more than a note.
    pub fn warning(&self) -> Option<(FindingCode, String)> {
        let is_grave = self.doubt.severity() > Severity::Note;
        is_grave.then(|| (self.doubt.code(), self.message.clone()))
    }

    /// As a finding of a result.
    pub fn finding(&self) -> Finding {
        let Self { doubt, message } = self;
        Finding { code: doubt.code(), severity: doubt.severity().into(), message: message.clone() }
    }
}

/// What looks like another unit or convention in the layout and in these answers to its test, the best first.
pub fn suspicions(test: &NominalTest, estimates: &[Estimate<f64>]) -> Vec<Suspicion> {
    let suspicion = |doubt| move |message| Suspicion::new(doubt, message);
    let stated = test.unit_suspicions.iter().cloned().map(suspicion(Doubt::UnitOfLayout));
    // What is known beforehand pulls the answers of some methods.
    let free = estimates.iter().find(|estimate| !estimate.method.entry().uses_priors);
    let Some(answer) = free.or(estimates.first()) else { return stated.collect() };
    let body = &answer.body;
    let [cx, cy, cz] = body.center_of_mass.into();
    let [jxx, jyy, jzz] = [0, 1, 2].map(|k| body.inertia[(k, k)]);
    let [jxy, jxz, jyz] = [(0, 1), (0, 2), (1, 2)].map(|place| body.inertia[place]);
    let properties = [body.mass, cx, cy, cz, jxx, jyy, jzz, jxy, jxz, jyz].map(Some);
    let is_physical = jxx > 0.0 && jyy > 0.0 && jzz > 0.0;
    let positions: Vec<_> = test.nodes.iter().map(|(_, position)| *position).collect();
    let sizes = match is_physical {
        true => size_suspicions(&positions, "the answer", &properties),
        false => Vec::new(),
    };
    let responses = unit_of_responses(test, answer).map(suspicion(Doubt::UnitOfResponses));
    let products =
        test.reference.as_ref().and_then(|reference| opposite_products(reference, answer));
    stated
        .chain(responses)
        .chain(sizes.into_iter().map(suspicion(Doubt::UnitOfLayout)))
        .chain(products.map(suspicion(Doubt::SignsOfProducts)))
        .collect()
}

/// Names the factor between the answer's mass and the expected one.
fn unit_of_responses(test: &NominalTest, answer: &Estimate<f64>) -> Option<String> {
    let prior =
        test.layout.priors.iter().find(|prior| prior.property == 0).map(|prior| prior.value);
    let reference = test.reference.as_ref().and_then(|reference| reference.mass_kg);
    let expected = [("[prior]", prior), ("[reference]", reference)];
    expected.into_iter().find_map(|(table, mass)| {
        let mass = mass.filter(|mass| *mass > 0.0)?;
        let factor = mass / answer.body.mass;
        let distance = |known: f64| (factor / known).ln().abs();
        let nearest = FACTORS.iter().min_by(|(a, _), (b, _)| distance(*a).total_cmp(&distance(*b)))?;
        (distance(nearest.0) < NEAR).then(|| {
            format!(
                "the accelerances are {factor:.4} times what the mass of {table}, {mass} kg, expects (the answer is \
                 {:.4} kg): {}",
                answer.body.mass, nearest.1
            )
        })
    })
}

/// Names products of inertia that are the answer's with the opposite signs.
fn opposite_products(reference: &Reference, answer: &Estimate<f64>) -> Option<String> {
    let expected = reference.inertia_kg_m2?;
    let pairs =
        [(0, 1), (0, 2), (1, 2)].map(|(a, b)| (answer.body.inertia[(a, b)], expected[a][b]));
    let norm = |part: fn(&(f64, f64)) -> f64| {
        pairs.iter().map(|pair| part(pair).powi(2)).sum::<f64>().sqrt()
    };
    let size = norm(|(_, expected)| *expected);
    let scatter = answer
        .covariance
        .as_ref()
        .map_or(0.0, |covariance| (7..10).map(|k| covariance[(k, k)]).sum::<f64>().sqrt());
    (size > 2.0 * scatter && size > 0.0 && norm(|(value, expected)| value + expected) < OPPOSITE * size).then(|| {
        "the products of inertia of [reference] have the opposite signs of the answer's: its source probably states \
         +∫xy dm, and J_xy here is the element of the tensor, −∫xy dm"
            .to_owned()
    })
}
