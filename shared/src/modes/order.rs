//! How many modes the responses show: fits of every order, and the smallest that leaves no more than the largest.

use heapless::Vec;

use super::origin_responses::OriginResponses;
use super::residues::fit_residues;
use super::vector_fitting::{FIT_MEMORY, MOST_PAIRS, Poles, VectorFit, find_poles};
use crate::real::Real;

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
    /// Fits this many pairs of poles. `None` for too few lines, and as [`find_poles`].
    fn of(responses: &OriginResponses<'_, R>, pairs: usize) -> Option<Self> {
        let accelerances = 6 * responses.forces.len();
        let unknowns = accelerances * (2 * pairs + 2) + 2 * pairs;
        let degrees_of_freedom = (2 * responses.s.len() * accelerances).checked_sub(unknowns)?;
        let VectorFit { poles, settled, .. } = find_poles(responses, pairs)?;
        let mut memory = [R::zero(); FIT_MEMORY];
        let residual = fit_residues(responses, &poles, &mut memory)?.left();
        Some(Self { poles, residual, degrees_of_freedom, settled })
    }

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
        let fits = (1..=pairs.min(MOST_PAIRS)).map_while(|pairs| Order::of(responses, pairs));
        Self { fits: fits.collect() }
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
