//! How long the suspension-mode methods take on dense responses of many hits: `cargo bench -p massline`.

use divan::Bencher;
use massline::layout_file::LayoutFile;
use massline::suspension::{ModalSettings, solve};
use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::identify::Method;
use massline_shared::identify::global_fit::{self, GlobalFitSettings, workspace};
use massline_shared::layout::HostLayout;
use massline_virtual::bench::Bench;
use massline_virtual::bench::responses::{Besides, add_noise, frequency_responses};
use nalgebra::Complex;

/// Lines from 0.5 to 12.5 Hz.
const LINES: usize = 3200;
/// Standard deviation of a response, (m/s²)/N.
const NOISE: f64 = 0.002;
const SEED: u64 = 1;

fn main() {
    divan::main();
}

/// The wheel's responses with noise, under the default error budget.
struct Test {
    layout: HostLayout,
    truth: RigidBody<f64>,
    frequencies: Vec<f64>,
    accelerance: Vec<Complex<f64>>,
}

impl Test {
    /// Sensors at the first nodes of the wheel's layout, and hits along all axes of its nodes.
    fn new(sensors: usize, hits: usize) -> Self {
        let nodes = ["1", "2", "3", "101", "102", "103", "104", "105"];
        let dofs =
            nodes.iter().rev().flat_map(|n| ["+X", "+Y", "+Z"].map(|a| format!("\"{n}:{a}\"")));
        let hits = dofs.take(hits).collect::<Vec<_>>().join(", ");
        let sensors = nodes[..sensors].join(", ");
        let mut lines: Vec<String> =
            include_str!("../examples/wheel.toml").lines().map(str::to_owned).collect();
        for line in &mut lines {
            if line.starts_with("sensors =") {
                *line = format!("sensors = [{sensors}]");
            } else if line.starts_with("hits =") {
                *line = format!("hits = [{hits}]");
            }
        }
        let layout = LayoutFile::parse(&lines.join("\n"), "wheel.toml").expect("a layout").layout;
        let bench = Bench::named("wheel").expect("the wheel's bench");
        let step = 12.0 / (LINES - 1) as f64;
        let frequencies: Vec<f64> = (0..LINES).map(|line| 0.5 + step * line as f64).collect();
        let mut accelerance =
            frequency_responses(&bench, &layout, &frequencies, &Besides::default())
                .expect("the wheel hangs");
        add_noise(&mut accelerance, NOISE, SEED, 0);
        Self { layout, truth: bench.truth(), frequencies, accelerance }
    }

    fn readings(&self) -> FrequencyResponses<'_, f64> {
        let (channels, hits) = (3 * self.layout.sensors.len(), self.layout.hits.len());
        FrequencyResponses::new(&self.frequencies, &self.accelerance, channels, hits)
            .expect("responses of all hits")
    }
}

/// The global fit of 3 sensors and 20 hits, from a body that is 2 % too heavy.
#[divan::bench(sample_count = 10)]
fn global_fit_3_sensors_20_hits(bencher: Bencher<'_, '_>) {
    let test = Test::new(3, 20);
    let start = RigidBody { mass: 1.02 * test.truth.mass, ..test.truth };
    let mut memory = vec![0.0; workspace(3, 20)];
    let settings = GlobalFitSettings::default();
    bencher.bench_local(|| {
        global_fit::solve(&test.layout, &test.readings(), &start, &settings, &mut memory)
            .expect("an answer")
    });
}

/// All methods that use the suspension modes, with their uncertainty and agreement, for 8 sensors and 24 hits.
#[divan::bench(sample_count = 3)]
fn all_methods_8_sensors_24_hits(bencher: Bencher<'_, '_>) {
    let test = Test::new(8, 24);
    bencher.bench_local(|| {
        let settings = ModalSettings::default();
        solve(&test.layout, &test.readings(), &Method::ALL, settings, None, |_, _| ())
            .expect("modes")
    });
}
