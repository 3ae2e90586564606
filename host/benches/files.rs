//! How long `massline solve` takes for a large universal file: 8 triaxial sensors, 20 hits, 3200 lines; 25 MB in binary
//! and 63 MB in ASCII. Aim in CPU time: 0.8 s and 1.2 s. `cargo bench -p massline --bench files`.

use divan::Bencher;
use massline::solve::{Options, solve};
use massline_files::layout_file::LayoutFile;
use massline_files::uff::{Encoding, UffFile, functions_of, write};
use massline_physics::Bench;
use massline_physics::responses::add_noise;
use massline_result::Verdict;
use massline_shared::FrequencyResponses;
use nalgebra::Complex;

const HITS: usize = 20;
const LINES: usize = 3200;
/// The first line and the distance of the lines, Hz.
const FIRST_HZ: f64 = 1.0;
const SPACING_HZ: f64 = 0.0625;
/// Standard deviation of a response, (m/s²)/N.
const NOISE: f64 = 0.0005;

fn main() {
    divan::main();
}

/// A rigid body with sensors and hits at the nodes of the wheel's layout, which no suspension holds.
fn test(encoding: Encoding) -> (LayoutFile, Vec<u8>) {
    let nodes = ["1", "2", "3", "101", "102", "103", "104", "105"];
    let dofs = nodes.iter().flat_map(|n| ["+X", "+Y", "+Z"].map(|axis| format!("\"{n}:{axis}\"")));
    let hits = dofs.take(HITS).collect::<Vec<_>>().join(", ");
    let text = include_str!("../examples/wheel.toml").lines().map(|line| {
        if line.starts_with("sensors =") {
            format!("sensors = [{}]", nodes.join(", "))
        } else if line.starts_with("hits =") {
            format!("hits = [{hits}]")
        } else {
            line.to_owned()
        }
    });
    let text: Vec<String> = text.collect();
    let file = LayoutFile::parse(&text.join("\n"), "wheel.toml").expect("a layout");
    let body = Bench::named("wheel").expect("the wheel's bench").truth();
    let (channels, hits) = (3 * file.layout.sensors.len(), file.layout.hits.len());
    let of_hits: Vec<_> =
        (0..hits).map(|hit| file.layout.accelerance(&body, hit).expect("a rigid body")).collect();
    let frequencies: Vec<f64> =
        (0..LINES).map(|line| FIRST_HZ + SPACING_HZ * line as f64).collect();
    let values = (0..channels).flat_map(|channel| of_hits.iter().map(move |hit| hit[channel]));
    let accelerance_of_line: Vec<_> = values.map(|value| Complex::new(value, 0.0)).collect();
    let mut accelerance = accelerance_of_line.repeat(LINES);
    add_noise(&mut accelerance, NOISE, 1, 0);
    let readings = FrequencyResponses::new(&frequencies, &accelerance, channels, hits);
    let functions = functions_of(&file.layout, &readings.expect("as many responses as there are"));
    (file, write(&functions, encoding))
}

fn solved(bencher: Bencher, encoding: Encoding) {
    let (layout, bytes) = test(encoding);
    let solved = || {
        let uff = UffFile::parse(&bytes).expect("a universal file");
        solve(&layout, &uff, &Options::default(), |_, _| ()).expect("an answer")
    };
    // Contradicted data would be searched for a mistake, which takes longer than the answer.
    let judgement = solved().judgement().expect("an answer");
    assert_eq!(judgement.verdict(), Verdict::Good, "{judgement:?}");
    bencher.bench_local(solved);
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn binary(bencher: Bencher) {
    solved(bencher, Encoding::Binary);
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn ascii(bencher: Bencher) {
    solved(bencher, Encoding::Ascii);
}
