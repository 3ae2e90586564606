//! The work that is measured: the first test of the three-bar frame of the theory, section 11.

use cortex_m_rt::entry;
use massline_on_target::{Cost, end, measure};
use massline_protocol::crc32_of_chunks;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Rig;
use massline_shared::design::{FurtherHitSearch, HitCandidates, Precision};
use massline_shared::diagnosis::Code;
use massline_shared::identify::maximum_likelihood::{self, ErrorBudget, Fit, Start};
use massline_shared::identify::{
    DofMassLines, Estimate, Identification, IdentifySettings, MASS_LINE_METHODS, MassLines, Method,
    Observations, Progress, ScatterAccumulator,
};
use massline_shared::layout::{
    Axis, Dof, Hit, HitUncertainty, RIG_HITS, RIG_SENSORS, RigLayout, Sensor, Sign, Target,
};
use massline_shared::measurement::campaign::{self, Step};
use massline_shared::measurement::{Measurement, Memory, NextAction};
use massline_shared::responses::Responses;
use massline_shared::signal::self_test::SelfTest;
use massline_shared::signal::{
    AdcProperties, CHANNELS, Calibration, RECORD_SCANS, Record, RestStatistics, Scan,
};
use massline_shared::units::{Hertz, ScanIndex, Seconds, Volts};
use nalgebra::{ComplexField, SVector};

use super::outcome::{close, report};

const ADC: AdcProperties = AdcProperties {
    rate: Hertz(4000.0),
    channels: CHANNELS as u8,
    bits: 12,
    reference: Volts(3.0),
    channel_delay: Seconds(10e-6),
};

/// Mass lines of a rig's responses.
type Dofs = [DofMassLines<f32, Rig>];

#[entry]
fn main() -> ! {
    // The firmware stores this in statics; it is not part of the measured stack.
    let mut memory = Memory::<f32>::new();
    measure_a_dof(&mut memory);
    measure_a_hit_with_hum(&mut memory);
    let mut workspace = [0.0; maximum_likelihood::RIG_WORKSPACE];
    let layout = layout(3);
    let dofs = mass_lines_of(&layout, 3);
    let fitted = identify(&mut workspace, &layout, &dofs, Method::InertiaRestraint, None);
    report("irm_solve", fitted.whole);
    judge(&fitted.estimate, &body());
    for hits in [5, 9, RIG_HITS] {
        let fitted = fit(&mut workspace, hits, &displaced(hits));
        judge_fit(&fitted.estimate, &body());
        let learned = fitted.estimate.learned;
        assert!(learned.is_some_and(|budget| budget.constant_log_variance > 0.0), "{learned:?}");
        report(format_args!("ml_learn_{hits}"), fitted.whole);
        report(format_args!("ml_learn_step_{hits}"), fitted.longest);
    }
    report("further_hit_step_12", search_cost(&mut workspace));
    // The start when the inertia restraint method has no answer.
    let (budget, start) = (ErrorBudget::FirstOrder, Start::Crude);
    let fitted = fit_with(&mut workspace, &displaced(5), 5, budget, start);
    judge_fit(&fitted.estimate, &body());
    report("ml_crude_5", fitted.whole);
    // A hit 40 mm from its mark, ten times the error of a hand: data that contradict the error budget.
    let mut outlier = displaced(5);
    outlier.hits[2].position[1] += 0.04;
    let fitted = fit(&mut workspace, 5, &outlier);
    let diagnostics = &fitted.estimate.diagnostics;
    assert!(
        diagnostics.iter().any(|diagnostic| diagnostic.code == Code::DataInconsistentWithBudget),
        "{:?}",
        fitted.estimate
    );
    report("ml_outlier_5", fitted.whole);
    end(true)
}

