//! Campaigns of the suspension profile on wheels that are drawn anew, each with its own converter: whether the intervals
//! of the global fit hold, and what becomes of mistakes.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test system -- drawn_wheels:: --nocapture` prints the figures
//! of such a run.

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::measurement::{SimulatedTest, TestLayout, measure};
use massline_analysis::parallel::each;
use massline_analysis::score_tests::SmallFault;
use massline_physics::{Bench, BenchSource, Fault};
use massline_shared::diagnosis::{Code, Subject};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::{Axis, CALIBRATED_HAMMER_GAIN, Prior};
use massline_shared::nalgebra::SVector;
use massline_tests::campaign::layout_file;
use massline_tests::drawn_wheels::{DrawnWheel, drawn_wheels};
use massline_tests::long;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Chosen before the first run.
const SEED: u64 = 20_261_201;

/// The test of the wheel with a calibrated hammer.
fn layout() -> TestLayout {
    let file = layout_file(include_str!("../../../host/examples/wheel.toml"));
    let mut layout: TestLayout = file.layout.cast().expect("it fits a rig");
    (layout.apparatus.hammer_gain, layout.calibrated_hammer) = (CALIBRATED_HAMMER_GAIN, false);
    layout
}

/// The tests of wheels with this layout.
fn measured(wheels: &[DrawnWheel], layout: &TestLayout) -> Vec<SimulatedTest> {
    each(
        wheels,
        || (),
        |(), wheel| {
            let whole = layout.cast().expect("a layout of the host");
            let mut source = BenchSource::new(&wheel.bench, &whole, wheel.seed).expect("it fits");
            let calibration = nominal_calibration(&wheel.bench);
            measure(&mut source, layout, &calibration).expect("lines")
        },
    )
}

fn global_fit(test: &SimulatedTest) -> Option<&Estimate<f64>> {
    test.estimates.iter().find(|estimate| estimate.method == Method::GlobalFit)
}

/// The errors of an answer in its standard deviations.
fn deviates(wheel: &DrawnWheel, estimate: &Estimate<f64>) -> SVector<f64, 10> {
    let error = estimate.theta() - wheel.bench.truth().theta();
    error.component_div(&estimate.sigma().expect("an interval"))
}

/// Share of the 95 % intervals that hold, of answers with these errors.
fn coverage(deviates: &[SVector<f64, 10>]) -> f64 {
    let holding: usize =
        deviates.iter().map(|own| own.iter().filter(|z| z.abs() < 1.96).count()).sum();
    holding as f64 / (10 * deviates.len()) as f64
}

/// The small fault that shows most, with its significance.
fn first_shown(test: &SimulatedTest) -> Option<(SmallFault, f64)> {
    test.score_tests.shown().first().map(|test| (test.fault, test.significance()))
}

fn bench(name: &str) -> Bench {
    Bench::named(name).expect("bundled")
}

#[test]
fn intervals_hold_whatever_the_wheel_and_its_converter() {
    let (few, many) = (3, 100);
    let mut wheels = drawn_wheels(&bench("wheel"), SEED, if long() { many } else { few });
    wheels.sort_by(|a, b| a.highest_hz.total_cmp(&b.highest_hz));
    let tests = measured(&wheels, &layout());
    let answered =
        wheels.iter().zip(&tests).filter_map(|(wheel, test)| Some((wheel, global_fit(test)?)));
    let deviates: Vec<_> = answered.clone().map(|(wheel, e)| deviates(wheel, e)).collect();
    let third = deviates.len().div_ceil(3);
    let thirds: Vec<f64> = deviates.chunks(third).map(coverage).collect();
    let squares: f64 = deviates.iter().map(|own| own.norm_squared()).sum();
    let rms = (squares / (10 * deviates.len()) as f64).sqrt();
    let rough = |e: &Estimate<f64>| e.diagnostics.iter().any(|d| d.code == Code::ModelFitsRoughly);
    let rough = answered.filter(|(_, estimate)| rough(estimate)).count();
    let differ = |test: &&SimulatedTest| {
        test.combined.as_ref().is_some_and(|agreement| !agreement.outliers.is_empty())
    };
    let differ = tests.iter().filter(differ).count();
    let shown: Vec<_> = tests.iter().filter_map(first_shown).collect();
    println!("small faults of sound wheels that show: {shown:?}");
    println!(
        "{} of {} wheels answered: coverage {:.3}, by thirds of the highest mode {thirds:.3?}, errors of {rms:.2} sd; \
         {rough} fit roughly, methods differ in {differ}",
        deviates.len(),
        wheels.len(),
        coverage(&deviates),
    );
    if long() {
        assert!(deviates.len() * 100 >= wheels.len() * 97, "{} of {many}", deviates.len());
        assert!((0.93..=0.97).contains(&coverage(&deviates)), "{}", coverage(&deviates));
        assert!(thirds.iter().all(|third| *third >= 0.91), "{thirds:?}");
        assert!(rough * 100 <= wheels.len(), "{rough} fit roughly");
        assert!(shown.len() * 50 <= wheels.len(), "{shown:?}");
    } else {
        // Thirty numbers; a run whose ten errors are one is 1.7 with a probability of a tenth.
        assert_eq!(deviates.len(), wheels.len());
        assert!(rms < 1.7, "{rms}");
        assert!(shown.is_empty(), "{shown:?}");
    }
}

