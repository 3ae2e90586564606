//! Random processes that change little from scan to scan: the wander of the sensors' outputs, the draught.

use rand_chacha::ChaCha8Rng;

use super::errors::normal;

/// Longest time from one knot to the next, s.
const LONGEST_S: f64 = 0.1;
/// Knots in one correlation time. The straight lines between them lower the variance by a third of 1/256.
const KNOTS: f64 = 256.0;

/// Independent normal processes whose correlation falls exponentially (Ornstein-Uhlenbeck): exact at knots some scans
/// apart, and straight between them.
#[derive(Clone, Debug)]
pub(super) struct Slow<const N: usize> {
    sigma: [f64; N],
    /// What is left of a value from one knot to the next.
    memory: f64,
    /// Scans from one knot to the next.
    interval: u64,
    value: [f64; N],
    step: [f64; N],
    /// Scans to the next knot.
    remaining: u64,
}

impl<const N: usize> Slow<N> {
    /// Processes of these standard deviations and this correlation time, s, at scans of this interval, s; none when all
    /// of them are zero.
    pub(super) fn new(sigma: [f64; N], correlation: f64, scan: f64) -> Option<Self> {
        if sigma.iter().all(|sigma| *sigma == 0.0) {
            return None;
        }
        let interval = ((correlation / KNOTS).min(LONGEST_S) / scan).max(1.0) as u64;
        let memory = (-(interval as f64) * scan / correlation).exp();
        Some(Self { sigma, memory, interval, value: [0.0; N], step: [0.0; N], remaining: 0 })
    }

    /// Draws the values of a process that has been going on for long.
    pub(super) fn settle(&mut self, rng: &mut ChaCha8Rng) {
        self.hold(self.sigma.map(|sigma| sigma * normal(rng)));
    }

    /// Goes on from these values, which are at a knot.
    pub(super) fn hold(&mut self, values: [f64; N]) {
        self.value = values;
        self.remaining = 0;
    }

    /// The present values.
    pub(super) fn value(&self) -> &[f64; N] {
        &self.value
    }

    /// Goes on to the next scan.
    pub(super) fn advance(&mut self, rng: &mut ChaCha8Rng) {
        if self.remaining == 0 {
            self.remaining = self.interval;
            let fresh = (1.0 - self.memory * self.memory).sqrt();
            for i in 0..N {
                let next = self.memory * self.value[i] + fresh * self.sigma[i] * normal(rng);
                self.step[i] = (next - self.value[i]) / self.interval as f64;
            }
        }
        self.remaining -= 1;
        for (value, step) in self.value.iter_mut().zip(&self.step) {
            *value += step;
        }
    }

    /// Scans from one knot to the next.
    pub(super) fn interval(&self) -> u64 {
        self.interval
    }

    /// What is left of a value from one knot to the next, and the standard deviations of all processes.
    pub(super) fn statistics(&self) -> (f64, &[f64; N]) {
        (self.memory, &self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn values_have_the_deviation_and_the_correlation_asked_for() {
        let mut slow = Slow::new([2.0, 0.0, 0.5], 0.05, 2.5e-4).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        slow.settle(&mut rng);
        // 200 s are 4000 correlation times.
        let values: Vec<[f64; 3]> = (0..800_000)
            .map(|_| {
                slow.advance(&mut rng);
                *slow.value()
            })
            .collect();
        let moment = |i: usize, lag: usize| {
            let products = values.iter().zip(&values[lag..]).map(|(a, b)| a[i] * b[i]);
            products.sum::<f64>() / (values.len() - lag) as f64
        };
        for (i, sigma) in [(0, 2.0_f64), (2, 0.5)] {
            // The relative 1 σ of the variance is √(2 · correlation time / time) = 2.2 %, that of a
            // correlation no more; four times that is allowed. 200 scans are one correlation time.
            assert!((moment(i, 0) / (sigma * sigma) - 1.0).abs() < 0.09, "{}", moment(i, 0));
            let correlation = moment(i, 200) / moment(i, 0);
            assert!((correlation - (-1.0_f64).exp()).abs() < 0.09, "{correlation}");
        }
        assert_eq!(moment(1, 0), 0.0);
    }

    #[test]
    fn a_process_that_is_slow_does_not_jump_between_scans() {
        let mut slow = Slow::new([1.0], 100.0, 2.5e-4).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        slow.settle(&mut rng);
        let mut before = slow.value()[0];
        let mut largest = 0.0_f64;
        for _ in 0..100_000 {
            slow.advance(&mut rng);
            largest = largest.max((slow.value()[0] - before).abs());
            before = slow.value()[0];
        }
        // Between two knots, 0.1 s or 400 scans apart, it changes by √(2 · 0.001) = 0.045, 1 σ: five of these in
        // 400 steps.
        assert!(largest < 5.0 * 0.045 / 400.0 && largest > 0.0, "{largest}");
    }

    #[test]
    fn processes_without_deviation_are_none() {
        assert!(Slow::new([0.0; 3], 1.0, 2.5e-4).is_none());
    }
}
