//! Responses without noise and without errors, as of a finite element model: what the answers assume must not be taken
//! out of them (theory, section 12).

use massline_shared::body::scale;
use nalgebra::SVector;

use super::*;

/// Largest part of scale by which an assumption may move an answer.
const MOST: f64 = 2e-4;

/// An object on its suspension, and the layout of its test with both bands.
struct ExactTest {
    name: &'static str,
    bench: Bench,
    layout: String,
}

/// The wheel, the three bars under five hits, and a body of 5 kg with products of inertia. The modes of all of them are
/// those of the wheel, and mass lines begin at five times the highest one.
fn exact_tests() -> [ExactTest; 3] {
    let wheel = wheel_with_modes([2.82, 3.22, 3.56, 6.14, 7.16, 7.66], 0.005);
    let of_wheel = LAYOUT.replace("profile = \"suspension\"", "band_hz = [40, 120]");
    let bars = include_str!("../../../examples/three-bar-test-1.toml")
        .replace("\"4:+X\"]", "\"4:+X\", \"4:+Y\", \"1:+Z\"]")
        .replace("[10.0, 120.0]", "[40.0, 120.0]");
    let (mut frame, mut block) = (wheel.clone(), wheel.clone());
    frame.body = Bench::named("default").unwrap().body;
    block.body = RigidBody::from_theta(&SVector::from([
        5.0, 0.02, -0.01, 0.03, 0.05, 0.06, 0.08, 0.004, -0.003, 0.002,
    ]));
    [
        ExactTest { name: "wheel", bench: wheel, layout: of_wheel.clone() },
        ExactTest { name: "three bars", bench: frame, layout: bars },
        ExactTest { name: "block", bench: block, layout: of_wheel },
    ]
}

impl ExactTest {
    fn file(&self) -> UffFile {
        let high = (0..41).map(|k| 40.0 + 2.0 * f64::from(k));
        let frequencies: Vec<f64> = lines().into_iter().chain(high).collect();
        let layout = LayoutFile::parse(&self.layout, "l").unwrap().layout;
        let responses =
            frequency_responses(&self.bench, &layout, &frequencies, 0.0, &NOTHING).unwrap();
        file_with(&layout, &frequencies, &responses, |_, _, _, h| h)
    }

    /// Solves with the directions of hits and marks as uncertain as they are, or stated as exact.
    fn solve(&self, uff: &UffFile, options: &Options, straight: bool) -> Solution {
        let exact = "\n[uncertainty]\nhit_direction_rad = 0\nnode_direction_rad = 0\n";
        let text = self.layout.clone() + if straight { exact } else { "" };
        solved(&text, uff, options).unwrap()
    }
}

/// The estimate of a method.
fn estimate_of(solution: &Solution, method: Method) -> &Estimate<f64> {
    let mut estimates = solution.identification.estimates.iter();
    estimates.find(|estimate| estimate.method == method).unwrap()
}

#[test]
fn no_mean_loss_is_taken_out_of_responses_that_show_no_scatter() {
    for test in exact_tests() {
        let uff = test.file();
        let truth = test.bench.truth();
        let length = LayoutFile::parse(&test.layout, "l").unwrap().layout.characteristic_length();
        let scale = scale(truth.mass, length);
        let part = |theta: SVector<f64, 10>| theta.component_div(&scale).amax();
        for (options, methods) in [
            (Options::default(), &[Method::MaximumLikelihood, Method::GlobalFit][..]),
            // Without mass lines nothing else has learned.
            (named(Method::GlobalFit), &[Method::GlobalFit]),
        ] {
            let [stated, straight] =
                [false, true].map(|straight| test.solve(&uff, &options, straight));
            for &method in methods {
                let [stated, straight] =
                    [&stated, &straight].map(|solution| estimate_of(solution, method).theta());
                let assumed = part(stated - straight);
                let off = part(stated - truth.theta());
                println!("{}, {method:?}: assumed {assumed:.1e}, off {off:.1e}", test.name);
                assert!(assumed < MOST, "{} {method:?} {assumed:e}", test.name);
                // What the band costs: B/s² is not all that modes at a fifth of the band do.
                let band = part(straight - truth.theta());
                let most = if method == Method::GlobalFit { MOST } else { MOST + band };
                assert!(off < most, "{} {method:?} {off:e} {band:e}", test.name);
            }
        }
    }
}

#[test]
fn a_budget_that_must_not_be_learned_keeps_its_mean_loss() {
    let [wheel, ..] = exact_tests();
    let text = format!("{}\n[uncertainty]\nlearn = false\n", wheel.layout);
    let solution = solved(&text, &wheel.file(), &named(Method::GlobalFit)).unwrap();
    // 50 mrad of the hits and 10 mrad of the marks.
    let loss = 1.0 - solution.answer().unwrap().body.mass / wheel.bench.truth().mass;
    assert!((loss - 0.0026).abs() < 2e-4, "{loss}");
}
