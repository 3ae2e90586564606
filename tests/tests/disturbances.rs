//! Each disturbance of a real bench alone: how far it shifts the answer, whether the intervals still hold, and
//! whether the result says so.
//!
//! `MASSLINE_LONG=1 cargo test --release -p massline-tests --test disturbances -- --nocapture` prints the table
//! of tests/README.md.

use massline::commands::bench_test::nominal_calibration;
use massline::interrupt::Interrupt;
use massline::monte_carlo::measurement::{SimulatedTest, TestLayout};
use massline::monte_carlo::{MonteCarlo, Run};
use massline_shared::diagnosis::Severity;
use massline_tests::campaign::{self, THREE_BAR_TESTS};
use massline_virtual::bench::Bench;
use massline_virtual::bench::suspension::Suspension;

const SEED: u64 = 20_261_123;

fn long() -> bool {
    std::env::var_os("MASSLINE_LONG").is_some()
}

fn runs() -> u64 {
    let wanted = std::env::var("RUNS").ok().and_then(|runs| runs.parse().ok());
    wanted.unwrap_or(if long() { 200 } else { 4 })
}

type Change = fn(&mut Bench);

fn fault(bench: &mut Bench, text: &str) {
    bench.faults.push(text.parse().expect("is a fault"));
}

fn stiffer(bench: &mut Bench, factor: f64) {
    if let Suspension::Cords { cords, .. } = &mut bench.suspension {
        cords.iter_mut().for_each(|cord| {
            cord.axial_n_per_m *= factor;
        });
    }
}

const ALL: &[(&str, Change)] = &[
    ("none", |_| ()),
    ("forces of 12 to 40 N", |b| b.tap.force_n = [12.0, 40.0]),
    ("2 of 5 hits flat at 75 %", |b| b.operator.flat_rate = 0.4),
    ("compress:2y", |b| fault(b, "compress:2y")),
    ("compress:1z", |b| fault(b, "compress:1z")),
    ("rail:2z at 30 m/s²", |b| fault(b, "rail:2z:30")),
    ("free moment 4 mm, lateral 3 %", |b| {
        b.tap.free_moment_m = 0.004;
        b.tap.lateral = 0.03;
    }),
    ("all hits 5 mm beside", |b| b.tap.offset_m = 0.005),
    ("hammer 3 % low", |b| b.hammer.gain_error = -0.03),
    ("boards of 5 g", |b| b.sensor.board_mass_kg = 0.005),
    ("INL 3 LSB", |b| b.adc.inl_lsb = 3.0),
    ("bow 8 LSB", |b| b.adc.bow_lsb = 8.0),
    ("mains 5 mV", |b| b.mains.amplitude_v = 0.005),
    ("mains 60 Hz 5 mV", |b| {
        b.mains.amplitude_v = 0.005;
        b.mains.frequency_hz = 60.0;
    }),
    ("multiplexer memory 1 %", |b| b.adc.memory = 0.01),
    ("elastic mode 180 Hz", |b| {
        b.elastic[0].frequency_hz = 180.0;
        b.elastic[0].damping_ratio = 0.01;
    }),
    ("suspension × 12", |b| stiffer(b, 12.0)),
    ("suspension × 36", |b| stiffer(b, 36.0)),
    ("cable 400 N/m", |b| fault(b, "cable:2:400")),
    ("RC 15 %", |b| (b.sensor.rc_tolerance, b.hammer.rc_tolerance) = (0.05, 0.05)),
    ("no capacitors", |b| b.sensor.bandwidth_hz = Some([1600.0, 1600.0, 550.0])),
    ("drift, clock, jitter", |b| {
        b.sensor.drift_v_per_s = 0.01;
        b.adc.clock_error = 1e-4;
        b.adc.jitter_s = 5e-6;
    }),
];

fn layout(test: &str) -> TestLayout {
    let mut layout: TestLayout = campaign::layout_file(test).layout.cast().expect("fits the rig");
    (layout.hammer_gain, layout.calibrated_hammer) = (0.0, false);
    layout
}

