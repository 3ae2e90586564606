//! Whether the answer of a method stands under small changes.

use super::Answer;
use super::checks::undetermined_property;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject, fatal};
use crate::identify::agreement::Propagation;
use crate::identify::{Estimate, Method};
use crate::real::Real;

/// The refusal of an answer that says next to nothing about a property.
pub fn refusal_of_property<R: Real>(property: usize, share: R) -> Diagnostics {
    let (code, subject) = (Code::PropertyUndetermined, Subject::property(property));
    Diagnostics::from_array([Diagnostic::about(code, Severity::Error, subject, share.to_f32())])
}

/// The answer with the covariance of the method at this place; `length` is L in m.
///
/// # Errors
/// `unstable_under_noise`, `property_undetermined` for one whose uncertainty says that there is no answer, and
/// `not_physically_consistent` for a negative moment of inertia.
pub fn judged_estimate<R: Real, const M: usize>(
    method: Method,
    answer: &Answer<R>,
    place: usize,
    covariances: &Propagation<R, M>,
    length: R,
) -> Result<Estimate<R>, Diagnostics> {
    if let Some(share) = covariances.unstable(place) {
        return Err(fatal(Code::UnstableUnderNoise, share));
    }
    let covariance = covariances.of_method(place);
    let sigma = covariance.diagonal().map(|variance| variance.sqrt());
    if let Some((property, share)) = undetermined_property(&answer.body.theta(), &sigma, length) {
        return Err(refusal_of_property(property, share));
    }
    let mut diagnostics = Diagnostics::new();
    if !answer.body.is_physically_consistent() {
        let margin = answer.body.physical_margin().unwrap_or(R::zero()).to_f32();
        let code = Code::NotPhysicallyConsistent;
        if answer.body.inertia.symmetric_eigenvalues().min() < R::zero() {
            return Err(fatal(code, margin));
        }
        // The list is empty.
        let _ = diagnostics.push(Diagnostic::whole(code, Severity::Warning, margin));
    }
    Ok(Estimate {
        method,
        body: answer.body,
        covariance: Some(covariance),
        condition: answer.condition,
        consistency: None,
        learned: None,
        diagnostics,
    })
}

/// Adds to an estimate what was found about modes that its method uses.
pub fn add_doubts<R>(estimate: &mut Estimate<R>, findings: &[Diagnostic]) {
    let doubts = estimate.method.entry().doubted_by;
    let room = estimate.diagnostics.capacity() - estimate.diagnostics.len();
    let own_doubts = findings.iter().filter(|d| doubts.contains(&d.code)).copied();
    estimate.diagnostics.extend(own_doubts.take(room));
}
