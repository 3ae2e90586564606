//! The suspension-mode methods on the wheel's responses, as files.

use massline_shared::body::scale;
use massline_virtual::bench::Bench;
use massline_virtual::bench::responses::{SprungPart, add_noise, frequency_responses};
use nalgebra::Complex;
use serde_json::json;

use super::*;
use crate::uff::{Encoding, Frf, NodeDirection, write};

const LAYOUT: &str = include_str!("../../examples/wheel.toml");
const CHANNELS: usize = 9;
const HITS: usize = 5;
/// Noise of a line, (m/s²)/N.
const NOISE: f64 = 0.002;

/// The lines of the paper, Hz.
fn lines() -> Vec<f64> {
    (0..97).map(|k| 0.5 + 0.125 * f64::from(k)).collect()
}

/// The wheel's responses with noise at these lines, changed by `change(frequency, channel, hit, response)`.
fn file(
    frequencies: &[f64],
    part: Option<SprungPart>,
    change: impl Fn(f64, usize, usize, Complex<f64>) -> Complex<f64>,
) -> UffFile {
    let layout = LayoutFile::parse(LAYOUT, "wheel.toml").unwrap().layout;
    let bench = Bench::named("wheel").unwrap();
    let mut responses = frequency_responses(&bench, &layout, frequencies, part).unwrap();
    add_noise(&mut responses, NOISE, 12, 0);
    let mut frfs = Vec::new();
    for (place, hit) in layout.hits.iter().enumerate() {
        let direction = hit.dof.axis.index() as i64 + 1;
        let reference = NodeDirection { node: hit.dof.node.into(), direction };
        for channel in 0..CHANNELS {
            let node = layout.sensors[channel / 3].node.into();
            let response = NodeDirection { node, direction: (channel % 3) as i64 + 1 };
            let of_line = responses.chunks_exact(CHANNELS * HITS).zip(frequencies);
            let accelerance = of_line
                .map(|(line, f)| change(*f, channel, place, line[channel * HITS + place]))
                .collect();
            let frequency_hz = frequencies.to_vec();
            frfs.push(Frf { response, reference, frequency_hz, accelerance });
        }
    }
    UffFile::parse(&write(&frfs, Encoding::Binary)).unwrap()
}

fn unchanged(frequencies: &[f64], part: Option<SprungPart>) -> UffFile {
    file(frequencies, part, |_, _, _, h| h)
}

fn solved(text: &str, uff: &UffFile, options: &Options) -> Result<FrfSolution> {
    solve(&LayoutFile::parse(text, "wheel.toml").unwrap(), uff, options, |_, _| ())
}

/// The responses have noise and no other errors.
fn noise_alone() -> String {
    let none = "sensor_position_m = 0\nsensor_rotation_rad = 0\ngain = 0\ncross_axis = 0\nhammer_gain = 0\n\
                hit_position_m = 0\nhit_direction_rad = 0\nnode_position_m = 0\nnode_direction_rad = 0\n";
    format!("{LAYOUT}\n[uncertainty]\n{none}")
}

fn named(method: Method) -> Options {
    Options { selection: Selection::Only(method), ..Options::default() }
}

#[test]
fn every_method_that_applies_answers_and_they_agree() {
    let solution = solved(&noise_alone(), &unchanged(&lines(), None), &Options::default()).unwrap();
    let truth = Bench::named("wheel").unwrap().truth();
    let methods: Vec<_> = solution.identification.estimates.iter().map(|e| e.method).collect();
    assert_eq!(
        methods,
        [
            Method::GlobalFit,
            Method::ToivolaNuutila,
            Method::ContiBretl,
            Method::Dppim,
            Method::ModalConstant
        ]
    );
    for estimate in &solution.identification.estimates {
        let off = (estimate.theta() - truth.theta()).component_div(&estimate.sigma().unwrap());
        // Fifty numbers lie within four standard deviations in 99.7 % of tests.
        assert!(off.amax() < 4.0, "{:?} {off}", estimate.method);
    }
    let agreement = solution.comparison.agreement.as_ref().unwrap();
    assert!(agreement.agrees());
    let json = solution.to_json();
    assert_eq!(json["agreement"]["agree"], json!(true));
    assert_eq!(json["suspension"]["modes"].as_array().unwrap().len(), 6);
    let text = solution.to_text();
    for said in
        ["the methods agree", "begins at 23 Hz", "no answer from mass lines", "Norm Indicator"]
    {
        assert!(text.contains(said), "{said}: {text}");
    }
    // The band of mass lines begins too near to the suspension modes.
    assert!(solution.mass_lines.is_empty() && solution.band_hz.is_none());
}

#[test]
fn a_tyre_is_seen_by_the_global_fit_and_the_others_say_how_far_they_are_off() {
    let tyre = SprungPart { share: 0.52, frequency_hz: 50.0, damping_ratio: 0.03 };
    let uff = unchanged(&lines(), Some(tyre));
    let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
    let truth = Bench::named("wheel").unwrap().truth();
    let mut estimates = solution.identification.estimates.iter();
    let global = estimates.next().unwrap();
    assert_eq!(global.method, Method::GlobalFit);
    let off = (global.theta() - truth.theta()).component_div(&global.sigma().unwrap());
    // Ten numbers lie within four standard deviations in 99.9 % of tests.
    assert!(off.amax() < 4.0, "{off}");
    let scale =
        scale(truth.mass, LayoutFile::parse(LAYOUT, "w").unwrap().layout.characteristic_length());
    for estimate in estimates {
        let warned = estimate.diagnostics.iter().find(|d| d.code == Code::FlexibleModeAboveBand);
        let stated = f64::from(warned.expect("a warning").value);
        let off = (estimate.theta() - truth.theta()).component_div(&scale).amax();
        // The stated bias is the distance from the global fit, which is within 0.5 % of the truth.
        assert!((off - stated).abs() < 0.005, "{:?} {off} {stated}", estimate.method);
    }
    assert!(solution.comparison.agreement.is_none());
}

