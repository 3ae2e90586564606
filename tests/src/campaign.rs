//! A virtual rig with a client on its link, and campaigns on it.
//!
//! The functions panic when a test cannot continue: when the rig does not start, does not answer, or ends
//! a campaign without a result.

use std::time::{Duration, Instant};

use massline::rig::PipeTransport;
use massline_analysis::monte_carlo::measurement::TestLayout;
use massline_client::campaign::{CampaignOutcome, Observer, StartOptions, begin, follow};
use massline_client::interrupt::Interrupt;
use massline_client::{Client, Timing};
use massline_files::layout_file::LayoutFile;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_protocol::message::Status;
use massline_protocol::object::MeasurementResult;
use massline_shared::layout::{Axis, Dof, Hit, RigLayout, Sign};
use massline_shared::measurement::campaign::Phase;
use massline_virtual::{VirtualRig, VirtualRigOptions};

/// A wall-clock limit that is reached only when something hangs.
pub const LATE: Duration = Duration::from_secs(120);

/// Retries soon and as often as needed: a rig in this process answers at once or not at all.
pub const IMPATIENT: Timing = Timing {
    answer: Duration::from_millis(50),
    attempts: 10_000,
    reconnect: LATE,
    pause: Duration::from_millis(1),
};

/// The shipped layouts of the three-bar frame: the paper's four tests.
pub const THREE_BAR_TESTS: [&str; 4] = [
    include_str!("../../host/examples/three-bar-test-1.toml"),
    include_str!("../../host/examples/three-bar-test-2.toml"),
    include_str!("../../host/examples/three-bar-test-3.toml"),
    include_str!("../../host/examples/three-bar-test-4.toml"),
];

/// The frame with five hit DOFs.
pub const FIVE_HITS: &str = r#"
title = "three-bar frame, five hits"
gravity = [0.0, 0.0, -9.80665]
sensors = [1, 2, 4]
hits = ["1:+Y", "2:+Z", "4:+X", "1:+Z", "3:+X"]
node = [
    { id = 1, position_m = [0.0, 0.0, 0.0] },
    { id = 2, position_m = [0.20785, -0.19902, 0.0] },
    { id = 3, position_m = [0.20785, 0.0, 0.0] },
    { id = 4, position_m = [0.20785, -0.19902, 0.14913] },
]
"#;

/// Reads the text of a layout file.
#[track_caller]
pub fn layout_file(text: &str) -> LayoutFile {
    LayoutFile::parse(text, "test.toml").expect("the layout is well-formed")
}

/// The first of [`THREE_BAR_TESTS`].
pub fn three_bar() -> LayoutFile {
    layout_file(THREE_BAR_TESTS[0])
}

/// The test of a layout file, hit with a calibrated hammer: its gain is exact.
#[track_caller]
pub fn with_calibrated_hammer(text: &str) -> TestLayout {
    let mut layout: TestLayout = layout_file(text).layout.cast().expect("fits the rig");
    (layout.apparatus.hammer_gain, layout.calibrated_hammer) = (0.0, false);
    layout
}

/// The test with every DOF of the frame's four nodes: after its own, the others along +X, +Y and +Z, as many as
/// a rig has memory for.
#[track_caller]
pub fn with_every_dof(mut layout: TestLayout) -> TestLayout {
    let nodes = three_bar().nodes;
    let [x, y, z] = [Axis::X, Axis::Y, Axis::Z];
    for axes in [[x, y, z, x], [y, z, x, y], [z, x, y, z]] {
        for (node, axis) in nodes.iter().zip(axes) {
            let dof = Dof { node: node.id, sign: Sign::Plus, axis };
            if layout.hits.iter().all(|hit| hit.dof != dof) {
                let hit = Hit::new(dof, node.position, node.axes[axis.index()]);
                layout.hits.push(hit).expect("twelve DOFs fit the rig");
            }
        }
    }
    layout
}

/// The first of [`THREE_BAR_TESTS`] with `hits` at each DOF instead of five.
pub fn three_bar_with_hits(hits: u8) -> LayoutFile {
    let mut file = three_bar();
    file.layout.test.hits_per_dof = hits;
    file
}

/// A bundled bench whose operator never taps too weakly, too hard or twice.
pub fn steady_hand(name: &str) -> Bench {
    let mut bench = Bench::named(name).expect("the bench is bundled");
    bench.operator.too_weak_rate = 0.0;
    bench.operator.too_hard_rate = 0.0;
    bench.operator.double_rate = 0.0;
    bench
}

/// The bench of a person who hits half as well as on this one.
pub fn half_as_well(mut bench: Bench) -> Bench {
    bench.tap.point_sigma_m *= 2.0;
    bench.tap.direction_sigma_rad *= 2.0;
    bench
}

/// The scans of `bench` while it is measured with the layout of `file`; every random number comes from
/// `seed`.
#[track_caller]
pub fn scans(bench: &Bench, file: &LayoutFile, seed: u64) -> Box<BenchSource> {
    Box::new(BenchSource::new(bench, &file.layout, seed).expect("the layout fits the bench"))
}

/// Connects one more client, which repeats its requests as [`IMPATIENT`] says.
pub fn connect(rig: &VirtualRig) -> Client {
    Client::with_timing(PipeTransport::new(rig.link()), IMPATIENT)
}

/// Starts a rig and connects a client, which has not sent a request yet.
pub fn start(options: VirtualRigOptions) -> (VirtualRig, Client) {
    let rig = VirtualRig::start(options).expect("the rig starts");
    let client = Client::new(PipeTransport::new(rig.link()));
    (rig, client)
}

/// Runs a whole campaign with `layout` on a rig of its own that takes the scans of `source`; returns the
/// result that the rig stores.
pub fn measure(
    source: Box<dyn ScanSource>,
    layout: &RigLayout,
    observer: &mut dyn Observer,
) -> MeasurementResult {
    let (rig, mut client) = start(VirtualRigOptions::new(source));
    client.identify().expect("the rig says who it is");
    client.put_layout(layout).expect("the rig takes the layout");
    begin(&mut client, StartOptions::default()).expect("the campaign begins");
    let ending = follow(&mut client, &Interrupt::new(), None, observer);
    let ending = ending.expect("the rig answers to the end of the campaign");
    let CampaignOutcome::Done(number) = ending else {
        panic!("the campaign has no result: {ending:?}")
    };
    let result = client.result(number).expect("the result can be read");
    rig.stop().expect("the rig has not panicked");
    result
}

/// The phase of the campaign; `None` for a number that this version does not know.
pub fn phase(status: &Status) -> Option<Phase> {
    Phase::try_from(status.phase).ok()
}

/// Polls the status until `wanted` is true for it.
#[track_caller]
pub fn wait_for(client: &mut Client, wanted: impl Fn(&Status) -> bool) -> Status {
    let start = Instant::now();
    loop {
        let status = client.status().expect("the rig answers");
        if wanted(&status) {
            return status;
        }
        assert!(start.elapsed() < LATE, "the rig does not get there: {status:?}");
    }
}
