//! During a campaign: which further hit DOF would narrow the interval of the worst property most.
//!
//! The search compares the bound of the DOFs measured so far with the bound of these and one more, for the
//! body, the noise and the error budget that the data show. A rig calls [`FurtherHitSearch::step`] repeatedly,
//! with other work in between; each step evaluates one bound.

use super::{Criterion, Precision, Predict};
use crate::capacity::Capacity;
use crate::identify::maximum_likelihood::BudgetScales;
use crate::identify::{DofMassLines, Estimate, Progress};
use crate::layout::{Hit, Layout};
use crate::real::Real;

/// A hit that narrows the interval by a smaller share than this does not help: what limits the interval is then
/// the same in all hits, such as the hammer's gain.
const NOTICEABLE: f64 = 0.01;

/// The DOFs among which a search chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitCandidates {
    /// Those of the layout behind all that have mass lines: a campaign does not return to one that was skipped.
    Following,
    /// Those with mass lines, to be hit as often again.
    Measured,
}

/// The hit that narrows the interval of the worst property most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FurtherHit<R> {
    /// Index of the DOF in the layout.
    pub dof: usize,
    /// Index of the worst property in `theta`.
    pub property: usize,
    /// Expected half width of its 95 % interval with that hit, in its unit.
    pub half_width: R,
}

/// A search in progress.
#[derive(Clone, Debug, PartialEq)]
pub struct FurtherHitSearch<R> {
    criterion: Criterion<R>,
    scales: BudgetScales<R>,
    candidates: HitCandidates,
    property: usize,
    half_width: R,
    /// The cost of the DOFs measured so far; `None` before the first step.
    present: Option<R>,
    /// Index of the next DOF to look at.
    next: usize,
    best: Option<(usize, R)>,
}

impl<R: Real> FurtherHitSearch<R> {
    /// A search from the estimate and the mass lines so far, with `sensors` triaxial sensors.
    pub fn new<C: Capacity>(
        precision: &Precision<R>,
        estimate: &Estimate<R>,
        lines: &[DofMassLines<R, C>],
        sensors: usize,
        candidates: HitCandidates,
    ) -> Self {
        let (property, _) = precision.worst();
        let single_hit = |lines: &DofMassLines<R, C>| {
            lines.1.noise.norm_squared() * R::of(f64::from(lines.1.hits.max(1)))
        };
        let sum = lines.iter().fold(R::zero(), |sum, lines| sum + single_hit(lines));
        let noise = (sum / R::of((3 * sensors * lines.len()).max(1) as f64)).sqrt();
        let (body, scale) = (estimate.body, precision.scale);
        Self {
            criterion: Criterion { body, noise, scale }.of_property(property),
            scales: estimate.learned.map_or_else(BudgetScales::default, |learned| learned.scales),
            candidates,
            property,
            half_width: precision.half_widths[property],
            present: None,
            next: 0,
            best: None,
        }
    }

    /// Evaluates one bound. Layout, mass lines and workspace must be the same in every step.
    pub fn step<C: Capacity>(
        &mut self,
        layout: &Layout<R, C>,
        lines: &[DofMassLines<R, C>],
        workspace: &mut [R],
    ) -> Progress {
        let mut measured = layout.clone();
        self.scales.apply_to(&mut measured);
        let index = self.next_candidate(measured.hits.len(), lines);
        let candidate = index.and_then(|index| measured.hits.get(index).copied());
        let place = index.and_then(|index| lines.iter().position(|(dof, _)| *dof == index));
        let hits = lines.iter().filter_map(|(dof, _)| measured.hits.get(*dof).copied()).collect();
        measured.hits = hits;
        if self.present.is_none() {
            self.present = self.criterion.cost(&measured, workspace);
            return if self.present.is_some() { Progress::Going } else { Progress::Done };
        }
        let (Some(index), Some(candidate)) = (index, candidate) else { return Progress::Done };
        self.next = index + 1;
        if let Some(cost) = self.cost_with(&measured, candidate, place, workspace)
            && self.best.is_none_or(|(_, least)| cost < least)
        {
            self.best = Some((index, cost));
        }
        Progress::Going
    }

    /// The next DOF to look at.
    fn next_candidate<C: Capacity>(
        &self,
        dofs: usize,
        lines: &[DofMassLines<R, C>],
    ) -> Option<usize> {
        let is_candidate = |dof: usize| match self.candidates {
            HitCandidates::Measured => lines.iter().any(|(other, _)| *other == dof),
            HitCandidates::Following => lines.iter().all(|(other, _)| *other < dof),
        };
        (self.next..dofs).find(|&dof| is_candidate(dof))
    }

    /// The cost with the hit; `place` is that of its DOF among the measured ones.
    fn cost_with<C: Capacity>(
        &self,
        measured: &Layout<R, C>,
        hit: Hit<R>,
        place: Option<usize>,
        workspace: &mut [R],
    ) -> Option<R> {
        match place {
            Some(place) => self.criterion.cost_with_repeated_hit(measured, place, workspace),
            None => Some(self.criterion.best_further_hit(measured, [hit], workspace)?.1),
        }
    }

