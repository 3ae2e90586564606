//! The suspension-mode methods on the wheel's responses, as files.

use massline_shared::body::scale;
use massline_virtual::bench::Bench;
use massline_virtual::bench::responses::{SprungPart, add_noise, frequency_responses};
use massline_virtual::bench::suspension::Suspension;
use nalgebra::Complex;
use serde_json::json;

use super::*;
use crate::uff::{Encoding, Frf, NodeDirection, write};

const LAYOUT: &str = include_str!("../../examples/wheel.toml");
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
    file_of(&Bench::named("wheel").unwrap(), LAYOUT, frequencies, part, change)
}

/// The same for another bench or other hits.
fn file_of(
    bench: &Bench,
    layout: &str,
    frequencies: &[f64],
    part: Option<SprungPart>,
    change: impl Fn(f64, usize, usize, Complex<f64>) -> Complex<f64>,
) -> UffFile {
    let layout = LayoutFile::parse(layout, "wheel.toml").unwrap().layout;
    let mut responses = frequency_responses(bench, &layout, frequencies, part).unwrap();
    add_noise(&mut responses, NOISE, 12, 0);
    let mut frfs = Vec::new();
    let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
    for (place, hit) in layout.hits.iter().enumerate() {
        let direction = hit.dof.axis.index() as i64 + 1;
        let reference = NodeDirection { node: hit.dof.node.into(), direction };
        for channel in 0..channels {
            let node = layout.sensors[channel / 3].node.into();
            let response = NodeDirection { node, direction: (channel % 3) as i64 + 1 };
            let of_line = responses.chunks_exact(channels * hits).zip(frequencies);
            let accelerance = of_line
                .map(|(line, f)| change(*f, channel, place, line[channel * hits + place]))
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
    // The lines do not reach into the band of mass lines.
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

/// Lines up to 120 Hz.
fn wide() -> Vec<f64> {
    (0..479).map(|k| 0.5 + 0.25 * f64::from(k)).collect()
}

#[test]
fn mass_lines_near_the_suspension_are_refused_also_by_name() {
    let uff = unchanged(&wide(), None);
    for method in [Method::InertiaRestraint, Method::MaximumLikelihood] {
        let error = solved(&noise_alone(), &uff, &named(method)).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, "suspension_in_band"), "{error}");
    }
    // Lines that reach only a little into the band are no mass line.
    let error =
        solved(&noise_alone(), &unchanged(&lines(), None), &named(Method::InertiaRestraint));
    assert_eq!(error.unwrap_err().code(), "band_too_narrow");
    // A band above them does: the wheel is rigid there.
    let above =
        noise_alone().replace("[uncertainty]", "[test]\nband_hz = [24, 120]\n[uncertainty]");
    let solution = solved(&above, &uff, &Options::default()).unwrap();
    let methods = solution.identification.estimates.iter().map(|e| e.method);
    let of_lines = [Method::MaximumLikelihood, Method::InertiaRestraint];
    assert_eq!(methods.filter(|m| of_lines.contains(m)).count(), 2);
}

#[test]
fn a_tyre_leaves_no_mass_line() {
    let tyre = SprungPart { share: 0.52, frequency_hz: 50.0, damping_ratio: 0.03 };
    let uff = unchanged(&wide(), Some(tyre));
    for band in ["[24, 120]", "[24, 45]"] {
        let band = format!("[test]\nband_hz = {band}\n[uncertainty]");
        let text = noise_alone().replace("[uncertainty]", &band);
        for method in [Method::InertiaRestraint, Method::MaximumLikelihood] {
            match solved(&text, &uff, &named(method)) {
                Ok(found) => {
                    let warned = found.diagnostics.iter().any(|d| d.code == Code::NoPlateau);
                    assert!(warned, "{}", found.to_text());
                }
                Err(error) => assert_eq!(error.exit_code(), 3, "{error}"),
            }
        }
    }
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
fn a_single_hit_is_enough_and_the_modes_that_it_hardly_shows_are_named() {
    let text = noise_alone().replace(
        "hits = [\"101:+X\", \"102:+Z\", \"103:+Z\", \"104:+Y\", \"105:+X\"]",
        "hits = [\"103:+Z\"]",
    );
    let solution = solved(&text, &unchanged(&lines(), None), &Options::default()).unwrap();
    let truth = Bench::named("wheel").unwrap().truth();
    let global = solution.answer().unwrap();
    assert_eq!(global.method, Method::GlobalFit);
    let off = (global.theta() - truth.theta()).component_div(&global.sigma().unwrap());
    // Ten numbers lie within four standard deviations in 99.9 % of tests.
    assert!(off.amax() < 4.0, "{off}");
    let text = solution.to_text();
    for said in ["mode 2 hardly shows under any hit", "mode 6 hardly shows under any hit"] {
        assert!(text.contains(said), "{said}: {text}");
    }
    // Three hits at least make a mass line.
    assert!(text.contains("modal-constant: not applicable"), "{text}");
}

/// The wheel on springs that move it along one direction or turn it about one axis in every mode, hit along X and Y at
/// this height above its centre of mass, m.
fn hit_in_one_plane(height: f64) -> (String, UffFile) {
    let mut bench = Bench::named("wheel").unwrap();
    let hz = [2.8, 3.2, 3.6, 6.1, 7.2, 7.7];
    bench.suspension = Suspension::Frequencies { hz, damping_ratio: 0.014 };
    let z = bench.body.center_of_mass[2] + height;
    let mut text = noise_alone().replace("\"102:+Z\", \"103:+Z\", ", "");
    for (point, at) in [
        ("-0.20, 0.10, 0.02", "-0.20, 0.10"),
        ("0.18, -0.21, -0.02", "0.18, -0.21"),
        ("-0.29, -0.06, -0.09", "-0.29, -0.06"),
    ] {
        assert!(text.contains(point));
        text = text.replace(point, &format!("{at}, {z}"));
    }
    let uff = file_of(&bench, &text, &lines(), None, |_, _, _, h| h);
    (text, uff)
}

#[test]
fn hits_in_one_plane_determine_nothing_and_the_missing_hit_is_named() {
    let (text, uff) = hit_in_one_plane(0.0);
    for (method, code) in [
        (Method::GlobalFit, "suspension_modes_missing"),
        (Method::ToivolaNuutila, "suspension_modes_missing"),
        (Method::ContiBretl, "six_modes_needed"),
        (Method::Dppim, "responses_do_not_span_six"),
        (Method::DppimStructural, "property_undetermined"),
        (Method::ModalConstant, "ten_parameters_not_identifiable"),
    ] {
        let error = solved(&text, &uff, &named(method)).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, code), "{error}");
    }
    let error = solved(&text, &uff, &Options::default()).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "suspension_modes_missing"));
    let said = error.to_string();
    assert!(said.contains("show 3 suspension modes"), "{said}");
    // The three hits push along X and Y in one plane.
    assert!(said.contains("a hit at 1:+Z (beside the sensor) would be"), "{said}");
}

