//! What the responses say against a rigid body on a linear suspension, and what follows for the methods.

use massline_shared::diagnosis::{Diagnostic, Subject};
use massline_shared::identify::random_signs;
use nalgebra::Vector3;

use super::*;

fn find_diagnostic(solution: &Solution, code: Code) -> Option<&Diagnostic> {
    solution.diagnostics.iter().find(|d| d.code == code)
}

/// The estimate of a method.
fn answer_of(solution: &Solution, method: Method) -> &Estimate<f64> {
    let mut estimates = solution.identification.estimates.iter();
    estimates.find(|estimate| estimate.method == method).expect("an answer")
}

fn has(estimate: &Estimate<f64>, code: Code) -> bool {
    estimate.diagnostics.iter().any(|d| d.code == code)
}

/// Responses with hum at 10 Hz.
fn hum(f: f64, channel: usize, hit: usize, h: Complex<f64>) -> Complex<f64> {
    let part = 0.03 * ((channel * 7 + hit * 3) as f64).cos();
    if (f - 10.0).abs() < 0.01 { h + Complex::new(part, -part) } else { h }
}

#[test]
fn sensors_that_sense_gravity_and_should_not_by_the_layout_are_named() {
    let text = noise_alone()
        .replace("sensors = [1, 2, 3]", "sensors = [{ node = 1, senses_gravity = false }, 2, 3]");
    let error = solved(&text, &unchanged(&lines(), NOTHING), &Options::default()).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "senses_gravity_suspect"), "{error}");
}

#[test]
fn gravity_that_is_reversed_missing_or_along_another_axis_is_named() {
    let uff = unchanged(&lines(), NOTHING);
    let along = ["gravity_suspect", "gravity along -Z"];
    for (stated, [code, sentence], text) in [
        (
            "reversed",
            ["gravity_reversed", "change the signs"],
            noise_alone().replace("-9.80665]", "9.80665]"),
        ),
        ("missing", along, noise_alone().replace("gravity = [0.0, 0.0, -9.80665]", "")),
        ("along x", along, noise_alone().replace("[0.0, 0.0, -9.80665]", "[-9.80665, 0.0, 0.0]")),
    ] {
        let error = solved(&text, &uff, &Options::default()).unwrap_err();
        assert_eq!((error.exit_code(), error.code()), (3, code), "{stated}: {error}");
        assert!(error.to_string().contains(sentence), "{stated}: {error}");
    }
    let named = solved(&LAYOUT.replace("-9.80665]", "9.80665]"), &uff, &named(Method::Dppim));
    assert_eq!(named.unwrap_err().code(), "gravity_reversed");
}

#[test]
fn tilted_gravity_is_no_flexible_mode_and_its_direction_is_found() {
    let truth = Bench::named("wheel").unwrap().truth();
    // Without the errors that the layout states, and with them: five and ten degrees about different axes.
    for (layout, gravity) in
        [(noise_alone(), [0.0, -0.855, -9.769]), (LAYOUT.to_owned(), [1.204, 1.204, -9.658])]
    {
        let text = layout.replace("[0.0, 0.0, -9.80665]", &format!("{gravity:?}"));
        let solution = solved(&text, &unchanged(&lines(), NOTHING), &Options::default()).unwrap();
        let warning = find_diagnostic(&solution, Code::GravityTilted).expect("a warning");
        let angle = (-gravity[2] / 9.80665_f64).acos().to_degrees();
        // The noise and the stated errors of sensors let the direction be found to within a degree.
        assert!((f64::from(warning.value) - angle).abs() < 1.0, "{warning:?}, {angle}°");
        let (modes, _) = solution.modes.as_ref().unwrap();
        let fitted = Vector3::from(modes.fitted_gravity.expect("a direction"));
        assert!((fitted - Vector3::new(0.0, 0.0, -9.80665)).norm() < 0.2, "{fitted}");
        let methods =
            [Method::GlobalFit, Method::ToivolaNuutila, Method::ContiBretl, Method::Dppim];
        for method in methods {
            let estimate = answer_of(&solution, method);
            assert!(has(estimate, Code::GravityTilted));
            assert!(!has(estimate, Code::FlexibleModeAboveBand));
            assert_near_truth(estimate, &truth);
        }
        assert_eq!(solution.comparison.agreement.as_ref().unwrap().outcome(), Outcome::Agree);
    }
}

