//! What small changes of the data and of the layout do to modes and answers, one change after the other.

use nalgebra::{Complex, SVector, Vector6};

use super::answering::{Forms, of_modes_alone, place_of};
use super::{RigLayout, SolverMemory, Stage, Stored, SuspensionSolver, measured};
use crate::identify::SUSPENSION_METHODS;
use crate::identify::agreement::shift;
use crate::identify::dppim::NearModes;
use crate::identify::suspension::{Observed, answer, found_again, noise_in_draw, of_object};
use crate::layout::{RIG_HITS, UncertainQuantity};
use crate::modes::{
    CompactMotions, Exponents, ForceMixing, MOST_FORCES, Modes, PoleSearch, Poles, ResidueFit,
    Residues, reduce_determined,
};
use crate::{Progress, Real};

/// Draws of noise. With the default error budget half as many as in the full computation move the combined estimate by a
/// thousandth of its standard deviation, and its intervals are 2 % wider; they cost half of the time.
pub(super) const DRAWS: u32 = 100;
/// Lines that one step reduces.
const LINES_OF_A_STEP: usize = 16;
/// Cost of a draw of noise, of a change of the motions, and of one of the forces alone, in the same unit.
const COST_OF_NOISE: u32 = 3;
const COST_OF_MOTIONS: u32 = 2;
const COST_OF_FORCES: u32 = 1;
/// Standard deviations of noise for which there is room in the motions.
const ROOM: f64 = 6.0;

/// Number of changes: none, the draws, then every error of the layout.
fn changes<R: Real>(layout: &RigLayout<R>) -> u32 {
    1 + DRAWS + u32::try_from(layout.uncertain_quantities().count()).unwrap_or(0)
}

/// The change in hand.
#[derive(Clone, Debug)]
pub(super) struct Change<R> {
    number: u32,
    work: Work<R>,
    answers: [Option<SVector<R, 10>>; SUSPENSION_METHODS],
    /// The standard deviations of the motions in memory are not those of the layout.
    weights_changed: bool,
    /// Cost of the changes before this one, and of all.
    cost: [u32; 2],
}

/// What is done next about a change.
#[derive(Clone, Debug)]
enum Work<R> {
    Begin,
    /// The motions are changed, from this line on.
    Motions(usize),
    Poles(PoleSearch<R>),
    Residues(Poles<R>, ResidueFit),
    /// The residues at these poles are known.
    Modes(Poles<R>),
    Forms(Forms<R>),
}

/// What a change acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ChangeKind {
    /// Nothing.
    None,
    /// The readings: a draw of noise.
    Noise(u32),
    /// The sensors or gravity, and with them the motions.
    Motions,
    /// The forces or what is known of the object.
    Forces,
}

impl ChangeKind {
    fn of<R: Real>(layout: &RigLayout<R>, number: u32) -> Self {
        let Some(draw) = number.checked_sub(1) else { return Self::None };
        let Some(place) = draw.checked_sub(DRAWS) else { return Self::Noise(draw) };
        match layout.uncertain_quantities().nth(place as usize) {
            Some(UncertainQuantity::Sensor { .. } | UncertainQuantity::Gravity(_)) => Self::Motions,
            _ => Self::Forces,
        }
    }

    fn changes_motions(self) -> bool {
        matches!(self, Self::Noise(_) | Self::Motions)
    }

    fn cost(self) -> u32 {
        match self {
            Self::None | Self::Noise(_) => COST_OF_NOISE,
            Self::Motions => COST_OF_MOTIONS,
            Self::Forces => COST_OF_FORCES,
        }
    }
}

impl<R: Real> Change<R> {
    /// The first one, which changes nothing.
    pub(super) fn first(layout: &RigLayout<R>) -> Self {
        let of_all = |number| ChangeKind::of(layout, number).cost();
        let all = (0..changes(layout)).map(of_all).sum();
        let answers = [None; SUSPENSION_METHODS];
        Self { number: 0, work: Work::Begin, answers, weights_changed: false, cost: [0, all] }
    }

    /// Number of the change: so many are done.
    pub(super) fn number(&self) -> u32 {
        self.number
    }

    /// Part of all changes that is done.
    pub(super) fn progress(&self) -> f32 {
        self.cost[0] as f32 / self.cost[1].max(1) as f32
    }
}

