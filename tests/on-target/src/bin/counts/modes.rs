//! The suspension modes and the methods that use them, on the motions of one point: 6 forces, 128 lines, 36 KiB.

use massline_on_target::{Cost, measure};
use massline_shared::body::RigidBody;
use massline_shared::body::scale;
use massline_shared::identify::Method;
use massline_shared::identify::suspension::Suspension;
use massline_shared::layout::RigLayout;
use massline_shared::modes::{
    LinesPerSide, MOST_LINES, Modes, Motions, Orders, OriginResponses, Peak, SUSPENSION_MODES,
    choose_lines, norm_indicator,
};
use nalgebra::{Complex, Matrix3x6, Matrix6, Vector3, Vector6};

use super::outcome::{close, report};

pub const FORCES: usize = 6;
/// Standard deviation of the real and of the imaginary part of a motion.
const NOISE: f32 = 0.001;

pub type AllMotions = [Vector6<Complex<f32>>; MOST_LINES * FORCES];

/// Measures how the modes are found and how each method answers.
pub fn measure_modes(layout: &RigLayout, body: &RigidBody<f32>) {
    let reference = layout.sensor_centroid();
    let length = layout.characteristic_length();
    let forces: [Vector6<f32>; FORCES] =
        core::array::from_fn(|hit| layout.hits[hit].unit_force(&reference));
    let frequencies = frequencies();
    let (s, motions) = simulated(layout, body);
    let sigma = [[1.0; 6]; MOST_LINES];
    let responses = OriginResponses {
        s: &s,
        motions: Motions::Full(&motions),
        sigma: &sigma,
        forces: &forces,
        length,
    };
    let (orders, cost) = measured(|| Orders::up_to(&responses, SUSPENSION_MODES + 1));
    report("modes_orders", cost);
    let order = orders.sufficient().expect("the modes show");
    assert_eq!(order.poles.len(), SUSPENSION_MODES, "{order:?}");
    let (found, cost) = measured(|| Modes::of_poles(&responses, &order.poles));
    report("modes_shapes", cost);
    let (modes, places) = found.expect("the responses have residues");
    assert_eq!(places.len(), SUSPENSION_MODES, "every mode is excited");
    let peaks: heapless::Vec<Peak<f32>, SUSPENSION_MODES> = modes
        .modes
        .iter()
        .map(|mode| Peak { frequency_hz: mode.frequency_hz, damping_ratio: mode.damping_ratio })
        .collect();
    let lines = choose_lines(&frequencies, &peaks, LinesPerSide::Width);
    for mode in &modes.modes {
        let shown = forces.iter().map(|force| mode.indicator(force, length)).fold(0.0, f32::max);
        let size = norm_indicator(&mode.shape, length);
        // A force along the mode through its farthest point would show all of it; one of six forces shows a tenth.
        assert!(shown > 0.1 * size * size, "{mode:?}");
    }
    let noise = NOISE * core::f32::consts::SQRT_2;
    let suspension =
        Suspension { responses: &responses, modes: &modes, lines: &lines, noise, known: &[] };
    for method in Method::of_modes() {
        let name = method.name();
        let (answer, cost) = measured(|| method.of_suspension(&suspension));
        report(name, cost);
        let answer = answer.expect("a method of the suspension").expect("an answer");
        // In parts of m, L and m L², so that every property counts: 5 % is five times what noise of 0.1 % of the
        // responses near the modes makes of the worst of them.
        let scale = scale(body.mass, length);
        let found = answer.body.shifted_to(&-reference).theta().component_div(&scale);
        close(name, &found, &body.theta().component_div(&scale), 0.05);
    }
}

/// Frequencies of the lines, Hz.
fn frequencies() -> [f32; MOST_LINES] {
    core::array::from_fn(|line| 0.5 + 0.1 * line as f32)
}

/// The Laplace variables of the lines, and the motions of the reference point at them.
pub fn simulated(
    layout: &RigLayout,
    body: &RigidBody<f32>,
) -> ([Complex<f32>; MOST_LINES], AllMotions) {
    let reference = layout.sensor_centroid();
    let forces: [Vector6<f32>; FORCES] =
        core::array::from_fn(|hit| layout.hits[hit].unit_force(&reference));
    let s = frequencies().map(|f| Complex::new(0.0, core::f32::consts::TAU * f));
    (s, motions(&s, &forces, &body.shifted_to(&reference), &reference))
}

/// The result of some work, and what it cost.
fn measured<T>(work: impl FnOnce() -> T) -> (T, Cost) {
    let mut result = None;
    let cost = measure(|| result = Some(work()));
    (result.expect("the work is done"), cost)
}

/// The motions of the reference point of a body on three springs, with noise.
fn motions(
    s: &[Complex<f32>; MOST_LINES],
    forces: &[Vector6<f32>; FORCES],
    body: &RigidBody<f32>,
    reference: &Vector3<f32>,
) -> AllMotions {
    let real = |v: f32| Complex::new(v, 0.0);
    let (mass, stiffness) = (body.mass_matrix(), stiffness(reference));
    let mut motions = [Vector6::zeros(); MOST_LINES * FORCES];
    let mut state = 1_u32;
    let mut noise = || {
        // A linear congruential generator (Numerical Recipes); twelve uniform numbers are nearly normal.
        let sum: f32 = (0..12)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / (1 << 24) as f32
            })
            .sum();
        NOISE * (sum - 6.0)
    };
    for (line, s) in s.iter().enumerate() {
        let dynamic = Matrix6::from_fn(|i, j| {
            let damping = 0.25 * mass[(i, j)] + 0.0006 * stiffness[(i, j)];
            s * s * mass[(i, j)] + s * damping + real(stiffness[(i, j)])
        });
        let inverse = dynamic.try_inverse().expect("the body is not at a pole");
        for (force, to) in forces.iter().zip(&mut motions[line * FORCES..]) {
            let exact = inverse * force.map(real) * (s * s);
            *to = exact.map(|v| v + Complex::new(noise(), noise()));
        }
    }
    motions
}

/// Stiffness about the reference point: three springs at points that are not on a line.
fn stiffness(reference: &Vector3<f32>) -> Matrix6<f32> {
    let springs = [
        ([0.0, 0.1, 0.05], [75.0, 50.0, 300.0]),
        ([0.3, -0.2, 0.0], [100.0, 150.0, 250.0]),
        ([0.2, 0.05, 0.2], [90.0, 125.0, 450.0]),
    ];
    let mut sum = Matrix6::zeros();
    for (point, n_per_m) in springs {
        let arm = Vector3::from(point) - reference;
        let mut motion = Matrix3x6::zeros();
        motion.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm.cross_matrix());
        for (axis, n_per_m) in n_per_m.into_iter().enumerate() {
            let row = motion.row(axis);
            sum += row.transpose() * row * n_per_m;
        }
    }
    sum
}
