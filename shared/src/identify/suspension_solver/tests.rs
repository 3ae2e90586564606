//! The wheel, solved in steps as on a rig, against the computation with full memory in double precision.

use nalgebra::{Complex, SVector};
use std::vec;
use std::vec::Vec;

use super::super::suspension::{SuspensionFit, judged_estimate, mode_findings};
use super::*;
use crate::body::{RigidBody, scale};
use crate::diagnosis::Code;
use crate::frequency_responses::FrequencyResponses;
use crate::identify::agreement::{Agreement, Answers, Propagation, ask, changes};
use crate::identify::dppim::worse_form;
use crate::identify::global_fit::tests::wheel::{self, NOISE, Object, Random};
use crate::identify::{Estimate, Method, Perturbation};
use crate::layout::Hit;
use crate::modes::Reduction;

type C = Complex<f64>;

/// The grid of a rig: records of 10.24 s after the decimation to 50 Hz.
const GRID: LineGrid<f64> =
    LineGrid { resolution_hz: 50.0 / 512.0, band_hz: [0.5, 12.5], decay: 0.0, correlation: 1.0 };

/// The wheel with three sensors and five hits.
fn layout() -> RigLayout<f64> {
    wheel::layout().cast().unwrap()
}

/// The wheel with eight hits, which are mixed to six forces.
fn with_more_hits() -> RigLayout<f64> {
    let mut layout = layout();
    for (position, direction) in [
        ([0.1, 0.25, -0.05], [0.0, 0.0, 1.0]),
        ([0.2, 0.0, 0.1], [0.0, -1.0, 0.0]),
        ([0.0, 0.2, -0.1], [1.0, 0.0, 0.0]),
    ] {
        layout.hits.push(Hit::new("102:+X".parse().unwrap(), position, direction)).unwrap();
    }
    layout
}

/// Responses of a test.
struct Test {
    layout: RigLayout<f64>,
    grid: LineGrid<f64>,
    /// Frequencies of the lines that are used, Hz.
    frequencies: Vec<f64>,
    /// `[line][channel][hit]`.
    data: Vec<C>,
}

impl Test {
    /// Of the wheel.
    fn new(layout: RigLayout<f64>, grid: LineGrid<f64>, seed: u64) -> Self {
        let frequencies: Vec<f64> = (0..grid.count())
            .map(|line| grid.resolution_hz * (grid.first() + line) as f64)
            .collect();
        let object = Object::new(0.0);
        let data = wheel::measure(&layout, &object, &frequencies, NOISE, &mut Random(seed));
        Self { layout, grid, frequencies, data }
    }

    fn readings(&self) -> FrequencyResponses<'_, f64> {
        let (channels, hits) = (3 * self.layout.sensors.len(), self.layout.hits.len());
        FrequencyResponses::new(&self.frequencies, &self.data, channels, hits).unwrap()
    }

    /// The same with only these hits.
    fn only(&self, dofs: &[usize]) -> Self {
        let hits = self.layout.hits.len();
        let mut layout = self.layout.clone();
        layout.hits = dofs.iter().map(|dof| self.layout.hits[*dof]).collect();
        let rows = self.data.chunks_exact(hits);
        let data = rows.flat_map(|row| dofs.iter().map(|dof| row[*dof])).collect();
        Self { layout, grid: self.grid, frequencies: self.frequencies.clone(), data }
    }

    /// A rig that has solved it, with these hit DOFs measured, as far as `until`.
    fn on_rig<R: Real>(
        &self,
        dofs: &[usize],
        until: impl Fn(&SuspensionSolver<R>) -> bool,
    ) -> Result<Rig<R>, Diagnostics> {
        Ok(Rig::new(&self.layout, self.grid, dofs)?.run(&self.data, until))
    }
}

/// A rig's solver and its memory.
struct Rig<R> {
    solver: SuspensionSolver<R>,
    layout: RigLayout<R>,
    codes: Vec<u16>,
    scratch: Vec<R>,
    readings: Vec<Complex<R>>,
    weights: Vec<R>,
    lines: Vec<Complex<R>>,
    steps: u32,
}

impl<R: Real> Rig<R> {
    fn new(
        layout: &RigLayout<f64>,
        grid: LineGrid<f64>,
        dofs: &[usize],
    ) -> Result<Self, Diagnostics> {
        let layout = layout.cast().unwrap();
        let LineGrid { resolution_hz, band_hz, decay, correlation } = grid;
        let grid = LineGrid {
            resolution_hz: R::of(resolution_hz),
            band_hz: band_hz.map(R::of),
            decay: R::of(decay),
            correlation: R::of(correlation),
        };
        let zero = Complex::new(R::zero(), R::zero());
        let mut solver = SuspensionSolver::idle();
        solver.begin(&layout, grid, dofs);
        if solver.has_failed() {
            return Err(solver.diagnostics().clone());
        }
        Ok(Self {
            solver,
            layout,
            codes: vec![0xA5A5; 2 * CompactMotions::<R>::CODES],
            // Memory that others have used before.
            scratch: vec![R::of(7.0); SEARCH_MEMORY],
            readings: vec![zero; READINGS],
            weights: vec![R::of(7.0); WEIGHTS],
            lines: vec![zero; MOST_LINES],
            steps: 0,
        })
    }

