//! How many modes the responses show, with as few fits as this takes.

use super::order::{Order, OrderFit};
use super::origin_responses::OriginResponses;
use super::vector_fitting::MOST_PAIRS;
use crate::{Progress, Real};

/// The order from which the sufficient one is looked for: fewer modes have no answer.
const FIRST: usize = 5;
/// Fits that a search needs when six modes show: those of eight, five and six pairs.
const USUAL_FITS: f32 = 3.0;

/// Searches for the sufficient order of [`Orders`](super::Orders): the largest order shows the noise, then the orders from
/// five on are fitted upwards until one suffices, and those below five downwards until one does not. What an order leaves
/// falls with its number, so the others need no fit.
///
/// ```text
/// 8 ──▶ 5 ── suffices ──▶ 4 ── suffices ──▶ 3 … the last that does
///       └─── does not ──▶ 6 ── does not ──▶ 7 … the first that does
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct OrderSearch<R> {
    /// The fit in hand, and its number of pairs.
    fit: Option<OrderFit<R>>,
    pairs: usize,
    largest: Option<Order<R>>,
    sufficient: Option<Order<R>>,
    /// Number of fits that are finished.
    fits: u8,
}

impl<R: Real> Default for OrderSearch<R> {
    fn default() -> Self {
        Self { fit: None, pairs: MOST_PAIRS, largest: None, sufficient: None, fits: 0 }
    }
}

impl<R: Real> OrderSearch<R> {
    /// Part of the search that is done, if it needs the usual number of fits.
    pub fn progress(&self) -> f32 {
        let of_fit = self.fit.as_ref().map_or(0.0, OrderFit::progress);
        ((f32::from(self.fits) + of_fit) / USUAL_FITS).min(1.0)
    }

    /// The sufficient order when the search is done; `None` when no order can be fitted.
    pub fn sufficient(&self) -> Option<&Order<R>> {
        self.sufficient.as_ref().or(self.largest.as_ref())
    }

    /// Runs one step, at most 1.6 million instructions on a rig. The responses and the memory, of
    /// [`SEARCH_MEMORY`](super::SEARCH_MEMORY) numbers, must be the same in every step.
    pub fn step(&mut self, responses: &OriginResponses<'_, R>, memory: &mut [R]) -> Progress {
        let Some(fit) = &mut self.fit else {
            self.fit = OrderFit::new(responses, self.pairs);
            return if self.fit.is_some() { Progress::Going } else { self.fitted(None) };
        };
        match fit.step(responses, memory) {
            Some(Progress::Going) => Progress::Going,
            Some(Progress::Done) => {
                let order = fit.order();
                self.fitted(order)
            }
            None => self.fitted(None),
        }
    }

    /// Takes the fit of an order, or that there is none, and chooses the next.
    fn fitted(&mut self, order: Option<Order<R>>) -> Progress {
        self.fit = None;
        self.fits = self.fits.saturating_add(1);
        let Some(largest) = &self.largest else {
            self.largest = order;
            let next = if self.largest.is_some() { FIRST.min(self.pairs) } else { self.pairs };
            // The largest order itself need not be fitted again.
            return self.go_on(if next == self.pairs { self.pairs - 1 } else { next });
        };
        let most = largest.poles.len();
        let suffices = order.as_ref().is_some_and(|order| order.suffices(largest));
        if suffices {
            let downwards = self.pairs <= FIRST;
            self.sufficient = order;
            return if downwards { self.go_on(self.pairs - 1) } else { Progress::Done };
        }
        // Below five, one more suffices already; above, the largest does in the end.
        let next = self.pairs + 1;
        if self.sufficient.is_some() || self.pairs < FIRST || next >= most {
            return Progress::Done;
        }
        self.go_on(next)
    }

    fn go_on(&mut self, pairs: usize) -> Progress {
        self.pairs = pairs;
        if pairs == 0 { Progress::Done } else { Progress::Going }
    }
}
