//! Score tests (Rao 1948) of small faults: a node typed a centimetre wrong, a gain that drifts, chips above their marks.
//!
//! Such a fault moves the answer by several of its standard deviations long before χ² contradicts the error budget, as
//! χ² asks every direction of the readings at once. A score test asks one: how much of the change that the fault would
//! make is in what the fit leaves, over what the whole covariance of the readings allows. It needs no further fit, so a
//! result is tested against the whole list, and carries how large each fault could be without being seen.
//!
//! | module | subject |
//! | --- | --- |
//! | `small_fault` | the list, and what each fault does to a layout |
//! | `changes` | what it does to the readings of mass lines |
//! | `left_over` | what a fit leaves of these readings, and its covariance |
//! | `fault_estimate` | the size of a fault from its scores |
//!
//! Those of a global fit are made in [`suspension`](crate::suspension).

mod changes;
mod fault_estimate;
mod left_over;
mod small_fault;

use massline_shared::EstimatedValue;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::maximum_likelihood::{BudgetScales, LearnedFrom};
use massline_shared::identify::single_fault::DECISIVE_CHI_SQUARED;
use massline_shared::identify::{Consistency, DofMassLines, Estimate, Method};
use massline_shared::layout::HostLayout;

use crate::identification::learned;
pub(crate) use fault_estimate::{FaultEstimate, FoundSize};
use left_over::LeftOver;
pub use small_fault::SmallFault;

/// What moves no property by more than this, in its standard deviations, is told as a note: nobody sees it beside them.
const HARDLY_MOVES: f64 = 0.5;

/// A fault that the data were tested for.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreTest {
    /// The fault.
    pub fault: SmallFault,
    /// What the data say of its size along each of its directions.
    pub sizes: Vec<EstimatedValue<f64>>,
    /// χ² of no such fault.
    pub consistency: Consistency<f64>,
    /// One standard deviation of the size, in the direction that changes a property most.
    pub sigma: f64,
    /// Largest change of a property, in its standard deviations, by a fault of that size.
    pub shift: f64,
    /// The same by a fault of the size that was found.
    pub found_shift: f64,
    /// The significance beyond which the data show the fault.
    pub limit: f64,
}

impl ScoreTest {
    /// `None` where the data say nothing of the fault.
    pub(crate) fn new(fault: SmallFault, estimate: FaultEstimate) -> Option<Self> {
        let FaultEstimate { sizes, consistency, sigma, shift, found_shift } = estimate;
        let limit = f64::INFINITY;
        let test = Self { fault, sizes, consistency, sigma, shift, found_shift, limit };
        test.significance().is_finite().then_some(test)
    }

    /// The standard normal deviate that is exceeded as rarely as the data show the fault.
    pub fn significance(&self) -> f64 {
        self.consistency.equivalent_z()
    }

    /// Whether the data show the fault.
    pub fn is_shown(&self) -> bool {
        self.significance() > self.limit
    }

    /// The size and its standard deviation, along the direction that was found.
    pub fn size(&self) -> EstimatedValue<f64> {
        let value = self.sizes.iter().map(|size| size.value * size.value).sum::<f64>().sqrt();
        let weighted: f64 =
            self.sizes.iter().map(|size| (size.value * size.sigma).powi(2)).sum::<f64>().sqrt();
        match self.sizes.as_slice() {
            [one] => *one,
            _ => EstimatedValue { value, sigma: if value > 0.0 { weighted / value } else { 0.0 } },
        }
    }
}

/// The faults that a result was tested for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScoreTests {
    /// Each fault that the data can show.
    pub tests: Vec<ScoreTest>,
    /// Largest change of a property, in its standard deviations, when the ends of the band are left out; zero where no
    /// mass line changes by more than its noise. `None` without tests.
    pub band_shift: Option<f64>,
}

