//! How long the suspension-mode methods take on dense responses of many hits: `cargo bench -p massline`.

use divan::Bencher;
use massline::solve::{Options, solve};
use massline_analysis::identification::Selection;
use massline_files::layout_file::LayoutFile;
use massline_files::uff::{Encoding, UffFile, functions_of, write};
use massline_physics::Bench;
use massline_physics::responses::{ObjectExtras, add_noise, frequency_responses};
use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::identify::Method;
use massline_shared::identify::global_fit::{self, GlobalFitSettings, workspace};
use massline_shared::modes::MOST_LINES;
use nalgebra::Complex;

/// Lines of a file, from 0.5 to 12.5 Hz.
const LINES: usize = 3200;
/// Standard deviation of a response, (m/s²)/N.
const NOISE: f64 = 0.002;
const SEED: u64 = 1;

fn main() {
    divan::main();
}

/// The wheel's responses with noise, under the default error budget.
struct Test {
    file: LayoutFile,
    truth: RigidBody<f64>,
    frequencies: Vec<f64>,
    accelerance: Vec<Complex<f64>>,
}

impl Test {
    /// Sensors at the first nodes of the wheel's layout, and hits along all axes of its nodes.
    fn new(sensors: usize, hits: usize, lines: usize) -> Self {
        let nodes = ["1", "2", "3", "101", "102", "103", "104", "105"];
        let dofs =
            nodes.iter().rev().flat_map(|n| ["+X", "+Y", "+Z"].map(|a| format!("\"{n}:{a}\"")));
        let hits = dofs.take(hits).collect::<Vec<_>>().join(", ");
        let sensors = nodes[..sensors].join(", ");
        let mut text: Vec<String> =
            include_str!("../examples/wheel.toml").lines().map(str::to_owned).collect();
        for line in &mut text {
            if line.starts_with("sensors =") {
                *line = format!("sensors = [{sensors}]");
            } else if line.starts_with("hits =") {
                *line = format!("hits = [{hits}]");
            }
        }
        let file = LayoutFile::parse(&text.join("\n"), "wheel.toml").expect("a layout");
        let bench = Bench::named("wheel").expect("the wheel's bench");
        let step = 12.0 / (lines - 1) as f64;
        let frequencies: Vec<f64> = (0..lines).map(|line| 0.5 + step * line as f64).collect();
        let mut accelerance =
            frequency_responses(&bench, &file.layout, &frequencies, 0.0, &ObjectExtras::default())
                .expect("the wheel hangs");
        add_noise(&mut accelerance, NOISE, SEED, 0);
        Self { file, truth: bench.truth(), frequencies, accelerance }
    }

    fn readings(&self) -> FrequencyResponses<'_, f64> {
        let layout = &self.file.layout;
        let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
        FrequencyResponses::new(&self.frequencies, &self.accelerance, channels, hits)
            .expect("responses of all hits")
    }

    fn universal_file(&self) -> UffFile {
        let frfs = functions_of(&self.file.layout, &self.readings());
        UffFile::parse(&write(&frfs, Encoding::Binary)).expect("a universal file")
    }
}

/// The global fit alone of 3 sensors, 20 hits and as many lines as are chosen from a file, from a body that is 2 % too
/// heavy.
#[divan::bench(sample_count = 10)]
fn global_fit_alone_3_sensors_20_hits(bencher: Bencher<'_, '_>) {
    let test = Test::new(3, 20, MOST_LINES);
    let start = RigidBody { mass: 1.02 * test.truth.mass, ..test.truth };
    let mut memory = vec![0.0; workspace(3, 20)];
    let readings = test.readings();
    let settings = GlobalFitSettings::default();
    bencher.bench_local(|| {
        global_fit::solve(&test.file.layout, &readings, &start, &settings, &mut memory)
            .expect("an answer")
    });
}

/// `solve --method global-fit` once the file is read: 3 sensors, 20 hits, 3200 lines.
#[divan::bench(sample_count = 3)]
fn global_fit_3_sensors_20_hits_3200_lines(bencher: Bencher<'_, '_>) {
    solved(bencher, 3, 20, Selection::Only(Method::GlobalFit));
}

/// `solve --method all` once the file is read: 8 sensors, 24 hits, 3200 lines.
#[divan::bench(sample_count = 3)]
fn all_methods_8_sensors_24_hits_3200_lines(bencher: Bencher<'_, '_>) {
    solved(bencher, 8, 24, Selection::All);
}

fn solved(bencher: Bencher<'_, '_>, sensors: usize, hits: usize, selection: Selection) {
    let test = Test::new(sensors, hits, LINES);
    let (uff, options) = (test.universal_file(), Options { selection, ..Options::default() });
    bencher.bench_local(|| solve(&test.file, &uff, &options, |_, _| ()).expect("an answer"));
}
