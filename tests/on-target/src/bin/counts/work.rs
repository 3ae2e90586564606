//! The work that is measured: the first test of the three-bar frame of the theory, section 11.

use core::fmt;
use massline_shared::signal::StaticReading;

use cortex_m_rt::entry;
use massline_on_target::{Measured, end, measure, print};
use massline_protocol::crc32_of_chunks;
use massline_shared::Responses;
use massline_shared::body::RigidBody;
use massline_shared::identify::inertia_restraint::{self, Settings};
use massline_shared::identify::maximum_likelihood::{CONTRADICTION, Fit, Start};
use massline_shared::identify::{
    Applicability, DofMassLines, Estimate, MassLines, Method, Methods, Progress, ScatterAccumulator,
};
use massline_shared::layout::{
    Axis, Dof, Hit, RIG_HITS, RIG_SENSORS, RigLayout, Sensor, Sign, TestSettings,
};
use massline_shared::mass_line::BasisRow;
use massline_shared::measurement::averaging::{
    DofSpectra, HitInHand, HitMemory, ProcessingSettings, band_of, fit_responses,
};
use massline_shared::signal::{
    AdcProperties, CHANNELS, Calibration, FftError, HitReport, PRE_TRIGGER_SCANS, RECORD_SCANS,
    RESPONSES, Record, SPECTRUM_LINES, grade,
};
use massline_shared::units::{Hertz, Seconds, Volts};
use nalgebra::{Complex, ComplexField, SMatrix, SVector};

const ADC: AdcProperties = AdcProperties {
    rate: Hertz(4000.0),
    channels: CHANNELS as u8,
    bits: 12,
    reference: Volts(3.0),
    channel_delay: Seconds(10e-6),
};
/// What the nine responses read.
type Readings = Responses<f32, RIG_SENSORS>;

const ZERO: Complex<f32> = Complex { re: 0.0, im: 0.0 };

/// What the firmware keeps in statics; it is not part of the stack that is measured.
struct Memory {
    record: Record,
    spectra: DofSpectra<f32>,
    scratch: [f32; RECORD_SCANS],
    force: [Complex<f32>; SPECTRUM_LINES],
    basis: [BasisRow<f32>; SPECTRUM_LINES],
}

#[entry]
fn main() -> ! {
    let mut memory = Memory {
        record: Record::new(),
        spectra: DofSpectra::<f32>::new(),
        scratch: [0.0; RECORD_SCANS],
        force: [ZERO; SPECTRUM_LINES],
        basis: [BasisRow::default(); SPECTRUM_LINES],
    };
    let layout = layout(3);
    let body = body();

    let methods: Methods = Method::of_mass_lines().collect();
    let check = || Applicability::new(&self::layout(RIG_HITS), &body, &methods);
    say("layout_check", measure(|| assert!(check().diagnostics.is_empty())));

    let truth = accelerance(&layout, &body, 0);
    record_a_hit(&mut memory.record, &truth);
    let test = TestSettings::<f32>::default();
    let mut report = HitReport::default();
    let measured = measure(|| {
        report = grade(&memory.record, &ADC, &Calibration::default(), &test, None);
    });
    say("hit_grading", measured);
    assert!(report.findings.is_empty());
    say("record_checksum", measure(|| assert_ne!(checksum(&memory.record), 0)));
    let reading = measure(|| assert_eq!(StaticReading::of(&memory.record).scans, 2048));
    say("static_reading", reading);
    let mut single = None;
    let measured = measure(|| single = Some(analyse(&mut memory, |step| step())));
    say("hit_analysis", measured);
    // Once more, step by step: between two of them the rig looks after everything else.
    let mut longest = measure(|| ());
    let again = analyse(&mut memory, |step| {
        let measured = measure(step);
        longest.instructions = longest.instructions.max(measured.instructions);
        longest.stack = longest.stack.max(measured.stack);
    });
    assert!(again.is_ok());
    say("hit_step", longest);
    let closed = measure(|| assert!(close_dof(&mut memory)));
    say("dof_closing", closed);
    let Some(Ok(Some(single))) = single else { panic!("the hit was not analysed") };
    // 12 bits of 16 g over a peak of a few m/s².
    close("mass line", &single, &truth, 0.02);

    let dofs = [0, 1, 2].map(|dof| (dof, mass_lines(&accelerance(&layout, &body, dof))));
    let mut estimate = None;
    let measured = measure(|| {
        estimate = Some(inertia_restraint::solve(&layout, &dofs, Settings::weighted()));
    });
    say("irm_solve", measured);
    let Some(Ok(estimate)) = estimate else { panic!("the ten properties were not found") };
    judge(&estimate, &body);
    for hits in [5, 9, RIG_HITS] {
        let fitted = fit(&mut memory.scratch, hits, &displaced(hits), Start::InertiaRestraint);
        judge_fit(&fitted.estimate, &body);
        say(format_args!("ml_solve_{hits}"), fitted.whole);
        say(format_args!("ml_step_{hits}"), fitted.longest);
    }
    // Where the inertia restraint method has no answer.
    let fitted = fit(&mut memory.scratch, 5, &displaced(5), Start::Crude);
    judge_fit(&fitted.estimate, &body);
    say("ml_crude_5", fitted.whole);
    // A hit at the wrong place, ten times what a hand misses by: data that contradict the budget.
    let mut astray = displaced(5);
    astray.hits[2].position[1] += 0.04;
    let fitted = fit(&mut memory.scratch, 5, &astray, Start::InertiaRestraint);
    let surprise = fitted.estimate.consistency.map(|c| c.surprise());
    assert!(surprise.is_some_and(|s| s > CONTRADICTION as f32), "{surprise:?}");
    say("ml_astray_5", fitted.whole);
    end(true)
}

