//! Runs the identification methods: takes observations and the requested methods, gives estimates and
//! reasons.
//!
//! [`identify`] runs everything at once; a rig calls [`Identification::step`] repeatedly, with other work in
//! between.
//!
//! ```
//! # use massline_shared::body::RigidBody;
//! # use massline_shared::capacity::Fixed;
//! # use massline_shared::identify::*;
//! # use massline_shared::layout::{Hit, Layout, Sensor};
//! # use nalgebra::SVector;
//! # let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
//! # let mut layout = Layout::<f64, Fixed<3, 3>>::default();
//! # for (node, position) in [(1, [0.0; 3]), (2, [0.2, -0.2, 0.0]), (3, [0.2, 0.0, 0.0])] {
//! #     layout.sensors.push(Sensor::new(node, position, axes)).unwrap();
//! # }
//! # for (dof, position, direction) in [
//! #     ("1:+Y", [0.0; 3], [0.0, 1.0, 0.0]),
//! #     ("2:+Z", [0.2, -0.2, 0.0], [0.0, 0.0, 1.0]),
//! #     ("4:+X", [0.2, -0.2, 0.15], [1.0, 0.0, 0.0]),
//! # ] {
//! #     layout.hits.push(Hit::new(dof.parse().unwrap(), position, direction)).unwrap();
//! # }
//! # let truth = RigidBody::from_theta(&SVector::from([
//! #     1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
//! # ]));
//! # let mass_lines: Vec<_> = (0..3)
//! #     .map(|hit| (hit, MassLines::without_scatter(layout.accelerance(&truth, hit).unwrap())))
//! #     .collect();
//! // A layout with three sensors and three hits, and one mass line for each response and hit.
//! let observed = Observations::of_mass_lines(&layout, &mass_lines);
//! let wanted = observed.methods();
//! let mut workspace = vec![0.0; workspace(&wanted, 3, 3)];
//! let identification = identify(&observed, &wanted, &IdentifySettings::default(), &mut workspace);
//! let best = &identification.estimates()[0];
//! assert_eq!(best.method, Method::MaximumLikelihood);
//! // The readings are exact; the fit allows for forces that are 0.26 % weaker because hits turn.
//! assert!((best.body.mass - 1.23).abs() < 0.0033);
//! ```

use heapless::Vec;

use super::method::Observable;
use super::observations::{Observations, SpectrumBins};
use super::{Estimate, IdentifySettings, METHODS, Method, RunningMethod};
use crate::capacity::Capacity;
use crate::diagnosis::Diagnostics;
use crate::progress::Progress;
use crate::real::Real;

/// Methods, best first.
pub type Methods = Vec<Method, METHODS>;

impl<R: Real, C: Capacity, L: SpectrumBins<R>> Observations<'_, R, C, L> {
    /// The methods that apply to these observations, best first.
    pub fn methods(&self) -> Methods {
        let seen = |method: &Method| match method.entry().observes {
            Observable::MassLines => true,
            Observable::SpectrumBins => self.spectrum_bins.responses().is_some(),
            Observable::Suspension => false,
        };
        Method::ALL.into_iter().filter(seen).collect()
    }
}

impl Method {
    /// The methods that use mass lines, best first: those that a rig runs.
    pub fn of_mass_lines() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|method| method.entry().observes == Observable::MassLines)
    }

    /// The methods that use the suspension modes, best first.
    pub fn of_modes() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().filter(|method| method.entry().observes == Observable::Suspension)
    }

    /// The name in reports and JSON.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// The method with a stored number; `None` when this program does not know it.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|method| method.number() == number)
    }
}

/// Number of methods that use mass lines: those that a rig runs.
pub const MASS_LINE_METHODS: usize = {
    let (mut count, mut place) = (0, 0);
    while place < METHODS {
        if matches!(Method::ALL[place].entry().observes, Observable::MassLines) {
            count += 1;
        }
        place += 1;
    }
    count
};

/// Size of the workspace that these methods need for this number of sensors and hits.
pub fn workspace(methods: &[Method], sensors: usize, hits: usize) -> usize {
    let size = |method: &Method| (method.entry().workspace)(sensors, hits);
    methods.iter().map(size).max().unwrap_or(0)
}

/// An identification with room for the answers of `N` methods: the requested methods, the one that is
/// running, and the answers so far.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::*;
/// let layout = frame::layout();
/// let mass_lines = frame::mass_lines(&layout);
/// let observed = Observations::of_mass_lines(&layout, &mass_lines);
/// let mut memory = vec![0.0; workspace(&Method::ALL, layout.sensors.len(), layout.hits.len())];
/// let mut identification = Identification::<f64>::idle();
/// identification.begin(Method::of_mass_lines());
/// while identification.step(&observed, &IdentifySettings::default(), &mut memory) == Progress::Going {
///     // Other work.
/// }
/// assert_eq!(identification.estimates().len(), MASS_LINE_METHODS);
/// ```
#[derive(Clone, Debug)]
pub struct Identification<R, const N: usize = METHODS> {
    /// Methods still to run. The last one is next, so the simplest runs first and the others can start from
    /// its answer.
    queue: Methods,
    running: RunningMethod<R>,
    /// The running method needs no further step.
    settled: bool,
    estimates: Vec<Estimate<R>, N>,
    refusals: Vec<(Method, Diagnostics), N>,
}

