//! `c_`: mode shapes, and the ten properties from them.

use massline_shared::identify::ResponseInverse;
use massline_shared::identify::conti_bretl::body_from_shapes;
use massline_shared::identify::suspension::FEWEST_MODES;
use massline_shared::identify::toivola_nuutila::solve_orthogonality;
use massline_shared::modes::{
    Mode, OriginResponses, best_force, identify_modes, norm_indicator, reduce_line, shape_of_force,
    shape_of_forces,
};
use massline_shared::{FrequencyResponses, Real};
use nalgebra::{Complex, Matrix6, Vector3, Vector6};

use crate::Check;
use crate::layout::{GoldenResponses, RESPONSES, SENSORS};

const MODES: usize = 6;
const FORCES: usize = 5;

/// `c_modes_`: the shapes at the sensors are given.
pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    let length = check.input_number("L")?;
    let inverse = ResponseInverse::new(&layout.response_matrix(&Vector3::zeros()), length)?;
    let readings = check.input("Phi")?;
    let modes = readings.clone().count() / RESPONSES;
    let mut shapes = heapless::Vec::<Vector6<R>, MODES>::new();
    for mode in 0..modes {
        let mut column = GoldenResponses::zeros(SENSORS);
        let values = readings.clone().skip(mode).step_by(modes);
        column.iter_mut().zip(values).for_each(|(to, value)| *to = value);
        shapes.push(inverse.motion(&column)).ok()?;
    }
    check.numbers("phi0", &row_major(&shapes));
    let solution = solve_orthogonality(&shapes, length)?;
    check.numbers("tn_n_eq", &[R::of(solution.equations as f64)]);
    check.numbers("tn_rank", &[R::of(solution.rank as f64)]);
    check.numbers("tn_rank_mass_known", &[R::of(solution.rank_of_known_mass as f64)]);
    check.numbers("tn_cond", &[solution.condition]);
    match solution.body {
        Some(body) => check.numbers("tn_theta", body.theta().as_slice()),
        None if modes < FEWEST_MODES => {}
        None => return None,
    }
    if modes == MODES {
        let (mass_matrix, body) = body_from_shapes(&Matrix6::from_columns(&shapes))?;
        check.matrix("cb_M0", &mass_matrix);
        check.numbers("cb_theta", body.theta().as_slice());
    }
    Some(())
}

/// `c_select_`: the residues of all forces at the origin are given.
pub(crate) fn run_select<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let length = check.input_number("L")?;
    let forces = check.input("F0")?;
    let forces: [Vector6<R>; FORCES] = core::array::from_fn(|j| {
        Vector6::from_iterator(forces.clone().skip(j).step_by(FORCES).take(6))
    });
    let values = check.input_array::<{ FORCES * 6 * MODES }>("residues0")?;
    let residue = |force: usize, mode: usize| {
        Vector6::from_fn(|row, _| values[(force * 6 + row) * MODES + mode])
    };
    let mut indicators = [R::zero(); FORCES * MODES];
    let mut picks = [R::zero(); MODES];
    let (mut picked, mut fitted) = ([Vector6::zeros(); MODES], [Vector6::zeros(); MODES]);
    for mode in 0..MODES {
        let residues: [Vector6<R>; FORCES] = core::array::from_fn(|force| residue(force, mode));
        for (force, residue) in residues.iter().enumerate() {
            indicators[force * MODES + mode] = norm_indicator(residue, length);
        }
        let best = best_force(&residues, length);
        picks[mode] = R::of(best as f64);
        picked[mode] = shape_of_force(&residues[best], &forces[best])?;
        fitted[mode] = shape_of_forces(&residues, &forces, length)?;
    }
    check.numbers("norm_indicator", &indicators);
    check.numbers("pick", &picks);
    check.numbers("phi0_picked", &row_major(&picked));
    check.numbers("phi0_all_forces", &row_major(&fitted));
    Some(())
}

/// Six rows from columns of six.
fn row_major<R: Real>(columns: &[Vector6<R>]) -> heapless::Vec<R, { 6 * MODES }> {
    (0..6).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
}

/// Lines of the cases of modal identification.
const LINES: usize = 97;
/// Most forces of these cases.
const MOST_FORCES: usize = 4;

/// `e_modal_`: frequency responses are given.
pub(crate) fn run_identification<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    let frequencies = check.input_array::<LINES>("f_hz")?;
    let mut accelerance = heapless::Vec::<Complex<R>, { LINES * RESPONSES * MOST_FORCES }>::new();
    for (re, im) in check.input("H_accelerance.re")?.zip(check.input("H_accelerance.im")?) {
        accelerance.push(Complex::new(re, im)).ok()?;
    }
    let count = layout.hits.len();
    let responses = FrequencyResponses::new(&frequencies, &accelerance, RESPONSES, count)?;
    let origin = Vector3::zeros();
    let zero = Vector6::from_element(Complex::new(R::zero(), R::zero()));
    let mut motions = [zero; LINES * MOST_FORCES];
    let motions = motions.get_mut(..LINES * count)?;
    let mut sigma = [[R::zero(); 6]; LINES];
    for (line, motions) in motions.chunks_exact_mut(count).enumerate() {
        sigma[line] = reduce_line(&layout, &responses, &origin, line, motions)?;
    }
    let s = frequencies.map(|f| Complex::new(R::zero(), R::two_pi() * f));
    let forces: heapless::Vec<Vector6<R>, MOST_FORCES> =
        layout.hits.iter().map(|hit| hit.unit_force(&origin)).collect();
    let length = layout.characteristic_length();
    let responses = OriginResponses { s: &s, motions, sigma: &sigma, forces: &forces, length };
    let modes = identify_modes(&responses, MODES)?.modes;
    let numbers = |quantity: fn(&Mode<R>) -> R| -> heapless::Vec<R, MODES> {
        modes.iter().map(quantity).collect()
    };
    check.numbers("freq", &numbers(|mode| mode.frequency_hz));
    check.numbers("zeta", &numbers(|mode| mode.damping_ratio));
    let shapes: heapless::Vec<Vector6<R>, MODES> = modes.iter().map(|mode| mode.shape).collect();
    check.numbers("phi0", &row_major(&shapes));
    let body = solve_orthogonality(&shapes, length)?.body?;
    check.numbers("theta", body.theta().as_slice());
    Some(())
}