/// A fit and what it cost.
struct Fitted {
    estimate: Estimate<f32>,
    /// All instructions, largest stack.
    whole: Measured,
    /// The longest step.
    longest: Measured,
}

/// The layout with sensors and hits that are not where it says, so that a fit has something to do.
fn displaced(hits: usize) -> RigLayout {
    let mut layout = layout(hits);
    for (i, sensor) in layout.sensors.iter_mut().enumerate() {
        sensor.position[i] += 0.001;
    }
    for (j, hit) in layout.hits.iter_mut().enumerate() {
        hit.position[j % 3] += 0.002;
    }
    layout
}

/// Maximum likelihood with so many hit DOFs on what is measured with the layout `is`.
fn fit(workspace: &mut [f32], hits: usize, is: &RigLayout, start: Start<'_, f32>) -> Fitted {
    let layout = layout(hits);
    let body = body();
    let all: [DofMassLines<f32, RIG_SENSORS>; RIG_HITS] = core::array::from_fn(|dof| {
        (dof, mass_lines(&accelerance(is, &body, dof.min(hits - 1))))
    });
    let dofs = &all[..hits];
    // As on the rig, the answer of the inertia restraint method is there before the fit begins.
    let restraint = match start {
        Start::InertiaRestraint => {
            inertia_restraint::solve(&layout, dofs, Settings::weighted()).ok()
        }
        _ => None,
    };
    let start = restraint.as_ref().map_or(start, |estimate| Start::At(&estimate.body));
    let mut fit = None;
    let started = measure(|| fit = Some(Fit::start(&layout, dofs, start)));
    let Some(Ok(mut fit)) = fit else { panic!("the fit did not start") };
    let (mut instructions, mut longest) = (started.instructions, started);
    let mut add = |part: Measured| {
        instructions += part.instructions;
        longest.instructions = longest.instructions.max(part.instructions);
        longest.stack = longest.stack.max(part.stack);
    };
    let mut progress = Ok(Progress::Going);
    while progress == Ok(Progress::Going) {
        add(measure(|| progress = fit.step(&layout, dofs, workspace)));
    }
    assert!(progress.is_ok(), "the fit did not settle: {progress:?}");
    let mut estimate = None;
    add(measure(|| estimate = Some(fit.answer(&layout, dofs, workspace))));
    let Some(Ok(estimate)) = estimate else { panic!("the fit has no answer") };
    Fitted { estimate, whole: Measured { instructions, ..longest }, longest }
}

/// The displacements are within the budget, so the answer lies within three of its deviations.
fn judge_fit(estimate: &Estimate<f32>, body: &RigidBody<f32>) {
    let within = estimate.sigma().map(|sigma| sigma * 3.0);
    let error = (estimate.theta() - body.theta()).abs();
    assert!(within.is_some_and(|within| error <= within), "the fit is {error} off");
}

/// As the firmware does with a hit; `run` runs each of its steps.
fn analyse(
    memory: &mut Memory,
    mut run: impl FnMut(&mut dyn FnMut()),
) -> Result<Option<Readings>, FftError> {
    let Memory { record, spectra, scratch, force, basis } = memory;
    let (calibration, test) = (Calibration::default(), TestSettings::<f32>::default());
    let settings = ProcessingSettings { adc: &ADC, calibration: &calibration, test: &test };
    let mut hit = None;
    run(&mut || {
        let memory = HitMemory { scratch, force, basis };
        hit = Some(HitInHand::begin(settings, record, memory, spectra));
    });
    let Some(hit) = hit else { panic!("the step was not run") };
    let mut hit = hit?;
    for response in 0..RESPONSES {
        let mut done = Ok(());
        run(&mut || {
            let memory = HitMemory { scratch, force, basis };
            done = hit.add_response(response, record, memory, spectra);
        });
        done?;
    }
    let mut own = None;
    run(&mut || own = hit.mass_lines(&calibration));
    Ok(own)
}

/// As the firmware closes a DOF; true when it has mass lines.
fn close_dof(memory: &mut Memory) -> bool {
    let Memory { spectra, scratch, basis, .. } = memory;
    let (calibration, test) = (Calibration::default(), TestSettings::<f32>::default());
    let settings = ProcessingSettings { adc: &ADC, calibration: &calibration, test: &test };
    let band = band_of(settings, spectra, &mut scratch[..SPECTRUM_LINES]);
    let band = band.unwrap_or(TestSettings::<f32>::usual_band());
    fit_responses(settings, spectra, band, basis).is_ok()
}