impl<R, const N: usize> Identification<R, N> {
    /// An identification without methods.
    pub const fn idle() -> Self {
        Self {
            queue: Vec::new(),
            running: RunningMethod::No,
            settled: false,
            estimates: Vec::new(),
            refusals: Vec::new(),
        }
    }

    /// Starts again with these methods, in the same memory.
    pub fn begin(&mut self, wanted: impl IntoIterator<Item = Method>) {
        self.queue.clear();
        // Limited to the number of answers that there is room for; every method runs once.
        self.queue.extend(wanted.into_iter().take(N.min(METHODS)));
        self.running = RunningMethod::No;
        self.settled = false;
        self.estimates.clear();
        self.refusals.clear();
    }

    /// Adds a known answer, from which the methods can start; it stays among the answers.
    pub fn start_from(&mut self, estimate: Estimate<R>) {
        // There is room for every method.
        let _ = self.estimates.insert(0, estimate);
    }

    /// The answers, best first.
    pub fn estimates(&self) -> &[Estimate<R>] {
        &self.estimates
    }

    /// The methods without an answer, best first, with their reasons.
    pub fn refusals(&self) -> &[(Method, Diagnostics)] {
        &self.refusals
    }

    /// Answers and refusals.
    pub fn into_parts(self) -> (Vec<Estimate<R>, N>, Vec<(Method, Diagnostics), N>) {
        (self.estimates, self.refusals)
    }
}

impl<R: Real, const N: usize> Identification<R, N> {
    /// Runs one step of the current method. Observations, settings and workspace must be the same in every
    /// step.
    pub fn step<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        settings: &IdentifySettings<R>,
        workspace: &mut [R],
    ) -> Progress {
        match self.running.method() {
            None => self.start_next(observed, settings),
            Some(method) if self.settled => self.finish(method, observed, workspace),
            Some(method) => match self.running.step(observed, workspace) {
                Ok(progress) => self.settled = progress == Progress::Done,
                Err(reasons) => self.refuse(method, reasons),
            },
        }
        let done = self.running.method().is_none() && self.queue.is_empty();
        if done { Progress::Done } else { Progress::Going }
    }

    fn start_next<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        settings: &IdentifySettings<R>,
    ) {
        let Some(method) = self.queue.pop() else { return };
        let start = self.estimates.first().map(|estimate| estimate.body);
        self.settled = false;
        match RunningMethod::start(method, observed, settings, start.as_ref()) {
            Ok(running) => self.running = running,
            Err(reasons) => self.refuse(method, reasons),
        }
    }

    fn finish<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        method: Method,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) {
        match self.running.finish(observed, workspace) {
            // There is room for every method, and better methods run later.
            Ok(estimate) => drop(self.estimates.insert(0, estimate)),
            Err(reasons) => self.refuse(method, reasons),
        }
        self.running = RunningMethod::No;
    }

    fn refuse(&mut self, method: Method, reasons: Diagnostics) {
        self.running = RunningMethod::No;
        // There is room for every method.
        let _ = self.refusals.insert(0, (method, reasons));
    }
}

/// Runs the requested methods to the end. `workspace` needs the length that [`workspace`] gives.
///
/// The methods run from the simplest to the best, each starting from the answer of the one before. The
/// reasons of a method without an answer are in [`Identification::refusals`]. Theory, sections 3 to 5.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::*;
/// let mut layout = frame::layout();
/// layout.sensors.pop(); // two sensors do not show all six motions
/// let mass_lines = frame::mass_lines(&layout);
/// let observed = Observations::of_mass_lines(&layout, &mass_lines);
/// let wanted = [Method::MaximumLikelihood, Method::InertiaRestraint];
/// let mut memory = vec![0.0; workspace(&wanted, layout.sensors.len(), layout.hits.len())];
/// let identification = identify(&observed, &wanted, &IdentifySettings::default(), &mut memory);
/// // Maximum likelihood compares readings and still works; the linear method does not.
/// assert_eq!(identification.estimates()[0].method, Method::MaximumLikelihood);
/// assert!((identification.estimates()[0].body.mass - 1.23).abs() < 0.0033);
/// assert_eq!(identification.refusals()[0].0, Method::InertiaRestraint);
/// ```
pub fn identify<R: Real, C: Capacity, L: SpectrumBins<R>>(
    observed: &Observations<'_, R, C, L>,
    wanted: &[Method],
    settings: &IdentifySettings<R>,
    workspace: &mut [R],
) -> Identification<R> {
    let mut identification = Identification::idle();
    // Best first, whatever the order of the request.
    identification.begin(Method::ALL.into_iter().filter(|method| wanted.contains(method)));
    while identification.step(observed, settings, workspace) == Progress::Going {}
    identification
}
