//! Fits the mistakes to a test.

use massline_shared::body::RigidBody;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::maximum_likelihood::{
    self, BudgetScales, ErrorBudget, Start, workspace,
};
use massline_shared::identify::single_fault::SingleFault;
use massline_shared::identify::{Consistency, DofMassLines, Estimate};
use massline_shared::layout::{HostLayout, check_geometry};
use nalgebra::SVector;

use super::judgement::{FittedMistakes, unknowns};
use super::sized::{Size, SizedFault, SizedMistake, TestUnder, known_scale, used_nodes};
use super::sized_fit::{self, SizedFit};
use super::{Examination, Mistake, Outcome, Suspect};
use crate::parallel::each;

/// Standard deviation of readings that are left out, relative to the largest reading that is not.
const LEFT_OUT: f64 = 1e3;
/// Readings without a subject that leave more than this of χ² over its degrees of freedom clear the subject: errors of
/// twice those stated leave four.
const CLEARS: f64 = 4.0;

/// What one mistake can be about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subject {
    Sensor(usize),
    Channel(usize, usize),
    Hit(usize),
    Node(u16),
}

/// The answer without everything that a mistake about a subject can change.
struct AnswerWithoutSubject {
    subject: Subject,
    answer: Option<Estimate<f64>>,
}

pub(super) struct Search<'a> {
    layout: &'a HostLayout,
    nodes: &'a [(u16, [f64; 3])],
    lines: &'a [DofMassLines<f64, Unbounded>],
}

impl<'a> Search<'a> {
    pub(super) fn new(
        layout: &'a HostLayout,
        nodes: &'a [(u16, [f64; 3])],
        lines: &'a [DofMassLines<f64, Unbounded>],
    ) -> Self {
        Self { layout, nodes, lines }
    }

    pub(super) fn examine(&self, with_hidden: bool) -> Examination {
        let plain = self.nominal_fit();
        let consistency = plain.as_ref().and_then(|estimate| estimate.consistency);
        let agrees = consistency.is_some_and(|c| !c.rejects_budget());
        let mut fitted = if agrees {
            // Any other mistake would show in χ²; a common gain shows only against a known mass.
            self.common_gain()
        } else {
            self.fit_all(consistency.as_ref())
        };
        fitted.sort();
        let explains = fitted.suspects.first().is_some_and(|best| {
            fitted.is_decisive(best, consistency.as_ref())
                && (!best.consistency.rejects_budget() || self.explains_with_larger_errors(best))
        });
        let tied = if explains { fitted.tied() } else { 0 };
        let mut named = fitted.suspects;
        let runner_up = named.drain(tied..).next();
        let corrected = each(&named, || (), |(), suspect| self.corrected(suspect));
        for (suspect, corrected) in named.iter_mut().zip(corrected) {
            suspect.corrected = corrected;
        }
        // A mistake without which no body is left explains nothing.
        named.retain(|suspect| {
            suspect.corrected.as_ref().is_none_or(|answer| is_body(&answer.body))
        });
        let outcome = if !named.is_empty() {
            Outcome::Suspected(named)
        } else if agrees {
            Outcome::NothingSuspicious
        } else {
            self.larger_errors().map_or(Outcome::Unexplained, Outcome::LargerErrors)
        };
        let hidden = plain.filter(|_| agrees && with_hidden).map(|answer| self.hidden(&answer));
        let (tested, untried) = (fitted.tried, fitted.untried);
        Examination { plain: consistency, outcome, runner_up, tested, untried, hidden }
    }

    /// The mistakes without a size that these data would not reveal.
    fn hidden(&self, answer: &Estimate<f64>) -> Vec<SingleFault<f64>> {
        let faults: Vec<_> = self.listed().collect();
        self.in_parallel(&faults, |fault, room| {
            let shown = fault.shows(self.layout, &answer.body, self.lines, room);
            shown.is_some_and(|consistency| !consistency.rejects_budget()).then_some(*fault)
        })
    }

