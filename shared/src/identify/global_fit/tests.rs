//! The fit recovers body and suspension, and refuses bad input.

mod sensitivities;
pub(in crate::identify) mod wheel;
mod wheel_tests;

use super::unknowns::real;
use super::*;
use crate::capacity::Rig;
use crate::layout::tests::{bar_body, bar_layout};
use crate::linalg::skew;
use nalgebra::{Matrix3, SMatrix, Vector3};
use std::vec;
use std::vec::Vec;

const DECAY: f64 = 10.0;

fn settings() -> GlobalFitSettings {
    GlobalFitSettings::PLAIN
}

/// Four cords at different points, stiff along z and softer across, N/m; the matrix is about the origin.
fn suspension(stiffness: f64) -> Matrix6<f64> {
    let mut sum = Matrix6::zeros();
    for (k, at) in [[0.0, 0.0, 0.1], [0.2, 0.0, 0.1], [0.2, -0.2, 0.2], [0.0, -0.2, 0.1]]
        .into_iter()
        .enumerate()
    {
        let along = stiffness * (1.0 + 0.2 * k as f64);
        let cord = Matrix3::from_diagonal(&Vector3::new(0.3 * along, 0.4 * along, along));
        let mut moves = SMatrix::<f64, 3, 6>::zeros();
        moves.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
        moves.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&Vector3::from(at)));
        sum += moves.transpose() * cord * moves;
    }
    sum
}

/// Bins from `low` to 120 Hz, 2 Hz apart.
fn frequencies(low: f64) -> Vec<f64> {
    (0..).map(|k| low + 2.0 * f64::from(k)).take_while(|f| *f <= 120.0).collect()
}

/// Responses of the bar on a suspension, by the formula at the top of the module.
fn responses(frequencies: &[f64], stiffness: f64, damping: f64, elastic: f64) -> Vec<Complex<f64>> {
    let (layout, body) = (bar_layout(), bar_body());
    let mut accelerances = Vec::new();
    for f in frequencies {
        let s = Complex::new(DECAY, std::f64::consts::TAU * f);
        let dynamic = body.mass_matrix().map(real)
            + suspension(stiffness).map(|k| real(k) / (s * s))
            + suspension(damping).map(|c| real(c) / s);
        let inverse = dynamic.try_inverse().unwrap();
        let response = layout.response_matrix_at(&Vector3::zeros(), s);
        for channel in 0..9 {
            for hit in layout.hits.iter() {
                let force = hit.unit_force(&Vector3::zeros()).map(real);
                let motion = inverse * force;
                let rigid: Complex<f64> =
                    response.row(channel).iter().zip(&motion).map(|(g, a)| g * a).sum();
                accelerances.push(rigid + s * s * (elastic * (channel as f64 - 3.0)));
            }
        }
    }
    accelerances
}

fn fit(
    frequencies: &[f64],
    accelerance: &[Complex<f64>],
    start: &RigidBody<f64>,
    settings: &GlobalFitSettings,
) -> Result<GlobalFitSolution<f64>, Diagnostics> {
    let data = FrequencyResponses::new(frequencies, accelerance, 9, 3).unwrap();
    let data = data.windowed(DECAY, 1.0);
    let mut workspace = vec![0.0; workspace(3, 3)];
    solve(&bar_layout(), &data, start, settings, &mut workspace)
}

/// The bar with mass, centre and inertia changed by two percent.
fn crude() -> RigidBody<f64> {
    let body = bar_body();
    RigidBody {
        mass: body.mass * 1.02,
        center_of_mass: body.center_of_mass + Vector3::new(0.002, -0.002, 0.002),
        inertia: body.inertia * 0.98,
    }
}

fn worst(solution: &GlobalFitSolution<f64>) -> f64 {
    let error = solution.estimate.body.theta() - bar_body().theta();
    // Scales [m, L, L, L, m L² × 6] with L = 0.136 m.
    let scale = |k: usize| [1.23, 0.136, 0.136, 0.136, 0.0227].get(k).copied().unwrap_or(0.0227);
    error.iter().enumerate().map(|(k, e)| (e / scale(k)).abs()).fold(0.0, f64::max)
}

#[test]
fn the_body_comes_back_from_lines_near_the_suspension_modes() {
    // The highest suspension mode of 300 N/m is near 6 Hz: mass lines would need a band from 18 Hz.
    let f = frequencies(8.0);
    let solution = fit(&f, &responses(&f, 300.0, 0.0, 0.0), &crude(), &settings()).unwrap();
    // The data are exact, so the error is what the last step leaves: the square of the error before it.
    assert!(worst(&solution) < 1e-6, "{:e}", worst(&solution));
    let readable = (solution.stiffness - suspension(300.0)).fixed_view::<3, 3>(0, 0).norm();
    assert!(readable < 1e-2, "{readable} N/m");
    assert!(solution.damping.is_none());
}

#[test]
fn damping_is_told_from_mass_when_it_is_fitted() {
    let f = frequencies(8.0);
    let data = responses(&f, 300.0, 1.5, 0.0);
    let with =
        fit(&f, &data, &crude(), &GlobalFitSettings { damping: Damping::Viscous, ..settings() })
            .unwrap();
    assert!(worst(&with) < 1e-5, "{:e}", worst(&with));
    let damping = (with.damping.unwrap() - suspension(1.5)).fixed_view::<3, 3>(0, 0).norm();
    assert!(damping < 1e-2, "{damping} N s/m");
    // Without the elastic term the fit is wrong or does not converge.
    if let Ok(without) = fit(&f, &data, &crude(), &settings()) {
        assert!(worst(&without) > 100.0 * worst(&with));
    }
}

