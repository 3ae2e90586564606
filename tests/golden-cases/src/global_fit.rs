//! `f_global_`: body and suspension from all frequency responses of a test.
//!
//! Double precision only: single precision is not enough for 31 unknowns, some of which the hits hardly
//! excite.

use massline_shared::FrequencyResponses;
use massline_shared::Real;
use massline_shared::body::RigidBody;
use massline_shared::identify::global_fit::{Damping, GlobalFitSettings, solve, workspace};
use nalgebra::{Complex, SVector};

use crate::Check;
use crate::layout::{RESPONSES, SENSORS};

/// Bins of the cases.
const BINS: usize = 40;
const HITS: usize = 3;

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    if size_of::<R>() < size_of::<f64>() {
        check.leave_out();
        return Some(());
    }
    let layout = check.layout()?;
    let frequencies = check.input_array::<BINS>("f_hz")?;
    let mut accelerance = heapless::Vec::<Complex<R>, { BINS * RESPONSES * HITS }>::new();
    for (re, im) in check.input("H_accelerance.re")?.zip(check.input("H_accelerance.im")?) {
        accelerance.push(Complex::new(re, im)).ok()?;
    }
    let start = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta_start")?));
    let damping = check.input_number("with_damping")? != R::zero();
    let damping = if damping { Damping::Viscous } else { Damping::None };
    let settings = GlobalFitSettings { damping, ..GlobalFitSettings::PLAIN };
    let responses = FrequencyResponses::new(&frequencies, &accelerance, RESPONSES, HITS)?;
    let responses = responses.windowed(check.input_number("sigma")?, R::one());
    let mut workspace = [R::zero(); workspace(SENSORS, HITS)];
    let solution = solve(&layout, &responses, &start, &settings, &mut workspace).ok()?;
    check.numbers("theta", solution.estimate.theta().as_slice());
    check.matrix("K", &solution.stiffness);
    Some(())
}
