//! Gains of single modes in single responses, which a converter adds.
//!
//! The codes of a converter are unequally wide. A channel that swings by a few of them has a gain of its own for every
//! mode and hit: it depends on where and how far the channel swings. Hits of equal strength do not average it, and no
//! parameter of the global fit describes it. What it does to the answer is added to the covariance (theory, section
//! 5):
//!
//! ```text
//! H(s) = Σᵣ hᵣ(s) [1 + a + b (1 − 2 (σᵣ + σ)/(s − pᵣ))]        a, b ~ N(0, (κ/A)²)
//! ```
//! with the part hᵣ of mode r in a response, its pole pᵣ, its decay rate σᵣ and the σ of the exponential window. The gain
//! a is there from beginning to end, b rises while the mode decays. A is the amplitude that all modes together give the
//! response: on simulated wheels both gains fell with its first power, from 2 to 40 codes and for large and small
//! modes alike. κ is the same for all responses and maximises the likelihood of what the fit has left.

use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::identify::global_fit::{Damping, GlobalFitSolution};
use massline_shared::layout::HostLayout;
use nalgebra::{Complex, DMatrix, DVector, Matrix6, SMatrix, SVector, Vector3, Vector6};

/// Standard normal deviate of the score for κ from which gains are there: chance gives it once in 30 000 tests.
const THERE: f64 = 4.0;
/// Most rounds of improving κ and the noise.
const MOST_ROUNDS: usize = 100;
/// κ has settled when it changes by less than this part.
const SETTLED: f64 = 1e-3;

/// Gains of the modes in all responses of a test.
#[derive(Clone, Debug)]
pub(super) struct ModalGains {
    modes: Vec<Mode>,
    responses: Vec<Response>,
    /// Standard deviation of a gain times the amplitude of its response, (m/s²)/(N s).
    kappa: f64,
    /// Variance of the real part of a reading without gains, with the correlation of neighbouring lines.
    noise: f64,
    /// Square of the factor on standard deviations because neighbouring lines are correlated.
    correlation: f64,
    /// Root mean square of what the gains add to the readings, over that of the readings.
    pub(super) share: f64,
}

/// The gains in one response.
#[derive(Clone, Debug)]
struct Response {
    channel: usize,
    hit: usize,
    /// Products of the columns of the gains with one another, and with what the fit has left.
    gram: DMatrix<f64>,
    right: DVector<f64>,
    /// Sum of the squares of what the fit has left.
    squares: f64,
}

impl ModalGains {
    /// The gains that the fit of `readings` has `left` to see; `None` where none show.
    pub(super) fn of(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        solution: &GlobalFitSolution<f64>,
        damping: Damping,
        left: &[Complex<f64>],
    ) -> Option<Self> {
        let modes = modes(layout, solution, damping)?;
        let hits = readings.hits();
        let places = (0..readings.channels() * hits).map(|place| (place / hits, place % hits));
        let response = |place| Response::new(layout, readings, &modes, place, left);
        let responses: Vec<Response> = places.filter_map(response).collect();
        let squares: f64 = responses.iter().map(|response| response.squares).sum();
        // Real and imaginary parts.
        let rows = (2 * readings.frequencies().len() * responses.len()) as f64;
        let correlation = readings.correlation.powi(2);
        let noise = squares / rows * correlation;
        let mut gains = Self { modes, responses, kappa: 0.0, noise, correlation, share: 0.0 };
        (gains.deviate() > THERE).then_some(())?;
        gains.learn(rows)?;
        let added: f64 = gains.responses.iter().map(|response| response.gram.trace()).sum();
        gains.share = gains.kappa * (added / squares_of(readings)).sqrt();
        Some(gains)
    }

    /// Standard deviation of the real part of a reading without gains, (m/s²)/N.
    pub(super) fn noise_without(&self) -> f64 {
        (self.noise / self.correlation).sqrt()
    }