    /// The answer of the nominal layout under the stated budget, from any start that leads to one: where there is none,
    /// every mistake explains the data.
    fn nominal_fit(&self) -> Option<Estimate<f64>> {
        let mut room = self.room();
        let mut from = |start: Start<'_, f64>, budget| {
            solve(self.layout, self.lines, start, budget, &mut room)
        };
        from(Start::InertiaRestraint, ErrorBudget::Stated)
            .or_else(|| from(Start::Crude, ErrorBudget::Stated))
            .or_else(|| {
                let learned = from(Start::InertiaRestraint, ErrorBudget::Learned)?;
                from(Start::At(&learned.body), ErrorBudget::Stated)
            })
    }

    /// The factors on the stated errors with which they explain the data: a person who hits less well, or coarser
    /// sensors.
    fn larger_errors(&self) -> Option<BudgetScales<f64>> {
        let (start, budget) = (Start::InertiaRestraint, ErrorBudget::Learned);
        let learned = solve(self.layout, self.lines, start, budget, &mut self.room())?;
        agrees_when_learned(&learned).then_some(learned.learned?.scales)
    }

    /// True when a mistake and larger errors than stated explain the data together.
    fn explains_with_larger_errors(&self, suspect: &Suspect) -> bool {
        let answer = self.test_under(&suspect.mistake).and_then(|(layout, lines)| {
            let start = Start::InertiaRestraint;
            solve(&layout, &lines, start, ErrorBudget::Learned, &mut self.room())
        });
        answer.is_some_and(|answer| agrees_when_learned(&answer))
    }

    /// The mistakes from a list that could have been made with what was measured.
    fn listed(&self) -> impl Iterator<Item = SingleFault<f64>> + '_ {
        let used = used_nodes(self.layout, self.lines);
        let is_measured = |hit: &usize| self.lines.iter().any(|(index, _)| index == hit);
        SingleFault::all(self.layout, self.nodes).filter(move |fault| match fault {
            SingleFault::HitAtNode { hit, .. } | SingleFault::HitReversed { hit } => {
                is_measured(hit)
            }
            SingleFault::NodesSwapped { nodes, .. } => nodes.iter().all(|node| used.contains(node)),
            _ => true,
        })
    }

    /// The fit of a common gain, where prior knowledge of the object can reveal it.
    fn common_gain(&self) -> FittedMistakes {
        let is_revealed = known_scale(self.layout).is_some();
        let suspects: Vec<_> = is_revealed
            .then(|| self.fit_sized(SizedFault::CommonGain, None, &mut self.room()))
            .into_iter()
            .flatten()
            .collect();
        let (tried, readings) = (suspects.len(), self.readings());
        FittedMistakes { suspects, tried, untried: Vec::new(), readings }
    }

    /// Fits all mistakes, except about subjects that the other readings clear.
    fn fit_all(&self, plain: Option<&Consistency<f64>>) -> FittedMistakes {
        let sensors = (0..self.layout.sensors.len()).map(Subject::Sensor);
        let hits = self.lines.iter().map(|(index, _)| Subject::Hit(*index));
        let nodes = used_nodes(self.layout, self.lines).into_iter().map(Subject::Node);
        let subjects: Vec<_> = sensors.chain(hits).chain(nodes).collect();
        let without = self.in_parallel(&subjects, |subject, room| {
            Some(AnswerWithoutSubject { subject: *subject, answer: self.without(*subject, room) })
        });
        let listed: Vec<_> = self.listed().collect();
        let sized = SizedFault::all(self.layout, self.lines);
        let tried = listed.len() + sized.len();
        let is_open = |subject: Option<Subject>| {
            let without = without.iter().find(|without| Some(without.subject) == subject);
            without.and_then(|w| w.answer.as_ref()).is_none_or(|answer| !clears(answer, plain))
        };
        let open: Vec<_> =
            listed.into_iter().filter(|fault| is_open(subject_of_listed(fault))).collect();
        let (open, untried): (Vec<_>, Vec<_>) =
            open.into_iter().partition(|fault| self.is_determined_with(fault));
        let mut suspects = self.in_parallel(&open, |fault, room| self.fit_listed(fault, room));
        let open: Vec<_> =
            sized.into_iter().filter(|fault| is_open(subject_of_sized(*fault))).collect();
        suspects.extend(self.in_parallel(&open, |fault, room| {
            let subject = subject_of_sized(*fault);
            let answer = without.iter().find(|without| Some(without.subject) == subject);
            self.fit_sized(*fault, answer.and_then(|w| w.answer.as_ref()), room)
        }));
        FittedMistakes { suspects, tried, untried, readings: self.readings() }
    }

    /// True when the hits and sensors determine the ten properties with this mistake too.
    fn is_determined_with(&self, fault: &SingleFault<f64>) -> bool {
        let diagnostics = fault.applied(self.layout).map(|layout| check_geometry(&layout, None));
        diagnostics.is_some_and(|diagnostics| {
            diagnostics.iter().all(|diagnostic| diagnostic.severity < Severity::Error)
        })
    }

    fn fit_listed(&self, fault: &SingleFault<f64>, room: &mut [f64]) -> Option<Suspect> {
        let consistency = fault.test(self.layout, self.lines, room)?;
        Some(Suspect { mistake: Mistake::Listed(*fault), consistency, corrected: None })
    }

    fn fit_sized(
        &self,
        fault: SizedFault,
        without: Option<&Estimate<f64>>,
        room: &mut [f64],
    ) -> Option<Suspect> {
        let of_channel = match (fault, without) {
            // Of two sensors none can be left out, but a channel can.
            (SizedFault::ChannelGain { sensor, axis }, None) => {
                self.without(Subject::Channel(sensor, axis.index()), room)
            }
            _ => None,
        };
        let without = without.or(of_channel.as_ref());
        let fit = sized_fit::fit(fault, self.layout, self.lines, without, room)?;
        let SizedFit { size, covariance, estimate } = fit;
        if fault.is_nothing(&size, &covariance) {
            return None;
        }
        let mistake = fault.with_size(size, &covariance, self.layout)?;
        let mut consistency = estimate.consistency?;
        let freedom = &mut consistency.degrees_of_freedom;
        *freedom = freedom.saturating_sub(fault.unknowns() as u16);
        let mistake = Mistake::Sized(mistake);
        Some(Suspect { mistake, consistency, corrected: None })
    }

    /// The answer without a subject; its χ² is that of the other readings.
    fn without(&self, subject: Subject, room: &mut [f64]) -> Option<Estimate<f64>> {
        let is_hit = |index: usize| match subject {
            Subject::Hit(hit) => hit == index,
            Subject::Node(node) => self.layout.hits.get(index).is_some_and(|h| h.dof.node == node),
            Subject::Sensor(_) | Subject::Channel(..) => false,
        };
        let is_response = |response: usize| match subject {
            Subject::Sensor(sensor) => response / 3 == sensor,
            Subject::Channel(sensor, axis) => response == 3 * sensor + axis,
            Subject::Node(node) => {
                self.layout.sensors.get(response / 3).is_some_and(|sensor| sensor.node == node)
            }
            Subject::Hit(_) => false,
        };
        let responses: Vec<_> =
            (0..3 * self.layout.sensors.len()).filter(|&response| is_response(response)).collect();
        let mut lines: Vec<_> =
            self.lines.iter().filter(|(index, _)| !is_hit(*index)).cloned().collect();
        for (_, own) in &mut lines {
            responses.iter().for_each(|&response| own.accelerance[response] = 0.0);
            let most = own.accelerance.largest();
            responses.iter().for_each(|&response| own.noise[response] = LEFT_OUT * most);
        }
        let mut answer = solve(self.layout, &lines, Start::Crude, ErrorBudget::Stated, room)?;
        let freedom = &mut answer.consistency.as_mut()?.degrees_of_freedom;
        *freedom = freedom.checked_sub((responses.len() * lines.len()) as u16)?;
        Some(answer)
    }

    /// Layout and readings under a mistake.
    fn test_under(&self, mistake: &Mistake) -> Option<TestUnder> {
        match mistake {
            Mistake::Listed(fault) => Some((fault.applied(self.layout)?, self.lines.to_vec())),
            Mistake::Sized(SizedMistake { fault, numbers, .. }) => {
                fault.corrected(numbers, self.layout, self.lines)
            }
        }
    }

    /// The ten properties without a mistake, under the budget that the answer of the test has. The size of the mistake
    /// is one more source of their uncertainty.
    fn corrected(&self, suspect: &Suspect) -> Option<Estimate<f64>> {
        let budget =
            if self.layout.learn_budget { ErrorBudget::Learned } else { ErrorBudget::Stated };
        let mut room = self.room();
        let (layout, lines) = self.test_under(&suspect.mistake)?;
        let start = Start::InertiaRestraint;
        let mut answer = solve(&layout, &lines, start, budget, &mut room)
            .or_else(|| solve(&layout, &lines, start, ErrorBudget::Stated, &mut room))?;
        let Mistake::Sized(SizedMistake { fault, numbers, spread, .. }) = &suspect.mistake else {
            return Some(answer);
        };
        let mut answer_of = |numbers: &Size| {
            let (layout, lines) = fault.corrected(numbers, self.layout, self.lines)?;
            solve(&layout, &lines, Start::At(&answer.body), ErrorBudget::Stated, &mut room)
        };
        let base = answer_of(numbers);
        let answers = [0, 1].map(|k| answer_of(&(numbers + spread.column(k))));
        if let Some(covariance) = &mut answer.covariance {
            for moved in answers.iter().take(unknowns(&suspect.mistake)) {
                let shift: SVector<f64, 10> = moved.as_ref()?.theta() - base.as_ref()?.theta();
                *covariance += shift * shift.transpose();
            }
        }
        Some(answer)
    }

    fn readings(&self) -> usize {
        3 * self.layout.sensors.len() * self.lines.len()
    }

    fn room(&self) -> Vec<f64> {
        vec![0.0; workspace(self.layout.sensors.len(), self.layout.hits.len())]
    }

    /// Applies `act` to each item on all cores; returns the results in order.
    fn in_parallel<I: Sync, T: Send>(
        &self,
        items: &[I],
        act: impl Fn(&I, &mut [f64]) -> Option<T> + Sync,
    ) -> Vec<T> {
        let results = each(items, || self.room(), |room, item| act(item, room));
        results.into_iter().flatten().collect()
    }
}

