//! Finds priors that contradict the data.
//!
//! A tight prior pulls the answer towards itself, so its residual in the fit is small even when it is wrong.
//! The fit is therefore done without it, and the result is compared with the prior.

use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::maximum_likelihood::{
    self, ErrorBudget, Start, without_repeats, workspace,
};
use massline_shared::identify::{DofMassLines, Estimate, REJECTION_Z};
use massline_shared::layout::{HostLayout, Prior};

use super::solve_learned;

/// The priors that contradict the data; to be called when the data contradict the budget or no fit succeeds.
/// Returns the one prior without which the rest agrees, or else all priors that are far from the answer of a
/// fit without any.
pub(super) fn inconsistent_priors(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
) -> Vec<Diagnostic> {
    if layout.priors.is_empty() {
        return Vec::new();
    }
    let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
    search(layout, |layout| {
        let (start, budget) = (Start::InertiaRestraint, ErrorBudget::Stated);
        let stated = maximum_likelihood::solve(layout, lines, start, budget, &mut memory);
        let stated = stated.ok()?.estimate;
        if !layout.learn_budget || without_repeats::have_repeats(lines) {
            return Some(stated);
        }
        // Whether the data agree is judged under the stated budget; the answer is not that of an assumed scatter.
        let learned = solve_learned(layout, lines, start).ok();
        Some(learned.map_or(stated.clone(), |solution| Estimate {
            consistency: stated.consistency,
            ..solution.estimate
        }))
    })
}

fn search(
    layout: &HostLayout,
    mut fit: impl FnMut(&HostLayout) -> Option<Estimate<f64>>,
) -> Vec<Diagnostic> {
    let mut without = |left_out: &dyn Fn(&Prior<f64>) -> bool| {
        let mut layout = layout.clone();
        layout.priors.retain(|prior| !left_out(prior));
        fit(&layout)
    };
    let mut worst: Option<(f64, Diagnostic)> = None;
    for prior in &layout.priors {
        let Some(estimate) = without(&|other| other.property == prior.property) else { continue };
        let agrees = estimate.consistency.is_some_and(|c| !c.rejects_budget());
        let Some((far, diagnostic)) = contradiction(prior, &estimate).filter(|_| agrees) else {
            continue;
        };
        if worst.is_none_or(|(most, _)| far > most) {
            worst = Some((far, diagnostic));
        }
    }
    if let Some((_, diagnostic)) = worst {
        return vec![diagnostic];
    }
    let Some(estimate) = without(&|_| true) else { return Vec::new() };
    contradicted(&layout.priors, &estimate)
}

/// The priors that an answer contradicts which does not use them.
pub fn contradicted(priors: &[Prior<f64>], without: &Estimate<f64>) -> Vec<Diagnostic> {
    let contradictions = priors.iter().filter_map(|prior| contradiction(prior, without));
    contradictions.map(|(_, diagnostic)| diagnostic).collect()
}

/// The distance of a prior from an answer without it, in standard deviations, if it is significant.
fn contradiction(prior: &Prior<f64>, without: &Estimate<f64>) -> Option<(f64, Diagnostic)> {
    let k = usize::from(prior.property);
    let value = *without.theta().get(k)?;
    let sigma = *without.sigma()?.get(k)?;
    let far = (value - prior.value).abs() / prior.sigma.hypot(sigma);
    let code = Code::PriorInconsistentWithData;
    let diagnostic =
        Diagnostic::about(code, Severity::Warning, Subject::Property(prior.property), value as f32);
    (far > REJECTION_Z).then_some((far, diagnostic))
}

#[cfg(test)]
mod tests {
    use super::super::MeasuredLines;
    use super::*;
    use massline_files::layout_file::LayoutFile;
    use massline_shared::body::RigidBody;
    use massline_shared::identify::MassLines;
    use nalgebra::SVector;

    const FILE: &str = include_str!("../../../examples/three-bar-test-1.toml");

    /// The contradicting priors for exact data of the `[reference]` object and a layout with this `[prior]`.
    fn find_contradicted(prior: &str) -> Vec<Diagnostic> {
        let file = LayoutFile::parse(&format!("{FILE}\n[prior]\n{prior}"), "l").unwrap();
        let ten = file.reference.unwrap().complete().unwrap();
        let body = RigidBody::from_theta(&SVector::from(ten));
        let exact = |hit| {
            let accelerance = file.layout.accelerance(&body, hit).unwrap();
            (hit, MassLines::without_scatter(accelerance))
        };
        let lines: MeasuredLines = (0..file.layout.hits.len()).map(exact).collect();
        inconsistent_priors(&file.layout, &lines)
    }

    #[test]
    fn a_prior_that_the_data_agree_with_is_not_named() {
        assert_eq!(find_contradicted("mass_kg = { value = 1.25, sigma = 0.01 }"), []);
    }

    #[test]
    fn a_wrong_mass_is_named_with_the_value_of_the_data() {
        let diagnostics = find_contradicted("mass_kg = { value = 2.4, sigma = 0.0001 }");
        assert_eq!(diagnostics.len(), 1);
        let [d] = diagnostics[..] else { unreachable!() };
        assert_eq!((d.code, d.subject), (Code::PriorInconsistentWithData, Subject::Property(0)));
        // Exact data of an object of 1.23 kg, which show no hits that turn.
        assert!((d.value - 1.23).abs() < 1e-4, "{d:?}");
    }

    #[test]
    fn of_two_priors_the_wrong_one_is_named() {
        let right = "mass_kg = { value = 1.23, sigma = 0.001 }";
        let diagnostics =
            find_contradicted(&format!("{right}\ncz_m = {{ value = 0.05, sigma = 0.001 }}"));
        assert_eq!(
            diagnostics.iter().map(|d| d.subject).collect::<Vec<_>>(),
            [Subject::Property(3)]
        );
    }

    #[test]
    fn two_wrong_ones_are_both_named() {
        let wrong = "mass_kg = { value = 2.4, sigma = 0.001 }";
        let diagnostics =
            find_contradicted(&format!("{wrong}\ncz_m = {{ value = 0.1, sigma = 0.001 }}"));
        assert_eq!(
            diagnostics.iter().map(|d| d.subject).collect::<Vec<_>>(),
            [0, 3].map(Subject::Property)
        );
    }
}
