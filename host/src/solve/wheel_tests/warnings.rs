//! What is refused or named.

use massline_shared::diagnosis::{Diagnostic, Subject};

use super::*;

/// Lines up to 120 Hz.
fn wide() -> Vec<f64> {
    (0..479).map(|k| 0.5 + 0.25 * f64::from(k)).collect()
}

#[test]
fn mass_lines_near_the_suspension_are_refused_also_by_name() {
    let uff = unchanged(&wide(), NOTHING);
    for method in [Method::InertiaRestraint, Method::MaximumLikelihood] {
        let error = solved(&noise_alone(), &uff, &named(method)).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, "suspension_in_band"), "{error}");
    }
    // Lines that reach only a little into the band are no mass line.
    let error =
        solved(&noise_alone(), &unchanged(&lines(), NOTHING), &named(Method::InertiaRestraint));
    assert_eq!(error.unwrap_err().code(), "band_too_narrow");
    // A band above them does: the wheel is rigid there.
    let solution = solved(&with_mass_lines("[24, 120]"), &uff, &Options::default()).unwrap();
    let methods = solution.identification.estimates.iter().map(|e| e.method);
    let of_lines = [Method::MaximumLikelihood, Method::InertiaRestraint];
    assert_eq!(methods.filter(|m| of_lines.contains(m)).count(), 2);
}

#[test]
fn a_tyre_leaves_no_mass_line() {
    let tyre = SprungPart { share: 0.52, frequency_hz: 50.0, damping_ratio: 0.03 };
    let uff = unchanged(&wide(), tyre);
    for band in ["[24, 120]", "[24, 45]"] {
        let text = with_mass_lines(band);
        for method in [Method::InertiaRestraint, Method::MaximumLikelihood] {
            match solved(&text, &uff, &named(method)) {
                Ok(solution) => {
                    let warned = solution.diagnostics.iter().any(|d| d.code == Code::NoPlateau);
                    assert!(warned, "{}", text_of(&solution));
                }
                Err(error) => assert_eq!(error.exit_code(), 3, "{error}"),
            }
        }
    }
}

/// The wheel on springs that move it along one direction or turn it about one axis in every mode, hit along X and Y at
/// this height above its centre of mass, m.
pub(super) fn hit_in_one_plane(height: f64) -> (String, UffFile) {
    let bench = wheel_with_modes([2.8, 3.2, 3.6, 6.1, 7.2, 7.7], 0.014);
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
    let uff = file_of(&bench, &text, &lines(), NOTHING, |_, _, _, h| h);
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
    let message = error.to_string();
    assert!(message.contains("show 3 suspension modes"), "{message}");
    // The three hits push along X and Y in one plane.
    assert!(
        message.contains("a hit at 1:+Z (axes of the body, beside the sensor) would be"),
        "{message}"
    );
}

#[test]
fn hits_just_above_that_plane_show_five_modes_and_where_to_hit() {
    let (text, uff) = hit_in_one_plane(0.01);
    let solution = solved(&text, &uff, &Options::default()).unwrap();
    let methods: Vec<_> = solution.identification.estimates.iter().map(|e| e.method).collect();
    assert_eq!(methods, [Method::GlobalFit, Method::ToivolaNuutila]);
    let text = text_of(&solution);
    for sentence in [
        "mode 4 hardly shows under any hit",
        "one of the six modes does not show: hit",
        "dppim: not applicable: the responses at the chosen lines span 5",
    ] {
        assert!(text.contains(sentence), "{sentence}: {text}");
    }
}

#[test]
fn a_record_that_ends_too_early_is_named() {
    // What is left of every mode at the end of 8 s multiplies its residue; here the sum is of the modes themselves.
    let layout = LayoutFile::parse(LAYOUT, "wheel.toml").unwrap().layout;
    let bench = Bench::named("wheel").unwrap();
    let modes =
        massline_physics::suspension::rigid_modes(&bench.body, &bench.suspension, &bench.gravity)
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
    let uff = file(&lines(), NOTHING, truncated);
    let error = solved(&noise_alone(), &uff, &named(Method::ToivolaNuutila)).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "record_too_short_for_damping"));
    // exp(−0.014 · 2π · 2.83 · 8) is 13.7 %.
    assert!(error.to_string().contains("mode 1 still has 13.7 %"), "{error}");
}

#[test]
fn a_reversed_hit_and_one_elsewhere_are_named() {
    let reversed = |_: f64, _: usize, hit: usize, h: Complex<f64>| if hit == 2 { -h } else { h };
    let error = solved(&noise_alone(), &file(&lines(), NOTHING, reversed), &Options::default());
    let error = error.unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "driving_point_reversed"), "{error}");
    assert!(error.to_string().contains("hit 3 (103:+Z) moves against the force"), "{error}");
    let text = noise_alone()
        .replace("position_m = [0.16, 0.12, 0.03]", "position_m = [-0.16, 0.12, 0.03]");
    let solution = solved(&text, &unchanged(&lines(), NOTHING), &Options::default()).unwrap();
    let is_named = solution.diagnostics.iter().any(|d| d.code == Code::NotReciprocal);
    assert!(is_named, "{:?}", solution.diagnostics);
}