/// What the rig tells a host that asks for the record.
fn checksum(record: &Record) -> u32 {
    let (mut crc, mut piece, mut at) = (crc32_of_chunks(), [0; 4 * Record::SCAN_BYTES], 0);
    loop {
        let read = record.read_bytes(at, &mut piece);
        if read == 0 {
            return crc.finalize();
        }
        crc.update(&piece[..read]);
        at += read;
    }
}

/// A tap of 5 ms and 20 N on a body that nothing holds; every channel is read after the one before.
fn record_a_hit(record: &mut Record, accelerance: &Readings) {
    const TAP: f32 = 20.0;
    let calibration = Calibration::default();
    for n in 0..RECORD_SCANS {
        record.push(&core::array::from_fn(|channel| {
            let delay = channel as f32 * ADC.channel_delay.0 * ADC.rate.0;
            let phase = (n as f32 + delay - PRE_TRIGGER_SCANS as f32) / TAP;
            let touching = (0.0..1.0).contains(&phase);
            let force = if touching { 20.0 * (core::f32::consts::PI * phase).sin() } else { 0.0 };
            let value = channel.checked_sub(1).map_or(force, |k| force * accelerance[k]);
            let code = value / calibration.per_code(&ADC, channel);
            let zero = calibration.channels[channel].zero.0 / ADC.volts_per_code();
            (code + zero + 0.5) as u16
        }));
    }
}

/// Three hits with a scatter of about a percent, so that there is a covariance to compute.
fn mass_lines(truth: &Readings) -> MassLines<f32, RIG_SENSORS> {
    let mut hits = ScatterAccumulator::new();
    for hit in 0..3 {
        hits.add(&Readings::from_fn(|axis, sensor| {
            let response = 3 * sensor + axis;
            truth[response] + 0.005 * ((hit * 5 + response * 3) % 7) as f32 - 0.015
        }));
    }
    let mut lines = hits.mass_lines_at(*truth);
    lines.noise.fill(0.005);
    lines
}

fn accelerance(layout: &RigLayout, body: &RigidBody<f32>, dof: usize) -> Readings {
    layout.accelerance(body, dof).expect("the body has inertia and the layout this hit")
}

fn body() -> RigidBody<f32> {
    RigidBody::from_theta(&SVector::from([
        1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
    ]))
}

/// The frame with the first of its hit DOFs: those of its first test, then others.
fn layout(hits: usize) -> RigLayout {
    const NODES: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [0.20785, -0.19902, 0.0], [0.20785, 0.0, 0.0]];
    const FREE_END: [f32; 3] = [0.20785, -0.19902, 0.14913];
    const AXES: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let sensor = |node: usize| Sensor::new(node as u16 + 1, NODES[node], AXES);
    let hit = |node, axis, position, direction| {
        Hit::new(Dof { node, axis, sign: Sign::Plus }, position, direction)
    };
    RigLayout {
        gravity: Some([0.0, 0.0, -9.80665]),
        sensors: (0..3).map(sensor).collect(),
        hits: [
            hit(1, Axis::Y, NODES[0], AXES[1]),
            hit(2, Axis::Z, NODES[1], AXES[2]),
            hit(4, Axis::X, FREE_END, AXES[0]),
            hit(4, Axis::Y, FREE_END, AXES[1]),
            hit(1, Axis::Z, NODES[0], AXES[2]),
            hit(3, Axis::Y, NODES[2], AXES[1]),
            hit(2, Axis::X, NODES[1], AXES[0]),
            hit(3, Axis::Z, NODES[2], AXES[2]),
            hit(1, Axis::X, NODES[0], AXES[0]),
            hit(4, Axis::Z, FREE_END, AXES[2]),
            hit(2, Axis::Y, NODES[1], AXES[1]),
            hit(3, Axis::X, NODES[2], AXES[0]),
        ]
        .into_iter()
        .take(hits)
        .collect(),
        ..RigLayout::default()
    }
}

fn judge(estimate: &Estimate<f32>, body: &RigidBody<f32>) {
    // Single precision over a condition of about 20.
    close("properties", &estimate.theta(), &body.theta(), 1e-4);
    assert!(estimate.covariance.is_some(), "the scatter of three hits gives a covariance");
}

fn close<const M: usize, const N: usize>(
    what: &str,
    got: &SMatrix<f32, M, N>,
    truth: &SMatrix<f32, M, N>,
    part: f32,
) {
    let error = (got - truth).amax();
    assert!(error <= part * truth.amax(), "{what}: {got} instead of {truth}");
}

fn say(name: impl fmt::Display, measured: Measured) {
    print(format_args!("{name}_instructions {}", measured.instructions));
    print(format_args!("{name}_stack {}", measured.stack));
}
