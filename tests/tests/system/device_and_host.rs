//! From the same mass lines the rig, in single precision, computes the same results as the host in double
//! precision.

use massline_analysis::identification::{Selection, identify, lines_of};
use massline_physics::Bench;
use massline_report::words::estimates_of;
use massline_shared::identify::{IdentifySettings, Observations};
use massline_tests::campaign::{THREE_BAR_TESTS, layout_file, measure, scans};

/// The first test with other sensors, hits and further tables.
fn first_with(sensors: &str, hits: &str, tables: &str) -> String {
    let text = THREE_BAR_TESTS[0].replace("sensors = [1, 2, 3]", &format!("sensors = {sensors}"));
    let text = text.replace("hits = [\"1:+Y\", \"2:+Z\", \"4:+X\"]", &format!("hits = {hits}"));
    assert!(text.contains(sensors) && text.contains(hits));
    text + tables
}

const FIVE: &str = "[\"1:+Y\", \"2:+Z\", \"4:+X\", \"4:+Y\", \"1:+Z\"]";
const NINE: &str = "[\"1:+X\", \"1:+Y\", \"1:+Z\", \"2:+Y\", \"2:+Z\", \"3:+X\", \"4:+X\", \"4:+Y\", \
                    \"4:+Z\"]";
const KNOWN: &str = "
[prior]
mass_kg = { value = 1.23, sigma = 0.001 }
[[attached]]
mass_kg = { value = 0.02, sigma = 0.001 }
center_of_mass_m = [0.1, 0.0, 0.0]
";

#[test]
fn device_and_host_agree_in_the_four_tests() {
    for test in THREE_BAR_TESTS {
        agree(test, &bench(), 1, 2);
    }
}

#[test]
fn device_and_host_agree_with_more_hits() {
    for hits in [FIVE, NINE] {
        agree(&first_with("[1, 2, 3]", hits, ""), &bench(), 1, 2);
    }
}

#[test]
fn device_and_host_agree_with_a_known_mass_and_one_that_hangs_on_the_object() {
    agree(&first_with("[1, 2, 3]", FIVE, KNOWN), &bench(), 1, 2);
}

/// Inertia restraint has no answer, so maximum likelihood begins with a crude start.
#[test]
fn device_and_host_agree_with_two_sensors() {
    agree(&first_with("[1, 4]", FIVE, ""), &bench(), 1, 1);
}

/// Error sources that explain a large residual leave a small χ² as the difference of large numbers.
#[test]
fn device_and_host_agree_when_a_hit_lands_on_another_node() {
    let mut bench = bench();
    bench.faults.push("hit:2:4".parse().expect("a fault"));
    for seed in 1..=8 {
        agree(THREE_BAR_TESTS[0], &bench, seed, 2);
    }
}

fn bench() -> Bench {
    Bench::named("default").expect("bundled")
}

/// Every number of every method agrees to a hundredth of its standard deviation.
fn agree(text: &str, bench: &Bench, seed: u64, methods: usize) {
    let file = layout_file(text);
    let source = scans(bench, &file, seed);
    let layout = file.rig_layout().expect("fits the rig");
    let result = measure(source, &layout, &mut ());
    let lines = lines_of(&result, &file.layout);
    let observed = Observations::of_mass_lines(&file.layout, &lines);
    let host = identify(&observed, Selection::All, &IdentifySettings::default());
    let rig = estimates_of(&result);
    assert_eq!(rig.len(), methods, "{:?}", result.diagnostics);
    assert_eq!(host.estimates.len(), methods);
    for (host, device) in host.estimates.iter().zip(&rig) {
        assert_eq!(host.method, device.method);
        let sigmas = host.sigma().zip(device.sigma()).expect("five hits a DOF");
        for k in 0..10 {
            let (host, device) = (host.theta()[k], device.theta()[k]);
            let (sigma, of_device) = (sigmas.0[k], sigmas.1[k]);
            // The project's limit for the error of single precision: a hundredth of the standard
            // deviation, for the linear method and for the fit.
            assert!((host - device).abs() <= 0.01 * sigma, "{k}: {device}, {host} ± {sigma}");
            // A standard deviation itself is known only to a few per cent.
            assert!((of_device / sigma - 1.0).abs() <= 0.01, "{k}: {of_device}, {sigma}");
        }
    }
}
