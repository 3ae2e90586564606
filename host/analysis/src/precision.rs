//! During a campaign: how precise the answer would be with the DOFs measured so far, and which further hit
//! would help most, solved in double precision from the mass lines of the rig.

use massline_protocol::object::DofResult;
use massline_shared::body::{INERTIAL_PARAMETERS, RigidBody};
use massline_shared::design::{FurtherHit, FurtherHitSearch, HitCandidates, Precision, Widths};
use massline_shared::identify::{
    self as solvers, Estimate, IdentifySettings, Method, Methods, Progress,
};
use massline_shared::layout::HostLayout;

use crate::identification::{HostObservations, answers, learned, lines_of_dofs};
use massline_result::{HalfWidths, WorstProperty};

/// The precision with some of the DOFs of a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct PrecisionReport<'a> {
    /// The layout of the campaign.
    pub layout: &'a HostLayout,
    /// Number of DOFs with mass lines.
    pub measured: usize,
    /// The intervals; `None` when more DOFs are needed.
    pub precision: Option<Precision<f64>>,
    /// The hit that would narrow the interval of the worst property most.
    pub further: Option<FurtherHit<f64>>,
    /// The body, where the intervals are known.
    pub body: Option<RigidBody<f64>>,
}

impl<'a> PrecisionReport<'a> {
    /// Solves the mass lines of these DOFs.
    pub fn of(layout: &'a HostLayout, dofs: &[DofResult]) -> Self {
        let lines = lines_of_dofs(dofs, layout);
        let measured = lines.len();
        let report = Self { layout, measured, precision: None, further: None, body: None };
        let wanted: Methods = Method::of_mass_lines().collect();
        let observed = HostObservations::of_mass_lines(layout, &lines);
        let estimates = answers(&observed, &wanted, &IdentifySettings::default()).estimates;
        let length = layout.characteristic_length();
        let precision = Precision::of(&estimates, layout.target, length);
        let (Some(precision), Some(best)) = (precision, estimates.first()) else { return report };
        let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
        let candidates = HitCandidates::Following;
        // What was learned is in the layout.
        let (budget, plain) = (learned(layout, best), Estimate { learned: None, ..best.clone() });
        let mut search = FurtherHitSearch::new(&precision, &plain, &lines, sensors, candidates);
        let mut memory = vec![0.0; solvers::workspace(&wanted, sensors, hits)];
        while search.step(&budget, &lines, &mut memory) == Progress::Going {}
        let body = Some(best.body);
        Self { precision: Some(precision), further: search.best_hit(), body, ..report }
    }

    /// True when the target is reached.
    pub fn is_reached(&self) -> bool {
        self.precision.as_ref().is_some_and(Precision::is_reached)
    }

    /// The report as a result has it.
    pub fn document(&self) -> massline_result::Precision {
        let worst = |known: &Precision<f64>| {
            let (property, ratio) = known.worst();
            WorstProperty {
                property: INERTIAL_PARAMETERS[property].symbol.into(),
                half_width95: known.half_widths[property],
                // Without a target there is nothing to compare with.
                over_target: known.target.is_set().then_some(ratio),
            }
        };
        let half_widths = |known: &Precision<f64>| {
            let Widths { mass, center, inertia } = known.widths();
            HalfWidths { mass, center_m: center, inertia }
        };
        let known = self.precision.as_ref();
        massline_result::Precision {
            dofs_measured: self.measured,
            dofs: self.layout.hits.len(),
            half_widths95: known.map(half_widths),
            contradicts_budget: known.map(|known| known.contradicted),
            worst: known.map(worst),
            further_hit: self.further.map(|hit| massline_result::FurtherHit {
                dof: self.dof(hit.dof),
                half_width95: hit.half_width,
            }),
            target_reached: self.is_reached(),
        }
    }

    /// The name of a DOF.
    pub fn dof(&self, index: usize) -> String {
        self.layout.hits.get(index).map_or_else(String::new, |hit| hit.dof.to_string())
    }
}

/// Lines of the DOFs that have been read so far, and the reports after each.
#[derive(Clone, Debug)]
pub struct PrecisionMonitor {
    layout: HostLayout,
    dofs: Vec<DofResult>,
    reports: Vec<massline_result::Precision>,
}

impl PrecisionMonitor {
    /// A monitor for a campaign with this layout, which has the standard deviations of the calibration.
    pub fn new(layout: HostLayout) -> Self {
        Self { layout, dofs: Vec::new(), reports: Vec::new() }
    }