fn solve(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    start: Start<'_, f64>,
    budget: ErrorBudget,
    room: &mut [f64],
) -> Option<Estimate<f64>> {
    let solution = maximum_likelihood::solve(layout, lines, start, budget, room);
    solution.ok().map(|solution| solution.estimate)
}

/// True for a positive mass and positive moments of inertia.
fn is_body(body: &RigidBody<f64>) -> bool {
    body.mass > 0.0 && body.inertia.symmetric_eigenvalues().min() > 0.0
}

/// True when the learned budget explains the data.
fn agrees_when_learned(answer: &Estimate<f64>) -> bool {
    let contradicts = |diagnostic: &Diagnostic| diagnostic.code == Code::DataInconsistentWithBudget;
    !answer.diagnostics.iter().any(contradicts)
}

/// True when the readings without a subject contradict each other, so no mistake with the subject explains the data. An
/// answer that fits fewer readings worse than all of them is not the best one, and clears nothing.
fn clears(without: &Estimate<f64>, plain: Option<&Consistency<f64>>) -> bool {
    without.consistency.is_some_and(|left| {
        let is_best = plain.is_none_or(|plain| left.chi_squared <= plain.chi_squared);
        is_best && left.rejects_budget() && left.reduced() > CLEARS
    })
}

fn subject_of_listed(fault: &SingleFault<f64>) -> Option<Subject> {
    match fault {
        SingleFault::SensorAxes { sensor, .. } => Some(Subject::Sensor(*sensor)),
        SingleFault::HitAtNode { hit, .. } | SingleFault::HitReversed { hit } => {
            Some(Subject::Hit(*hit))
        }
        SingleFault::CablesSwapped { .. } | SingleFault::NodesSwapped { .. } => None,
    }
}

fn subject_of_sized(fault: SizedFault) -> Option<Subject> {
    match fault {
        SizedFault::ChannelGain { sensor, .. } | SizedFault::SensorGain { sensor } => {
            Some(Subject::Sensor(sensor))
        }
        SizedFault::HitGain { hit } | SizedFault::HitDisplaced { hit } => Some(Subject::Hit(hit)),
        SizedFault::NodeCoordinate { node, .. } => Some(Subject::Node(node)),
        SizedFault::CommonGain => None,
    }
}