impl<R: Real> SuspensionSolver<R> {
    /// Runs one step of the change in hand.
    // This and its parts are not inlined, so that each needs only its own stack.
    #[inline(never)]
    pub(super) fn step_change(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let Stage::Changes(Change { number, work, .. }) = &self.stage else {
            return Progress::Going;
        };
        let number = *number;
        let mut of = measured(layout, &self.dofs);
        if number == changes(&of) {
            return self.compare(of.characteristic_length(), memory);
        }
        let kind = ChangeKind::of(&of, number);
        let mixing = self.mixing(&of);
        let place = number.checked_sub(1 + DRAWS);
        if place.is_some_and(|place| !shift(&mut of, place as usize)) {
            // The layout has no such error.
            self.next_change(kind, memory);
            return Progress::Going;
        }
        match work {
            Work::Begin => self.begin_change(&of, kind, memory),
            Work::Motions(start) => self.change_motions(layout, &of, kind, *start, memory),
            Work::Poles(_) => self.poles_of_change(&mixing, &of, kind, memory),
            Work::Residues(..) => self.residues_of_change(&mixing, &of, kind, memory),
            Work::Modes(_) => self.modes_of_change(&mixing, &of, kind, memory),
            Work::Forms(_) => self.forms_of_change(&mixing, &of, kind, memory),
        }
        Progress::Going
    }

    fn set_work(&mut self, work: Work<R>) {
        if let Stage::Changes(change) = &mut self.stage {
            change.work = work;
        }
    }

    /// Prepares the units, and chooses where to begin.
    #[inline(never)]
    fn begin_change(
        &mut self,
        layout: &RigLayout<R>,
        kind: ChangeKind,
        memory: &SolverMemory<'_, R>,
    ) {
        self.units[1] = self.units[0];
        if matches!(kind, ChangeKind::Noise(_)) {
            self.make_room_for_noise(layout.characteristic_length(), memory);
        }
        let same_poles = self.same_poles();
        let Stage::Changes(change) = &mut self.stage else { return };
        change.answers = [None; SUSPENSION_METHODS];
        // The standard deviations of the motions have to be those of the layout again.
        let begins_with_motions = kind.changes_motions() || change.weights_changed;
        change.work = match kind {
            _ if begins_with_motions => Work::Motions(0),
            ChangeKind::Forces => same_poles,
            _ => Work::Poles(PoleSearch::once(self.fit.poles.clone())),
        };
    }

    /// Units with which there is room for noise in the motions.
    fn make_room_for_noise(&mut self, length: R, memory: &SolverMemory<'_, R>) {
        let largest = |component: usize| {
            let weights = memory.weights.iter().skip(component).step_by(6).take(self.grid.count());
            weights.fold(R::zero(), |top, v| top.max(*v))
        };
        let noise = self.fit.noise * self.grid.correlation * R::of(ROOM);
        for component in 0..6 {
            let balance = if component < 3 { R::one() } else { length };
            let more = largest(component) * noise / balance;
            for units in self.units[1].iter_mut().take(usize::from(self.forces)) {
                units[component] = CompactMotions::exponent_with_room(units[component], more);
            }
        }
    }

