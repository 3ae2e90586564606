//! `massline hits` on what other recorders write: times, encodings, separators, decimal signs, headers, signals in mV.
//!
//! All files hold the same hit: a half sine of 60 N at 0.4 s, sampled at 5120 Hz, and a response that reaches 24.7
//! m/s².

mod labview;
mod times;
mod units;

use serde_json::Value;
use tempfile::TempDir;

use crate::hits::run;

const RATE: f64 = 5120.0;
const SAMPLES: usize = 6144;
/// The sample at which the force begins, after 0.4 s.
const CONTACT: usize = 2048;
const PEAK_N: f64 = 60.0;
const PEAK_M_PER_S2: f64 = 24.7;

/// Force and response of a row.
fn sample(row: usize) -> [f64; 2] {
    let since = row.wrapping_sub(CONTACT);
    // Noise of a tenth of a newton, the same in every run.
    let noise = |seed: usize| ((row * 7919 + seed) % 101) as f64 * 2e-3 - 0.1;
    if since >= SAMPLES {
        return [noise(0), 0.1 * noise(50)];
    }
    let t = since as f64 / RATE;
    let pulse =
        if since <= 16 { PEAK_N * (std::f64::consts::PI * since as f64 / 16.0).sin() } else { 0.0 };
    let ringing = PEAK_M_PER_S2 * (-30.0 * t).exp() * (std::f64::consts::TAU * 60.0 * t).sin();
    [pulse + noise(0), ringing / 0.88 + 0.1 * noise(50)]
}

/// A file with these lines before the numbers; `row` writes a row of time, force and response.
fn text(header: &str, row: impl Fn(usize, f64, [f64; 2]) -> String) -> String {
    let mut text = header.to_owned();
    for k in 0..SAMPLES {
        text += &row(k, k as f64 / RATE, sample(k));
        text.push('\n');
    }
    text
}

/// Columns with a comma, and the time times a factor.
fn scaled(header: &str, factor: f64) -> String {
    text(header, |_, t, [f, a]| format!("{},{f:.5},{a:.5}", t * factor))
}

/// The time at which a row was sampled, by its number and by the time at which it should have been.
type TimeOfRow<'t> = &'t dyn Fn(usize, f64) -> f64;

struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) -> String {
        let path = self.0.path().join(name);
        std::fs::write(&path, content).unwrap();
        path.display().to_string()
    }
}

/// Grades a file and checks rate and peaks of its only hit.
#[track_caller]
fn graded(arguments: &[&str]) -> Value {
    let (exit, value, stderr) = run(arguments);
    assert_eq!(exit, 0, "{value} {stderr}");
    let number = |value: &Value| value.as_f64().unwrap();
    let rate = number(&value["recording"]["rate_hz"]);
    // A time of two significant digits gives the rate to better than a thousandth.
    assert!((rate / RATE - 1.0).abs() < 1e-3, "{rate}");
    let hits = value["hits"].as_array().unwrap();
    assert_eq!(hits.len(), 1, "{value}");
    // The noise is 0.1 N; the peak of the response lies between samples.
    let peak = number(&hits[0]["peak_force_n"]);
    assert!((peak - PEAK_N).abs() < 0.5, "{peak}");
    let peak = number(&hits[0]["peak_response_m_per_s2"]);
    assert!((peak - PEAK_M_PER_S2).abs() < 1.0, "{peak}");
    assert!((number(&hits[0]["start_s"]) - 0.4).abs() < 2e-3, "{value}");
    value
}

/// Checks that a file is refused with this code and these words; gives the message.
#[track_caller]
fn refused(arguments: &[&str], code: &str, words: &[&str]) -> String {
    let (exit, value, _) = run(arguments);
    assert_eq!((exit, &value["error"]["code"]), (2, &code.into()), "{value}");
    let message = value["error"]["message"].as_str().unwrap().to_owned();
    for word in words {
        assert!(message.contains(word), "{word:?} is not in {message:?}");
    }
    message
}