    /// True when the mass lines of the DOF with this index are known.
    pub fn knows(&self, index: u8) -> bool {
        self.dofs.iter().any(|dof| dof.index == index)
    }

    /// Forgets the mass lines of a DOF that is measured again; returns whether they were known.
    pub fn forget(&mut self, index: u8) -> bool {
        let before = self.dofs.len();
        self.dofs.retain(|dof| dof.index != index);
        self.dofs.len() < before
    }

    /// The number of DOFs whose mass lines are known.
    pub fn measured(&self) -> usize {
        self.dofs.len()
    }

    /// Takes the mass lines of a DOF.
    pub fn add(&mut self, dof: DofResult) {
        self.dofs.push(dof);
    }

    /// The report with all DOFs so far.
    pub fn latest(&self) -> PrecisionReport<'_> {
        PrecisionReport::of(&self.layout, &self.dofs)
    }

    /// As [`Self::latest`]; it is also kept for [`Self::into_reports`].
    pub fn report(&mut self) -> PrecisionReport<'_> {
        let report = PrecisionReport::of(&self.layout, &self.dofs);
        self.reports.push(report.document());
        report
    }

    /// All reports, in the order of the campaign.
    pub fn into_reports(self) -> Vec<massline_result::Precision> {
        self.reports
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_files::layout_file::LayoutFile;
    use massline_shared::capacity::Rig;
    use massline_shared::identify::MassLines;
    use massline_shared::layout::RigLayout;
    use massline_shared::layout::Target;
    use massline_shared::measurement::MeasuredDof;
    use nalgebra::SVector;

    fn layout() -> HostLayout {
        let text = include_str!("../../examples/three-bar-test-1.toml").replace(
            "hits = [\"1:+Y\", \"2:+Z\", \"4:+X\"]",
            "hits = [\"1:+Y\", \"2:+Z\", \"4:+X\", \"4:+Y\", \"1:+Z\"]",
        );
        LayoutFile::parse(&text, "test").unwrap().layout
    }

    /// Exact mass lines of the first DOFs of the three-bar frame.
    fn dofs(layout: &HostLayout, count: usize) -> Vec<DofResult> {
        let rig: RigLayout = layout.cast().unwrap();
        let body = RigidBody::from_theta(&SVector::from([
            1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
        ]));
        let result = |index: usize| {
            let mut lines =
                MassLines::<f32, Rig>::without_scatter(rig.accelerance(&body, index).unwrap());
            (lines.hits, lines.noise) = (5, lines.noise.map(|_| 0.002));
            // Hits that scatter by a twentieth, as with directions of 50 mrad.
            (0..9).for_each(|k| lines.scatter[(k, k)] = 0.05 * 0.05);
            let details =
                MeasuredDof { dof: rig.hits[index].dof, band_hz: [10.0, 120.0], coherence: None };
            DofResult::of(&details, &(index, lines))
        };
        (0..count).map(result).collect()
    }

    #[test]
    fn before_the_properties_are_determined_more_dofs_are_needed() {
        let layout = layout();
        let report = PrecisionReport::of(&layout, &dofs(&layout, 2));
        assert!(report.precision.is_none() && !report.is_reached());
        assert!(report.document().half_widths95.is_none());
    }

    #[test]
    fn afterwards_the_intervals_and_the_best_further_hit_are_named() {
        let layout = layout();
        let report = PrecisionReport::of(&layout, &dofs(&layout, 3));
        assert!(report.precision.is_some());
        let further = report.further.unwrap();
        assert!(further.dof >= 3, "a DOF without mass lines: {further:?}");
        let document = report.document();
        let worst = document.worst.as_ref().unwrap();
        assert!(document.further_hit.as_ref().unwrap().half_width95 < worst.half_width95);
        assert_eq!(worst.over_target, None);
    }

    #[test]
    fn a_target_is_reached_within_the_widths_and_not_beyond() {
        let mut layout = layout();
        let lines = dofs(&layout, 3);
        let mass = PrecisionReport::of(&layout, &lines).precision.unwrap().widths().mass;
        for (part, reached) in [(0.99, false), (1.01, true)] {
            layout.target = Target { mass: Some(part * mass), ..Target::default() };
            assert_eq!(PrecisionReport::of(&layout, &lines).is_reached(), reached);
        }
    }
}