    /// Solves these responses of all hits of the layout; stops early when `until` holds.
    fn run(mut self, data: &[C], until: impl Fn(&SuspensionSolver<R>) -> bool) -> Self {
        let (hits, channels) = (self.layout.hits.len(), 3 * self.layout.sensors.len());
        let Self { solver, layout, codes, scratch, readings, weights, lines, steps } = &mut self;
        let mut memory = SolverMemory { codes, scratch, readings, weights, lines };
        let mut shown = 0.0;
        loop {
            if let Some((dof, channel)) = solver.wants() {
                let nothing = Complex::new(R::zero(), R::zero());
                let mut all = vec![nothing; solver.grid.first()];
                all.extend((0..solver.grid.count()).map(|line| {
                    let value = data[(line * channels + channel) * hits + dof];
                    Complex::new(R::of(value.re), R::of(value.im))
                }));
                solver.take(layout, &all, &mut memory);
                continue;
            }
            *steps += 1;
            let progress = solver.step(layout, &mut memory);
            assert!(solver.completed() >= shown, "{} after {shown}", solver.completed());
            shown = solver.completed();
            if progress == Progress::Done || until(solver) {
                return self;
            }
        }
    }

    /// The estimates of all methods, and how they agree.
    fn results(&mut self) -> (Vec<Option<Estimate<f64>>>, Option<Agreement<R>>) {
        let Self { solver, layout, codes, scratch, readings, weights, lines, .. } = self;
        let memory = SolverMemory { codes, scratch, readings, weights, lines };
        let estimates = Method::of_modes()
            .map(|method| Some(solver.estimate(method, layout, &memory)?.ok()?.cast()))
            .collect();
        (estimates, solver.agreement().cloned())
    }
}

/// What the computation with full memory finds.
struct Full {
    estimates: Vec<Option<Estimate<f64>>>,
    agreement: Option<Agreement<f64>>,
    modes: Vec<(f64, f64)>,
}

/// All methods by [`SuspensionFit`], as a program on a host asks them.
fn in_full(layout: &RigLayout<f64>, readings: &FrequencyResponses<'_, f64>) -> Full {
    let mut memory = Reduction::new();
    let fit = SuspensionFit::new(layout, readings, &mut memory).unwrap();
    let methods: Vec<Method> = Method::of_modes().collect();
    let mut answers: Vec<_> = methods
        .iter()
        .map(|method| fit.answer(*method, layout, &memory, fit.modes()).ok())
        .collect();
    let misfit = |place: usize| answers[place].and_then(|answer| answer.misfit);
    let places =
        [Method::Dppim, Method::DppimStructural].map(|of| methods.iter().position(|m| *m == of));
    let pair = misfit(places[0].unwrap()).zip(misfit(places[1].unwrap()));
    if let Some((worse, ..)) = pair.and_then(|(viscous, other)| worse_form(viscous, other)) {
        answers[methods.iter().position(|method| *method == worse).unwrap()] = None;
    }
    let asked = (0..changes(layout)).map(|change| {
        ask(layout, change, |changed| -> Answers<f64, SUSPENSION_METHODS> {
            let modes = fit.changed(changed, &mut memory);
            core::array::from_fn(|place| {
                answers[place]?;
                let found = fit.answer(methods[place], changed.layout, &memory, modes.as_ref()?);
                Some(found.ok()?.body.theta())
            })
        })
    });
    let propagation = Propagation::of(asked);
    let estimates: Vec<_> = (0..methods.len())
        .map(|place| {
            let length = layout.characteristic_length();
            let answer = answers[place]?;
            judged_estimate(methods[place], &answer, place, &propagation, length).ok()
        })
        .collect();
    let thetas: Vec<Option<SVector<f64, 10>>> =
        estimates.iter().map(|e| e.as_ref().map(Estimate::theta)).collect();
    Full {
        agreement: Agreement::of(&thetas, &propagation),
        estimates,
        modes: fit.modes().modes.iter().map(|m| (m.frequency_hz, m.damping_ratio)).collect(),
    }
}