#[test]
fn hits_just_above_that_plane_show_five_modes_and_where_to_hit() {
    let (text, uff) = hit_in_one_plane(0.01);
    let solution = solved(&text, &uff, &Options::default()).unwrap();
    let methods: Vec<_> = solution.identification.estimates.iter().map(|e| e.method).collect();
    assert_eq!(methods, [Method::GlobalFit, Method::ToivolaNuutila]);
    let text = solution.to_text();
    for said in [
        "mode 4 hardly shows under any hit",
        "1 of the six modes do not show: hit",
        "dppim: not applicable: responses_do_not_span_six: the responses at the chosen lines span 5",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
}

#[test]
fn hum_within_the_band_is_no_mode() {
    for sign in [1.0, -1.0] {
        // Hum adds to every response of a hit with the same phase.
        let hum = |f: f64, channel: usize, hit: usize, h: Complex<f64>| {
            let part = sign * 0.003 * ((channel * 7 + hit * 3) as f64).cos();
            if (f - 10.0).abs() < 0.01 { h + Complex::new(part, -part) } else { h }
        };
        let uff = file(&lines(), None, hum);
        let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
        let truth = Bench::named("wheel").unwrap().truth();
        let off = solution.answer().unwrap().theta() - truth.theta();
        let scale = scale(truth.mass, 0.19);
        // The bound of these five hits is 0.05 % in all.
        assert!(off.component_div(&scale).amax() < 0.005, "{off}");
    }
}

#[test]
fn a_prior_counts_with_its_own_uncertainty() {
    let lines: Vec<f64> = (0..200).map(|k| 0.5 + 0.031_25 * f64::from(k)).collect();
    let uff = unchanged(&lines, None);
    let options = Options { suspension_band_hz: [0.5, 6.6], ..named(Method::ToivolaNuutila) };
    let truth = Bench::named("wheel").unwrap().truth();
    let [x, y, z]: [f64; 3] = truth.center_of_mass.into();
    let with = |x: f64, sigma: f64| {
        let prior = |name: &str, value: f64, sigma: f64| {
            format!("{name} = {{ value = {value}, sigma = {sigma} }}\n")
        };
        let text = [
            noise_alone(),
            "\n[prior]\n".into(),
            prior("mass_kg", truth.mass, 0.001),
            prior("cx_m", x, sigma),
            prior("cy_m", y, sigma),
            prior("cz_m", z, sigma),
        ];
        solved(&text.concat(), &uff, &options)
    };
    let theta = |x: f64| with(x, 0.005).unwrap().answer().unwrap().theta();
    let moved = (theta(x + 0.005) - theta(x)).abs();
    let sigma = with(x, 0.005).unwrap().answer().unwrap().sigma().unwrap();
    // One prior is one of the sources of uncertainty.
    assert!((0..10).all(|k| moved[k] <= sigma[k] * 1.001), "{moved} {sigma}");
    // What is known to 10 m is not known.
    let error = with(x, 10.0).unwrap_err();
    assert_eq!(error.code(), "toivola_nuutila_four_modes_rank_nine", "{error}");
}

#[test]
fn the_uncertainty_of_a_shape_is_that_at_its_point() {
    let uff = unchanged(&lines(), None);
    let sigma = |shift: f64| {
        let moved = noise_alone()
            .lines()
            .map(|line| match line.strip_prefix("position_m = [") {
                None => format!("{line}\n"),
                Some(rest) => {
                    let (x, rest) = rest.split_once(',').unwrap();
                    let x: f64 = x.parse().unwrap();
                    format!("position_m = [{},{rest}\n", x + shift)
                }
            })
            .collect::<String>();
        let solution = solved(&moved, &uff, &named(Method::ContiBretl)).unwrap();
        solution.modes.unwrap().0.rows[4].shape_sigma
    };
    let (near, far) = (sigma(0.0), sigma(5.0));
    // The rotation is the same; at 5 m it moves the origin.
    let turned = (near[4].powi(2) + near[5].powi(2)).sqrt();
    assert!((far[4] - near[4]).abs() < 1e-3 * near[4], "{near} {far}");
    assert!(far[2] > 4.0 * near[4] && far.fixed_rows::<3>(0).norm() < 6.0 * turned, "{near} {far}");
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
        let force = layout.hits[hit].unit_force(&nalgebra::Vector3::zeros());
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
    // exp(−0.014 · 2π · 2.83 · 8) is 13.7 %.
    assert!(error.to_string().contains("mode 1 still has 13.7 %"), "{error}");
}

#[test]
fn a_reversed_hit_and_one_elsewhere_are_named() {
    let reversed = |_: f64, _: usize, hit: usize, h: Complex<f64>| if hit == 2 { -h } else { h };
    let error = solved(&noise_alone(), &file(&lines(), None, reversed), &Options::default());
    let error = error.unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "driving_point_reversed"), "{error}");
    assert!(error.to_string().contains("hit 3 (103:+Z) moves against the force"), "{error}");
    let text = noise_alone()
        .replace("position_m = [0.16, 0.12, 0.03]", "position_m = [-0.16, 0.12, 0.03]");
    let solution = solved(&text, &unchanged(&lines(), None), &Options::default()).unwrap();
    let found = solution.diagnostics.iter().any(|d| d.code == Code::NotReciprocal);
    assert!(found, "{:?}", solution.diagnostics);
}

