//! During a campaign of the suspension profile: which modes the points measured so far show, and which point to hit
//! next.

use massline_shared::FrequencyResponses;
use massline_shared::identify::suspension::clear_modes;
use massline_shared::layout::{Dof, Hit, HostLayout};
use massline_shared::modes::{Mode, ModeVisibility, Reduction, SUSPENSION_MODES};
use massline_shared::signal::AdcProperties;

use crate::suspension::{DofLines, HostFit, TestLines};
use crate::where_to_hit::{HitDirections, NEW};
use massline_result::{ModesSoFar, NextPoint, SeenMode};

/// A measured hit that shows less than this share of the most that any hit could is not enough: half of it doubles the
/// error of the shape.
pub const WELL: f64 = 0.5;
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

    /// What all DOFs so far show, with a rig that still asks for those of `left`, by their indices in the layout,
    /// unless they are known. It is also kept for [`Self::into_reports`].
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

/// The point to hit next: of those that are `left`, the one that pushes most unlike the others while modes are missing,
/// then the one that shows much more of the mode that shows worst. Where there is none, a point that the layout would
/// need. `measured` has the hits so far.
fn next(
    measured: &HostLayout,
    modes: &[(Mode<f64>, ModeVisibility<f64>)],
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
) -> Vec<(Mode<f64>, ModeVisibility<f64>)> {
    let mut memory = Box::new(Reduction::new());
    let Ok(fit) = HostFit::new(layout, readings, &mut memory) else { return Vec::new() };
    let clear = clear_modes(fit.modes(), layout.characteristic_length());
    let shown = |mode: &Mode<f64>| ModeVisibility::of(&mode.shape, layout, 0..layout.hits.len());
    clear.filter_map(|mode| Some((mode.clone(), shown(mode)?))).collect()
}

/// What may be lacking in readings that have no answer.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingModes {
    /// How many of the suspension modes do not show.
    pub missing: usize,
    /// Where all show: the frequency of the one that hardly does, Hz, and its share of the largest possible.
    pub hardly: Option<(f64, f64)>,
    /// A hit that would show more, along an axis of the body.
    pub hit: Option<String>,
}

/// The modes that do not show in readings, or hardly, and a hit that would show them. `None` where all of them show.
pub fn lacking_modes(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
) -> Option<MissingModes> {
    let modes = shown_modes(layout, readings);
    let missing = SUSPENSION_MODES.saturating_sub(modes.len());
    let hardly = worst_of(&modes).filter(|(_, shown)| missing == 0 && shown.is_hardly_shown());
    let hardly = hardly.map(|(mode, shown)| (mode.frequency_hz, shown.share()));
    (missing > 0 || hardly.is_some()).then(|| {
        let hit = next(layout, &modes, &[]).map(|point| point.dof);
        MissingModes { missing, hardly, hit }
    })
}

fn worst_of(
    modes: &[(Mode<f64>, ModeVisibility<f64>)],
) -> Option<&(Mode<f64>, ModeVisibility<f64>)> {
    modes.iter().min_by(|a, b| a.1.share().total_cmp(&b.1.share()))
}

#[cfg(test)]
mod tests;
