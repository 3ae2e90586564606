//! Wheels that hang on three mounts, each another body on other springs with another damping.

use std::f64::consts::TAU;

use massline_physics::suspension::{Cord, Suspension, rigid_modes};
use massline_physics::{Bench, ErrorsFrom};
use massline_shared::body::RigidBody;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Frequencies of the lowest and of the highest suspension mode, Hz: all lie within the band of the profile.
const LOWEST: f64 = 1.5;
const HIGHEST: [f64; 2] = [4.0, 9.0];
/// Least ratio of neighbouring frequencies.
const APART: f64 = 1.03;

/// A wheel on a bench.
#[derive(Clone, Debug)]
pub struct DrawnWheel {
    /// The bench.
    pub bench: Bench,
    /// Frequency of its highest suspension mode, Hz.
    pub highest_hz: f64,
    /// Seed of its test.
    pub seed: u64,
}

/// So many wheels of 8 to 30 kg on this bench, with errors as large as the layout states.
pub fn drawn_wheels(bench: &Bench, seed: u64, count: usize) -> Vec<DrawnWheel> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let bench = Bench { errors: ErrorsFrom::Layout, ..bench.clone() };
    std::iter::from_fn(|| Some(drawn(&bench, &mut random))).flatten().take(count).collect()
}

/// A wheel; `None` for one whose modes lie elsewhere.
fn drawn(bench: &Bench, random: &mut ChaCha8Rng) -> Option<DrawnWheel> {
    let mut within = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mass = within(8.0, 30.0);
    let about_axis = mass * within(0.15, 0.28).powi(2);
    let across = about_axis * within(0.5, 0.75);
    let other = across * within(0.93, 1.07);
    let [xy, xz, yz] = [(); 3].map(|()| about_axis * within(-0.01, 0.01));
    let inertia = Matrix3::new(across, xy, xz, xy, other, yz, xz, yz, about_axis);
    let center = [within(-0.004, 0.004), within(-0.004, 0.004), within(-0.08, 0.02)];
    let body = RigidBody { mass, center_of_mass: center.into(), inertia };
    let (along, sideways, turn) = (within(3.0, 8.0), within(2.0, 6.0), within(0.0, TAU));
    let cords = [0.0, 1.0, 2.0].map(|third| {
        let angle = turn + TAU / 3.0 * third + within(-0.3, 0.3);
        let radius = within(0.12, 0.26);
        // A third of what makes the mass swing with this frequency.
        let mut spring = |hz: f64, spread: f64| {
            mass * (TAU * hz).powi(2) / 3.0 * within(1.0 - spread, 1.0 + spread)
        };
        let springs = [spring(sideways, 0.4), spring(sideways, 0.4), spring(along, 0.2)];
        Cord {
            point_m: [radius * angle.cos(), radius * angle.sin(), within(0.03, 0.15)],
            direction: Vector3::z().into(),
            axial_n_per_m: None,
            length_m: 0.25,
            spring_n_per_m: Some(springs),
        }
    });
    let damping_ratio = within(0.006, 0.025);
    let seed = random.random();
    let suspension = Suspension::Cords { cords: cords.into(), damping_ratio };
    let hz = rigid_modes(&body, &suspension, &bench.gravity).ok()?.map(|mode| mode.omega / TAU);
    let [lowest, .., highest] = hz;
    let are_apart = hz.windows(2).all(|pair| pair[1] > APART * pair[0]);
    let fits = lowest > LOWEST && (HIGHEST[0]..HIGHEST[1]).contains(&highest) && are_apart;
    let bench = Bench { body, suspension, ..bench.clone() };
    fits.then_some(DrawnWheel { bench, highest_hz: highest, seed })
}