    /// Standard normal deviate of the score for κ² where there are no gains.
    fn deviate(&self) -> f64 {
        let (mut score, mut variance) = (0.0, 0.0);
        for Response { gram, right, .. } in &self.responses {
            score += right.norm_squared() / self.noise - gram.trace();
            variance += 2.0 * gram.norm_squared();
        }
        score / variance.sqrt()
    }

    /// Sets κ and the noise to what is most likely for so many real numbers (MacKay 1992, Neural Computation 4, 415).
    fn learn(&mut self, rows: f64) -> Option<()> {
        let columns: f64 = self.responses.iter().map(|r| r.gram.ncols() as f64).sum();
        let squares: f64 = self.responses.iter().map(|r| r.squares).sum();
        let size: f64 = self.responses.iter().map(|r| r.gram.trace()).sum();
        // What is left would be gains and nothing else.
        self.kappa = (squares / size * columns / rows).sqrt();
        for _round in 0..MOST_ROUNDS {
            let prior = self.noise / self.kappa.powi(2);
            let (mut gains, mut determined, mut rest) = (0.0, 0.0, 0.0);
            for Response { gram, right, squares, .. } in &self.responses {
                let own = DMatrix::from_diagonal_element(gram.ncols(), gram.ncols(), prior);
                let factor = (gram + own).cholesky()?;
                let values = factor.solve(right);
                gains += values.norm_squared();
                determined += gram.ncols() as f64 - prior * factor.inverse().trace();
                rest += squares - 2.0 * values.dot(right) + values.dot(&(gram * &values));
            }
            self.noise = rest / (rows - determined) * self.correlation;
            let before = self.kappa;
            self.kappa = (gains / determined).sqrt();
            if (self.kappa / before - 1.0).abs() < SETTLED {
                break;
            }
        }
        (self.kappa.is_finite() && self.noise.is_finite()).then_some(())
    }

    /// What has to be added to the covariance of an answer with these changes of theta with every reading, which was
    /// found with noise of this variance at each line. The gains take their share out of that noise.
    pub(super) fn covariance(
        &self,
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        gain: &[SVector<Complex<f64>, 10>],
        assumed: impl Fn(usize) -> f64,
    ) -> SMatrix<f64, 10, 10> {
        let (channels, hits) = (readings.channels(), readings.hits());
        let mut covariance = SMatrix::zeros();
        for (line, of_line) in gain.chunks_exact(channels * hits).enumerate() {
            let more = self.noise - assumed(line);
            for gain in of_line {
                let (re, im) = (gain.map(|g| g.re), gain.map(|g| g.im));
                covariance += (re * re.transpose() + im * im.transpose()) * more;
            }
        }
        for Response { channel, hit, .. } in &self.responses {
            let Some(columns) = columns_of(layout, readings, &self.modes, [*channel, *hit]) else {
                continue;
            };
            for column in columns.column_iter() {
                let mut change = SVector::<f64, 10>::zeros();
                for (line, parts) in column.as_slice().chunks_exact(2).enumerate() {
                    let gain = &gain[(line * channels + channel) * hits + hit];
                    change += gain.map(|g| g.re * parts[0] + g.im * parts[1]);
                }
                covariance += change * change.transpose() * self.kappa.powi(2);
            }
        }
        covariance
    }
}

/// Sum of the squares of all readings.
pub(super) fn squares_of(readings: &FrequencyResponses<'_, f64>) -> f64 {
    let (channels, hits) = (readings.channels(), readings.hits());
    let places = (0..channels).flat_map(|channel| (0..hits).map(move |hit| (channel, hit)));
    let at_line = |line: usize| {
        places
            .clone()
            .map(move |(channel, hit)| readings.at(line, channel, hit).norm_sqr())
            .sum::<f64>()
    };
    (0..readings.frequencies().len()).map(at_line).sum()
}

