//! What the rig computes in single precision is what the host computes in double precision from the
//! same mass lines.

use massline::campaign::{Begin, Ending, Observer, begin, follow};
use massline::client::{Client, PipeTransport};
use massline::identification::{Options, Selection, identify, lines_of};
use massline::interrupt::Interrupt;
use massline::layout_file::LayoutFile;
use massline::report::Answer;
use massline_shared::identify::inertia_restraint::Settings;
use massline_shared::protocol::object::MeasurementResult;
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

fn on_the_rig(file: &LayoutFile) -> MeasurementResult {
    let bench = Bench::named("default").expect("bundled");
    let source = BenchSource::new(&bench, &file.layout, 1).expect("the bench takes it");
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

#[test]
fn device_and_host_agree_to_a_hundredth_of_each_standard_deviation() {
    for test in TESTS {
        let file = LayoutFile::parse(test, "test.toml").expect("a shipped layout");
        let result = on_the_rig(&file);
        let options =
            Options { selection: Selection::All, inertia_restraint: Settings::weighted() };
        let lines = lines_of(&result, &file.layout);
        let host = identify(&file.layout, &lines, &options).expect("an answer");
        assert_eq!(result.estimates.len(), 2, "maximum likelihood and inertia restraint");
        assert_eq!(host.answers.len(), 2);
        for (host, device) in host.answers.iter().zip(result.estimates.iter()) {
            let device = Answer::from_stored(device);
            assert_eq!(host.method, device.method);
            let sigmas = host.sigma().zip(device.sigma()).expect("five hits a DOF");
            for k in 0..10 {
                let (host, device) = (host.properties()[k], device.properties()[k]);
                let (sigma, of_device) = (sigmas.0[k], sigmas.1[k]);
                // What single precision may cost, by the project's own bound; the linear method and
                // the fit stay a hundred times below the standard deviation.
                assert!((host - device).abs() <= 0.01 * sigma, "{k}: {device}, {host} ± {sigma}");
                // A standard deviation is itself known to no better than a few per cent.
                assert!((of_device / sigma - 1.0).abs() <= 0.01, "{k}: {of_device}, {sigma}");
            }
        }
    }
}