/// One DOF with one hit, measured with the steps that the firmware drives.
fn measure_a_dof(memory: &mut Memory<f32>) {
    let mut rig = Measurement::new(ADC, memory);
    let check = || assert!(rig.check(&layout(RIG_HITS)).is_empty());
    report("layout_check", measure(check));
    let truth = hit_once(&mut rig, 0.0);
    assert_eq!(rig.next_action(), NextAction::Compute, "the record is whole");
    report("hit_grading", measure(|| rig.work()));
    assert!(rig.last_hit().is_some_and(|hit| hit.findings.is_empty()), "{:?}", rig.last_hit());
    report("record_checksum", measure(|| assert_ne!(checksum(rig.record()), 0)));
    let reading = measure(|| assert_eq!(RestStatistics::of(rig.record()).scans, 2048));
    report("rest_statistics", reading);
    let analysis = analyse(&mut rig);
    report("hit_analysis", analysis.whole());
    report("hit_step", analysis.longest);
    report("dof_closing", measure(|| rig.work()));
    assert_measured(&rig, &truth);
    // The last channel is compared with all others.
    let mut test = SelfTest::new(&ADC);
    report("self_test_channel", measure(|| rig.test_channel(&mut test, CHANNELS - 1)));
    assert!(test.channels()[CHANNELS - 1].level > 0.0);
}

/// One hit with hum of three harmonics in all ten channels.
fn measure_a_hit_with_hum(memory: &mut Memory<f32>) {
    let mut rig = Measurement::new(ADC, memory);
    // 5 mV.
    let truth = hit_once(&mut rig, 6.8);
    rig.work();
    assert!(rig.last_hit().is_some_and(|hit| hit.good), "{:?}", rig.last_hit());
    let analysis = analyse(&mut rig);
    report("hit_analysis_hum", analysis.whole());
    report("hit_step_hum", analysis.longest);
    rig.work();
    let has_diagnostic = |code| rig.result().diagnostics.iter().any(|d| d.code == code);
    assert!(has_diagnostic(Code::HumOf50Hz));
    assert_measured(&rig, &truth);
}

/// Hits the body once at the only DOF of a campaign, up to the whole record, with this amplitude of hum in every
/// channel, codes, and returns the accelerances.
fn hit_once(rig: &mut Measurement<'_, f32>, hum: f32) -> Responses<f32, Rig> {
    let mut layout = layout(3);
    layout.test.hits_per_dof = 1;
    let truth = accelerance(&layout, &body(), 0);
    rig.set_layout(layout);
    assert!(rig.start(campaign::Start::DEFAULT, false, true).is_ok());
    rig.sampling_started();
    for (index, scan) in (0..).zip(hit(&truth, hum)) {
        rig.feed(ScanIndex(index), &[scan]);
    }
    truth
}

fn assert_measured(rig: &Measurement<'_, f32>, truth: &Responses<f32, Rig>) {
    let result = rig.result();
    let [(0, lines)] = result.mass_lines else { panic!("the DOF has no mass lines") };
    // 12 bits over ±16 g, for a peak of a few m/s².
    let error = (&lines.accelerance - truth).largest();
    assert!(error <= 0.02 * truth.largest(), "{:?} instead of {truth:?}", lines.accelerance);
}

/// The steps of the analysis of the hit in the record; between two of them the rig handles everything else.
fn analyse(rig: &mut Measurement<'_, f32>) -> Costs {
    let mut analysis = Costs::default();
    while matches!(rig.campaign().map(|c| c.step()), Some(Step::Analyse { .. })) {
        analysis.add(measure(|| rig.work()));
    }
    analysis
}

/// The cost of work that is done in steps.
#[derive(Default)]
struct Costs {
    instructions: u32,
    /// The longest step, with the largest stack of any step.
    longest: Cost,
}

impl Costs {
    fn add(&mut self, part: Cost) {
        self.instructions += part.instructions;
        self.longest.instructions = self.longest.instructions.max(part.instructions);
        self.longest.stack = self.longest.stack.max(part.stack);
    }

    /// Sum of all instructions, with the largest stack of any step.
    fn whole(&self) -> Cost {
        Cost { instructions: self.instructions, ..self.longest }
    }
}

/// A fit and what it cost.
struct CostedFit {
    estimate: Estimate<f32>,
    /// All instructions, with the largest stack.
    whole: Cost,
    /// The longest step.
    longest: Cost,
}

/// The layout with displaced sensors and hits, so that a fit has something to correct.
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

