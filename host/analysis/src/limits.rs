//! What limits an answer: the shares of the sources of error in its uncertainty, by the Cramér-Rao bound for the body
//! that was found under the layout and the noise of its test.

use massline_physics::suspension::RigidMode;
use massline_result::{Estimate, MassLine, MeasuredDof, Mode, Modes, TestResult};
use massline_shared::design::{self, DEFAULT_NOISE, Part};
use massline_shared::identify::Method;
use massline_shared::identify::maximum_likelihood::{
    BudgetScales, LearnedBudget, LearnedFrom, workspace,
};
use massline_shared::layout::{Hit, HostLayout, TestProfile};
use nalgebra::Vector6;

use crate::design::LayoutCriterion;

/// The smallest noise of a mass line, relative to 1/m, that anything measured has. What is less is the rounding of
/// computed responses.
const LEAST_NOISE: f64 = 1e-9;

/// A test as a bound needs it.
pub struct BoundedTest {
    /// The layout with the hits that are in the answer, as often as they were made, and the budget that was learned.
    pub layout: HostLayout,
    /// The bound for the body that was found.
    pub criterion: LayoutCriterion,
    /// Whether the noise is that of the data; otherwise it is assumed.
    pub noise_is_known: bool,
}

impl BoundedTest {
    /// A result under the layout that it was solved with; `record_s` is how long the object has rung in a record of the
    /// suspension profile, s. `None` without an answer, and for suspension modes unless there are six of a test by a
    /// rig whose records are known.
    pub fn of(result: &TestResult, layout: &HostLayout, record_s: Option<f64>) -> Option<Self> {
        let answer = result.answer()?;
        let layout = as_measured(layout, &result.measured_dofs());
        let by_mass_lines = Method::of_mass_lines().any(|method| answer.method == method);
        match &result.suspension {
            Some(modes) if !by_mass_lines => {
                // Of responses from a file, neither the window nor the length of the records is known.
                let record_s = record_s.filter(|_| !result.lines.is_empty())?;
                Self::of_modes(modes, answer, layout, record_s)
            }
            _ => Some(Self::of_mass_lines(result, answer, layout)),
        }
    }

    fn of_mass_lines(result: &TestResult, answer: &Estimate, mut layout: HostLayout) -> Self {
        if let Some(learned) = &answer.learned_budget {
            as_learned(learned).apply_to(&mut layout);
        }
        let body = answer.body();
        let measured = noise(&result.mass_lines, &layout).map(|noise| noise * body.mass);
        let measured = measured.filter(|relative| *relative > LEAST_NOISE);
        let relative = measured.unwrap_or(DEFAULT_NOISE);
        let criterion = LayoutCriterion::of_mass_lines(body, &layout, relative);
        Self { criterion, layout, noise_is_known: measured.is_some() }
    }

    fn of_modes(
        modes: &Modes,
        answer: &Estimate,
        layout: HostLayout,
        record_s: f64,
    ) -> Option<Self> {
        let noise = modes.noise_m_per_s2_per_n.filter(|noise| *noise > 0.0)?;
        let six = six_modes(modes).filter(|_| layout.test.profile == TestProfile::Suspension)?;
        let body = answer.body();
        let of_one_hit = noise * f64::from(layout.test.hits_per_dof.max(1)).sqrt();
        let relative = of_one_hit * body.mass;
        let criterion = LayoutCriterion::of_modes(body, &layout, relative, &six, record_s);
        Some(Self { layout, criterion, noise_is_known: true })
    }

    /// The shares of the sources of error, where the hits and sensors determine the ten properties.
    pub fn parts(&self) -> Vec<Part<f64>> {
        let mut memory = vec![0.0; workspace(self.layout.sensors.len(), self.layout.hits.len())];
        let parts = design::parts(&self.criterion, &self.layout, &mut memory);
        parts.map_or(Vec::new(), |parts| parts.to_vec())
    }
}