    /// Changes the motions at some lines: readings that are predicted from the motions are reduced again.
    #[inline(never)]
    fn change_motions(
        &mut self,
        layout: &RigLayout<R>,
        changed: &RigLayout<R>,
        kind: ChangeKind,
        start: usize,
        memory: &mut SolverMemory<'_, R>,
    ) {
        let (count, forces) = (self.grid.count(), usize::from(self.forces));
        let end = (start + LINES_OF_A_STEP).min(count);
        let channels = 3 * layout.sensors.len();
        if let Stage::Changes(change) = &mut self.stage {
            change.weights_changed = kind == ChangeKind::Motions;
        }
        let sigma = self.fit.noise * self.grid.correlation;
        let (base, work) = memory.codes.split_at_mut(CompactMotions::<R>::CODES);
        let Some(motions) = CompactMotions::new(base, &self.units[0]) else { return };
        let zero = Vector6::from_element(Complex::new(R::zero(), R::zero()));
        for line in start..end {
            let s = self.grid.s(line);
            let rows = layout.response_matrix_at(&self.reference, s);
            let mut of_forces = [zero; MOST_FORCES];
            for (force, motion) in of_forces.iter_mut().enumerate().take(forces) {
                *motion = motions.motion(line, force);
            }
            let reading = |channel: usize, force: usize| {
                let predicted = rows
                    .row(channel)
                    .iter()
                    .zip(of_forces[force].iter())
                    .fold(zero[0], |sum, (row, motion)| sum + row * motion);
                let ChangeKind::Noise(draw) = kind else { return predicted };
                let place = (line * channels + channel) * forces + force;
                predicted + noise_in_draw(sigma, draw, place)
            };
            let mut reduced = [zero; MOST_FORCES];
            let reduced = &mut reduced[..forces];
            let of = if kind.changes_motions() { changed } else { layout };
            let Some(sigma) = reduce_determined(of, s, &self.reference, reading, reduced) else {
                // No method has an answer to this change.
                return self.end_change(kind, memory);
            };
            memory.weights[6 * line..][..6].copy_from_slice(&sigma);
            if kind.changes_motions() {
                for (force, motion) in reduced.iter().enumerate() {
                    CompactMotions::store_line(work, &self.units[1], (line, force), motion);
                }
            }
        }
        if end < count {
            return self.set_work(Work::Motions(end));
        }
        let same_poles = self.same_poles();
        let Stage::Changes(change) = &mut self.stage else { return };
        change.work = match kind {
            ChangeKind::None | ChangeKind::Noise(_) => {
                Work::Poles(PoleSearch::once(self.fit.poles.clone()))
            }
            ChangeKind::Motions | ChangeKind::Forces => same_poles,
        };
    }

    /// Errors of the layout mix the motions with each other and do not move their poles. A search would: it is in single
    /// precision, and a pole that the noise has found beside a mode may take its place.
    fn same_poles(&self) -> Work<R> {
        Work::Residues(self.fit.relocated.clone(), ResidueFit::default())
    }

    /// Moves the poles to those of the changed motions.
    #[inline(never)]
    fn poles_of_change(
        &mut self,
        mixing: &ForceMixing<R, RIG_HITS>,
        changed: &RigLayout<R>,
        kind: ChangeKind,
        memory: &mut SolverMemory<'_, R>,
    ) {
        let forces = mixing.forces(changed, &self.reference);
        let Self { grid, units, stage, fit, .. } = self;
        let Stage::Changes(Change { work: Work::Poles(search), .. }) = stage else { return };
        let (stored, scratch) = changed_motions(units, kind, memory);
        let length = changed.characteristic_length();
        let found = stored
            .responses(grid.count(), &forces, length)
            .and_then(|responses| search.step(&responses, scratch));
        match found {
            Some(Progress::Going) => {}
            Some(Progress::Done) => {
                let poles = search.found().poles.clone();
                if kind == ChangeKind::None {
                    fit.relocated = poles.clone();
                }
                self.set_work(Work::Residues(poles, ResidueFit::default()));
            }
            None => self.end_change(kind, memory),
        }
    }

    /// Fits the residues at these poles.
    #[inline(never)]
    fn residues_of_change(
        &mut self,
        mixing: &ForceMixing<R, RIG_HITS>,
        changed: &RigLayout<R>,
        kind: ChangeKind,
        memory: &mut SolverMemory<'_, R>,
    ) {
        let forces = mixing.forces(changed, &self.reference);
        let Self { grid, units, stage, .. } = self;
        let Stage::Changes(Change { work: Work::Residues(poles, residues), .. }) = stage else {
            return;
        };
        let (stored, scratch) = changed_motions(units, kind, memory);
        let length = changed.characteristic_length();
        let fitted = stored
            .responses(grid.count(), &forces, length)
            .and_then(|responses| residues.step(&responses, poles, scratch));
        match fitted {
            Some(Progress::Going) => {}
            Some(Progress::Done) => {
                let poles = poles.clone();
                self.set_work(Work::Modes(poles));
            }
            None => self.end_change(kind, memory),
        }
    }