#[test]
fn a_sensor_with_turned_axes_is_named() {
    // The file says that sensor 2 is turned by 90°, and it is not.
    let text = noise_alone().replace("sensors = [1, 2, 3]", "sensors = [1, {TURNED}, 3]");
    let turned = "{ node = 2, axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]] }";
    let text = text.replace("{TURNED}", turned);
    let error = solved(&text, &unchanged(&lines(), None), &Options::default()).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "sensor_axes_suspect"), "{error}");
    assert!(error.to_string().contains("sensor 2 (on node 2) has its axes"), "{error}");
}

#[test]
fn sensors_that_do_not_see_all_motions_are_named() {
    for (sensors, code) in
        [("[1, 2]", "fewer_than_three_sensors"), ("[1, 2, 4]", "sensors_collinear")]
    {
        // Half way between the first two.
        let text = noise_alone().replace("sensors = [1, 2, 3]", &format!("sensors = {sensors}"));
        let node = "[[node]]\nid = 4\nposition_m = [-0.0822725, 0.0475, 0.03]\n[uncertainty]";
        let text = text.replace("[uncertainty]", node);
        let uff = file_of(&Bench::named("wheel").unwrap(), &text, &lines(), None, |_, _, _, h| h);
        let error = solved(&text, &uff, &Options::default()).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, code), "{error}");
    }
}

