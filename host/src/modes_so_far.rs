//! During a campaign of the suspension profile: which modes the points measured so far show, and which point to hit next.

use massline_shared::layout::{Dof, HostLayout};
use massline_shared::modes::{Mode, Reduction, SUSPENSION_MODES, Shown};
use massline_shared::signal::AdcProperties;

use crate::document::{ModesSoFar, NextPoint, SeenMode};
use crate::output::counted;
use crate::report::{HitDirections, NEW, two_digits};
use crate::suspension::{DofLines, HostFit, TestLines};

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

    /// What all DOFs so far show; it is also kept for [`Self::into_reports`].
    pub fn report(&mut self) -> &ModesSoFar {
        let report = self.latest();
        self.reports.push(report);
        &self.reports[self.reports.len() - 1]
    }

    /// All reports, in the order of the campaign.
    pub fn into_reports(self) -> Vec<ModesSoFar> {
        self.reports
    }

    fn latest(&self) -> ModesSoFar {
        let test = TestLines::new(&self.layout, &self.adc, &self.dofs);
        let modes = modes_of(&test);
        let hits = 0..test.layout().hits.len();
        let shown: Vec<(Mode<f64>, Shown<f64>)> = modes
            .into_iter()
            .filter_map(|mode| {
                let shown = Shown::of(&mode.shape, test.layout(), hits.clone())?;
                Some((mode, shown))
            })
            .collect();
        let seen = shown.iter().map(|(mode, shown)| SeenMode {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            dof: test.layout().hits[shown.hit].dof.to_string(),
            norm_indicator: shown.indicator,
            share_of_possible: shown.share().min(1.0),
        });
        ModesSoFar {
            dofs_measured: hits.len(),
            dofs: self.layout.hits.len(),
            modes: seen.collect(),
            modes_missing: SUSPENSION_MODES.saturating_sub(shown.len()),
            next: self.next(&test, &shown),
        }
    }

    /// The point to hit next: of those that have not been hit, the one that pushes most unlike the others while modes are
    /// missing, then the one that shows much more of the mode that shows worst. Where the layout has none, a point that it would
    /// need.
    fn next(&self, test: &TestLines, shown: &[(Mode<f64>, Shown<f64>)]) -> Option<NextPoint> {
        let (layout, reference) = (&self.layout, self.layout.sensor_centroid());
        let length = layout.characteristic_length();
        // The points that are left, in the order in which the rig asks for them.
        let left = || {
            let hits = layout.hits.iter().enumerate();
            let is_open = |dof: usize| self.dofs.iter().all(|lines| lines.dof != dof);
            hits.filter(move |(dof, _)| is_open(*dof)).map(|(_, hit)| hit).enumerate()
        };
        let of_layout = |(before, dof): (usize, Dof)| NextPoint {
            dof: dof.to_string(),
            points_before: Some(before),
        };
        let of_body = |dof: String| NextPoint { dof, points_before: None };
        if shown.len() < SUSPENSION_MODES {
            let so_far = HitDirections::of(test.layout())?;
            let newest = left()
                .map(|(before, hit)| {
                    (so_far.share_outside(&hit.unit_force(&reference)), (before, hit.dof))
                })
                .filter(|(share, _)| *share > NEW)
                .max_by(|a, b| a.0.total_cmp(&b.0));
            return match newest {
                Some((_, point)) => Some(of_layout(point)),
                None => so_far.newest(test.layout()).map(|place| of_body(place.dof())),
            };
        }
        let (mode, worst) = shown.iter().min_by(|a, b| a.1.share().total_cmp(&b.1.share()))?;
        if worst.share() >= WELL {
            return None;
        }
        let best = left()
            .map(|(before, hit)| {
                (mode.indicator(&hit.unit_force(&reference), length), (before, hit.dof))
            })
            .filter(|(indicator, _)| *indicator > MUCH_BETTER * worst.indicator)
            .max_by(|a, b| a.0.total_cmp(&b.0));
        match best {
            Some((_, point)) => Some(of_layout(point)),
            None => worst.is_hardly_shown().then(|| of_body(worst.better.to_string())),
        }
    }
}

/// The suspension modes that these lines show; none where they show none.
fn modes_of(test: &TestLines) -> Vec<Mode<f64>> {
    let Ok(responses) = test.responses() else { return Vec::new() };
    let mut memory = Box::new(Reduction::new());
    let fit = HostFit::new(test.layout(), &responses, &mut memory);
    fit.map_or_else(|_| Vec::new(), |fit| fit.modes().modes.to_vec())
}

impl ModesSoFar {
    /// `2 of 5 points`.
    pub fn progress(&self) -> String {
        format!("{} of {} points", self.dofs_measured, self.dofs)
    }

    /// A line for each mode: frequency, the hit that shows it best, its Norm Indicator.
    pub fn rows(&self) -> Vec<String> {
        let row = |mode: &SeenMode| {
            let SeenMode { frequency_hz, dof, norm_indicator, share_of_possible, .. } = mode;
            format!(
                "{:>7} Hz  {dof:8} {} ({:.0} % of the largest possible)",
                format!("{frequency_hz:.2}"),
                two_digits(*norm_indicator),
                100.0 * share_of_possible,
            )
        };
        self.modes.iter().map(row).collect()
    }

    /// What is missing, and what to hit next.
    pub fn advice(&self) -> String {
        let seen = match self.modes_missing {
            0 => "all six modes show".to_owned(),
            1 => "one of the six modes does not show yet".into(),
            missing => format!("{missing} of the six modes do not show yet"),
        };
        match &self.next {
            None if self.modes_missing == 0 => {
                format!("{seen}; the points to come make the answer more certain")
            }
            None => format!("{seen}, and no point of the layout pushes in a new direction"),
            Some(NextPoint { dof, points_before }) => {
                let why = match self.modes_missing {
                    0 => "shows one of them better",
                    _ => "pushes most unlike the points so far",
                };
                match points_before {
                    Some(0) => format!("{seen}; hit {dof} next: it {why}"),
                    Some(before) => {
                        let later = counted(*before as u32, "more point");
                        format!("{seen}; {dof}, after {later}, {why}: do not leave it out")
                    }
                    None => format!("{seen}; add {dof} (axes of the body) to the layout: it {why}"),
                }
            }
        }
    }

    /// The report as text: a heading, a line for each mode, the advice.
    pub fn to_text(&self) -> String {
        let heading = format!(
            "after {}, modes seen, each with the hit that shows it best and its Norm Indicator:",
            self.progress()
        );
        let heading =
            if self.modes.is_empty() { format!("after {}:", self.progress()) } else { heading };
        let lines = [vec![heading], self.rows(), vec![self.advice()]].concat();
        lines.join("\n  ")
    }
}

#[cfg(test)]
mod tests;