#[test]
fn tilted_gravity_is_found_beside_structural_damping() {
    // Eight degrees.
    let text = LAYOUT.replace("[0.0, 0.0, -9.80665]", "[0.965, 0.965, -9.711]");
    let uff = unchanged(&lines(), ObjectExtras { structural: true, ..NOTHING });
    let solution = solved(&text, &uff, &Options::default()).unwrap();
    let warning = find_diagnostic(&solution, Code::GravityTilted).expect("a warning");
    // The stated errors of sensors let the direction be found to within a degree.
    assert!((warning.value - 8.0).abs() < 1.0, "{warning:?}");
    let truth = Bench::named("wheel").unwrap().truth();
    for method in [Method::GlobalFit, Method::ToivolaNuutila, Method::DppimStructural] {
        assert_near_truth(answer_of(&solution, method), &truth);
    }
}

#[test]
fn tilted_gravity_is_found_beside_hum_at_one_line() {
    // Eight degrees.
    let text = LAYOUT.replace("[0.0, 0.0, -9.80665]", "[0.965, 0.965, -9.711]");
    let uff = file(&lines(), NOTHING, hum);
    let solution = solved(&text, &uff, &Options::default()).unwrap();
    let warning = find_diagnostic(&solution, Code::GravityTilted).expect("a warning");
    assert!((warning.value - 8.0).abs() < 1.0, "{warning:?}");
    assert!(has(answer_of(&solution, Method::GlobalFit), Code::LinesDisturbed));
    let truth = Bench::named("wheel").unwrap().truth();
    for method in [Method::GlobalFit, Method::ToivolaNuutila, Method::Dppim] {
        assert_near_truth(answer_of(&solution, method), &truth);
    }
}

#[test]
fn an_object_that_hangs_within_its_budget_of_gravity_needs_no_word() {
    // Three degrees about an oblique axis; the budget has 1.15 about each axis.
    let text = LAYOUT.replace("[0.0, 0.0, -9.80665]", "[0.363, 0.363, -9.793]");
    let truth = Bench::named("wheel").unwrap().truth();
    for besides in [NOTHING, ObjectExtras { structural: true, ..NOTHING }] {
        let solution = solved(&text, &unchanged(&lines(), besides), &Options::default()).unwrap();
        assert!(find_diagnostic(&solution, Code::GravityTilted).is_none());
        for estimate in &solution.identification.estimates {
            assert_near_truth(estimate, &truth);
        }
        assert_eq!(solution.comparison.agreement.as_ref().unwrap().outcome(), Outcome::Agree);
        let fitted = solution.global_fit.as_ref().unwrap().gravity.unwrap();
        assert!((1.0..2.5).contains(&fitted.pull), "{fitted:?}");
    }
}

#[test]
fn a_slightly_wrong_gain_of_one_hit_pulls_it_and_answers_hold() {
    let gain = |_: f64, _: usize, hit: usize, h: Complex<f64>| if hit == 1 { h * 1.04 } else { h };
    let solution = solved(LAYOUT, &file(&lines(), NOTHING, gain), &Options::default()).unwrap();
    let global = answer_of(&solution, Method::GlobalFit);
    let pull = global.diagnostics.iter().find(|d| d.code == Code::LargeHitPull).expect("a pull");
    assert_eq!(pull.subject, Subject::hit(1));
    for estimate in &solution.identification.estimates {
        assert!(!has(estimate, Code::FlexibleModeAboveBand));
        assert_near_truth(estimate, &Bench::named("wheel").unwrap().truth());
    }
}

#[test]
fn a_short_delay_is_a_rough_fit_and_answers_hold() {
    let late = |f: f64, _: usize, _: usize, h: Complex<f64>| {
        h * Complex::new(0.0, -std::f64::consts::TAU * f * 0.3e-3).exp()
    };
    let solution = solved(LAYOUT, &file(&lines(), NOTHING, late), &Options::default()).unwrap();
    for estimate in &solution.identification.estimates {
        let warning = estimate.diagnostics.iter().find(|d| d.code == Code::ModelFitsRoughly);
        // The phase is 1.4 % at 7.7 Hz, and the suspension takes up some of it as damping.
        assert!((0.004..0.014).contains(&warning.expect("a warning").value), "{warning:?}");
        assert_near_truth(estimate, &Bench::named("wheel").unwrap().truth());
    }
    assert_eq!(solution.comparison.agreement.as_ref().unwrap().outcome(), Outcome::Agree);
}