    /// Asks the methods that need the modes alone.
    #[inline(never)]
    fn modes_of_change(
        &mut self,
        mixing: &ForceMixing<R, RIG_HITS>,
        changed: &RigLayout<R>,
        kind: ChangeKind,
        memory: &mut SolverMemory<'_, R>,
    ) {
        let forces = mixing.forces(changed, &self.reference);
        let Self { grid, units, stage, fit, answers, reference, deviations, .. } = self;
        let Stage::Changes(change) = stage else { return };
        let Work::Modes(poles) = &change.work else { return };
        let (stored, scratch) = changed_motions(units, kind, memory);
        let length = changed.characteristic_length();
        let Some(responses) = stored.responses(grid.count(), &forces, length) else { return };
        let Some(residues) = Residues::new(&responses, poles, scratch) else { return };
        let mut modes = Modes::empty();
        if modes.find(&responses, &residues).is_none() {
            return self.end_change(kind, memory);
        }
        let kept = fit.kept.iter().map(|place| usize::from(*place));
        let Some(places) = found_again(&modes.poles, &fit.poles, kept) else {
            return self.end_change(kind, memory);
        };
        modes.keep(&places);
        deviations.add(&modes.modes, matches!(kind, ChangeKind::Noise(_)));
        let (of_modes, noise) = (fit.lines(responses.s), fit.noise);
        let observed = Observed { responses: &responses, modes: &modes, lines: &of_modes, noise };
        for (method, to) in of_modes_alone(&mut change.answers) {
            if answers[place_of(method)].answer().is_some() {
                let found = answer(method, changed, reference, &observed);
                *to = found.ok().map(|answer| answer.body.theta());
            }
        }
        change.work = Work::Forms(Forms::default());
    }

    /// Asks the direct method.
    #[inline(never)]
    fn forms_of_change(
        &mut self,
        mixing: &ForceMixing<R, RIG_HITS>,
        changed: &RigLayout<R>,
        kind: ChangeKind,
        memory: &mut SolverMemory<'_, R>,
    ) {
        let forces = mixing.forces(changed, &self.reference);
        let Self { grid, units, stage, fit, answers, reference, .. } = self;
        let Stage::Changes(change) = stage else { return };
        let Work::Forms(forms) = &mut change.work else { return };
        let (stored, _) = changed_motions(units, kind, memory);
        let length = changed.characteristic_length();
        let Some(responses) = stored.responses(grid.count(), &forces, length) else { return };
        let of_modes = fit.lines(responses.s);
        let near = NearModes { responses: &responses, lines: &of_modes, noise: fit.noise };
        let wanted = |method| answers[place_of(method)].answer().is_some();
        let answered = &mut change.answers;
        let progress = forms.step(&near, wanted, |method, answer| {
            let found = answer.and_then(|answer| of_object(changed, reference, &answer));
            answered[place_of(method)] = found.ok().map(|answer| answer.body.theta());
        });
        if progress == Progress::Done {
            self.end_change(kind, memory);
        }
    }

    /// Takes the answers to a change.
    #[inline(never)]
    fn end_change(&mut self, kind: ChangeKind, memory: &mut SolverMemory<'_, R>) {
        let Stage::Changes(change) = &self.stage else { return };
        let (now, before) = (&change.answers, &self.unchanged);
        let moved = core::array::from_fn(|m| now[m].zip(before[m]).map(|(new, old)| new - old));
        let readings = &mut *memory.readings;
        match (kind, &mut self.propagation) {
            (ChangeKind::None, _) => self.unchanged = *now,
            (ChangeKind::Noise(_), Some(sums)) => sums.add_draw(readings, &moved),
            (_, Some(sums)) => sums.add_shift(readings, &moved),
            (_, None) => {}
        }
        self.next_change(kind, memory);
    }

    fn next_change(&mut self, kind: ChangeKind, memory: &mut SolverMemory<'_, R>) {
        let Stage::Changes(change) = &mut self.stage else { return };
        if change.number == DRAWS
            && let Some(sums) = &self.propagation
        {
            sums.end_draws(memory.readings);
        }
        change.cost[0] += kind.cost();
        change.number += 1;
        change.work = Work::Begin;
    }
}

/// The motions of a change, and the memory for equations.
fn changed_motions<'a, R: Real>(
    units: &'a [Exponents; 2],
    kind: ChangeKind,
    memory: &'a mut SolverMemory<'_, R>,
) -> (Stored<'a, R>, &'a mut [R]) {
    let SolverMemory { codes, scratch, weights, lines, .. } = memory;
    let region = usize::from(kind.changes_motions());
    let codes = codes.get(region * CompactMotions::<R>::CODES..).unwrap_or(&[]);
    (Stored { codes, units: &units[region], lines, weights }, scratch)
}