impl Response {
    /// `None` where no mode shows.
    fn new(
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        modes: &[Mode],
        (channel, hit): (usize, usize),
        left: &[Complex<f64>],
    ) -> Option<Self> {
        let columns = columns_of(layout, readings, modes, [channel, hit])?;
        let at = |row: usize| {
            let reading = left[(row / 2 * readings.channels() + channel) * readings.hits() + hit];
            if row.is_multiple_of(2) { reading.re } else { reading.im }
        };
        let left = DVector::from_fn(columns.nrows(), |row, _| at(row));
        let (gram, right) = (columns.tr_mul(&columns), columns.tr_mul(&left));
        Some(Self { channel, hit, gram, right, squares: left.norm_squared() })
    }
}

/// What each gain adds to a response for a κ of one, real and imaginary part of every line: first the gains that stay,
/// then those that rise, of every mode. `None` for a response in which no mode shows.
fn columns_of(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    modes: &[Mode],
    [channel, hit]: [usize; 2],
) -> Option<DMatrix<f64>> {
    let force = layout.hits.get(hit)?.unit_force(&Vector3::zeros());
    // The mode's motion as this channel sees it, for one newton of the hit.
    let seen = |mode: &Mode, s: Complex<f64>| {
        let row = layout.response_row_at(channel, s);
        let motion: Complex<f64> = row.iter().zip(&mode.shape).map(|(g, phi)| g * *phi).sum();
        motion * mode.shape.dot(&force)
    };
    let ringing =
        |mode: &Mode| seen(mode, Complex::new(0.0, mode.omega)).norm_sqr() * mode.omega.powi(2);
    let amplitude = modes.iter().map(ringing).sum::<f64>().sqrt();
    (amplitude > 0.0).then_some(())?;
    let (lines, count) = (readings.frequencies().len(), modes.len());
    let mut columns = DMatrix::zeros(2 * lines, 2 * count);
    for line in 0..lines {
        let s = readings.s(line);
        for (k, mode) in modes.iter().enumerate() {
            let part = seen(mode, s) * mode.dynamic(s) / amplitude;
            let rate = 2.0 * (mode.decay + readings.decay);
            let rising = part - part * rate / (s - mode.pole());
            for (column, value) in [(k, part), (count + k, rising)] {
                columns[(2 * line, column)] = value.re;
                columns[(2 * line + 1, column)] = value.im;
            }
        }
    }
    Some(columns)
}

/// A mode of the fitted object on its suspension.
#[derive(Clone, Debug)]
struct Mode {
    /// Undamped angular frequency, rad/s.
    omega: f64,
    /// Decay rate, 1/s.
    decay: f64,
    /// Mass-normalised shape about the origin.
    shape: Vector6<f64>,
}

impl Mode {
    fn pole(&self) -> Complex<f64> {
        let square = self.omega.powi(2) - self.decay.powi(2);
        Complex::new(-self.decay, square.max(0.0).sqrt())
    }

    /// `1/(1 + 2σᵣ/s + ωᵣ²/s²)`.
    fn dynamic(&self, s: Complex<f64>) -> Complex<f64> {
        let inverse = s.inv();
        (inverse * inverse * self.omega.powi(2) + inverse * (2.0 * self.decay) + 1.0).inv()
    }
}

/// The modes of a solution, without the coupling that damping may add; `None` where its body has no mass matrix.
fn modes(
    layout: &HostLayout,
    solution: &GlobalFitSolution<f64>,
    damping: Damping,
) -> Option<Vec<Mode>> {
    let object = solution.estimate.body.phi();
    let attached = layout.attached.iter().map(|body| SVector::from(body.phi));
    let moving = RigidBody::from_phi(&attached.fold(object, |sum, phi| sum + phi))?;
    let inverse = moving.mass_matrix().cholesky()?.l().try_inverse()?;
    let eigen = (inverse * solution.stiffness * inverse.transpose()).symmetric_eigen();
    let damping_matrix = solution.damping.unwrap_or(Matrix6::zeros());
    let mode = |k: usize| {
        let shape = inverse.tr_mul(&eigen.eigenvectors.column(k));
        let omega = eigen.eigenvalues[k].max(0.0).sqrt();
        let damped = shape.dot(&(damping_matrix * shape)).max(0.0) / 2.0;
        let decay = if damping == Damping::Structural { damped / omega } else { damped };
        (omega > 0.0).then_some(Mode { omega, decay, shape })
    };
    Some((0..6).filter_map(mode).collect())
}

