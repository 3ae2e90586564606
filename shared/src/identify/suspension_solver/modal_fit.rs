//! From motions to the suspension modes, what they show, and what the methods answer.

use nalgebra::{Complex, Vector6};

use super::answering::{Forms, of_modes_alone, place_of};
use super::changes::Change;
use super::{
    MethodAnswer, RigLayout, SolverMemory, Stage, Stored, SuspensionMode, SuspensionSolver,
};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, fatal};
use crate::identify::Method;
use crate::identify::agreement::PackedPropagation;
use crate::identify::dppim::{NearModes, worse_form};
use crate::identify::driving_points::points_at_lines;
use crate::identify::suspension::{
    Observed, Selection, answer, lines_about, mode_findings, of_object, select, suspects,
};
use crate::layout::RIG_HITS;
use crate::modes::{ForceMixing, LinesPerSide, Modes, OriginResponses, ResidueFit, Residues};
use crate::{Progress, Real};

impl<R: Real> SuspensionSolver<R> {
    /// Runs one step of the search for the order.
    #[inline(never)]
    pub(super) fn step_orders(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let forces = self.mixing(layout).forces(layout, &self.reference);
        let Self { grid, units, stage, fit, .. } = self;
        let Stage::Orders(search) = stage else { return Progress::Going };
        let SolverMemory { codes, scratch, weights, lines, .. } = memory;
        let stored = Stored { codes, units: &units[0], lines, weights };
        let length = layout.characteristic_length();
        let Some(responses) = stored.responses(grid.count(), &forces, length) else {
            return self.fail(missing());
        };
        if search.step(&responses, scratch) == Progress::Going {
            return Progress::Going;
        }
        let Some(order) = search.sufficient() else { return self.fail(missing()) };
        fit.noise = order.noise_variance().sqrt();
        fit.poles = order.poles.clone();
        *stage = Stage::Residues(ResidueFit::default());
        Progress::Going
    }

    /// Runs one step of the residues of these poles.
    #[inline(never)]
    pub(super) fn step_residues(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let forces = self.mixing(layout).forces(layout, &self.reference);
        let units = self.units[0];
        let Self { grid, stage, fit, .. } = self;
        let Stage::Residues(residues) = stage else { return Progress::Going };
        let SolverMemory { codes, scratch, weights, lines, .. } = memory;
        let stored = Stored { codes, units: &units, lines, weights };
        let length = layout.characteristic_length();
        let Some(responses) = stored.responses(grid.count(), &forces, length) else {
            return self.fail(missing());
        };
        match residues.step(&responses, &fit.poles, scratch) {
            Some(Progress::Going) => Progress::Going,
            Some(Progress::Done) => {
                *stage = Stage::Modes;
                Progress::Going
            }
            None => self.fail(missing()),
        }
    }

    /// Takes the modes that these residues give.
    #[inline(never)]
    pub(super) fn step_modes(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let forces = self.mixing(layout).forces(layout, &self.reference);
        let units = self.units[0];
        let SolverMemory { codes, scratch, weights, lines, .. } = memory;
        let stored = Stored { codes, units: &units, lines, weights };
        let length = layout.characteristic_length();
        let Some(responses) = stored.responses(self.grid.count(), &forces, length) else {
            return self.fail(missing());
        };
        let poles = self.fit.poles.clone();
        let Some(residues) = Residues::new(&responses, &poles, scratch) else {
            return self.fail(missing());
        };
        let mut modes = Modes::empty();
        let Some(places) = modes.find(&responses, &residues) else { return self.fail(missing()) };
        self.found(layout, &responses, &mut modes, &places)
    }

    /// Errors for points that do not move at the resonances as accelerations under a force do.
    #[inline(never)]
    fn suspect_points(
        &self,
        layout: &RigLayout<R>,
        responses: &OriginResponses<'_, R>,
    ) -> Diagnostics {
        let lines = lines_about(&self.fit.poles, responses.s, LinesPerSide::Width);
        let near = lines.below.iter().chain(&lines.above).copied();
        let mixing = self.mixing(layout);
        let points = points_at_lines(layout, &self.reference, near, |line, of_hits| {
            *of_hits = (0..layout.hits.len())
                .map(|hit| motion_of_hit(responses, &mixing, line, hit))
                .collect();
            Some(())
        });
        points.map_or_else(Diagnostics::new, |points| suspects(&points))
    }

