//! What the methods answer.

use massline_shared::body::scale;

use super::*;

#[test]
fn every_method_that_applies_answers_and_they_agree() {
    let solution =
        solved(&noise_alone(), &unchanged(&lines(), NOTHING), &Options::default()).unwrap();
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
        assert_near_truth(estimate, &truth);
    }
    let agreement = solution.comparison.agreement.as_ref().unwrap();
    assert_eq!(agreement.outcome(), Outcome::Agree);
    let json = json!(solution.result());
    assert_eq!(json["agreement"]["outcome"], json!("agree"));
    assert_eq!(json["suspension"]["modes"].as_array().unwrap().len(), 6);
    let text = text_of(&solution);
    for sentence in [
        "the methods agree",
        "begins at 23 Hz",
        "inertia-restraint: not applicable",
        "Norm Indicator",
    ] {
        assert!(text.contains(sentence), "{sentence}: {text}");
    }
    // The lines do not reach into the band of mass lines.
    assert!(solution.measured.mass_lines.is_empty() && solution.measured.band_hz.is_none());
}

#[test]
fn a_tyre_is_seen_by_the_global_fit_and_the_others_say_how_far_they_are_off() {
    let tyre = SprungPart { share: 0.52, frequency_hz: 50.0, damping_ratio: 0.03 };
    let uff = unchanged(&lines(), tyre);
    let solution = solved(&noise_alone(), &uff, &Options::default()).unwrap();
    let truth = Bench::named("wheel").unwrap().truth();
    let mut estimates = solution.identification.estimates.iter();
    let global = estimates.next().unwrap();
    assert_eq!(global.method, Method::GlobalFit);
    assert_near_truth(global, &truth);
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
    let uff = unchanged(&lines, NOTHING);
    let options = Options { suspension_band_hz: Some([0.5, 6.6]), ..named(Method::ToivolaNuutila) };
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
    let body = &known.identification.estimates[0].body;
    let off = (body.inertia - truth.inertia).amax() / truth.inertia.amax();
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
    let solution = solved(&text, &unchanged(&lines(), NOTHING), &Options::default()).unwrap();
    let truth = Bench::named("wheel").unwrap().truth();
    let global = solution.answer().unwrap();
    assert_eq!(global.method, Method::GlobalFit);
    assert_near_truth(global, &truth);
    let text = text_of(&solution);
    for sentence in ["mode 2 hardly shows under any hit", "mode 6 hardly shows under any hit"] {
        assert!(text.contains(sentence), "{sentence}: {text}");
    }
    // Three hits at least make a mass line.
    assert!(text.contains("modal-constant: not applicable"), "{text}");
}

#[test]
fn hum_within_the_band_is_no_mode() {
    for sign in [1.0, -1.0] {
        // Hum adds to every response of a hit with the same phase.
        let hum = |f: f64, channel: usize, hit: usize, h: Complex<f64>| {
            let part = sign * 0.003 * ((channel * 7 + hit * 3) as f64).cos();
            if (f - 10.0).abs() < 0.01 { h + Complex::new(part, -part) } else { h }
        };
        let uff = file(&lines(), NOTHING, hum);
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
    let uff = unchanged(&lines, NOTHING);
    let options = Options { suspension_band_hz: Some([0.5, 6.6]), ..named(Method::ToivolaNuutila) };
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
    let uff = unchanged(&lines(), NOTHING);
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
fn a_method_that_is_asked_for_by_name_is_warned_of_a_tyre_as_well() {
    let tyre = SprungPart { share: 0.52, frequency_hz: 50.0, damping_ratio: 0.03 };
    let uff = unchanged(&lines(), tyre);
    for method in [Method::ContiBretl, Method::ToivolaNuutila, Method::Dppim] {
        let text = text_of(&solved(&noise_alone(), &uff, &named(method)).unwrap());
        assert!(text.contains("a flexible mode above the band moves the apparent mass"), "{text}");
        assert!(!text.contains("a mass line begins"), "{text}");
    }
    // The modes alone say so as well.
    let layout = LayoutFile::parse(&noise_alone(), "wheel.toml").unwrap().layout;
    let modes = modes_of(layout, &uff, &Options::default(), |_, _| ()).unwrap().modes;
    assert!(modes.diagnostics.iter().any(|d| d.code == Code::FlexibleModeShows));
}

#[test]
fn lightly_damped_modes_do_not_make_the_hammer_better() {
    let bench = wheel_with_modes([2.8, 3.2, 3.6, 6.1, 7.2, 7.7], 0.0005);
    let uff = file_of(&bench, LAYOUT, &lines(), NOTHING, |_, _, _, h| h);
    let solution = solved(LAYOUT, &uff, &Options::default()).unwrap();
    let gain = LayoutFile::parse(LAYOUT, "wheel.toml").unwrap().layout.apparatus.hammer_gain;
    for estimate in &solution.identification.estimates {
        let share = estimate.sigma().unwrap()[0] / estimate.body.mass;
        // Rounding takes a little of it where the modes are sharpest.
        assert!(share > 0.95 * gain, "{:?} {share}", estimate.method);
    }
}
