//! During a campaign of the suspension profile: which modes the points measured so far show, and which point to hit next.

use massline_shared::FrequencyResponses;
use massline_shared::identify::suspension::clear_modes;
use massline_shared::layout::{Dof, Hit, HostLayout};
use massline_shared::modes::{Mode, Reduction, SUSPENSION_MODES, Shown};
use massline_shared::signal::AdcProperties;

use crate::output::counted;
use crate::report::{HitDirections, NEW, do_not_show, two_digits};
use crate::suspension::{DofLines, HostFit, TestLines};
use massline_result::{ModesSoFar, NextPoint, SeenMode};

/// A measured hit that shows less than this share of the most that any hit could is not enough: half of it doubles the error of
/// the shape.
const WELL: f64 = 0.5;
/// A further point is named where it shows so many times what the points so far show.
const MUCH_BETTER: f64 = 1.5;

/// The lines of the DOFs that have been read so far, and the reports after each.
#[derive(Clone, Debug)]
pub struct ModesMonitor {
    layout: HostLayout,
    adc: AdcProperties,
    dofs: Vec<DofLines>,
    reports: Vec<ModesSoFar>,
}

impl ModesMonitor {
    /// A monitor for a campaign with this layout on a rig with this converter.
    pub fn new(layout: HostLayout, adc: AdcProperties) -> Self {
        Self { layout, adc, dofs: Vec::new(), reports: Vec::new() }
    }

    /// True when the lines of the DOF with this index are known.
    pub fn knows(&self, index: u8) -> bool {
        self.dofs.iter().any(|lines| lines.dof == usize::from(index))
    }

    /// Forgets the lines of a DOF that is measured again; returns whether they were known.
    pub fn forget(&mut self, index: u8) -> bool {
        let before = self.dofs.len();
        self.dofs.retain(|lines| lines.dof != usize::from(index));
        self.dofs.len() < before
    }

    /// The number of DOFs whose lines are known.
    pub fn measured(&self) -> usize {
        self.dofs.len()
    }

    /// Takes the lines of a DOF.
    pub fn add(&mut self, dof: DofLines) {
        self.dofs.push(dof);
        self.dofs.sort_by_key(|lines| lines.dof);
    }

    /// True when the last report counts points that are no longer asked for; `left` as for [`Self::report`].
    pub fn is_outdated(&self, left: &[usize]) -> bool {
        let count = self.dofs.len() + self.still_open(left).count();
        self.reports.last().is_some_and(|last| last.dofs != count)
    }

    /// What all DOFs so far show, with a rig that still asks for those of `left`, by their indices in the layout, unless they are
    /// known. It is also kept for [`Self::into_reports`].
    pub fn report(&mut self, left: &[usize]) -> &ModesSoFar {
        let report = self.latest(left);
        self.reports.push(report);
        &self.reports[self.reports.len() - 1]
    }

    /// All reports, in the order of the campaign.
    pub fn into_reports(self) -> Vec<ModesSoFar> {
        self.reports
    }

    fn latest(&self, left: &[usize]) -> ModesSoFar {
        let test = TestLines::new(&self.layout, &self.adc, &self.dofs);
        let modes = test
            .responses()
            .map_or_else(|_| Vec::new(), |responses| shown_modes(test.layout(), &responses));
        let seen = modes.iter().map(|(mode, shown)| SeenMode {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            dof: test.layout().hits[shown.hit].dof.to_string(),
            norm_indicator: shown.indicator,
            share_of_possible: shown.share().min(1.0),
        });
        let left: Vec<&Hit<f64>> = self.still_open(left).collect();
        let measured = test.layout().hits.len();
        ModesSoFar {
            dofs_measured: measured,
            dofs: measured + left.len(),
            modes: seen.collect(),
            modes_missing: SUSPENSION_MODES.saturating_sub(modes.len()),
            next: next(test.layout(), &modes, &left),
        }
    }

    /// The hits of these DOFs whose lines are not known.
    fn still_open(&self, left: &[usize]) -> impl Iterator<Item = &Hit<f64>> {
        let is_open = |dof: &usize| self.dofs.iter().all(|lines| lines.dof != *dof);
        left.iter().filter(move |dof| is_open(dof)).filter_map(|dof| self.layout.hits.get(*dof))
    }
}

