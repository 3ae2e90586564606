//! What the rig computes in single precision is what the host computes in double precision from the
//! same mass lines.

use massline::campaign::{Begin, Ending, Observer, begin, follow};
use massline::client::{Client, PipeTransport};
use massline::identification::{Selection, identify, lines_of};
use massline::interrupt::Interrupt;
use massline::layout_file::LayoutFile;
use massline::report::estimates_of;
use massline_protocol::object::MeasurementResult;
use massline_shared::identify::{IdentifySettings, Observations};
use massline_virtual::bench::{Bench, BenchSource};
use massline_virtual::rig::{VirtualRig, VirtualRigOptions};

const TESTS: [&str; 4] = [
    include_str!("../../host/examples/three-bar-test-1.toml"),
    include_str!("../../host/examples/three-bar-test-2.toml"),
    include_str!("../../host/examples/three-bar-test-3.toml"),
    include_str!("../../host/examples/three-bar-test-4.toml"),
];

struct Silent;
impl Observer for Silent {}

fn on_the_rig(file: &LayoutFile, bench: &Bench, seed: u64) -> MeasurementResult {
    let source = BenchSource::new(bench, &file.layout, seed).expect("the bench takes it");
    let rig = VirtualRig::start(VirtualRigOptions::new(Box::new(source))).expect("a rig");
    let mut client = Client::new(PipeTransport::new(rig.link()));
    client.identify().expect("an identity");
    client.put_layout(&file.rig_layout().expect("fits the rig")).expect("a layout");
    begin(&mut client, Begin::default()).expect("a start");
    let ending = follow(&mut client, &Interrupt::new(), None, &mut Silent).expect("an end");
    let Ending::Done(number) = ending else { panic!("no result: {ending:?}") };
    let result = client.result(number).expect("a result");
    rig.stop().expect("no panic");
    result
}

/// The first test with other sensors, hits and knowledge.
fn first_with(sensors: &str, hits: &str, tables: &str) -> String {
    let text = TESTS[0].replace("sensors = [1, 2, 3]", &format!("sensors = {sensors}"));
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
    for test in TESTS {
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

/// Where inertia restraint has no answer and maximum likelihood begins with a crude start.
#[test]
fn device_and_host_agree_with_two_sensors() {
    agree(&first_with("[1, 4]", FIVE, ""), &bench(), 1, 1);
}

/// Causes that explain a large residual leave a small χ² as the difference of large numbers.
#[test]
fn device_and_host_agree_when_a_hit_lands_on_another_node() {
    let mut bench = bench();
    bench.faults.push("hit:2:4".parse().expect("a fault"));
    for seed in 1..=8 {
        agree(TESTS[0], &bench, seed, 2);
    }
}

fn bench() -> Bench {
    Bench::named("default").expect("bundled")
}

/// Every number of every method agrees to a hundredth of its standard deviation.
fn agree(text: &str, bench: &Bench, seed: u64, methods: usize) {
    let file = LayoutFile::parse(text, "test.toml").expect("a good layout");
    let result = on_the_rig(&file, bench, seed);
    let lines = lines_of(&result);
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
            // What single precision may cost, by the project's own bound; the linear method and
            // the fit stay a hundred times below the standard deviation.
            assert!((host - device).abs() <= 0.01 * sigma, "{k}: {device}, {host} ± {sigma}");
            // A standard deviation is itself known to no better than a few per cent.
            assert!((of_device / sigma - 1.0).abs() <= 0.01, "{k}: {of_device}, {sigma}");
        }
    }
}