/// The largest difference of two answers in standard deviations of the second, and the range of the ratios of their standard
/// deviations.
fn compare(rig: &Estimate<f64>, full: &Estimate<f64>) -> (f64, [f64; 2]) {
    let (sigma, of_full) = (rig.sigma().unwrap(), full.sigma().unwrap());
    let distance = (rig.theta() - full.theta()).component_div(&of_full).abs().max();
    let ratios = sigma.component_div(&of_full);
    (distance, [ratios.min(), ratios.max()])
}

#[test]
fn a_rig_finds_what_the_full_computation_finds() {
    let test = Test::new(layout(), GRID, 88_172_645_463_325_252);
    let full = in_full(&test.layout, &test.readings());
    let mut rig = test.on_rig::<f32>(&[0, 1, 2, 3, 4], |_| false).unwrap();
    assert!(!rig.solver.has_failed(), "{:?}", rig.solver.diagnostics());
    assert_eq!(rig.solver.modes().len(), full.modes.len());
    for (mode, (frequency, damping)) in rig.solver.modes().iter().zip(&full.modes) {
        // Noise moves the frequencies by 1e-4 and the damping by 1e-2 of themselves, twenty times more than 16 bits do.
        assert!((f64::from(mode.frequency_hz) / frequency - 1.0).abs() < 5e-6);
        assert!((f64::from(mode.damping_ratio) / damping - 1.0).abs() < 5e-4);
    }
    let (estimates, agreement) = rig.results();
    for (rig, full) in estimates.iter().zip(&full.estimates) {
        assert_eq!(rig.is_some(), full.is_some());
        let Some((rig, full)) = rig.as_ref().zip(full.as_ref()) else { continue };
        let (distance, ratios) = compare(rig, full);
        // What the rig may differ by; it does so by 0.005.
        assert!(distance < 0.05, "{:?} {distance}", full.method);
        // Half as many draws make this difference; with the same draws the 16 bits and the readings that are predicted
        // make 0.4 %.
        assert!(ratios[0] > 0.95 && ratios[1] < 1.05, "{:?} {ratios:?}", full.method);
    }
    let (rig, full) = (agreement.unwrap(), full.agreement.unwrap());
    assert_eq!(rig.outliers, full.outliers);
    for k in 0..10 {
        let sigma = full.covariance[(k, k)].sqrt();
        assert!((f64::from(rig.theta[k]) - full.theta[k]).abs() < 0.05 * sigma, "{k}");
        assert!((f64::from(rig.covariance[(k, k)].sqrt()) / sigma - 1.0).abs() < 0.05, "{k}");
    }
}

/// The modes, the answers and the refusals of a test as a rig and as the full computation find them.
fn agrees_with_full(test: &Test, dofs: &[usize]) -> Vec<Option<Code>> {
    let rig = test.on_rig::<f32>(dofs, |solver| !solver.unanswered()).unwrap();
    let part = test.only(dofs);
    let readings = part.readings();
    let mut memory = Reduction::new();
    let fit = match SuspensionFit::new(&part.layout, &readings, &mut memory) {
        Ok(fit) => fit,
        Err(reasons) => {
            let codes = |of: &Diagnostics| of.iter().map(|d| d.code).collect::<Vec<_>>();
            assert_eq!(codes(rig.solver.diagnostics()), codes(&reasons));
            return reasons.iter().map(|d| Some(d.code)).collect();
        }
    };
    assert!(!rig.solver.has_failed(), "{:?}", rig.solver.diagnostics());
    let order = fit.orders().sufficient().unwrap();
    assert_eq!(rig.solver.fit.poles.len(), order.poles.len());
    assert_eq!(rig.solver.modes().len(), fit.modes().modes.len());
    let codes = |all: &Diagnostics| all.iter().map(|d| (d.code, d.subject)).collect::<Vec<_>>();
    let findings = mode_findings(fit.modes(), &memory.responses());
    let mut expected = codes(&findings);
    expected.extend(fit.one_more().map(|d| (d.code, d.subject)));
    assert_eq!(codes(rig.solver.diagnostics()), expected);
    let scale = scale(17.0, part.layout.characteristic_length());
    let mut of_draw = Reduction::new();
    let drawn = Perturbation { layout: &part.layout, quantity: None, draw: Some(0) };
    let modes_of_draw = fit.changed(&drawn, &mut of_draw).unwrap();
    let mut refused = Vec::new();
    for method in Method::of_modes() {
        let full = fit.answer(method, &part.layout, &memory, fit.modes());
        let reason = match &rig.solver.answers[answering::place_of(method)] {
            MethodAnswer::Refused(reason) => Some(reason.code),
            _ => None,
        };
        refused.push(reason);
        let worse = [Code::DampingNotViscous, Code::DampingNotStructural];
        if reason.is_some_and(|code| worse.contains(&code)) {
            continue;
        }
        assert_eq!(reason, full.as_ref().err().map(|reasons| reasons[0].code), "{method:?}");
        let Some((rig, full)) = rig.solver.answer(method).zip(full.ok()) else { continue };
        let rig = RigidBody::from_theta(&rig.body.theta().map(f64::from));
        let off =
            |theta: SVector<f64, 10>| (theta - full.body.theta()).component_div(&scale).amax();
        let of_draw = fit.answer(method, &part.layout, &of_draw, &modes_of_draw);
        // Single precision and 16 bits make less than a tenth of what one draw of noise makes.
        let by_noise = of_draw.map_or(f64::INFINITY, |answer| off(answer.body.theta()));
        assert!(off(rig.theta()) < 0.1 * by_noise, "{method:?} {} {by_noise}", off(rig.theta()));
    }
    refused
}