#[test]
fn with_a_tyre_there_is_an_answer_and_its_intervals_hold() {
    let wheels = drawn_wheels(&bench("wheel-with-tyre"), SEED, if long() { 60 } else { 1 });
    let tests = measured(&wheels, &layout());
    let answered = wheels
        .iter()
        .zip(&tests)
        .filter_map(|(wheel, test)| Some(deviates(wheel, global_fit(test)?)));
    let answered: Vec<_> = answered.collect();
    println!(
        "with a tyre {} of {} answered: coverage {:.3}",
        answered.len(),
        wheels.len(),
        coverage(&answered)
    );
    assert!(answered.len() * 10 >= wheels.len() * 9, "{} of {}", answered.len(), wheels.len());
    if long() {
        assert!((0.90..=0.97).contains(&coverage(&answered)), "{}", coverage(&answered));
    }
}

/// Everything that is said about a test, of the global fit or of why it has no answer.
fn said(test: &SimulatedTest) -> Vec<(Code, Subject)> {
    let refusals = test.refusals.iter().filter(|(method, _)| *method == Method::GlobalFit);
    let of_refusals = refusals.flat_map(|(_, reasons)| reasons.iter());
    let of_answer = global_fit(test).into_iter().flat_map(|estimate| &estimate.diagnostics);
    of_refusals.chain(of_answer).map(|finding| (finding.code, finding.subject)).collect()
}

#[test]
fn gravity_the_wrong_way_round_and_turned_or_swapped_sensors_are_named() {
    let count = if long() { 40 } else { 1 };
    let mut reversed = layout();
    reversed.gravity = reversed.gravity.map(|gravity| gravity.map(|component| -component));
    let with = |fault: &str| {
        let fault: Fault = fault.parse().expect("a fault");
        Bench { faults: vec![fault], ..bench("wheel") }
    };
    let cases = [
        ("reversed gravity", bench("wheel"), reversed, Code::GravityReversed),
        ("turned sensor", with("rotate:3:z90"), layout(), Code::SensorAxesSuspect),
        ("swapped sensors", with("swap:1,2"), layout(), Code::CablesSwapped),
    ];
    for (name, bench, layout, code) in cases {
        let wheels = drawn_wheels(&bench, SEED, count);
        let tests = measured(&wheels, &layout);
        let named = |test: &&SimulatedTest| said(test).iter().any(|(found, _)| *found == code);
        let named = tests.iter().filter(named).count();
        println!("{name}: named in {named} of {count}");
        assert!(named * 10 >= count * 9, "{name}: {named} of {count}");
    }
}

/// Makes a small fault of a wheel; returns what names it.
type Make = fn(&mut Bench, &TestLayout, &mut ChaCha8Rng) -> SmallFault;

#[test]
fn small_faults_are_named() {
    let count = if long() { 30 } else { 1 };
    let kinds: [(&str, Make); 3] = [
        ("a node 15 mm off", |bench, layout, random| {
            let (sensors, hits) = (&layout.sensors, &layout.hits);
            let place = random.random_range(0..sensors.len() + hits.len());
            // A force that is displaced along its direction is the same force.
            let (node, along) = match place.checked_sub(sensors.len()) {
                None => (sensors[place].node, [0.0; 3]),
                Some(hit) => (hits[hit].dof.node, hits[hit].direction),
            };
            let axes = Axis::ALL.into_iter().filter(|axis| along[axis.index()] == 0.0);
            let axes: Vec<Axis> = axes.collect();
            let axis = axes[random.random_range(0..axes.len())];
            let distance_m = if random.random_bool(0.5) { 0.015 } else { -0.015 };
            bench.faults.push(Fault::NodeMisplaced { node, axis, distance_m });
            SmallFault::NodeMisplaced { node, axis }
        }),
        ("hits that lean by 150 mrad", |bench, layout, random| {
            let hit = random.random_range(0..layout.hits.len());
            bench.faults.push(Fault::HitLeans { hit, angle_rad: 0.15 });
            SmallFault::HitLeans { hit }
        }),
        ("chips 15 mm above their marks", |bench, _, _| {
            bench.faults.push(Fault::ChipsAboveMarks { height_m: 0.015 });
            SmallFault::ChipsAboveMarks
        }),
    ];
    let layout = layout();
    for (kind, (name, make)) in (SEED..).zip(kinds) {
        let mut random = ChaCha8Rng::seed_from_u64(kind);
        let mut wheels = drawn_wheels(&bench("wheel"), SEED, count);
        let faults: Vec<SmallFault> =
            wheels.iter_mut().map(|wheel| make(&mut wheel.bench, &layout, &mut random)).collect();
        let tests = measured(&wheels, &layout);
        let is_named = |(test, fault): (&SimulatedTest, SmallFault)| {
            test.score_tests.shown().iter().any(|shown| shown.fault == fault)
        };
        let named = tests.iter().zip(faults).filter(|pair| is_named(*pair)).count();
        println!("{name}: named in {named} of {count}");
        assert!(named * 10 >= count * 9, "{name}: {named} of {count}");
    }
}

/// The hammer's gain scales mass and inertia and leaves no trace where no mass is known.
#[test]
fn a_hammer_that_reads_too_little_is_named_where_the_mass_is_known() {
    let count = if long() { 20 } else { 1 };
    let mut wheels = drawn_wheels(&bench("wheel"), SEED, count);
    let named = wheels.iter_mut().filter_map(|wheel| {
        wheel.bench.faults.push("hammer:0.95".parse().expect("a fault"));
        let mut layout = layout();
        let (value, sigma) = (wheel.bench.body.mass, 0.002 * wheel.bench.body.mass);
        layout.priors.push(Prior { property: 0, value, sigma }).expect("room");
        let tests = measured(std::slice::from_ref(wheel), &layout);
        first_shown(&tests[0]).filter(|(fault, _)| *fault == SmallFault::HammerGainOff)
    });
    let named = named.count();
    println!("a hammer that reads 5 % too little: named in {named} of {count}");
    assert!(named * 10 >= count * 9, "{named} of {count}");
}
