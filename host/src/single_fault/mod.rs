//! After a campaign: finds the single mistake that explains data that contradict the error budget, and the
//! mistakes that the data would not reveal.
//!
//! | χ² of the nominal layout | action |
//! | --- | --- |
//! | agrees with the budget | nothing is suspected; with a known mass a common scale is tried |
//! | contradicts the budget | every mistake is fitted, the one with the least χ² is named |
//! | contradicts the stated budget, and no mistake explains it, but the learned budget does | nothing is suspected |
//!
//! Mistakes whose χ² is hardly larger than the least are named beside it, because the data cannot distinguish
//! them.

mod report;
mod words;

pub(crate) use report::chi_squared_text;
pub(crate) use words::clause as fault_clause;

use massline_protocol::object::MeasurementResult;
use massline_shared::Estimated;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::maximum_likelihood::{self, ErrorBudget, Start, workspace};
use massline_shared::identify::single_fault::{DECISIVE_CHI_SQUARED, SingleFault, SingleFaultFit};
use massline_shared::identify::{Consistency, DofMassLines, Estimate};
use massline_shared::layout::{HOST_HITS, HOST_SENSORS, HostLayout, Layout, RIG_HITS, RIG_SENSORS};
use rayon::prelude::*;

use crate::identification::{layout_of, lines_of, solve_learned};
use crate::layout_file::LayoutFile;

/// The nominal test: its layout, and the points that could be hit by mistake.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalTest {
    /// The layout.
    pub layout: HostLayout,
    /// Numbers and positions of the nodes, body frame, m.
    pub nodes: Vec<(u16, [f64; 3])>,
}

impl NominalTest {
    /// The test with all nodes of a layout file.
    pub fn of_file(file: &LayoutFile) -> Self {
        let nodes = file.nodes.iter().map(|node| (node.id, node.position)).collect();
        Self { layout: file.layout.clone(), nodes }
    }

    /// The test with the nodes of its sensors and hits only, as a rig stores them.
    pub fn of_layout(layout: HostLayout) -> Self {
        let sensors = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position));
        let hits = layout.hits.iter().map(|hit| (hit.dof.node, hit.position));
        let mut nodes: Vec<_> = sensors.chain(hits).collect();
        nodes.sort_by_key(|&(node, _)| node);
        nodes.dedup_by_key(|&mut (node, _)| node);
        Self { layout, nodes }
    }

    /// Looks for single mistakes in mass lines.
    pub fn examine<const S: usize>(&self, lines: &[DofMassLines<f64, S>]) -> Examination {
        examine(&self.layout, &self.nodes, lines)
    }

    /// Looks for single mistakes in a rig's result.
    pub fn examine_result(&self, result: &MeasurementResult) -> Examination {
        examine(&layout_of(result, &self.layout), &self.nodes, &lines_of(result))
    }
}

/// A mistake with the χ² of its fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspect {
    /// The mistake.
    pub fault: SingleFault<f64>,
    /// χ² of the fit with this mistake.
    pub consistency: Consistency<f64>,
    /// For a common scale only: the ratio of the accelerances to their correct values.
    pub scale: Option<Estimated<f64>>,
}

/// The verdict on single mistakes.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The nominal layout agrees with the data, with the stated budget or with the learned one.
    NothingSuspicious,
    /// One mistake explains the data, or several that the data cannot distinguish: the least χ² first.
    Suspected(Vec<Suspect>),
    /// The data contradict the budget, and no single mistake changes that.
    Unexplained,
}

/// The result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Examination {
    /// χ² of the nominal layout; `None` when that fit has no answer.
    pub plain: Option<Consistency<f64>>,
    /// The verdict.
    pub verdict: Verdict,
    /// The best mistake that is not suspected.
    pub runner_up: Option<Suspect>,
    /// Number of mistakes that were fitted.
    pub tested: usize,
    /// Mistakes that these data would not reveal. `None` without a search: when the nominal layout has no fit
    /// that agrees with the data, and for layouts larger than a rig's, where the search takes too long.
    pub hidden: Option<Vec<SingleFault<f64>>>,
}

/// Looks for single mistakes in a test. `nodes` are the points that could have been hit, with their
/// positions in the body frame, m.
pub fn examine<const S: usize>(
    layout: &HostLayout,
    nodes: &[(u16, [f64; 3])],
    lines: &[DofMassLines<f64, S>],
) -> Examination {
    // A layout that fits a rig is solved twenty times faster in matrices of the rig's size.
    let small = layout.cast::<f64, RIG_SENSORS, RIG_HITS>();
    match small {
        Some(small) => {
            let lines = resized::<S, RIG_SENSORS>(lines);
            Search::<RIG_SENSORS, RIG_HITS>::new(&small, nodes, &lines).examine(true)
        }
        None => {
            let lines = resized::<S, HOST_SENSORS>(lines);
            Search::<HOST_SENSORS, HOST_HITS>::new(layout, nodes, &lines).examine(false)
        }
    }
}

/// The lines in matrices with room for another number of sensors.
fn resized<const FROM: usize, const TO: usize>(
    lines: &[DofMassLines<f64, FROM>],
) -> Vec<DofMassLines<f64, TO>> {
    lines.iter().map(|(index, lines)| (*index, lines.resized())).collect()
}

struct Search<'a, const S: usize, const H: usize> {
    layout: &'a Layout<f64, S, H>,
    nodes: &'a [(u16, [f64; 3])],
    lines: &'a [DofMassLines<f64, S>],
}