#[test]
fn four_modes_have_rank_nine_and_a_prior_of_two_properties_closes_it() {
    let lines: Vec<f64> = (0..200).map(|k| 0.5 + 0.031_25 * f64::from(k)).collect();
    let uff = unchanged(&lines, None);
    let options = Options { suspension_band_hz: [0.5, 6.6], ..named(Method::ToivolaNuutila) };
    let error = solved(&noise_alone(), &uff, &options).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "toivola_nuutila_four_modes_rank_nine"));
    let truth = Bench::named("wheel").unwrap().truth();
    let prior = format!(
        "{}\n[prior]\nmass_kg = {{ value = {}, sigma = 0.001 }}\n\
         cx_m = {{ value = {}, sigma = 0.0001 }}\ncy_m = {{ value = {}, sigma = 0.0001 }}\n\
         cz_m = {{ value = {}, sigma = 0.0001 }}\n",
        noise_alone(),
        truth.mass,
        truth.center_of_mass[0],
        truth.center_of_mass[1],
        truth.center_of_mass[2],
    );
    let known = solved(&prior, &uff, &options).unwrap();
    let found = &known.identification.estimates[0].body;
    let off = (found.inertia - truth.inertia).amax() / truth.inertia.amax();
    assert!(off < 0.02, "{off}");
    let error = solved(
        &noise_alone(),
        &uff,
        &Options { selection: Selection::Only(Method::ContiBretl), ..options },
    );
    assert_eq!(error.unwrap_err().code(), "six_modes_needed");
}

#[test]
fn forces_that_do_not_show_all_modes_are_refused_by_name_or_say_where_to_hit() {
    // A single force along the axis of the wheel.
    let text = noise_alone().replace(
        "hits = [\"101:+X\", \"102:+Z\", \"103:+Z\", \"104:+Y\", \"105:+X\"]",
        "hits = [\"103:+Z\"]",
    );
    let solution = solved(&text, &unchanged(&lines(), None), &Options::default());
    match solution {
        Ok(solution) => {
            let text = solution.to_text();
            assert!(text.contains("hardly shows under any hit"), "{text}");
        }
        Err(error) => assert_eq!(error.exit_code(), 3, "{error}"),
    }
}

#[test]
fn a_record_that_ends_too_early_is_named() {
    // What is left of every mode at the end of 8 s multiplies its residue; here the sum is of the modes themselves.
    let layout = LayoutFile::parse(LAYOUT, "wheel.toml").unwrap().layout;
    let bench = Bench::named("wheel").unwrap();
    let modes = massline_virtual::bench::suspension::rigid_modes(
        &bench.body,
        &bench.suspension,
        &bench.gravity,
    )
    .unwrap();
    let record = 8.0;
    let truncated = |f: f64, channel: usize, hit: usize, _: Complex<f64>| {
        let s = Complex::new(0.0, std::f64::consts::TAU * f);
        let row = layout.response_row_at(channel, s);
        let force = layout.hits[hit].unit_force(&Vector3::zeros());
        let mut sum = Complex::new(0.0, 0.0);
        for mode in &modes {
            let damped = (1.0 - mode.damping_ratio.powi(2)).sqrt();
            let pole = Complex::new(-mode.damping_ratio, damped) * mode.omega;
            let residue = Complex::new(0.0, -0.5 / (damped * mode.omega));
            let excited = mode.shape.dot(&force);
            // s² r/(s − p) of both poles is this constant and the fractions of the acceleration.
            let mut response = Complex::new(2.0 * (residue * pole).re, 0.0);
            for (p, r) in [(pole, residue), (pole.conj(), residue.conj())] {
                let kept = Complex::new(1.0, 0.0) - (p * record).exp();
                response += r * p * p * kept / (s - p);
            }
            sum += row.dot(&mode.shape.map(|v| response * v * excited));
        }
        sum
    };
    let uff = file(&lines(), None, truncated);
    let error = solved(&noise_alone(), &uff, &named(Method::ToivolaNuutila)).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "record_too_short_for_damping"));
    // exp(−0.014 · 2π · 2.83 · 8) is 14 %.
    assert!(error.to_string().contains("mode 1 still has 14 %"), "{error}");
}

#[test]
fn a_reversed_hit_and_one_elsewhere_are_named() {
    let reversed = |_: f64, _: usize, hit: usize, h: Complex<f64>| if hit == 2 { -h } else { h };
    let uff = file(&lines(), None, reversed);
    let solution = solved(&noise_alone(), &uff, &Options::default());
    let text = match solution {
        Ok(solution) => solution.to_text(),
        Err(error) => error.to_string(),
    };
    assert!(text.contains("103:+Z"), "{text}");
    let text = noise_alone()
        .replace("position_m = [0.16, 0.12, 0.03]", "position_m = [-0.16, 0.12, 0.03]");
    let solution = solved(&text, &unchanged(&lines(), None), &Options::default()).unwrap();
    let found = solution.diagnostics.iter().any(|d| d.code == Code::NotReciprocal);
    assert!(found, "{:?}", solution.diagnostics);
}

#[test]
fn a_gap_in_the_lines_is_named() {
    let lines: Vec<f64> = lines().into_iter().filter(|f| !(4.0..5.5).contains(f)).collect();
    let solution = solved(&noise_alone(), &unchanged(&lines, None), &Options::default()).unwrap();
    let gap = solution.diagnostics.iter().find(|d| d.code == Code::FrequencyGap).unwrap();
    assert!((gap.value - 3.875).abs() < 1e-5, "{gap:?}");
}
