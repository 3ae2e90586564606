//! `d_dppim_`: the direct method on given columns of receptances, in both forms.

use massline_shared::Real;
use massline_shared::identify::dppim::{Excitation, solve_structural, solve_viscous, span};
use nalgebra::{Complex, Vector6};

use crate::Check;

/// Largest number of columns of a set.
const COLUMNS: usize = 24;

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let length = check.input_number("L")?;
    let first = columns(check, ["w1", "Y1.re", "Y1.im", "F1"])?;
    let second = columns(check, ["w2", "Y2.re", "Y2.im", "F2"])?;
    for (place, path) in ["alpha", "beta"].into_iter().enumerate() {
        let pairs = first.iter().flat_map(|one| second.iter().map(move |other| (one, other)));
        let products = pairs.map(|(one, other)| one.products(other)[place]);
        check.complex_numbers(path, &products.collect::<heapless::Vec<_, { COLUMNS * COLUMNS }>>());
    }
    check.numbers("rank_Y1", &[R::of(span(first.as_slice(), length)? as f64)]);
    let viscous = solve_viscous(first.as_slice(), second.as_slice(), length)?;
    check.numbers("rank_viscous", &[R::of(viscous.rank as f64)]);
    check.numbers("theta_viscous", viscous.body?.theta().as_slice());
    let structural = solve_structural(first.as_slice(), second.as_slice(), length)?;
    check.numbers("rank_hysteretic", &[R::of(structural.rank as f64)]);
    check.numbers("theta_hysteretic", structural.body?.theta().as_slice());
    Some(())
}

/// The columns of a set: angular frequencies, receptances at the origin and forces.
fn columns<R: Real>(
    check: &Check<'_, '_, R>,
    [omega, re, im, force]: [&str; 4],
) -> Option<heapless::Vec<Excitation<R>, COLUMNS>> {
    let omega = check.input(omega)?;
    let count = omega.clone().count();
    let [re, im, force] = [check.input(re)?, check.input(im)?, check.input(force)?];
    let mut excitations = heapless::Vec::new();
    for (k, omega) in omega.enumerate() {
        let [re, im, force] = [re.clone(), im.clone(), force.clone()]
            .map(|rows| Vector6::from_iterator(rows.skip(k).step_by(count).take(6)));
        let receptance = re.zip_map(&im, Complex::new);
        excitations
            .push(Excitation { s: Complex::new(R::zero(), omega), force, receptance })
            .ok()?;
    }
    Some(excitations)
}