fn measured(bench: &Bench, layout: &TestLayout) -> Vec<Run> {
    let calibration = nominal_calibration(bench);
    let study = MonteCarlo {
        bench,
        layout,
        calibration: &calibration,
        seed: SEED,
        runs: runs(),
        threads: None,
    };
    study.runs(&Interrupt::new(), |_| ()).expect("the bench takes the layout")
}

#[derive(Default)]
struct Row {
    shifts: f64,
    squares: f64,
    held: f64,
    numbers: f64,
    warned: u64,
    silent: u64,
    runs: u64,
    rejected: u64,
    codes: std::collections::BTreeMap<String, u64>,
}

impl Row {
    fn add(&mut self, run: &SimulatedTest, undisturbed: &SimulatedTest, truth: &[f64; 10]) {
        let (Some(best), Some(before)) = (run.estimates.first(), undisturbed.estimates.first())
        else {
            return;
        };
        let (sigma, half) = (best.sigma().unwrap(), best.half_widths().unwrap());
        let sigma_before = before.sigma().unwrap();
        let mut wrong = false;
        for k in 0..10 {
            let error = best.theta()[k] - truth[k];
            self.shifts += ((best.theta()[k] - before.theta()[k]) / sigma_before[k]).powi(2);
            self.squares += (error / sigma[k]).powi(2);
            self.held += f64::from(u8::from(error.abs() <= half[k]));
            self.numbers += 1.0;
            wrong |= error.abs() > 3.0 * sigma[k];
        }
        self.runs += 1;
        self.warned += u64::from(run.warns());
        self.silent += u64::from(wrong && !run.warns());
        self.rejected += u64::from(run.rejected);
        let mut of_run: Vec<String> = run
            .diagnostics
            .iter()
            .chain(&best.diagnostics)
            .filter(|d| d.severity >= Severity::Warning)
            .map(|d| d.code.name().to_string())
            .chain(run.hits.iter().filter(|(_, hit)| !hit.good).flat_map(|(_, hit)| {
                hit.findings
                    .iter()
                    .filter(|f| f.is_error())
                    .map(|f| format!("hit:{} {:?}", f.code.name(), f.subject))
                    .collect::<Vec<_>>()
            }))
            .collect();
        of_run.sort();
        of_run.dedup();
        for code in of_run {
            *self.codes.entry(code).or_default() += 1;
        }
    }
}

#[test]
fn each_disturbance_alone() {
    let healthy = || {
        let mut bench = Bench::named("default").expect("bundled");
        (bench.operator.too_weak_rate, bench.operator.too_hard_rate) = (0.0, 0.0);
        bench
    };
    let tests = [THREE_BAR_TESTS[0], THREE_BAR_TESTS[3]];
    let undisturbed: Vec<Vec<Run>> =
        tests.iter().map(|test| measured(&healthy(), &layout(test))).collect();
    println!(
        "| disturbance | shift, sd | z rms | coverage, % | warned, % | silent, % | rejected hits a run | why |"
    );
    let only = std::env::var("ONLY").unwrap_or_default();
    for (name, change) in ALL.iter().filter(|(name, _)| name.contains(&only)) {
        let mut bench = healthy();
        change(&mut bench);
        let truth: [f64; 10] = bench.truth().theta().into();
        let mut row = Row::default();
        for (test, before) in tests.iter().zip(&undisturbed) {
            let runs = measured(&bench, &layout(test));
            for (run, before) in runs.iter().zip(before) {
                if let (Ok(run), Ok(before)) = (run, before) {
                    row.add(run, before, &truth);
                }
            }
        }
        let rms = |sum: f64| (sum / row.numbers).sqrt();
        let percent = |count: u64| 100.0 * count as f64 / row.runs as f64;
        println!(
            "| {name} | {:.2} | {:.2} | {:.1} | {:.1} | {:.1} | {:.2} | {:?} |",
            rms(row.shifts),
            rms(row.squares),
            100.0 * row.held / row.numbers,
            percent(row.warned),
            percent(row.silent),
            row.rejected as f64 / row.runs as f64,
            row.codes,
        );
    }
}