/// The layout with the hits that are in the answer, made as often as they were: what scatters from hit to hit is that
/// of so many. The whole layout where the measured DOFs are not known.
fn as_measured(layout: &HostLayout, measured: &[MeasuredDof]) -> HostLayout {
    let mut layout = layout.clone();
    if measured.is_empty() {
        return layout;
    }
    let wanted = f64::from(layout.test.hits_per_dof.max(1));
    layout.hits.retain_mut(|hit: &mut Hit<f64>| {
        let dof = hit.dof.to_string();
        let Some(measured_dof) = measured.iter().find(|measured_dof| measured_dof.dof == dof)
        else {
            return false;
        };
        if let Some(hits) = measured_dof.hits {
            let factor = (wanted / f64::from(hits.max(1))).sqrt();
            hit.uncertainty.position *= factor;
            hit.uncertainty.direction *= factor;
        }
        true
    });
    layout
}

/// What an answer has learned about its error budget, as the solvers have it.
fn as_learned(budget: &massline_result::LearnedBudget) -> LearnedBudget<f64> {
    LearnedBudget {
        scales: BudgetScales {
            hit_position: budget.hit_position_scale,
            hit_direction: budget.hit_direction_scale,
            constant: budget.constant_scale,
        },
        learned_from: match budget.learned_from {
            massline_result::LearnedFrom::RepeatHits => LearnedFrom::RepeatHits,
            massline_result::LearnedFrom::Residuals => LearnedFrom::Residuals,
        },
        // Only the intervals of the answer depend on how certain this is.
        scatter_degrees_of_freedom: 0,
        constant_log_variance: 0.0,
        widening: [1.0; 10],
    }
}

/// The standard deviation of the accelerance of one hit, (m/s²)/N, that leaves the noise of the mass lines after as
/// many hits as the layout wants; `None` where no noise is known.
fn noise(lines: &[MassLine], layout: &HostLayout) -> Option<f64> {
    let responses = 3 * layout.sensors.len();
    let averaged =
        lines.iter().flat_map(|line| line.noise_m_per_s2_per_n.iter().take(responses)).flatten();
    let squares: Vec<f64> = averaged.map(|noise| noise.powi(2)).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    let noise = (mean * f64::from(layout.test.hits_per_dof.max(1))).sqrt();
    (noise.is_finite() && noise > 0.0).then_some(noise)
}

/// The six modes of a test; `None` when there are others.
fn six_modes(modes: &Modes) -> Option<[RigidMode; 6]> {
    let mode = |mode: &Mode| RigidMode {
        omega: std::f64::consts::TAU * mode.frequency_hz.value,
        damping_ratio: mode.damping_ratio.value.max(0.0),
        shape: Vector6::from(mode.shape.value),
    };
    let rigid: Vec<RigidMode> = modes.modes.iter().map(mode).collect();
    rigid.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_files::layout_file::LayoutFile;

    fn line(dof: &str, hits: Option<u16>, noise: f64) -> MassLine {
        MassLine {
            dof: dof.into(),
            hits,
            band_hz: None,
            coherence: None,
            accelerance_m_per_s2_per_n: vec![0.0; 9],
            noise_m_per_s2_per_n: vec![Some(noise); 9],
        }
    }

    #[test]
    fn hits_count_as_often_as_they_were_made_and_skipped_ones_not_at_all() {
        let text = include_str!("../../examples/three-bar-test-1.toml");
        let layout = LayoutFile::parse(text, "test-1.toml").unwrap().layout;
        let lines = [line("1:+Y", Some(20), 0.001), line("2:+Z", None, 0.001)];
        let measured_dof =
            |dof: &str, hits| MeasuredDof { dof: dof.into(), hits, band_hz: None, coherence: None };
        let measured =
            as_measured(&layout, &[measured_dof("1:+Y", Some(20)), measured_dof("2:+Z", None)]);
        let dofs: Vec<String> = measured.hits.iter().map(|hit| hit.dof.to_string()).collect();
        assert_eq!(dofs, ["1:+Y", "2:+Z"]);
        // The layout wants 5 hits: 20 halve what scatters.
        let ratio = |k: usize| {
            let [now, then] =
                [&measured, &layout].map(|layout| layout.hits[k].uncertainty.position);
            now / then
        };
        assert_eq!([ratio(0), ratio(1)], [0.5, 1.0]);
        // Of one hit, the noise is √5 of that of five.
        assert!((noise(&lines, &layout).unwrap() / (0.001 * 5.0_f64.sqrt()) - 1.0).abs() < 1e-12);
        assert_eq!(noise(&[line("1:+Y", None, 0.0)], &layout), None);
        assert_eq!(noise(&[], &layout), None);
    }
}