#[cfg(test)]
mod tests {
    use massline_physics::Bench;
    use massline_shared::identify::global_fit::GlobalFitSettings;

    use super::*;
    use crate::suspension::GlobalAnswer;
    use crate::suspension::test_wheel::{wheel, wheel_responses};

    const LINES: usize = 240;
    const WHITE: f64 = 1e-3;

    /// Numbers of variance one, by the generator of Steele, Lea and Flood: sums of twelve even ones.
    struct Random(u64);

    impl Random {
        fn normal(&mut self) -> f64 {
            let mut even = || {
                self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
                let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
                let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
                ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| even()).sum::<f64>() - 6.0
        }
    }

    fn layout() -> HostLayout {
        let mut layout = wheel();
        layout.set_exact();
        layout.learn_budget = false;
        layout
    }

    fn frequencies() -> Vec<f64> {
        (0..LINES).map(|line| 0.5 + 0.05 * line as f64).collect()
    }

    /// Responses of the wheel whose gains of single modes have this κ, with white noise.
    fn measured(kappa: f64, white: f64, random: &mut Random) -> Vec<Complex<f64>> {
        let gain = |amplitude: f64| 1.0 + kappa / amplitude * random.normal();
        let mut responses = wheel_responses(&layout(), &frequencies(), gain);
        for response in &mut responses {
            *response += Complex::new(random.normal(), random.normal()) * white;
        }
        responses
    }

    fn answered(responses: &[Complex<f64>]) -> GlobalAnswer {
        let (layout, frequencies) = (layout(), frequencies());
        let readings =
            FrequencyResponses::new(&frequencies, responses, 9, layout.hits.len()).unwrap();
        let start = Bench::named("wheel").unwrap().truth();
        let settings = GlobalFitSettings { most_extra_terms: 0, ..Default::default() };
        GlobalAnswer::of_real_converter(&layout, &readings, &start, &settings).unwrap()
    }

    #[test]
    fn gains_of_single_modes_are_learned_and_widen_the_intervals_until_they_hold() {
        let truth = Bench::named("wheel").unwrap().truth().theta();
        // Of responses that swing by 0.1 to 2 (m/s²)/(N s).
        let kappa = 4e-3;
        let mut random = Random(1);
        let (mut squares, mut count) = (0.0, 0.0);
        for _run in 0..12 {
            let answer = answered(&measured(kappa, WHITE, &mut random));
            // 270 gains that stay have this size and 270 that rise none, which is a κ of all of √½ of it; the fit takes
            // up some of them, and where the white noise drowns them they do not count.
            let ratio = answer.gains.expect("gains").kappa / kappa;
            assert!((0.55..0.95).contains(&ratio), "{ratio}");
            let estimate = &answer.solution.estimate;
            let error = (estimate.theta() - truth).component_div(&estimate.sigma().unwrap());
            squares += error.norm_squared();
            count += 10.0;
        }
        let deviate = (squares / count).sqrt();
        // Half of the columns stay empty, so that the gains count for √½ of their size; 120 numbers of perhaps 60
        // independent ones scatter by 9 %.
        assert!((0.7..1.55).contains(&deviate), "{deviate}");
    }

    #[test]
    fn white_noise_and_exact_responses_have_no_gains() {
        let mut random = Random(5);
        for white in [WHITE, 0.0] {
            let answer = answered(&measured(0.0, white, &mut random));
            assert!(answer.gains.is_none(), "{white}");
        }
    }
}