#[test]
fn a_residual_of_elastic_modes_is_eliminated() {
    let f = frequencies(10.0);
    let data = responses(&f, 300.0, 0.0, 1e-7);
    let with =
        fit(&f, &data, &crude(), &GlobalFitSettings { elastic: true, ..settings() }).unwrap();
    assert!(worst(&with) < 1e-6, "{:e}", worst(&with));
    let without = fit(&f, &data, &crude(), &settings()).unwrap();
    assert!(worst(&without) > 1e-3, "{:e}", worst(&without));
}

#[test]
fn the_standard_deviation_is_that_of_many_fits() {
    let f = frequencies(10.0).into_iter().step_by(2).collect::<Vec<_>>();
    let clean = responses(&f, 100.0, 0.0, 0.0);
    let mut state = 3_u64;
    let mut noise = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5) * 0.04
    };
    let (mut squares, mut variances) = (0.0, 0.0);
    let runs = 15;
    for _ in 0..runs {
        let noisy: Vec<_> = clean.iter().map(|h| h + Complex::new(noise(), noise())).collect();
        let solution = fit(&f, &noisy, &bar_body(), &settings()).unwrap();
        let sigma = solution.estimate.sigma().unwrap();
        let error = solution.estimate.theta() - bar_body().theta();
        squares += error.component_div(&sigma).norm_squared() / 10.0;
        variances += 1.0;
    }
    // 150 squares of standard normal variables, some of them correlated: their mean is known to about 15 %,
    // and the tolerance is twice that.
    let ratio: f64 = squares / variances;
    assert!((ratio - 1.0).abs() < 0.3, "{ratio}");
}

#[test]
fn data_that_are_not_finite_too_few_or_of_another_size_are_refused() {
    let f = frequencies(10.0);
    let good = responses(&f, 100.0, 0.0, 0.0);
    let code = |result: Result<GlobalFitSolution<f64>, Diagnostics>| result.unwrap_err()[0].code;
    let mut nan = good.clone();
    nan[7].im = f64::NAN;
    assert_eq!(code(fit(&f, &nan, &crude(), &settings())), Code::DataNotFinite);
    let every = GlobalFitSettings { damping: Damping::Viscous, elastic: true, ..settings() };
    let few = fit(&f[..1], &good[..27], &crude(), &every);
    assert_eq!(code(few), Code::BandTooNarrow);
    assert!(FrequencyResponses::new(&f, &good[1..], 9, 3).is_none());
    let data = FrequencyResponses::new(&f, &good, 3, 9).unwrap();
    let mut workspace = vec![0.0; workspace(3, 3)];
    let wrong = solve(&bar_layout(), &data, &crude(), &settings(), &mut workspace);
    assert_eq!(code(wrong), Code::FrfMissing);
    let data = FrequencyResponses::new(&f, &good, 9, 3).unwrap();
    let small = solve(&bar_layout(), &data, &crude(), &settings(), &mut workspace[1..]);
    assert_eq!(code(small), Code::BandTooNarrow);
}

/// The bar without a suspension at 12 bins, Hz; each channel and hit with its own constant error, relative.
fn plain_mass_lines(error: f64) -> (Layout<f64, Rig>, Vec<f64>, Vec<Complex<f64>>) {
    let (mut layout, body) = (bar_layout(), bar_body());
    layout.gravity = None;
    let f: Vec<f64> = (1..=12).map(|k| 10.0 * f64::from(k)).collect();
    let mut data = Vec::new();
    for _ in &f {
        for channel in 0..9 {
            for hit in 0..3 {
                let error = error * f64::from(7 * channel as u16 + 13 * hit as u16).sin();
                data.push(real(layout.accelerance(&body, hit).unwrap()[channel] * (1.0 + error)));
            }
        }
    }
    (layout, f, data)
}

#[test]
fn a_band_above_the_suspension_that_shows_nothing_of_it_is_refused() {
    // Plain mass lines at 12 bins with constant errors of 2 %: three hits leave six directions of K undetermined.
    let (layout, f, data) = plain_mass_lines(0.02);
    for settings in [settings(), GlobalFitSettings { elastic: true, ..Default::default() }] {
        let data = FrequencyResponses::new(&f, &data, 9, 3).unwrap();
        let mut workspace = vec![0.0; workspace(3, 3)];
        let refused = solve(&layout, &data, &crude(), &settings, &mut workspace).map(|s| s.noise);
        let code = refused.map_err(|reasons| reasons[0].code);
        let known = [Code::TenParametersNotIdentifiable, Code::NotConverged];
        assert!(code.is_err_and(|code| known.contains(&code)), "{code:?}");
    }
}

#[test]
fn exact_mass_lines_of_three_hits_do_not_determine_the_stiffness() {
    let (layout, f, data) = plain_mass_lines(0.0);
    let data = FrequencyResponses::new(&f, &data, 9, 3).unwrap();
    let refused = solve(&layout, &data, &crude(), &settings(), &mut vec![0.0; workspace(3, 3)]);
    let refused = refused.unwrap_err()[0];
    // Motions of a free body have the same directions at every frequency: six of 21 directions do not show.
    assert_eq!((refused.code, refused.value), (Code::TenParametersNotIdentifiable, 15.0));
}
