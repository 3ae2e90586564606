//! The wheel, solved in steps as on a rig, against the computation with full memory in double precision.

use nalgebra::{Complex, SVector};
use std::vec;
use std::vec::Vec;

use super::super::{SuspensionFit, judged_estimate};
use super::*;
use crate::frequency_responses::FrequencyResponses;
use crate::identify::agreement::{Agreement, Answers, Propagation, ask, changes};
use crate::identify::dppim::worse_form;
use crate::identify::global_fit::tests::wheel::{self, NOISE, Object, Random};
use crate::identify::{Estimate, Method};
use crate::modes::Reduction;

type C = Complex<f64>;

/// The grid of a rig: records of 10.24 s after the decimation to 50 Hz.
const GRID: LineGrid<f64> =
    LineGrid { resolution_hz: 50.0 / 512.0, band_hz: [0.5, 12.5], decay: 0.0, correlation: 1.0 };

/// The wheel with three sensors and five hits.
fn layout() -> RigLayout<f64> {
    wheel::layout().cast().unwrap()
}

/// Responses of the wheel at the lines of the grid that are used, `[line][channel][hit]`.
fn responses(layout: &RigLayout<f64>, noise: f64, seed: u64) -> (Vec<f64>, Vec<C>) {
    let frequencies: Vec<f64> = (0..GRID.count())
        .map(|line| GRID.resolution_hz * (GRID.first() + line) as f64)
        .collect();
    let object = Object::new(0.0);
    let data = wheel::measure(layout, &object, &frequencies, noise, &mut Random(seed));
    (frequencies, data)
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
    fn new(layout: &RigLayout<f64>, dofs: &[usize]) -> Result<Self, Diagnostics> {
        let layout = layout.cast().unwrap();
        let LineGrid { resolution_hz, band_hz, decay, correlation } = GRID;
        let grid = LineGrid {
            resolution_hz: R::of(resolution_hz),
            band_hz: band_hz.map(R::of),
            decay: R::of(decay),
            correlation: R::of(correlation),
        };
        let zero = Complex::new(R::zero(), R::zero());
        Ok(Self {
            solver: SuspensionSolver::new(&layout, grid, dofs)?,
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
            assert!(solver.progress() >= shown, "{} after {shown}", solver.progress());
            shown = solver.progress();
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
        (estimates, solver.agreement(layout, &memory))
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
    let layout = layout();
    let (frequencies, data) = responses(&layout, NOISE, 88_172_645_463_325_252);
    let readings = FrequencyResponses::new(&frequencies, &data, 9, 5).unwrap();
    let start = std::time::Instant::now();
    let full = in_full(&layout, &readings);
    std::println!("full {:?}", start.elapsed());
    let mut rig = Rig::<f32>::new(&layout, &[0, 1, 2, 3, 4]).unwrap().run(&data, |_| false);
    assert!(!rig.solver.has_failed(), "{:?}", rig.solver.diagnostics());
    std::println!("size {} steps {}", size_of_val(&rig.solver), rig.steps);
    for (mode, (frequency, damping)) in rig.solver.modes().iter().zip(&full.modes) {
        std::println!("{} {frequency} {} {damping}", mode.frequency_hz, mode.damping_ratio);
    }
    let (estimates, agreement) = rig.results();
    for (rig, full) in estimates.iter().zip(&full.estimates) {
        assert_eq!(rig.is_some(), full.is_some());
        let Some((rig, full)) = rig.as_ref().zip(full.as_ref()) else { continue };
        std::println!("{:?} {:?}", full.method, compare(rig, full));
    }
    let (rig, full) = (agreement.unwrap(), full.agreement.unwrap());
    for k in 0..10 {
        let sigma = full.covariance[(k, k)].sqrt();
        std::println!(
            "{k} {} {}",
            (f64::from(rig.theta[k]) - full.theta[k]) / sigma,
            f64::from(rig.covariance[(k, k)].sqrt()) / sigma
        );
    }
    std::println!("{:?} {:?}", rig.outliers, full.outliers);
}