/// Maximum likelihood with `hits` hit DOFs on the mass lines of the layout `is`, started from the answer
/// of the inertia restraint method, as on the rig.
fn fit(workspace: &mut [f32], hits: usize, is: &RigLayout) -> CostedFit {
    let (layout, dofs) = (layout(hits), turned(mass_lines_of(is, hits)));
    let start = identify(workspace, &layout, &dofs, Method::InertiaRestraint, None).estimate;
    identify(workspace, &layout, &dofs, Method::MaximumLikelihood, Some(&start))
}

/// The longest step of the search for the hit that helps most, with the largest number of DOFs: all but one are
/// measured.
fn search_cost(workspace: &mut [f32]) -> Cost {
    let measured = RIG_HITS - 1;
    let fitted = fit(workspace, measured, &displaced(measured));
    let (layout, dofs) = (layout(RIG_HITS), turned(mass_lines_of(&displaced(measured), measured)));
    let estimates = [fitted.estimate];
    let length = layout.characteristic_length();
    let precision =
        Precision::of(&estimates, Target { mass: Some(1e-3), ..Target::default() }, length);
    let Some(precision) = precision else { panic!("the fit has intervals") };
    let [best] = &estimates;
    let candidates = HitCandidates::Following;
    let mut search =
        FurtherHitSearch::new(&precision, best, &dofs, layout.sensors.len(), candidates);
    let (mut costs, mut progress) = (Costs::default(), Progress::Going);
    while progress == Progress::Going {
        costs.add(measure(|| progress = search.step(&layout, &dofs, workspace)));
    }
    costs.longest
}

/// Runs a method through the common interface, started from another method's answer when there is one.
fn identify(
    workspace: &mut [f32],
    layout: &RigLayout,
    dofs: &Dofs,
    method: Method,
    start: Option<&Estimate<f32>>,
) -> CostedFit {
    let observed = Observations::of_mass_lines(layout, dofs);
    let mut identification: Identification<_, MASS_LINE_METHODS> = Identification::idle();
    identification.begin([method]);
    if let Some(start) = start {
        identification.start_from(start.clone());
    }
    let (mut costs, mut progress) = (Costs::default(), Progress::Going);
    while progress == Progress::Going {
        let step =
            || progress = identification.step(&observed, &IdentifySettings::default(), workspace);
        costs.add(measure(step));
    }
    let answer = identification.estimates().iter().find(|estimate| estimate.method == method);
    let Some(estimate) = answer else { panic!("no answer: {:?}", identification.refusals()) };
    CostedFit { estimate: estimate.clone(), whole: costs.whole(), longest: costs.longest }
}

/// Maximum likelihood with this error budget and start.
fn fit_with(
    workspace: &mut [f32],
    is: &RigLayout,
    hits: usize,
    budget: ErrorBudget,
    start: Start<'_, f32>,
) -> CostedFit {
    let (layout, dofs) = (layout(hits), turned(mass_lines_of(is, hits)));
    let mut costs = Costs::default();
    let mut fit = None;
    costs.add(measure(|| fit = Some(Fit::start(&layout, &dofs, start, budget))));
    let Some(Ok(mut fit)) = fit else { panic!("the fit did not start") };
    let mut progress = Ok(Progress::Going);
    while progress == Ok(Progress::Going) {
        costs.add(measure(|| progress = fit.step(&layout, &dofs, workspace)));
    }
    assert!(progress.is_ok(), "the fit did not converge: {progress:?}");
    let (mut estimate, mut fit) = (None, Some(fit));
    costs.add(measure(|| estimate = fit.take().map(|mut fit| fit.answer(&layout, workspace))));
    let Some(Ok(estimate)) = estimate else { panic!("the fit has no answer") };
    CostedFit { estimate, whole: costs.whole(), longest: costs.longest }
}

/// The mass lines of the layout `is` at its first hit DOFs.
fn mass_lines_of(is: &RigLayout, hits: usize) -> DofList {
    let body = body();
    (0..hits).map(|dof| (dof, mass_lines(&accelerance(is, &body, dof)))).collect()
}