#[test]
fn fewer_or_more_hits_are_answered_and_refused_as_by_the_full_computation() {
    let test = Test::new(layout(), GRID, 12_345);
    // A single hit, two, and all but the first.
    let single = agrees_with_full(&test, &[0]);
    assert_eq!(single[4], Some(Code::TenParametersNotIdentifiable));
    agrees_with_full(&test, &[1, 2]);
    agrees_with_full(&test, &[1, 2, 3, 4]);
    let mixed = Test::new(with_more_hits(), GRID, 54_321);
    agrees_with_full(&mixed, &[0, 1, 2, 3, 4, 5, 6, 7]);
}

#[test]
fn fewer_than_five_modes_are_refused_method_by_method() {
    let grid = LineGrid { band_hz: [0.5, 5.0], ..GRID };
    let refused = agrees_with_full(&Test::new(layout(), grid, 99), &[0, 1, 2, 3, 4]);
    assert_eq!(refused[0], Some(Code::SuspensionModesMissing));
    assert_eq!(refused[1], Some(Code::SixModesNeeded));
    // Five modes are below 7.4 Hz: enough for the orthogonality of shapes.
    let grid = LineGrid { band_hz: [0.5, 7.4], ..GRID };
    let refused = agrees_with_full(&Test::new(layout(), grid, 99), &[0, 1, 2, 3, 4]);
    assert_eq!(refused[..2], [None, Some(Code::SixModesNeeded)]);
}

#[test]
fn what_cannot_be_solved_is_named() {
    let begin = |layout: &RigLayout<f64>, dofs: &[usize]| {
        let rig = Rig::<f32>::new(layout, GRID, dofs);
        rig.err().map(|reasons| reasons[0].code)
    };
    let all = [0, 1, 2, 3, 4];
    let mut two = layout();
    two.sensors.pop();
    assert_eq!(begin(&two, &all), Some(Code::ResponseRankDeficient));
    let mut collinear = layout();
    for (place, sensor) in collinear.sensors.iter_mut().enumerate() {
        sensor.position = [0.1 * place as f64, 0.05 * place as f64, 0.0];
    }
    assert_eq!(begin(&collinear, &all), Some(Code::ResponseRankDeficient));
    let mut wild = layout();
    wild.hits[2].position[1] = f64::NAN;
    assert_eq!(begin(&wild, &all), Some(Code::LayoutNotFinite));
    assert_eq!(begin(&layout(), &[]), Some(Code::FrfMissing));
    assert_eq!(begin(&layout(), &[0, 5]), Some(Code::FrfMissing));

    let mut test = Test::new(layout(), GRID, 7);
    test.data[1234].im = f64::NAN;
    let rig = test.on_rig::<f32>(&all, |_| false).unwrap();
    assert!(rig.solver.has_failed());
    assert_eq!(rig.solver.diagnostics()[0].code, Code::DataNotFinite);
    // Nothing moves.
    test.data.fill(C::new(0.0, 0.0));
    let rig = test.on_rig::<f32>(&all, |_| false).unwrap();
    assert_eq!(rig.solver.diagnostics()[0].code, Code::SuspensionModesMissing);
}

#[test]
fn the_hit_that_shows_a_mode_best_is_named() {
    let test = Test::new(layout(), GRID, 3);
    // Without its third hit.
    let rig = test.on_rig::<f32>(&[0, 1, 3, 4], |solver| !solver.unanswered()).unwrap();
    for mode in 0..rig.solver.modes().len() {
        let all: Vec<f32> = rig.solver.norm_indicators(&rig.layout, mode).collect();
        assert_eq!(all.len(), 5);
        let (best, indicator) = rig.solver.best_hit(&rig.layout, mode).unwrap();
        assert!(all.iter().all(|other| *other <= indicator) && all[best] == indicator);
    }
    assert_eq!(rig.solver.measured().collect::<Vec<_>>(), [0, 1, 3, 4]);
    assert!(rig.solver.best_hit(&rig.layout, 6).is_none());
}