impl<'a, const S: usize, const H: usize> Search<'a, S, H> {
    fn new(
        layout: &'a Layout<f64, S, H>,
        nodes: &'a [(u16, [f64; 3])],
        lines: &'a [DofMassLines<f64, S>],
    ) -> Self {
        Self { layout, nodes, lines }
    }

    fn examine(&self, with_hidden: bool) -> Examination {
        let plain = self.nominal_fit();
        let consistency = plain.as_ref().and_then(|estimate| estimate.consistency);
        let agrees = consistency.is_some_and(|c| !c.rejects_budget());
        let mut suspects = if agrees {
            // Any other mistake would show in χ²; a common scale shows only against a known mass.
            self.tested(|fault| *fault == SingleFault::CommonScale)
        } else {
            self.tested(|_| true)
        };
        suspects.sort_by(|a, b| a.consistency.chi_squared.total_cmp(&b.consistency.chi_squared));
        let tested = suspects.len();
        let (named, others) = split(&suspects, consistency.as_ref());
        let verdict = match (named.is_empty(), agrees) {
            (true, true) => Verdict::NothingSuspicious,
            (true, false) if self.is_rough_work() => Verdict::NothingSuspicious,
            (true, false) => Verdict::Unexplained,
            (false, _) => Verdict::Suspected(named),
        };
        let hidden = plain.filter(|_| agrees && with_hidden).map(|estimate| {
            let faults = SingleFault::all(self.layout, self.nodes)
                .filter(|fault| involves_measured(fault, self.lines));
            let faults: Vec<_> = faults.collect();
            self.in_parallel(&faults, |fault, room| {
                let shown = fault.shows(self.layout, &estimate.body, self.lines, room);
                shown.is_some_and(|c| !is_shown(fault, &c)).then_some(*fault)
            })
        });
        Examination {
            plain: consistency,
            verdict,
            runner_up: others.first().copied(),
            tested,
            hidden,
        }
    }

    /// The answer of the nominal layout under its stated budget.
    fn nominal_fit(&self) -> Option<Estimate<f64>> {
        let (start, budget) = (Start::InertiaRestraint, ErrorBudget::Stated);
        let fit =
            maximum_likelihood::solve(self.layout, self.lines, start, budget, &mut self.room());
        fit.ok().map(|solution| solution.estimate)
    }

    /// True when errors of the stated kinds explain the data, although they are larger than stated: a person
    /// who hits less well, or coarser sensors.
    fn is_rough_work(&self) -> bool {
        let learned = solve_learned(self.layout, self.lines, Start::InertiaRestraint);
        let contradicts = |found: &Diagnostic| found.code == Code::DataInconsistentWithBudget;
        learned.is_ok_and(|solution| !solution.estimate.diagnostics.iter().any(contradicts))
    }

    /// Fits all mistakes for which `wanted` is true.
    fn tested(&self, wanted: impl Fn(&SingleFault<f64>) -> bool) -> Vec<Suspect> {
        let faults = SingleFault::all(self.layout, self.nodes)
            .filter(|fault| wanted(fault) && involves_measured(fault, self.lines));
        let faults: Vec<_> = faults.collect();
        self.in_parallel(&faults, |fault, room| {
            let SingleFaultFit { consistency, scale } =
                fault.test(self.layout, self.lines, room)?;
            Some(Suspect { fault: *fault, consistency, scale })
        })
    }

    fn room(&self) -> Vec<f64> {
        vec![0.0; workspace(self.layout.sensors.len())]
    }

    /// Applies `act` to each mistake on all cores; returns the results in order.
    fn in_parallel<T: Send>(
        &self,
        faults: &[SingleFault<f64>],
        act: impl Fn(&SingleFault<f64>, &mut [f64]) -> Option<T> + Sync,
    ) -> Vec<T> {
        let made = faults.par_iter().map_init(|| self.room(), |room, fault| act(fault, room));
        made.flatten_iter().collect()
    }
}

/// False for a mistake at a hit DOF that was not measured.
fn involves_measured<const S: usize>(
    fault: &SingleFault<f64>,
    lines: &[DofMassLines<f64, S>],
) -> bool {
    match fault {
        SingleFault::HitAtNode { hit, .. } | SingleFault::HitReversed { hit } => {
            lines.iter().any(|(index, _)| index == hit)
        }
        _ => true,
    }
}

/// Splits the mistakes into those that explain the data, the best first, and the rest.
///
/// A mistake explains the data when it makes χ² decisively smaller and plausible for the budget. Mistakes
/// whose χ² is not decisively larger than the least are equally good.
fn split<'s>(
    ascending: &'s [Suspect],
    plain: Option<&Consistency<f64>>,
) -> (Vec<Suspect>, &'s [Suspect]) {
    let plain = plain.map_or(f64::INFINITY, |c| c.chi_squared);
    let explains = |best: &Suspect| {
        plain - best.consistency.chi_squared >= DECISIVE_CHI_SQUARED
            && !best.consistency.rejects_budget()
    };
    let Some(best) = ascending.first().filter(|best| explains(best)) else {
        return (Vec::new(), ascending);
    };
    let limit = best.consistency.chi_squared + DECISIVE_CHI_SQUARED;
    let tied = ascending.iter().take_while(|s| s.consistency.chi_squared < limit).count();
    let (named, others) = ascending.split_at(tied);
    (named.to_vec(), others)
}

/// True when the data would reveal a mistake: always for a common scale, which a known mass reveals; else
/// when χ² contradicts the budget.
fn is_shown(fault: &SingleFault<f64>, consistency: &Consistency<f64>) -> bool {
    if *fault == SingleFault::CommonScale {
        return true;
    }
    consistency.rejects_budget()
}
