//! The suspension-mode methods on the wheel's responses, as files: what they answer, and what they refuse or warn of.

mod answers;
mod doubts;
mod exact;
mod warnings;

use massline_physics::Bench;
use massline_physics::responses::{
    Dashpot, ObjectExtras, SprungPart, add_noise, frequency_responses,
};
use massline_physics::suspension::Suspension;
use massline_shared::body::RigidBody;
use massline_shared::identify::Estimate;
use massline_shared::identify::agreement::Outcome;
use massline_shared::layout::uncertainty_keys;
use nalgebra::Complex;
use serde_json::json;

use super::*;
use massline_files::uff::{Encoding, Frf, NodeDirection, write};
use massline_report::words::{Extent, result_text};

const LAYOUT: &str = include_str!("../../examples/wheel.toml");
/// Nothing besides the body on its springs.
const NOTHING: ObjectExtras = ObjectExtras { part: None, dashpot: None, structural: false };
/// Noise of a line, (m/s²)/N.
const NOISE: f64 = 0.002;

/// The lines of the paper, Hz.
fn lines() -> Vec<f64> {
    (0..97).map(|k| 0.5 + 0.125 * f64::from(k)).collect()
}

/// The wheel's responses with noise at these lines, changed by `change(frequency, channel, hit, response)`.
fn file(
    frequencies: &[f64],
    besides: impl Into<ObjectExtras>,
    change: impl Fn(f64, usize, usize, Complex<f64>) -> Complex<f64>,
) -> UffFile {
    file_of(&Bench::named("wheel").unwrap(), LAYOUT, frequencies, besides, change)
}

/// The same for another bench or other hits.
fn file_of(
    bench: &Bench,
    layout: &str,
    frequencies: &[f64],
    besides: impl Into<ObjectExtras>,
    change: impl Fn(f64, usize, usize, Complex<f64>) -> Complex<f64>,
) -> UffFile {
    let layout = LayoutFile::parse(layout, "wheel.toml").unwrap().layout;
    let mut responses =
        frequency_responses(bench, &layout, frequencies, 0.0, &besides.into()).unwrap();
    add_noise(&mut responses, NOISE, 12, 0);
    file_with(&layout, frequencies, &responses, change)
}

/// These responses of a layout, as a file.
fn file_with(
    layout: &HostLayout,
    frequencies: &[f64],
    responses: &[Complex<f64>],
    change: impl Fn(f64, usize, usize, Complex<f64>) -> Complex<f64>,
) -> UffFile {
    let mut frfs = Vec::new();
    let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
    for (place, hit) in layout.hits.iter().enumerate() {
        let direction = hit.dof.axis.index() as i64 + 1;
        let reference = NodeDirection { node: hit.dof.node.into(), direction };
        for channel in 0..channels {
            let node = layout.sensors[channel / 3].node.into();
            let response = NodeDirection { node, direction: (channel % 3) as i64 + 1 };
            let of_line = responses.chunks_exact(channels * hits).zip(frequencies);
            let accelerance = of_line
                .map(|(line, f)| change(*f, channel, place, line[channel * hits + place]))
                .collect();
            let frequency_hz = frequencies.to_vec();
            frfs.push(Frf { response, reference, frequency_hz, accelerance });
        }
    }
    UffFile::parse(&write(&frfs, Encoding::Binary)).unwrap()
}

fn unchanged(frequencies: &[f64], besides: impl Into<ObjectExtras>) -> UffFile {
    file(frequencies, besides, |_, _, _, h| h)
}

fn text_of(solution: &Solution) -> String {
    result_text(&solution.result(), Extent::Details)
}

fn solved(text: &str, uff: &UffFile, options: &Options) -> Result<Solution> {
    solve(&LayoutFile::parse(text, "wheel.toml").unwrap(), uff, options, |_, _| ())
}

/// The responses have noise and no other errors.
fn noise_alone() -> String {
    let none: String = uncertainty_keys().map(|key| format!("{} = 0\n", key.name)).collect();
    format!("{LAYOUT}\n[uncertainty]\n{none}")
}

/// The same with mass lines in this band, Hz.
fn with_mass_lines(band: &str) -> String {
    noise_alone().replace("profile = \"suspension\"", &format!("band_hz = {band}"))
}

fn named(method: Method) -> Options {
    Options { selection: Selection::Only(method), ..Options::default() }
}

/// Every number within four standard deviations: fifty of them are, in 99.7 % of tests.
fn assert_near_truth(estimate: &Estimate<f64>, truth: &RigidBody<f64>) {
    let off = (estimate.theta() - truth.theta()).component_div(&estimate.sigma().unwrap());
    assert!(off.amax() < 4.0, "{:?} {off}", estimate.method);
}

/// The wheel on springs that give it modes of these frequencies, Hz, and this damping ratio.
fn wheel_with_modes(hz: [f64; 6], damping_ratio: f64) -> Bench {
    let mut bench = Bench::named("wheel").unwrap();
    bench.suspension = Suspension::Frequencies { hz, damping_ratio };
    bench
}
