//! Checks that hold for every body on any suspension, whatever its properties: the point that is hit moves along the
//! force, and two hits do the same at each other.
//!
//! With the motion `yⱼ` of a reference point under the unit force `fⱼ = [F; T]`, the response at hit `i`, along it, to
//! hit `j` is `fᵢᵀ yⱼ`. So the checks need no sensor at the hits, and gravity is out of the motions already.

use nalgebra::{Complex, Vector6};

use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::real::Real;

/// Difference over the geometric mean of the driving points from which two hits are not reciprocal. Hits that scatter
/// by the default error budget differ by 0.05.
const NOT_RECIPROCAL: f64 = 0.25;

/// Checks the accelerances of hits at several lines: `motion(line, hit)`. The hits are those of the layout, in its
/// order. `power` weighs a driving point: above the suspension the real part of its accelerance is positive, and near a
/// mode the imaginary part.
pub fn check_reciprocity<R: Real>(
    forces: &[Vector6<R>],
    lines: usize,
    motion: impl Fn(usize, usize) -> Vector6<Complex<R>>,
    power: impl Fn(Complex<R>) -> R,
) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    let mut warn = |code: Code, subject: Subject, value: R| {
        let diagnostic = Diagnostic::about(code, Severity::Warning, subject, value.to_f32());
        // There is room for sixteen diagnostics; any others are dropped.
        let _ = diagnostics.push(diagnostic);
    };
    let at = |line: usize, place: usize, hit: usize| {
        let moved = motion(line, hit);
        let parts = forces[place].iter().zip(&moved).map(|(f, y)| y.scale(*f));
        parts.fold(Complex::new(R::zero(), R::zero()), |sum, part| sum + part)
    };
    let square = |response: &dyn Fn(usize) -> Complex<R>| {
        (0..lines).fold(R::zero(), |sum, line| sum + response(line).norm_sqr())
    };
    for hit in 0..forces.len() {
        let sum = (0..lines).fold(R::zero(), |sum, line| sum + power(at(line, hit, hit)));
        if sum < R::zero() {
            warn(Code::DrivingPointReversed, Subject::hit(hit), R::zero());
        }
        for other in 0..hit {
            let difference = square(&|line| at(line, hit, other) - at(line, other, hit));
            let own = square(&|line| at(line, hit, hit)) * square(&|line| at(line, other, other));
            let share = (difference / own.sqrt()).sqrt();
            if share > R::of(NOT_RECIPROCAL) {
                warn(Code::NotReciprocal, Subject::hits(other, hit), share);
            }
        }
    }
    diagnostics
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use std::vec::Vec;

    use super::*;
    use crate::layout::tests::{bar_body, bar_layout};

    /// Findings about a free bar when the force of one hit is changed.
    fn findings(change: impl Fn(usize, Vector6<f64>) -> Vector6<f64>) -> Vec<(Code, Subject)> {
        let layout = bar_layout();
        let forces: Vec<_> =
            layout.hits.iter().map(|hit| hit.unit_force(&Vector3::zeros())).collect();
        let motion = |_line: usize, hit: usize| {
            let motion = bar_body().acceleration(&change(hit, forces[hit])).unwrap();
            motion.map(|v| Complex::new(v, 0.0))
        };
        let diagnostics = check_reciprocity(&forces, 1, motion, |h| h.re);
        diagnostics.iter().map(|d| (d.code, d.subject)).collect()
    }

    #[test]
    fn a_body_is_reciprocal_and_moves_with_the_force() {
        assert!(findings(|_, force| force).is_empty());
    }

    #[test]
    fn a_reversed_hit_moves_against_its_force() {
        let findings = findings(|hit, force| if hit == 1 { -force } else { force });
        assert!(findings.contains(&(Code::DrivingPointReversed, Subject::Hit(1))), "{findings:?}");
        assert!(!findings.iter().any(|(code, subject)| {
            *code == Code::DrivingPointReversed && *subject != Subject::Hit(1)
        }));
    }

    #[test]
    fn a_hit_elsewhere_is_not_reciprocal_with_the_others() {
        // 0.1 m beside its mark.
        let beside = |force: Vector6<f64>| {
            let arm = Vector3::new(0.1, 0.1, 0.1);
            let torque = arm.cross(&force.fixed_rows::<3>(0).into_owned());
            force + Vector6::new(0.0, 0.0, 0.0, torque.x, torque.y, torque.z)
        };
        let findings = findings(|hit, force| if hit == 2 { beside(force) } else { force });
        assert!(!findings.is_empty());
        for (code, subject) in findings {
            let with_it = matches!(subject, Subject::Hits { second: 2, .. });
            assert!(code == Code::NotReciprocal && with_it, "{code} {subject:?}");
        }
    }
}
