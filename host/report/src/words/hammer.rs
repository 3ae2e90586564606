//! How much of the uncertainty of the mass is the hammer's, and what to do about it.

use massline_shared::identify::{Estimate, Observable};
use massline_shared::layout::HostLayout;

/// What helps against an uncertain gain of the hammer, of a rig or of another recorder.
pub fn calibrate_hammer(by_rig: bool) -> &'static str {
    match by_rig {
        true => {
            "calibrate it with a block of known mass (`massline calibrate block`), or weigh the object and state the \
             mass in [prior]"
        }
        false => {
            "calibrate it against a known mass, or weigh the object and state the mass in [prior]"
        }
    }
}

/// Share of the variance of the mass from which the hammer is worth a word.
const MOST: f64 = 0.5;
/// Largest share that can be one: standard deviations are linearised and rounded.
const LARGEST: f64 = 1.1;

/// The hammer's share of the variance of an answer's mass, and what to do, where that is most of it; `None`
/// otherwise, for answers by mass lines, and where a prior knows the mass.
pub fn hammer_text(layout: &HostLayout, estimate: &Estimate<f64>, by_rig: bool) -> Option<String> {
    if estimate.method.entry().observes == Observable::MassLines {
        return None;
    }
    let is_known = layout.priors.iter().any(|prior| prior.property == 0);
    let sigma = estimate.sigma().filter(|_| !is_known)?;
    let share = (layout.apparatus.hammer_gain * estimate.body.mass / sigma[0]).powi(2);
    // A standard deviation without the hammer's part says nothing about it; one that is hardly anything else may be
    // a little too small.
    if !(MOST..=LARGEST).contains(&share) {
        return None;
    }
    Some(format!(
        "the hammer's gain, uncertain by {:.1} % (1 sd), accounts for {:.0} % of the variance of the mass: {}",
        100.0 * layout.apparatus.hammer_gain,
        100.0 * share.min(1.0),
        calibrate_hammer(by_rig)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::Method;
    use massline_shared::layout::Prior;
    use nalgebra::SMatrix;

    /// An answer of 10 kg with this standard deviation of the mass, kg.
    fn answer(sigma: f64) -> Estimate<f64> {
        let theta = [10.0, 0.0, 0.0, 0.0, 0.2, 0.2, 0.3, 0.0, 0.0, 0.0];
        Estimate {
            method: Method::GlobalFit,
            body: RigidBody::from_theta(&theta.into()),
            covariance: Some(SMatrix::identity() * sigma.powi(2)),
            condition: 1.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        }
    }

    #[test]
    fn a_hammer_that_makes_most_of_the_variance_is_to_be_calibrated() {
        let mut layout = HostLayout::default();
        layout.apparatus.hammer_gain = 0.02;
        // 2 % of 10 kg are 0.2 kg: 64 % of the variance that 0.25 kg are.
        let text = hammer_text(&layout, &answer(0.25), true).unwrap();
        assert!(
            text.contains("uncertain by 2.0 % (1 sd), accounts for 64 % of the variance"),
            "{text}"
        );
        assert!(text.contains("`massline calibrate block`"), "{text}");
        let elsewhere = hammer_text(&layout, &answer(0.25), false).unwrap();
        assert!(elsewhere.ends_with(
            "calibrate it against a known mass, or weigh the object and state the mass in [prior]"
        ));
        // A quarter of the variance, and a standard deviation that cannot contain the hammer's.
        assert_eq!(hammer_text(&layout, &answer(0.4), true), None);
        assert_eq!(hammer_text(&layout, &answer(0.1), true), None);
        layout.priors.push(Prior { property: 0, value: 10.0, sigma: 0.01 }).unwrap();
        assert_eq!(hammer_text(&layout, &answer(0.25), true), None);
    }
}