impl ScoreTests {
    /// Tests the answer of maximum likelihood to these mass lines; nothing is tested where there is none, or where it was
    /// held to a physical body and is no minimum.
    pub fn of(
        layout: &HostLayout,
        lines: &[DofMassLines<f64, Unbounded>],
        estimates: &[Estimate<f64>],
    ) -> Self {
        let answer = estimates.iter().find(|e| e.method == Method::MaximumLikelihood);
        let is_held = |answer: &Estimate<f64>| {
            answer.diagnostics.iter().any(|d| d.code == Code::HeldToConsistency)
        };
        let Some(answer) = answer.filter(|answer| !is_held(answer)) else { return Self::default() };
        let learned_layout = learned(layout, answer);
        let log_variance = answer.learned.map(|learned| learned.constant_log_variance);
        let with_learned = LeftOver::of(learned_layout, lines, answer, log_variance);
        let band_shift = with_learned.as_ref().and_then(LeftOver::band_shift);
        // Without a learned budget it is the same.
        let stated =
            answer.learned.and_then(|_| LeftOver::of(stated(layout, answer), lines, answer, None));
        let both: Vec<_> = [with_learned, stated].into_iter().flatten().collect();
        // Where the errors are smaller than stated the learned budget sees more, where they are as stated the stated one:
        // it does not take a part of the fault for errors.
        let most = |fault| {
            let tests = both.iter().filter_map(|left_over| test(fault, left_over));
            tests.max_by(|a, b| a.significance().total_cmp(&b.significance()))
        };
        let tests = SmallFault::all(layout, lines).filter_map(most).collect();
        Self { band_shift, ..Self::among(tests) }
    }

    /// These tests, with limits for as many as they are.
    pub(crate) fn among(mut tests: Vec<ScoreTest>) -> Self {
        let count = tests.len();
        tests.iter_mut().for_each(|test| test.limit = test.fault.limit(count));
        Self { tests, band_shift: None }
    }

    /// Makes notes of warnings about the ends of the band where these hardly move the answer.
    pub fn in_proportion(&self, diagnostics: &mut [Diagnostic]) {
        // Lines that were not compared, or whose changes drown in their noise, say nothing: their shift is zero.
        if self.band_shift.is_some_and(|shift| 0.0 < shift && shift < HARDLY_MOVES) {
            let is_of_band =
                |code: Code| matches!(code, Code::SuspensionInBand | Code::MovesWithBand);
            for diagnostic in diagnostics.iter_mut().filter(|d| is_of_band(d.code)) {
                diagnostic.severity = Severity::Note;
            }
        }
    }

    /// The faults that the data show: the most significant one first, then those that the data cannot tell from it.
    pub fn shown(&self) -> Vec<&ScoreTest> {
        let mut shown: Vec<_> = self.tests.iter().filter(|test| test.is_shown()).collect();
        shown.sort_by(|a, b| b.significance().total_cmp(&a.significance()));
        let Some(best) = shown.first().map(|best| best.significance()) else { return shown };
        // Of two that explain nearly as much of χ², the data prefer none.
        shown.retain(|test| {
            best * best - test.significance() * test.significance() < DECISIVE_CHI_SQUARED
        });
        shown
    }
}

/// The layout with the scatter of the hits that repeat hits have taught, and everything else as stated.
fn stated(layout: &HostLayout, answer: &Estimate<f64>) -> HostLayout {
    let mut layout = layout.clone();
    if let Some(learned) = answer.learned.filter(|l| l.learned_from == LearnedFrom::RepeatHits) {
        BudgetScales { constant: 1.0, ..learned.scales }.apply_to(&mut layout);
    }
    layout
}

fn test(fault: SmallFault, left_over: &LeftOver<'_>) -> Option<ScoreTest> {
    let changes = fault.changes(left_over)?;
    // What shows only where nobody would call it small is not tested.
    let length = left_over.layout.characteristic_length();
    let largest = fault.largest(length, left_over.whole.mass);
    ScoreTest::new(fault, left_over.estimate(&changes, largest)?)
}

#[cfg(test)]
mod tests;