/// The point to hit next: of those that are `left`, the one that pushes most unlike the others while modes are missing, then the
/// one that shows much more of the mode that shows worst. Where there is none, a point that the layout would need. `measured`
/// has the hits so far.
fn next(
    measured: &HostLayout,
    modes: &[(Mode<f64>, Shown<f64>)],
    left: &[&Hit<f64>],
) -> Option<NextPoint> {
    let reference = measured.sensor_centroid();
    let best_left = |score: &dyn Fn(&Hit<f64>) -> f64, least: f64| {
        let scored = left.iter().enumerate().map(|(before, hit)| (score(hit), before, hit.dof));
        scored.filter(|(score, ..)| *score > least).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let of_layout = |(_, before, dof): (f64, usize, Dof)| NextPoint {
        dof: dof.to_string(),
        points_before: Some(before),
    };
    let of_body = |dof: String| NextPoint { dof, points_before: None };
    if modes.len() < SUSPENSION_MODES {
        let so_far = HitDirections::of(measured)?;
        let outside = |hit: &Hit<f64>| so_far.share_outside(&hit.unit_force(&reference));
        return match best_left(&outside, NEW) {
            Some(point) => Some(of_layout(point)),
            None => so_far.newest(measured).map(|place| of_body(place.dof())),
        };
    }
    let (mode, worst) = worst_of(modes)?;
    if worst.share() >= WELL {
        return None;
    }
    let length = measured.characteristic_length();
    let indicator = |hit: &Hit<f64>| mode.indicator(&hit.unit_force(&reference), length);
    match best_left(&indicator, MUCH_BETTER * worst.indicator) {
        Some(point) => Some(of_layout(point)),
        None => worst.is_hardly_shown().then(|| of_body(worst.better.to_string())),
    }
}

/// The suspension modes that these readings show clearly, and how well; none where they show none.
fn shown_modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
) -> Vec<(Mode<f64>, Shown<f64>)> {
    let mut memory = Box::new(Reduction::new());
    let Ok(fit) = HostFit::new(layout, readings, &mut memory) else { return Vec::new() };
    let clear = clear_modes(fit.modes(), layout.characteristic_length());
    let shown = |mode: &Mode<f64>| Shown::of(&mode.shape, layout, 0..layout.hits.len());
    clear.filter_map(|mode| Some((mode.clone(), shown(mode)?))).collect()
}

/// What may be lacking in readings that have no answer: the modes that do not show, or hardly, and a hit that would show them.
/// `None` where all of them show.
pub fn lacking_modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
) -> Option<String> {
    let modes = shown_modes(layout, readings);
    let shown = match SUSPENSION_MODES.saturating_sub(modes.len()) {
        0 => {
            let (mode, worst) = worst_of(&modes).filter(|(_, shown)| shown.is_hardly_shown())?;
            let percent = 100.0 * worst.share();
            format!(
                "the mode of {:.2} Hz hardly shows ({percent:.0} % of the largest possible)",
                mode.frequency_hz
            )
        }
        missing => do_not_show(missing),
    };
    Some(match next(layout, &modes, &[]) {
        None => shown,
        Some(NextPoint { dof, .. }) => {
            format!("{shown}; a hit at {dof} (axes of the body) would show more")
        }
    })
}

fn worst_of(modes: &[(Mode<f64>, Shown<f64>)]) -> Option<&(Mode<f64>, Shown<f64>)> {
    modes.iter().min_by(|a, b| a.1.share().total_cmp(&b.1.share()))
}

/// `2 of 5 points`.
pub fn progress(of: &ModesSoFar) -> String {
    format!("{} of {} points", of.dofs_measured, of.dofs)
}

/// A line for each mode: frequency, the hit that shows it best, its Norm Indicator.
pub fn rows(of: &ModesSoFar) -> Vec<String> {
    let row = |mode: &SeenMode| {
        let SeenMode { frequency_hz, dof, norm_indicator, share_of_possible, .. } = mode;
        format!(
            "{:>7} Hz  {dof:8} {} ({:.0} % of the largest possible)",
            format!("{frequency_hz:.2}"),
            two_digits(*norm_indicator),
            100.0 * share_of_possible,
        )
    };
    of.modes.iter().map(row).collect()
}

/// What is missing, and what to hit next.
pub fn advice(of: &ModesSoFar) -> String {
    let seen = match of.modes_missing {
        0 => all_show(of),
        missing if of.dofs_measured < of.dofs => {
            format!("{} yet", do_not_show(missing))
        }
        missing => do_not_show(missing),
    };
    let why = match of.modes_missing {
        0 => "shows that mode better",
        _ => "pushes most unlike the points so far",
    };
    match &of.next {
        None if of.modes_missing > 0 => {
            format!("{seen}, and the points push in all directions: hit harder or more often")
        }
        None if of.dofs_measured < of.dofs => {
            format!("{seen}; the points to come make the answer more certain")
        }
        None => seen,
        Some(NextPoint { dof, points_before: Some(0) }) => {
            format!("{seen}; hit {dof} next: it {why}")
        }
        Some(NextPoint { dof, points_before: Some(before) }) => {
            let later = counted(*before as u32, "more point");
            format!("{seen}; {dof}, after {later}, {why}: do not leave it out")
        }
        Some(NextPoint { dof, points_before: None }) => {
            format!("{seen}; add {dof} (axes of the body) to the layout: it {why}")
        }
    }
}

/// That all six modes show, and which of them does not show well.
fn all_show(of: &ModesSoFar) -> String {
    let worst = of.modes.iter().min_by(|a, b| a.share_of_possible.total_cmp(&b.share_of_possible));
    match worst.filter(|mode| mode.share_of_possible < WELL) {
        None => "all six modes show".into(),
        Some(mode) => format!(
            "all six modes show, that of {:.2} Hz with only {:.0} % of the largest possible",
            mode.frequency_hz,
            100.0 * mode.share_of_possible
        ),
    }
}

/// The report as text: a heading, a line for each mode, the advice.
pub fn text(of: &ModesSoFar) -> String {
    let heading = format!(
        "after {}, modes seen, each with the hit that shows it best and its Norm Indicator:",
        progress(of)
    );
    let heading = if of.modes.is_empty() { format!("after {}:", progress(of)) } else { heading };
    let lines = [vec![heading], rows(of), vec![advice(of)]].concat();
    lines.join("\n  ")
}

#[cfg(test)]
mod tests;