    /// The best hit of a search that is done; `None` when none narrows the interval by 1 %.
    pub fn best_hit(&self) -> Option<FurtherHit<R>> {
        let (dof, cost) = self.best?;
        let narrower = (cost / self.present?).sqrt();
        let half_width = self.half_width * narrower;
        (narrower < R::of(1.0 - NOTICEABLE)).then_some(FurtherHit {
            dof,
            property: self.property,
            half_width,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Rig;
    use crate::identify::maximum_likelihood::RIG_WORKSPACE;
    use crate::identify::{
        Identification, IdentifySettings, MASS_LINE_METHODS, MassLines, Method, Observations,
    };
    use crate::layout::Target;
    use crate::layout::tests::{bar_body, bar_layout};

    type Wide = Layout<f64, Rig>;
    type Lines = std::vec::Vec<DofMassLines<f64, Rig>>;

    /// The three-bar frame with five hits: two more at the nodes of the first three.
    fn layout() -> Wide {
        let mut layout: Wide = bar_layout().cast().unwrap();
        // After a calibration with a known mass; otherwise no hit helps against the gain of the hammer.
        layout.apparatus.hammer_gain = 0.0;
        let [first, second, _] = [0, 1, 2].map(|k| layout.hits[k]);
        for (like, name, direction) in
            [(first, "1:+Z", [0.0, 0.0, 1.0]), (second, "2:+X", [1.0, 0.0, 0.0])]
        {
            let dof = name.parse().unwrap();
            layout.hits.push(Hit { dof, direction, ..like }).unwrap();
        }
        layout
    }

    /// Exact mass lines of the first `count` DOFs, with a noise of 0.5 % of 1/m for each of five hits.
    fn lines(layout: &Wide, count: usize) -> Lines {
        let exact_lines = |dof: usize| {
            let mut lines =
                MassLines::without_scatter(layout.accelerance(&bar_body(), dof).unwrap());
            (lines.hits, lines.noise) = (5, lines.noise.map(|_| 0.004 / 5_f64.sqrt()));
            (dof, lines)
        };
        (0..count).map(exact_lines).collect()
    }

    fn search(layout: &Wide, lines: &Lines, candidates: HitCandidates) -> Option<FurtherHit<f64>> {
        let mut memory = [0.0; RIG_WORKSPACE];
        let observed = Observations::of_mass_lines(layout, lines);
        let mut identification = Identification::<f64, MASS_LINE_METHODS>::idle();
        identification.begin(Method::of_mass_lines());
        while identification.step(&observed, &IdentifySettings::default(), &mut memory)
            == Progress::Going
        {}
        let length = layout.characteristic_length();
        let precision =
            Precision::of(identification.estimates(), Target::default(), length).unwrap();
        let best = &identification.estimates()[0];
        let mut search = FurtherHitSearch::new(&precision, best, lines, 3, candidates);
        while search.step(layout, lines, &mut memory) == Progress::Going {}
        let hit = search.best_hit()?;
        assert_eq!(hit.property, precision.worst().0);
        assert!(hit.half_width < precision.half_widths[hit.property]);
        Some(hit)
    }

    #[test]
    fn the_hit_found_is_the_one_whose_bound_is_smallest() {
        let layout = layout();
        let lines = lines(&layout, 3);
        let best = search(&layout, &lines, HitCandidates::Following).unwrap();
        // Without the search: the standard deviation of that property with either hit added.
        let mut memory = [0.0; RIG_WORKSPACE];
        let mut sigma = |extra: usize| {
            let mut layout = layout.clone();
            let hit = layout.hits[extra];
            layout.hits.truncate(3);
            layout.hits.push(hit).unwrap();
            let criterion = Criterion { noise: 0.004, ..Criterion::new(bar_body(), 0.14, 0.0) };
            criterion.bound(&layout, &mut memory).unwrap().sigma()[best.property]
        };
        let (third, fourth) = (sigma(3), sigma(4));
        assert_eq!(best.dof, if third < fourth { 3 } else { 4 });
    }

    #[test]
    fn a_hit_that_was_skipped_is_not_advised() {
        let layout = layout();
        let five_dofs = lines(&layout, 5);
        for skipped in 0..3 {
            let kept: Lines =
                five_dofs.iter().take(4).filter(|(dof, _)| *dof != skipped).cloned().collect();
            let advice = search(&layout, &kept, HitCandidates::Following);
            assert!(advice.is_none_or(|hit| hit.dof == 4), "{skipped}: {advice:?}");
        }
    }

    #[test]
    fn no_hit_helps_against_what_is_the_same_in_all_of_them() {
        let mut layout = layout();
        // The mass and all moments are as uncertain as the gain of the hammer.
        layout.apparatus.hammer_gain = 0.2;
        let lines = lines(&layout, 3);
        assert_eq!(search(&layout, &lines, HitCandidates::Following), None);
    }

    #[test]
    fn with_every_dof_measured_only_hitting_again_is_left() {
        let layout = layout();
        let lines = lines(&layout, 5);
        assert_eq!(search(&layout, &lines, HitCandidates::Following), None);
        let again = search(&layout, &lines, HitCandidates::Measured).unwrap();
        assert!(again.dof < 5);
    }
}