#[test]
fn mass_lines_of_another_quantity_or_hammer_are_named_before_they_are_solved() {
    let lines: Vec<f64> = (48..200).map(|k| 0.5 * f64::from(k)).collect();
    let s = |f: f64| Complex::new(0.0, std::f64::consts::TAU * f);
    let mobility = file(&lines, NOTHING, |f, _, _, h| h / s(f));
    let reversed = file(&lines, NOTHING, |_, _, _, h| -h);
    let accelerance = unchanged(&lines, NOTHING);
    for (uff, quantity, code, words) in [
        (&mobility, None, "looks_like_mobility", "--quantity mobility"),
        (&reversed, None, "all_points_reversed", "reversed polarity"),
    ] {
        let options = Options { quantity, ..Options::default() };
        let error = solved(LAYOUT, uff, &options).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, code), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }
    // An option that contradicts the units of the file is refused.
    for quantity in [Quantity::Velocity, Quantity::Displacement] {
        let options = Options { quantity: Some(quantity), ..Options::default() };
        let error = solved(LAYOUT, &accelerance, &options).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (2, "uff_wrong_units"), "{error}");
        assert!(error.to_string().contains("\"m/s^2\" is not a known unit"), "{error}");
    }
    // A lightly damped elastic mode has nearly all of the squares in one line, and is no velocity.
    let peak = file(&lines, NOTHING, |f, _, _, h| {
        if (f - 90.0).abs() < 0.1 { h * Complex::new(0.0, -200.0) } else { h }
    });
    match solved(LAYOUT, &peak, &Options::default()) {
        Ok(solution) => assert!(!solution.diagnostics.is_empty()),
        Err(error) => assert_ne!(error.code(), "looks_like_mobility", "{error}"),
    }
    let of_one = file(&lines, NOTHING, |_, _, hit, h| if hit == 2 { -h } else { h });
    let solution = solved(LAYOUT, &of_one, &Options::default()).unwrap();
    let reversed =
        |d: &Diagnostic| d.code == Code::DrivingPointReversed && d.subject == Subject::hit(2);
    assert!(solution.diagnostics.iter().any(reversed), "{:?}", solution.diagnostics);
}

#[test]
fn a_sensor_with_turned_axes_is_named() {
    // The file says that sensor 2 is turned by 90°, and it is not.
    let text = noise_alone().replace("sensors = [1, 2, 3]", "sensors = [1, {TURNED}, 3]");
    let turned = "{ node = 2, axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]] }";
    let text = text.replace("{TURNED}", turned);
    let error = solved(&text, &unchanged(&lines(), NOTHING), &Options::default()).unwrap_err();
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
        let uff =
            file_of(&Bench::named("wheel").unwrap(), &text, &lines(), NOTHING, |_, _, _, h| h);
        let error = solved(&text, &uff, &Options::default()).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, code), "{error}");
    }
}

#[test]
fn a_dead_channel_is_named() {
    let dead = |_: f64, channel: usize, hit: usize, h: Complex<f64>| {
        if channel == 7 && hit == 0 { Complex::default() } else { h }
    };
    let error = solved(&noise_alone(), &file(&lines(), NOTHING, dead), &Options::default());
    let error = error.unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (2, "channel_dead"), "{error}");
    assert!(error.to_string().contains("node 3, axis Y, due to the hit 101:+X"), "{error}");
}

#[test]
fn two_modes_at_one_frequency_have_no_shape_and_the_global_fit_answers() {
    let bench = wheel_with_modes([2.8, 2.8, 3.6, 6.1, 7.2, 7.7], 0.014);
    let uff = file_of(&bench, LAYOUT, &lines(), NOTHING, |_, _, _, h| h);
    let error = solved(&noise_alone(), &uff, &named(Method::ToivolaNuutila)).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "modes_not_separated"), "{error}");
    let solution = solved(&noise_alone(), &uff, &named(Method::GlobalFit)).unwrap();
    let global = solution.answer().unwrap();
    assert_near_truth(global, &bench.truth());
}

#[test]
fn a_prior_that_the_responses_contradict_is_named() {
    let prior = format!("{}\n[prior]\nmass_kg = {{ value = 18.5, sigma = 0.1 }}\n", noise_alone());
    let solution = solved(&prior, &unchanged(&lines(), NOTHING), &Options::default()).unwrap();
    let codes: Vec<Code> = solution.diagnostics.iter().map(|d| d.code).collect();
    assert!(codes.contains(&Code::PriorInconsistentWithData), "{codes:?}");
}

#[test]
fn a_gap_in_the_lines_is_named() {
    let lines: Vec<f64> = lines().into_iter().filter(|f| !(4.0..5.5).contains(f)).collect();
    let solution =
        solved(&noise_alone(), &unchanged(&lines, NOTHING), &Options::default()).unwrap();
    let gap = solution.diagnostics.iter().find(|d| d.code == Code::FrequencyGap).unwrap();
    assert!((gap.value - 3.875).abs() < 1e-5, "{gap:?}");
}