#[test]
fn a_wrong_gain_of_one_hit_is_no_flexible_mode_and_the_hit_is_named() {
    // From a few of the stated standard deviations to a change of the hammer's range.
    for factor in [1.08, 1.5] {
        let gain = |_: f64, _: usize, hit: usize, h: Complex<f64>| {
            if hit == 1 { h * factor } else { h }
        };
        let uff = file(&lines(), NOTHING, gain);
        let solution = solved(LAYOUT, &uff, &Options::default()).unwrap();
        for estimate in &solution.identification.estimates {
            let warning =
                estimate.diagnostics.iter().find(|d| d.code == Code::HitContradictsOthers);
            assert_eq!(warning.unwrap().subject, Subject::hit(1), "{:?}", estimate.method);
            assert!(!has(estimate, Code::FlexibleModeAboveBand));
        }
        assert!(solution.global_fit.is_none());
        let json = json!(solution.result());
        assert!(json["agreement"]["combined"].is_null(), "{}", json["agreement"]);
        let verdict = json["agreement"]["verdict"].as_str().unwrap();
        assert!(verdict.starts_with("no body on a suspension fits"), "{verdict}");
        let refused = json["not_applicable"].as_array().unwrap();
        let global = refused.iter().find(|refusal| refusal["method"] == "global-fit").unwrap();
        assert_eq!(global["code"], "hit_contradicts_others", "{global}");
        assert_eq!(json["agreement"]["doubt"], "model_does_not_fit");
    }
}

#[test]
fn readings_that_no_body_explains_put_every_answer_in_doubt() {
    // A millisecond between hammer and sensors, as of another filter.
    let late = |f: f64, _: usize, _: usize, h: Complex<f64>| {
        h * Complex::new(0.0, -std::f64::consts::TAU * f * 1e-3).exp()
    };
    let solution = solved(LAYOUT, &file(&lines(), NOTHING, late), &Options::default()).unwrap();
    for estimate in &solution.identification.estimates {
        assert!(has(estimate, Code::ModelDoesNotFit), "{:?}", estimate.method);
    }
    assert!(solution.comparison.agreement.is_none());
}

#[test]
fn hum_at_one_line_is_left_out_of_the_global_fit_and_all_agree() {
    let solution = solved(LAYOUT, &file(&lines(), NOTHING, hum), &Options::default()).unwrap();
    let global = answer_of(&solution, Method::GlobalFit);
    assert_near_truth(global, &Bench::named("wheel").unwrap().truth());
    let agreement = solution.comparison.agreement.as_ref().unwrap();
    assert_eq!(agreement.outcome(), Outcome::Agree, "{}", json!(solution.result())["agreement"]);
}

#[test]
fn a_hit_elsewhere_has_a_large_pull() {
    // 15 mm beside its mark; one millimetre is stated.
    let text =
        LAYOUT.replace("position_m = [0.16, 0.12, 0.03]", "position_m = [0.16, 0.135, 0.03]");
    let solution = solved(&text, &unchanged(&lines(), NOTHING), &Options::default()).unwrap();
    let global = answer_of(&solution, Method::GlobalFit);
    let pull = global.diagnostics.iter().find(|d| d.code == Code::LargeHitPull).expect("a pull");
    assert_eq!(pull.subject, Subject::hit(1));
    // Below 2, nothing is said.
    assert!(pull.value > 2.0, "{pull:?}");
}

#[test]
fn a_part_that_swings_within_the_band_rules_out_an_answer() {
    for (share, hz) in [(0.02, 9.0), (0.05, 5.0), (0.2, 9.0), (0.52, 9.0)] {
        let part = SprungPart { share, frequency_hz: hz, damping_ratio: 0.03 };
        let uff = unchanged(&lines(), part);
        let error = solved(&noise_alone(), &uff, &Options::default()).unwrap_err();
        let code = (error.exit_code(), error.code());
        assert_eq!(code, (3, "more_modes_than_six"), "{share} at {hz} Hz: {error}");
    }
}