type DofList = heapless::Vec<DofMassLines<f32, Rig>, RIG_HITS>;

/// The mass lines with hits and marks that turn as the budget states: along its direction a force is on average
/// weaker, by half the squares of its turns about two axes each.
fn turned(mut dofs: DofList) -> DofList {
    let HitUncertainty { direction, node_direction, .. } = HitUncertainty::<f32>::default();
    for (_, lines) in &mut dofs {
        lines.accelerance *= 1.0 - direction * direction - node_direction * node_direction;
    }
    dofs
}

/// The displacements are within the stated budget, so the errors must be within three of its standard deviations;
/// the learned ones are smaller, because there are no other errors.
fn judge_fit(estimate: &Estimate<f32>, body: &RigidBody<f32>) {
    let learned = estimate.learned.map_or(1.0, |learned| learned.scales.constant);
    let within = estimate.sigma().map(|sigma| sigma * (3.0 / learned.min(1.0)));
    let error = (estimate.theta() - body.theta()).abs();
    assert!(within.is_some_and(|within| error <= within), "the fit is {error} off");
}

/// The checksum that the rig reports to a host that asks for the record.
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

/// Scans with a tap of 5 ms and 20 N on a free body; every channel is sampled after the one before it, and hums at
/// 50.1 Hz with this amplitude, codes, with half of it at twice and a quarter at three times that.
fn hit(accelerance: &Responses<f32, Rig>, hum: f32) -> impl Iterator<Item = Scan> {
    const TAP: f32 = 20.0;
    /// Long enough for the trigger to measure the rest level.
    const QUIET: usize = 200;
    let calibration = Calibration::default();
    (0..QUIET + RECORD_SCANS).map(move |n| {
        core::array::from_fn(|channel| {
            let delay = channel as f32 * ADC.channel_delay.0 * ADC.rate.0;
            let phase = (n as f32 + delay - QUIET as f32) / TAP;
            let touching = (0.0..1.0).contains(&phase);
            let force = if touching { 20.0 * (core::f32::consts::PI * phase).sin() } else { 0.0 };
            let value = channel.checked_sub(1).map_or(force, |k| force * accelerance[k]);
            let code = value / calibration.per_code(&ADC, channel);
            let zero = calibration.channels[channel].zero.0 / ADC.volts_per_code();
            let turn = |harmonic: f32| {
                if hum == 0.0 {
                    return 0.0;
                }
                let turns = harmonic * 50.1 * (n as f32 + delay) / ADC.rate.0;
                (core::f32::consts::TAU * turns).cos()
            };
            let hum = hum * (turn(1.0) + 0.5 * turn(2.0) + 0.25 * turn(3.0));
            (code + hum + zero + 0.5) as u16
        })
    })
}

/// Three hits of different force with a scatter of about one percent, so that there is a covariance and a trend to
/// compute.
fn mass_lines(truth: &Responses<f32, Rig>) -> MassLines<f32, Rig> {
    let mut hits = ScatterAccumulator::new(RIG_SENSORS);
    for hit in 0..3 {
        let read = Responses::from_fn(RIG_SENSORS, |response| {
            truth[response] + 0.005 * ((hit * 5 + response * 3) % 7) as f32 - 0.015
        });
        let force = 15.0 + 2.0 * hit as f32;
        hits.add(&read, Some(force * force));
    }
    hits.mass_lines_at(truth.clone()).with_noise(Responses::repeat(RIG_SENSORS, 0.005))
}

fn accelerance(layout: &RigLayout, body: &RigidBody<f32>, dof: usize) -> Responses<f32, Rig> {
    layout.accelerance(body, dof).expect("the body has inertia and the layout this hit")
}

fn body() -> RigidBody<f32> {
    RigidBody::from_theta(&SVector::from([
        1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
    ]))
}

/// The frame with the first `hits` hit DOFs: those of its first test, then others.
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
    // Tolerance: single precision with a condition number of about 20.
    close("properties", &estimate.theta(), &body.theta(), 1e-4);
    assert!(estimate.covariance.is_some(), "the scatter of three hits gives a covariance");
}
