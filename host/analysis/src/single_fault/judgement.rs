//! Which of the fitted mistakes are suspected.
//!
//! A search begins only where the data contradict their budget, which chance does in one of a thousand healthy tests,
//! so the number of mistakes does not raise the number of healthy tests that are suspected beyond that. Where the
//! errors are larger than stated the search begins more often, and then it matters that many mistakes are tried and
//! that some have a size that follows the noise. χ² therefore has to fall by what chance exceeds in one of a thousand
//! such searches, in units of the errors that the mistake leaves (Student's distribution, as their size is not known;
//! Wallace 1959).

use massline_shared::identify::Consistency;
use massline_shared::identify::single_fault::{AxisMap, DECISIVE_CHI_SQUARED, SingleFault};

use super::{Mistake, SizedFault, Suspect};

/// By how much more χ² falls by chance, once in a thousand, for each unknown beyond the first.
const FURTHER_UNKNOWN: f64 = 3.0;

/// The mistakes that were fitted, and the numbers that say how far they can be trusted.
pub(super) struct FittedMistakes {
    /// The mistakes with their fits.
    pub(super) suspects: Vec<Suspect>,
    /// Number of mistakes among which these were found.
    pub(super) tried: usize,
    /// Mistakes with which the test would not determine the ten properties.
    pub(super) untried: Vec<SingleFault<f64>>,
    /// Number of readings.
    pub(super) readings: usize,
}

impl FittedMistakes {
    /// Sorts the mistakes, the best first: by χ² and ln(readings) for each unknown (Schwarz 1978), so that a size that
    /// follows the noise is no advantage. A mistake without a size replaces the same with one, unless that is
    /// decisively better.
    pub(super) fn sort(&mut self) {
        let readings = self.readings;
        self.suspects.sort_by(|a, b| cost(a, readings).total_cmp(&cost(b, readings)));
        // A size that is hardly better than the usual one is that one.
        let repeats = |sized: &Suspect, suspects: &[Suspect]| {
            let limit = cost(sized, readings) + DECISIVE_CHI_SQUARED;
            let is_same = |other: &Suspect| contains(&sized.mistake, &other.mistake);
            suspects.iter().any(|other| is_same(other) && cost(other, readings) < limit)
        };
        let is_repetition: Vec<bool> =
            self.suspects.iter().map(|suspect| repeats(suspect, &self.suspects)).collect();
        let mut repetitions = is_repetition.into_iter();
        self.suspects.retain(|_| !repetitions.next().unwrap_or(false));
    }

    /// The sum of χ² by which the best mistake has to improve the nominal fit.
    pub(super) fn decisive(&self, best: &Suspect) -> f64 {
        let further = unknowns(&best.mistake).saturating_sub(1) as f64;
        let limit = DECISIVE_CHI_SQUARED
            + 2.0 * (self.tried.max(1) as f64).ln()
            + FURTHER_UNKNOWN * further;
        let freedom = f64::from(best.consistency.degrees_of_freedom.max(1));
        freedom * ((limit / freedom).exp() - 1.0) * best.consistency.reduced().max(1.0)
    }

    /// True when the best mistake makes χ² decisively smaller than that of the nominal layout.
    pub(super) fn is_decisive(&self, best: &Suspect, plain: Option<&Consistency<f64>>) -> bool {
        let plain = plain.map_or(f64::INFINITY, |plain| plain.chi_squared);
        plain - best.consistency.chi_squared >= self.decisive(best)
    }

    /// Number of mistakes that the data cannot distinguish from the best; they are sorted.
    pub(super) fn tied(&self) -> usize {
        let Some(best) = self.suspects.first() else { return 0 };
        let limit = cost(best, self.readings) + DECISIVE_CHI_SQUARED;
        self.suspects.iter().take_while(|other| cost(other, self.readings) < limit).count()
    }
}

/// Number of unknowns that a mistake adds.
pub(super) fn unknowns(mistake: &Mistake) -> usize {
    match mistake {
        Mistake::Listed(_) => 0,
        Mistake::Sized(sized) => sized.fault.unknowns(),
    }
}

fn cost(suspect: &Suspect, readings: usize) -> f64 {
    let unknowns = unknowns(&suspect.mistake) as f64;
    suspect.consistency.chi_squared + unknowns * (readings.max(1) as f64).ln()
}

/// True when a mistake with a size has, for one of its sizes, the same effect as one without.
fn contains(sized: &Mistake, listed: &Mistake) -> bool {
    let (Mistake::Sized(sized), &Mistake::Listed(listed)) = (sized, listed) else {
        return false;
    };
    match (sized.fault, listed) {
        (SizedFault::HitGain { hit }, SingleFault::HitReversed { hit: other })
        | (SizedFault::HitDisplaced { hit }, SingleFault::HitAtNode { hit: other, .. }) => {
            hit == other
        }
        (
            SizedFault::ChannelGain { sensor, axis },
            SingleFault::SensorAxes { sensor: other, reads },
        ) => sensor == other && reads == AxisMap::with_reversed(axis),
        (SizedFault::SensorGain { sensor }, SingleFault::SensorAxes { sensor: other, reads }) => {
            sensor == other && reads == AxisMap::REVERSED
        }
        _ => false,
    }
}