#[test]
fn a_small_part_that_swings_within_the_band_is_warned_of() {
    let part = SprungPart { share: 0.003, frequency_hz: 9.0, damping_ratio: 0.03 };
    let solution = solved(&noise_alone(), &unchanged(&lines(), part), &Options::default()).unwrap();
    let warning = find_diagnostic(&solution, Code::MoreModesThanSix).expect("a warning");
    assert!((warning.value - 9.0).abs() < 0.2, "{warning:?}");
}

/// A dashpot at the rim that makes the lowest mode complex.
fn rubbing() -> ObjectExtras {
    let dashpot = Dashpot { point: Vector3::new(0.19, 0.0, 0.03), coefficient: 25.0 };
    ObjectExtras { dashpot: Some(dashpot), ..NOTHING }
}

#[test]
fn complex_shapes_put_the_methods_off_that_use_shapes_and_the_verdict_names_both() {
    let uff = unchanged(&lines(), rubbing());
    let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
    let warning = find_diagnostic(&solution, Code::ModeComplex).expect("a warning");
    assert!(warning.value > 0.1, "{warning:?}");
    let with_shapes = [Method::ToivolaNuutila, Method::ContiBretl];
    for estimate in &solution.identification.estimates {
        let uses_shapes = with_shapes.contains(&estimate.method);
        assert_eq!(has(estimate, Code::ModeComplex), uses_shapes, "{:?}", estimate.method);
    }
    let truth = Bench::named("wheel").unwrap().truth();
    assert_near_truth(answer_of(&solution, Method::GlobalFit), &truth);
    assert_near_truth(answer_of(&solution, Method::Dppim), &truth);
    let json = json!(solution.result());
    let off: Vec<_> = json["agreement"]["off"].as_array().unwrap().to_vec();
    for method in with_shapes {
        assert!(off.contains(&json!(method.name())), "{}", json["agreement"]);
    }
    let verdict = json["agreement"]["verdict"].as_str().unwrap();
    assert!(verdict.contains("are off") && verdict.contains("has a complex shape"), "{verdict}");
    let combined = &json["agreement"]["combined"];
    let sigma = combined["sigma"]["m"].as_f64().unwrap();
    let error = combined["value"]["m"].as_f64().unwrap() - truth.mass;
    assert!(error.abs() < 4.0 * sigma, "{combined}");
}

#[test]
fn modes_within_a_bandwidth_and_at_the_end_of_the_band_are_named() {
    // Half-power bandwidths of 2.8 % of the frequency.
    let bench = wheel_with_modes([2.8, 2.84, 3.6, 6.1, 7.2, 7.7], 0.014);
    let uff = file_of(&bench, LAYOUT, &lines(), NOTHING, |_, _, _, h| h);
    let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
    let close = find_diagnostic(&solution, Code::ModesClose).expect("a warning");
    assert_eq!(close.subject, Subject::mode(0));
    let options = Options { suspension_band_hz: Some([0.5, 7.8]), ..Options::default() };
    let solution = solved(&noise_alone(), &unchanged(&lines(), NOTHING), &options).unwrap();
    let edge = find_diagnostic(&solution, Code::ModeAtBandEdge).expect("a warning");
    assert_eq!(edge.subject, Subject::mode(5));
}

#[test]
fn a_mode_that_no_hit_moves_is_poorly_excited_and_noise_decides_about_answers() {
    let solve_at = |height: f64| {
        let (text, uff) = super::warnings::hit_in_one_plane(height);
        solved(&text, &uff, &Options::default())
    };
    let solution = solve_at(0.008).unwrap();
    let poor = find_diagnostic(&solution, Code::ModePoorlyExcited).expect("a warning");
    assert!(poor.subject == Subject::mode(3) && poor.value < 0.1, "{poor:?}");
    assert!(has(answer_of(&solution, Method::ToivolaNuutila), Code::ModePoorlyExcited));
    // Hit half as high above the plane, a mode is found in some draws of noise and not in others.
    let solution = solve_at(0.004).unwrap();
    let refused = &solution.identification.not_applicable;
    let unstable = refused.iter().find(|(method, _)| *method == Method::ToivolaNuutila).unwrap();
    assert_eq!(unstable.1[0].code, Code::UnstableUnderNoise);
}

