//! The error budget that a fit has used: what was stated beside what the data have taught.

use massline_result::BudgetTerm;
use massline_shared::identify::maximum_likelihood::{LearnedBudget, LearnedFrom};
use massline_shared::layout::HostLayout;

/// The learned scales, in an entry of `results`.
pub(super) fn learned_budget(learned: &LearnedBudget<f64>) -> massline_result::LearnedBudget {
    massline_result::LearnedBudget {
        learned_from: learned_from(learned),
        hit_position_scale: learned.scales.hit_position,
        hit_direction_scale: learned.scales.hit_direction,
        constant_scale: learned.scales.constant,
        scatter_degrees_of_freedom: learned.scatter_degrees_of_freedom,
        constant_log_sigma: learned.constant_log_variance.sqrt(),
        interval_widening: learned.widening,
    }
}

/// Scatter of the hits as stated and as learned, and the learned scale of what stays the same over the test.
pub fn error_budget(
    learned: &LearnedBudget<f64>,
    layout: &HostLayout,
) -> massline_result::ErrorBudget {
    let [position, direction] = stated_scatter(layout);
    let scales = &learned.scales;
    let both = |stated: f64, scale: f64| BudgetTerm { stated, learned: stated * scale };
    massline_result::ErrorBudget {
        learned_from: learned_from(learned),
        hit_position_m: both(position, scales.hit_position),
        hit_direction_rad: both(direction, scales.hit_direction),
        constant_scale: both(1.0, scales.constant),
    }
}

fn learned_from(learned: &LearnedBudget<f64>) -> massline_result::LearnedFrom {
    match learned.learned_from {
        LearnedFrom::RepeatHits => massline_result::LearnedFrom::RepeatHits,
        LearnedFrom::Residuals => massline_result::LearnedFrom::Residuals,
    }
}

/// What was learned about the error budget, a sentence for each part.
pub fn budget_text(
    budget: &massline_result::ErrorBudget,
    learned: &massline_result::LearnedBudget,
) -> String {
    let [position, direction] = [budget.hit_position_m, budget.hit_direction_rad]
        .map(|term| BudgetTerm { stated: 1e3 * term.stated, learned: 1e3 * term.learned });
    let constant = budget.constant_scale.learned;
    if budget.learned_from == massline_result::LearnedFrom::Residuals {
        let of_hits = |kind: &str, scale: f64, one: BudgetTerm, unit: &str| match one.stated > 0.0 {
            true => format!(
                "  {kind} of hits and marks: {scale:.2} times the stated uncertainties (a single hit: {:.1} {unit}; \
                 stated: {:.1} {unit})\n",
                one.learned, one.stated
            ),
            false => {
                format!("  {kind} of hits and marks: {scale:.2} times the stated uncertainties\n")
            }
        };
        return String::from(
            "error budget, learned from what the answer leaves of these data (they hold fewer than three single hits \
             at a DOF):\n",
        ) + &of_hits("positions", learned.hit_position_scale, position, "mm")
            + &of_hits("directions", learned.hit_direction_scale, direction, "mrad")
            + &format!("  sensors: {constant:.2} times the stated uncertainties\n");
    }
    let mut text = String::from("error budget, learned from these data:\n");
    text += &if learned.scatter_degrees_of_freedom > 0 {
        format!(
            "  you hit within {:.1} mm and {:.0} mrad (one standard deviation; stated: {:.1} mm, {:.0} mrad)\n",
            position.learned, direction.learned, position.stated, direction.stated
        )
    } else {
        format!("  hits: as stated, {:.1} mm and {:.0} mrad\n", position.stated, direction.stated)
    };
    text += &if learned.constant_log_sigma > 0.0 {
        format!("  sensors and marks: {constant:.2} times the stated uncertainties\n")
    } else {
        "  sensors and marks: as stated\n".to_owned()
    };
    text
}

/// Root mean square over the hits of the stated scatter: position, m, and direction, rad.
fn stated_scatter(layout: &HostLayout) -> [f64; 2] {
    let count = layout.hits.len().max(1) as f64;
    let squares = layout
        .hits
        .iter()
        .map(|hit| [hit.uncertainty.position.powi(2), hit.uncertainty.direction.powi(2)]);
    let sums = squares.fold([0.0; 2], |sum, square| [sum[0] + square[0], sum[1] + square[1]]);
    sums.map(|sum| (sum / count).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::identify::maximum_likelihood::BudgetScales;
    use massline_shared::layout::Hit;

    fn text_of(learned: &LearnedBudget<f64>) -> String {
        budget_text(&error_budget(learned, &layout()), &learned_budget(learned))
    }

    fn learned() -> LearnedBudget<f64> {
        let scales = BudgetScales { hit_position: 0.6, hit_direction: 0.56, constant: 1.5 };
        LearnedBudget {
            scales,
            scatter_degrees_of_freedom: 40,
            learned_from: LearnedFrom::RepeatHits,
            constant_log_variance: 0.04,
            widening: [1.01; 10],
        }
    }

    fn layout() -> HostLayout {
        let mut layout = HostLayout::default();
        for node in ["1:+X", "2:+Y"] {
            layout.hits.push(Hit::new(node.parse().unwrap(), [0.0; 3], [1.0, 0.0, 0.0]));
        }
        layout
    }

    #[test]
    fn what_was_learned_stands_beside_what_was_stated() {
        let text = text_of(&learned());
        let hits =
            "you hit within 1.8 mm and 28 mrad (one standard deviation; stated: 3.0 mm, 50 mrad)";
        assert!(text.contains(hits), "{text}");
        assert!(text.contains("1.50 times the stated"), "{text}");
        let budget = error_budget(&learned(), &layout());
        assert!((budget.hit_position_m.learned - 0.0018).abs() < 1e-12);
        assert!((budget.hit_direction_rad.stated - 0.05).abs() < 1e-12);
    }

    #[test]
    fn three_factors_are_named_where_the_residuals_have_taught_them() {
        let of_residuals = LearnedBudget {
            scatter_degrees_of_freedom: 0,
            learned_from: LearnedFrom::Residuals,
            ..learned()
        };
        let text = text_of(&of_residuals);
        for part in [
            "fewer than three single hits",
            "positions of hits and marks: 0.60 times the stated uncertainties (a single hit: 1.8 mm; stated: 3.0 mm)",
            "directions of hits and marks: 0.56 times the stated uncertainties (a single hit: 28.0 mrad; stated: 50.0 \
             mrad)",
            "sensors: 1.50 times the stated uncertainties",
        ] {
            assert!(text.contains(part), "{text}");
        }
        assert!(!text.contains("you hit within") && !text.contains("as stated"), "{text}");
        let budget = error_budget(&of_residuals, &layout());
        assert_eq!(budget.learned_from, massline_result::LearnedFrom::Residuals);
        assert!((budget.hit_direction_rad.learned - 0.028).abs() < 1e-12);
    }

    #[test]
    fn what_could_not_be_learned_is_as_stated() {
        let nothing = LearnedBudget {
            scatter_degrees_of_freedom: 0,
            constant_log_variance: 0.0,
            ..learned()
        };
        let text = text_of(&nothing);
        assert_eq!(text.matches("as stated").count(), 2, "{text}");
    }
}