#[test]
fn a_dead_channel_is_named() {
    let dead = |_: f64, channel: usize, hit: usize, h: Complex<f64>| {
        if channel == 7 && hit == 0 { Complex::default() } else { h }
    };
    let error = solved(&noise_alone(), &file(&lines(), None, dead), &Options::default());
    let error = error.unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (2, "channel_dead"), "{error}");
    assert!(error.to_string().contains("node 3, axis Y, due to the hit 101:+X"), "{error}");
}

#[test]
fn two_modes_at_one_frequency_have_no_shape_and_the_global_fit_answers() {
    let mut bench = Bench::named("wheel").unwrap();
    let hz = [2.8, 2.8, 3.6, 6.1, 7.2, 7.7];
    bench.suspension = Suspension::Frequencies { hz, damping_ratio: 0.014 };
    let uff = file_of(&bench, LAYOUT, &lines(), None, |_, _, _, h| h);
    let error = solved(&noise_alone(), &uff, &named(Method::ToivolaNuutila)).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "modes_not_separated"), "{error}");
    let solution = solved(&noise_alone(), &uff, &named(Method::GlobalFit)).unwrap();
    let global = solution.answer().unwrap();
    let off = (global.theta() - bench.truth().theta()).component_div(&global.sigma().unwrap());
    // Ten numbers lie within four standard deviations in 99.9 % of tests.
    assert!(off.amax() < 4.0, "{off}");
}

#[test]
fn a_prior_that_the_responses_contradict_is_named() {
    let prior = format!("{}\n[prior]\nmass_kg = {{ value = 18.5, sigma = 0.1 }}\n", noise_alone());
    let solution = solved(&prior, &unchanged(&lines(), None), &Options::default()).unwrap();
    let codes: Vec<Code> = solution.diagnostics.iter().map(|d| d.code).collect();
    assert!(codes.contains(&Code::PriorInconsistentWithData), "{codes:?}");
}

#[test]
fn a_method_that_is_asked_for_by_name_is_warned_of_a_tyre_as_well() {
    let tyre = SprungPart { share: 0.52, frequency_hz: 50.0, damping_ratio: 0.03 };
    let uff = unchanged(&lines(), Some(tyre));
    for method in [Method::ContiBretl, Method::ToivolaNuutila, Method::Dppim] {
        let text = solved(&noise_alone(), &uff, &named(method)).unwrap().to_text();
        assert!(text.contains("a flexible mode above the band moves the apparent mass"), "{text}");
    }
}

#[test]
fn lightly_damped_modes_do_not_make_the_hammer_better() {
    let mut bench = Bench::named("wheel").unwrap();
    let hz = [2.8, 3.2, 3.6, 6.1, 7.2, 7.7];
    bench.suspension = Suspension::Frequencies { hz, damping_ratio: 0.0005 };
    let uff = file_of(&bench, LAYOUT, &lines(), None, |_, _, _, h| h);
    let solution = solved(LAYOUT, &uff, &Options::default()).unwrap();
    let gain = LayoutFile::parse(LAYOUT, "wheel.toml").unwrap().layout.hammer_gain;
    for estimate in &solution.identification.estimates {
        let share = estimate.sigma().unwrap()[0] / estimate.body.mass;
        // Rounding takes a little of it where the modes are sharpest.
        assert!(share > 0.95 * gain, "{:?} {share}", estimate.method);
    }
}

#[test]
fn a_gap_in_the_lines_is_named() {
    let lines: Vec<f64> = lines().into_iter().filter(|f| !(4.0..5.5).contains(f)).collect();
    let solution = solved(&noise_alone(), &unchanged(&lines, None), &Options::default()).unwrap();
    let gap = solution.diagnostics.iter().find(|d| d.code == Code::FrequencyGap).unwrap();
    assert!((gap.value - 3.875).abs() < 1e-5, "{gap:?}");
}