#[test]
fn structural_damping_is_told_from_viscous_damping() {
    let uff = unchanged(&lines(), ObjectExtras { structural: true, ..NOTHING });
    let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
    let refused = &solution.identification.not_applicable;
    let viscous = refused.iter().find(|(method, _)| *method == Method::Dppim).unwrap();
    assert_eq!(viscous.1[0].code, Code::DampingNotViscous);
    let truth = Bench::named("wheel").unwrap().truth();
    assert_near_truth(answer_of(&solution, Method::DppimStructural), &truth);
    // The global fit takes it into account.
    assert_near_truth(answer_of(&solution, Method::GlobalFit), &truth);
    assert_eq!(solution.comparison.agreement.as_ref().unwrap().outcome(), Outcome::Agree);
    // Asked for by name, it answers with a warning.
    let solution = solved(&noise_alone(), &uff, &named(Method::Dppim)).unwrap();
    assert!(has(answer_of(&solution, Method::Dppim), Code::DampingNotViscous));
    // And the other way round.
    let uff = unchanged(&lines(), NOTHING);
    let solution = solved(&noise_alone(), &uff, &named(Method::DppimStructural)).unwrap();
    assert!(has(answer_of(&solution, Method::DppimStructural), Code::DampingNotStructural));
}

#[test]
fn sensors_that_contradict_each_other_are_named() {
    // One axis of a sensor reads half of what it should.
    let gain = |factor: f64| {
        let of_channel = move |_: f64, channel: usize, _: usize, h: Complex<f64>| {
            if channel == 4 { h * factor } else { h }
        };
        solved(&noise_alone(), &file(&lines(), NOTHING, of_channel), &Options::default())
    };
    let half = gain(0.5).unwrap();
    let warning = find_diagnostic(&half, Code::ReadingsNotRigid).expect("a warning");
    assert!(warning.value > 0.1, "{warning:?}");
    // Four times as much is no reading of the same body.
    let error = gain(4.0).unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "readings_not_rigid"), "{error}");
}

#[test]
fn all_points_that_move_backwards_are_another_quantity() {
    let backwards = |_: f64, _: usize, _: usize, h: Complex<f64>| -h;
    let error = solved(&noise_alone(), &file(&lines(), NOTHING, backwards), &Options::default());
    let error = error.unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "all_points_reversed"), "{error}");
    assert!(error.to_string().contains("--quantity receptance"), "{error}");
}

#[test]
fn velocities_that_are_read_as_accelerations_are_named() {
    let mobility = |f: f64, _: usize, _: usize, h: Complex<f64>| {
        h / Complex::new(0.0, std::f64::consts::TAU * f)
    };
    let error = solved(&noise_alone(), &file(&lines(), NOTHING, mobility), &Options::default());
    let error = error.unwrap_err();
    assert_eq!((error.exit_code(), error.code()), (3, "looks_like_mobility"), "{error}");
    assert!(error.to_string().contains("--quantity mobility"), "{error}");
}

#[test]
fn noise_in_proportion_to_the_response_is_no_record_that_ends_too_early() {
    // One per cent of every reading, as of a gain that varies from line to line.
    for seed in 0..4 {
        let noisy = |f: f64, channel: usize, hit: usize, h: Complex<f64>| {
            let line = (8.0 * f).round() as usize;
            let [re, im] = random_signs(seed, (line * 9 + channel) * 5 + hit).map(f64::from);
            h * Complex::new(1.0 + 0.01 * re, 0.01 * im)
        };
        let uff = file(&lines(), NOTHING, noisy);
        let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
        assert!(find_diagnostic(&solution, Code::RecordTooShort).is_none(), "{seed}");
    }
}

#[test]
fn lines_of_a_logarithmic_scale_have_no_gap() {
    let lines: Vec<f64> = (0..97).map(|k| 0.5 * 25_f64.powf(f64::from(k) / 96.0)).collect();
    let solution = solved(&noise_alone(), &unchanged(&lines, NOTHING), &Options::default());
    assert!(find_diagnostic(&solution.unwrap(), Code::FrequencyGap).is_none());
}
