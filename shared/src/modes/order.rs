//! How many modes the responses show: fits of every order, and the smallest that leaves no more than the largest.

use heapless::Vec;

use super::origin_responses::OriginResponses;
use super::residues::{ResidueFit, Residues};
use super::vector_fitting::{MOST_PAIRS, PoleSearch, Poles, SEARCH_MEMORY};
use crate::{Progress, Real};

/// A pole is stable when the next smaller order has one within these distances: relative in frequency, and in damping
/// ratio. Half of what is usual in modal analysis, since the poles are shared by all responses.
const STABLE: [f64; 2] = [0.005, 0.05];
/// Standard deviations of χ² by which a smaller order may leave more than the largest.
const SIGNIFICANT: f64 = 5.0;

/// A fit of one order.
#[derive(Clone, Debug, PartialEq)]
pub struct Order<R> {
    /// The poles, as many as the order.
    pub poles: Poles<R>,
    /// Sum of the squared residuals of the fit, relative to the noise of a reading.
    pub residual: R,
    /// Equations minus unknowns.
    pub degrees_of_freedom: usize,
    /// False when the poles still moved.
    pub settled: bool,
}

impl<R: Real> Order<R> {
    /// Variance of the noise of a reading, as sum of real and imaginary part, relative to what the lines were weighted
    /// with.
    pub fn noise_variance(&self) -> R {
        self.residual * R::of(2.0 / self.degrees_of_freedom.max(1) as f64)
    }

    /// True when this order leaves not significantly more than the largest, which shows the noise.
    pub fn suffices(&self, largest: &Self) -> bool {
        let noise = largest.residual / R::of(largest.degrees_of_freedom.max(1) as f64);
        let freedom = self.degrees_of_freedom.saturating_sub(largest.degrees_of_freedom) as f64;
        let allowed = R::of(freedom + SIGNIFICANT * libm::sqrt(2.0 * freedom));
        self.residual - largest.residual <= noise * allowed
    }

    /// True for a pole that the fit of the next smaller order also has.
    pub fn is_stable(&self, place: usize, smaller: &Self) -> bool {
        let Some(pole) = self.poles.get(place) else { return false };
        let figures = |pole: &nalgebra::Complex<R>| {
            let size = pole.norm_sqr().sqrt();
            [size, -pole.re / size]
        };
        let [size, damping] = figures(pole);
        smaller.poles.iter().map(figures).any(|[other, other_damping]| {
            (size - other).abs() < size * R::of(STABLE[0])
                && (damping - other_damping).abs() < damping * R::of(STABLE[1]) + R::of(1e-3)
        })
    }
}

/// The fits of all orders from one pair of poles on, as far as the lines suffice.
#[derive(Clone, Debug, PartialEq)]
pub struct Orders<R> {
    fits: Vec<Order<R>, MOST_PAIRS>,
}

impl<R: Real> Orders<R> {
    /// Fits every order up to this number of pairs of poles.
    pub fn up_to(responses: &OriginResponses<'_, R>, pairs: usize) -> Self {
        let mut memory = [R::zero(); SEARCH_MEMORY];
        let mut fit = |pairs| {
            let mut fit = OrderFit::new(responses, pairs)?;
            while fit.step(responses, &mut memory)? == Progress::Going {}
            fit.order()
        };
        let fits = (1..=pairs.min(MOST_PAIRS)).map_while(&mut fit).collect();
        Self { fits }
    }

    /// The fits, from the smallest order on.
    pub fn fits(&self) -> &[Order<R>] {
        &self.fits
    }

    /// The smallest order whose residual is not significantly above that of the largest, which shows the noise. `None`
    /// when there is no fit.
    pub fn sufficient(&self) -> Option<&Order<R>> {
        let largest = self.fits.last()?;
        self.fits.iter().find(|fit| fit.suffices(largest))
    }
}

/// The fit of one order, in steps between which other work can be done. A step is at most 1.6 million instructions on a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderFit<R> {
    poles: PoleSearch<R>,
    /// The residues, when the poles are found.
    residues: Option<ResidueFit>,
    left: R,
    degrees_of_freedom: usize,
}

impl<R: Real> OrderFit<R> {
    /// A fit of this many pairs of poles. `None` for too few lines, and as [`find_poles`](super::find_poles).
    pub fn new(responses: &OriginResponses<'_, R>, pairs: usize) -> Option<Self> {
        let accelerances = 6 * responses.forces.len();
        let unknowns = accelerances * (2 * pairs + 2) + 2 * pairs;
        let degrees_of_freedom = (2 * responses.s.len() * accelerances).checked_sub(unknowns)?;
        let poles = PoleSearch::new(responses, pairs)?;
        Some(Self { poles, residues: None, left: R::zero(), degrees_of_freedom })
    }

    /// Part of the fit that is done at least.
    pub fn progress(&self) -> f32 {
        if self.residues.is_some() { 1.0 } else { self.poles.progress() }
    }

    /// Runs one step. The responses and the memory, of [`SEARCH_MEMORY`] numbers, must be the same in every step. `None` when
    /// the equations have no solution.
    pub fn step(
        &mut self,
        responses: &OriginResponses<'_, R>,
        memory: &mut [R],
    ) -> Option<Progress> {
        let Some(residues) = &mut self.residues else {
            if self.poles.step(responses, memory)? == Progress::Done {
                self.residues = Some(ResidueFit::default());
            }
            return Some(Progress::Going);
        };
        let poles = &self.poles.found().poles;
        let progress = residues.step(responses, poles, memory)?;
        if progress == Progress::Done {
            self.left = Residues::new(responses, poles, memory)?.left();
        }
        Some(progress)
    }

    /// The order, when the fit is done.
    pub fn order(&self) -> Option<Order<R>> {
        let found = self.poles.found();
        self.residues.map(|_| Order {
            poles: found.poles.clone(),
            residual: self.left,
            degrees_of_freedom: self.degrees_of_freedom,
            settled: found.settled,
        })
    }
}