    /// Takes the modes, and asks the methods that need nothing else.
    #[inline(never)]
    fn found(
        &mut self,
        layout: &RigLayout<R>,
        responses: &OriginResponses<'_, R>,
        modes: &mut Modes<R>,
        places: &[usize],
    ) -> Progress {
        let Selection { kept, one_more } = select(modes, responses.s, responses.length);
        if places.len() < self.fit.poles.len() || kept.is_empty() {
            let suspect = self.suspect_points(layout, responses);
            if !suspect.is_empty() {
                return self.fail(suspect);
            }
        }
        if kept.is_empty() {
            return self.fail(missing());
        }
        if let Some(error) = one_more.filter(Diagnostic::is_error) {
            return self.fail(Diagnostics::from_array([error]));
        }
        modes.keep(&kept);
        // Places are below the number of pairs of poles.
        self.fit.kept = kept.iter().map(|kept| places[*kept] as u8).collect();
        self.fit.modes = modes.modes.iter().map(SuspensionMode::of).collect();
        self.diagnostics = mode_findings(modes, responses);
        self.diagnostics.extend(one_more);
        if layout.lacks_gravity() && !self.diagnostics.is_full() {
            let finding = Diagnostic::whole(Code::GravityNotGiven, Severity::Warning, 0.0);
            self.diagnostics.extend([finding]);
        }
        let Self { fit, reference, answers, .. } = self;
        let lines = fit.lines(responses.s);
        let observed = Observed { responses, modes, lines: &lines, noise: fit.noise };
        for (method, to) in of_modes_alone(answers) {
            *to = MethodAnswer::of(answer(method, layout, reference, &observed));
        }
        self.stage = Stage::Forms(Forms::default());
        Progress::Going
    }

    /// Runs one step of the direct method.
    #[inline(never)]
    pub(super) fn step_forms(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let forces = self.mixing(layout).forces(layout, &self.reference);
        let Self { grid, units, stage, fit, answers, reference, .. } = self;
        let Stage::Forms(forms) = stage else { return Progress::Going };
        let SolverMemory { codes, weights, lines, .. } = memory;
        let stored = Stored { codes, units: &units[0], lines, weights };
        let length = layout.characteristic_length();
        let Some(responses) = stored.responses(grid.count(), &forces, length) else {
            return Progress::Going;
        };
        let of_modes = fit.lines(responses.s);
        let near = NearModes { responses: &responses, lines: &of_modes, noise: fit.noise };
        let progress = forms.step(
            &near,
            |_| true,
            |method, answer| {
                let of_object = answer.and_then(|answer| of_object(layout, reference, &answer));
                answers[place_of(method)] = MethodAnswer::of(of_object);
            },
        );
        if progress == Progress::Done {
            self.refuse_worse_form();
            self.propagation = PackedPropagation::new(memory.readings);
            self.stage = Stage::Changes(Change::first(layout));
        }
        Progress::Going
    }

    /// Refuses the form of the direct method that fits clearly worse than the other.
    fn refuse_worse_form(&mut self) {
        let misfit = |method: Method| self.answers[place_of(method)].answer()?.misfit;
        let pair = misfit(Method::Dppim).zip(misfit(Method::DppimStructural));
        let worse = pair.and_then(|(viscous, structural)| worse_form(viscous, structural));
        if let Some((method, code, times)) = worse {
            let reason = Diagnostic::whole(code, Severity::Error, times.to_f32());
            self.answers[place_of(method)] = MethodAnswer::Refused(reason);
        }
    }
}

/// The motion of the reference point under a hit of the layout: the body moves under six mixed forces as under all.
fn motion_of_hit<R: Real>(
    responses: &OriginResponses<'_, R>,
    mixing: &ForceMixing<R, RIG_HITS>,
    line: usize,
    hit: usize,
) -> Vector6<Complex<R>> {
    let zero = Vector6::from_element(Complex::new(R::zero(), R::zero()));
    (0..mixing.count()).fold(zero, |sum, force| {
        let share = Complex::new(mixing.share(force, hit), R::zero());
        sum + responses.motion(line, force) * share
    })
}

fn missing() -> Diagnostics {
    fatal(Code::SuspensionModesMissing, 0.0)
}
