//! Exact responses of the wheel on its suspension, for tests.

use std::f64::consts::TAU;

use massline_files::layout_file::LayoutFile;
use massline_physics::Bench;
use massline_physics::suspension::rigid_modes;
use massline_shared::layout::HostLayout;
use nalgebra::{Complex, Vector3, Vector6};

/// The layout of the wheel.
pub(super) fn wheel() -> HostLayout {
    let text = include_str!("../../../examples/wheel.toml");
    LayoutFile::parse(text, "wheel.toml").unwrap().layout
}

/// Responses of the bundled wheel at these frequencies, `[bin][channel][hit]`, where every mode has a `gain` of its own
/// in every response, which depends on the amplitude of that response, (m/s²)/(N s).
pub(super) fn wheel_responses(
    layout: &HostLayout,
    frequencies: &[f64],
    mut gain: impl FnMut(f64) -> f64,
) -> Vec<Complex<f64>> {
    let bench = Bench::named("wheel").unwrap();
    let modes = rigid_modes(&bench.body, &bench.suspension, &bench.gravity).unwrap();
    let (hits, channels) = (layout.hits.len(), 3 * layout.sensors.len());
    let mut responses = vec![Complex::ZERO; frequencies.len() * channels * hits];
    for place in 0..channels * hits {
        let (channel, hit) = (place / hits, place % hits);
        let force = layout.hits[hit].unit_force(&Vector3::zeros());
        let product = |shape: &Vector6<f64>, s: Complex<f64>| {
            let row = layout.response_row_at(channel, s).transpose();
            (row * shape.map(Complex::from))[0] * shape.dot(&force)
        };
        let at_resonance = modes
            .iter()
            .map(|mode| product(&mode.shape, Complex::new(0.0, mode.omega)).norm() * mode.omega);
        let amplitude = at_resonance.fold(0.0, f64::hypot);
        for mode in modes {
            let gain = gain(amplitude);
            for (line, frequency) in frequencies.iter().enumerate() {
                let s = Complex::new(0.0, TAU * frequency);
                let (omega, zeta) = (mode.omega, mode.damping_ratio);
                let ratio = s * s / (s * s + s * (2.0 * zeta * omega) + omega * omega);
                responses[line * channels * hits + place] += product(&mode.shape, s) * ratio * gain;
            }
        }
    }
    responses
}
