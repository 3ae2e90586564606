//! The suspension modes and the methods in steps, as a rig solves them: 6 hits, 123 lines.

use massline_on_target::{StepCosts, measure_steps, print};
use massline_shared::Progress;
use massline_shared::body::{RigidBody, scale};
use massline_shared::identify::agreement::{Comparing, PackedPropagation};
use massline_shared::identify::suspension_solver::{
    LineGrid, READINGS, SolverMemory, SuspensionSolver, WEIGHTS,
};
use massline_shared::identify::{Method, SUSPENSION_METHODS, random_signs};
use massline_shared::layout::RigLayout;
use massline_shared::modes::{CompactMotions, MOST_LINES, SEARCH_MEMORY, SUSPENSION_MODES};
use nalgebra::{Complex, SVector};

use super::modes::{FORCES, simulated};
use super::outcome::close;

/// The first line that is used; the motions begin there.
const FIRST: usize = 5;
const RESOLUTION_HZ: f32 = 0.1;
/// Changes that are measured after the one that changes nothing: draws of noise. All of them would take minutes.
const DRAWS: u32 = 2;

/// Measures the steps from the responses to the modes, and those of a draw of noise.
// Not inlined, so that its memory is not on the stack of the other measurements.
#[inline(never)]
pub fn measure_solver(layout: &RigLayout, body: &RigidBody<f32>) {
    let (s, motions) = simulated(layout, body);
    let mut codes = [0; 2 * CompactMotions::<f32>::CODES];
    let mut scratch = [0.0; SEARCH_MEMORY];
    let mut readings = [Complex::new(0.0, 0.0); READINGS];
    let mut weights = [0.0; WEIGHTS];
    let mut lines = [Complex::new(0.0, 0.0); MOST_LINES];
    let mut memory = SolverMemory {
        codes: &mut codes,
        scratch: &mut scratch,
        readings: &mut readings,
        weights: &mut weights,
        lines: &mut lines,
    };
    let grid = LineGrid {
        resolution_hz: RESOLUTION_HZ,
        band_hz: [0.5, 12.75],
        decay: 0.0,
        correlation: 1.0,
    };
    let dofs: [usize; FORCES] = core::array::from_fn(|dof| dof);
    let mut solver = SuspensionSolver::idle();
    solver.begin(layout, grid, &dofs);
    assert!(!solver.has_failed(), "a layout that determines the motion");
    print(format_args!("solver_state_bytes {}", size_of_val(&solver)));
    let reference = solver.reference();
    let costs = measure_steps(|| {
        if let Some((dof, channel)) = solver.wants() {
            let mut response = [Complex::new(0.0, 0.0); MOST_LINES];
            for (line, to) in response.iter_mut().enumerate().skip(FIRST) {
                let rows = layout.response_matrix_at(&reference, s[line - FIRST]);
                let motion = motions[(line - FIRST) * FORCES + dof];
                *to = rows.row(channel).iter().zip(&motion).map(|(row, y)| row * y).sum();
            }
            solver.take(layout, &response, &mut memory);
            return true;
        }
        solver.step(layout, &mut memory);
        solver.taken() < 1.0
    });
    report("solver_intake", costs);
    let costs = measure_steps(|| {
        solver.step(layout, &mut memory);
        solver.unanswered()
    });
    report("solver_answers", costs);
    assert!(!solver.has_failed(), "{:?}", solver.diagnostics());
    assert_eq!(solver.modes().len(), SUSPENSION_MODES);
    let mut until = |changes: u32| {
        measure_steps(|| {
            assert_eq!(solver.step(layout, &mut memory), Progress::Going);
            solver.changes_done() < changes
        })
    };
    // The first change is none.
    report("solver_change", until(1));
    let draws = until(1 + DRAWS);
    report("solver_draw", StepCosts { whole: draws.whole / u64::from(DRAWS), ..draws });
    let scale = scale(body.mass, layout.characteristic_length());
    for method in Method::of_modes() {
        let Some(answer) = solver.answer(method) else { continue };
        let found = answer.body.theta().component_div(&scale);
        // As for the methods alone.
        close(method.name(), &found, &body.theta().component_div(&scale), 0.05);
    }
}

fn report(name: &str, costs: StepCosts) {
    print(format_args!("{name}_instructions {}", costs.whole));
    print(format_args!("{name}_step_instructions {}", costs.longest));
    print(format_args!("{name}_stack {}", costs.stack));
    print(format_args!("{name}_steps {}", costs.steps));
}

/// Measures the comparison of five answers that all differ by more than chance, which takes longest.
#[inline(never)]
pub fn measure_comparison() {
    const METHODS: usize = SUSPENSION_METHODS;
    const DRAWS: u32 = 40;
    let mut memory = [Complex::new(0.0_f32, 0.0); PackedPropagation::<METHODS>::MEMORY];
    let mut sums = PackedPropagation::<METHODS>::new(&mut memory).expect("memory for the sums");
    for draw in 0..DRAWS {
        let deviation = |method: usize| {
            SVector::from_fn(|k, _| {
                let sign = |place: usize| random_signs(draw, place)[0] as f32;
                0.3 * sign(k) + 0.1 * sign(10 * (method + 1) + k)
            })
        };
        sums.add_draw(&mut memory, &core::array::from_fn(|method| Some(deviation(method))));
    }
    sums.end_draws(&mut memory);
    let answers: [_; METHODS] = core::array::from_fn(|method| {
        let of = |k: usize| (method * method) as f32 + 0.1 * k as f32;
        Some(SVector::<f32, 10>::from_fn(|k, _| of(k)))
    });
    let covariances = sums.covariances(&memory);
    let mut comparing = None;
    let costs = measure_steps(|| match &mut comparing {
        None => {
            comparing = Comparing::new(&answers, &covariances);
            comparing.is_some()
        }
        Some(comparing) => comparing.step(&answers, &covariances) == Some(Progress::Going),
    });
    let found = comparing.expect("several answers");
    assert!(found.found().between.min() > 0.0, "{:?}", found.found());
    report("solver_comparison", costs);
}
