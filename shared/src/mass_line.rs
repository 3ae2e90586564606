//! The mass line: the constant part of an accelerance between the suspension and the elastic modes.
//!
//! ```text
//! H(s) = A + B / s² + C s²        s = σ + iω
//! ```
//! A is the accelerance of the free rigid body, B the suspension and gravity, C the residual of the
//! elastic modes. The coefficients are real; σ belongs to an exponential window. Theory, section 5.
//!
//! The design is the same for all channels of a hit, so [`MassLineBasis`] factors it once and
//! [`MassLineBasis::fit`] costs about twenty multiplications a line and channel.
#![allow(clippy::needless_range_loop, reason = "triangular matrices read better by their indices")]

use nalgebra::Complex;

use crate::Real;

/// Most terms of the model.
pub const MAX_TERMS: usize = 3;

/// Which terms are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Terms {
    /// A alone.
    A,
    /// A and the suspension's `B/s²`.
    Ab,
    /// A, `B/s²` and the elastic residual `C s²`.
    #[default]
    Abc,
}

impl Terms {
    /// How many: 1, 2 or 3.
    pub fn count(self) -> usize {
        match self {
            Self::A => 1,
            Self::Ab => 2,
            Self::Abc => 3,
        }
    }
}

/// One spectral line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<R> {
    /// Hz.
    pub frequency: R,
    /// Weight of its residual, proportional to the inverse variance: the auto spectrum of the force
    /// `G_FF` for white sensor noise. Only the ratio of the weights counts.
    pub weight: R,
}

/// Why there is no mass line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MassLineError {
    /// The band does not hold more equations than unknowns: code `band_too_narrow`.
    BandTooNarrow,
    /// A frequency, weight or accelerance is NaN or infinite, a weight is negative or all are zero:
    /// code `data_not_finite`.
    NotFinite,
    /// The frequencies do not ascend.
    NotAscending,
    /// The workspace holds fewer lines than the band.
    WorkspaceTooSmall,
    /// The accelerances end before the band does.
    LinesMissing,
}

impl core::fmt::Display for MassLineError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::BandTooNarrow => "the band holds too few lines for the mass line",
            Self::NotFinite => "a spectral line is not finite",
            Self::NotAscending => "the frequencies do not ascend",
            Self::WorkspaceTooSmall => "the band holds more lines than there is memory for",
            Self::LinesMissing => "the accelerance ends before the band does",
        })
    }
}

impl core::error::Error for MassLineError {}

/// What one line keeps of the factored design; the workspace of [`MassLineBasis`] is a slice of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BasisRow<R> {
    root_weight: R,
    /// Orthonormal over the real and imaginary rows of all lines.
    re: [R; MAX_TERMS],
    im: [R; MAX_TERMS],
}

impl BasisRow<f32> {
    /// All zeros, for a static workspace.
    pub const EMPTY: Self =
        Self { root_weight: 0.0, re: [0.0; MAX_TERMS], im: [0.0; MAX_TERMS] };
}

/// The design of the fit, factored: `W^½ [1, ω_r²/s², s²/ω_r²] = Q R` with orthonormal Q.
#[derive(Debug)]
pub struct MassLineBasis<'a, R> {
    rows: &'a [BasisRow<R>],
    /// Lines before the band.
    skipped: usize,
    terms: usize,
    /// The imaginary parts are fitted too.
    complex: bool,
    /// `R⁻¹`, upper triangular.
    inverse: [[R; MAX_TERMS]; MAX_TERMS],
    /// What turns the scaled coefficients into A, B and C.
    scale: [R; MAX_TERMS],
}

/// Coefficients of the model; those of terms that were not fitted are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassLine<R> {
    /// A in (m/s²)/N, B in (m/s⁴)/N, C in m/N.
    pub coefficients: [R; MAX_TERMS],
    /// Formal standard deviations from the scatter of the lines about the model, in the same units.
    /// With an exponential window they are too small by [`window_correlation`].
    pub sigma: [R; MAX_TERMS],
}

impl<R: Real> MassLine<R> {
    /// The accelerance A of the free rigid body, (m/s²)/N.
    pub fn accelerance(&self) -> R {
        self.coefficients[0]
    }

    /// The model at `s`, rad/s.
    pub fn at(&self, s: Complex<R>) -> Complex<R> {
        let square = s * s;
        let inverse = Complex::new(R::one(), R::zero()) / square;
        let [a, b, c] = self.coefficients;
        Complex::new(a + inverse.re * b + square.re * c, inverse.im * b + square.im * c)
    }
}

impl<'a, R: Real> MassLineBasis<'a, R> {
    /// Factors the design of all `lines` within `band` (Hz, both ends included).
    ///
    /// `decay` is σ in 1/s: with zero, or with A alone, only the real parts are fitted, else real and
    /// imaginary parts.
    /// The lines must ascend in frequency. `workspace` needs a row for every line of the band.
    ///
    /// # Errors
    /// See [`MassLineError`].
    pub fn new(
        lines: impl IntoIterator<Item = Line<R>>,
        band: [R; 2],
        decay: R,
        terms: Terms,
        workspace: &'a mut [BasisRow<R>],
    ) -> Result<Self, MassLineError> {
        if ![band[0], band[1], decay].iter().all(|v| v.finite()) {
            return Err(MassLineError::NotFinite);
        }
        // The constant alone leaves no unknown in the imaginary parts.
        let complex = decay != R::zero() && terms != Terms::A;
        let (skipped, count, reference) = fill(lines, band, decay, workspace)?;
        let terms = terms.count();
        let equations = if complex { 2 * count } else { count };
        if equations <= terms {
            return Err(MassLineError::BandTooNarrow);
        }
        let rows = workspace.get_mut(..count).ok_or(MassLineError::WorkspaceTooSmall)?;
        let inverse = orthonormalise(rows, terms, complex).ok_or(MassLineError::BandTooNarrow)?;
        let scale = [R::one(), reference, R::one() / reference];
        Ok(Self { rows, skipped, terms, complex, inverse, scale })
    }

    /// Lines within the band.
    pub fn lines(&self) -> usize {
        self.rows.len()
    }

    /// Fits one channel. `h` is its accelerance at all lines that [`MassLineBasis::new`] was given,
    /// in the same order; it is walked twice.
    ///
    /// # Errors
    /// [`MassLineError::NotFinite`] and [`MassLineError::LinesMissing`].
    pub fn fit<I>(&self, h: I) -> Result<MassLine<R>, MassLineError>
    where
        I: IntoIterator<Item = Complex<R>>,
        I::IntoIter: Clone,
    {
        let h = h.into_iter().skip(self.skipped);
        let zero = R::zero();
        let mut projection = [zero; MAX_TERMS];
        let mut count = 0;
        for (row, h) in self.rows.iter().zip(h.clone()) {
            let (re, im) = (row.root_weight * h.re, row.root_weight * h.im);
            for (k, sum) in projection.iter_mut().enumerate() {
                *sum += row.re[k] * re + row.im[k] * im;
            }
            count += 1;
        }
        if count < self.rows.len() {
            return Err(MassLineError::LinesMissing);
        }
        let mut residual = zero;
        for (row, h) in self.rows.iter().zip(h) {
            let (mut re, mut im) = (row.root_weight * h.re, row.root_weight * h.im);
            for (k, p) in projection.iter().enumerate() {
                re -= row.re[k] * *p;
                im -= row.im[k] * *p;
            }
            residual += re * re;
            if self.complex {
                residual += im * im;
            }
        }
        let line = self.coefficients(&projection, residual);
        let finite = line.coefficients.iter().chain(&line.sigma).all(|v| v.finite());
        if finite { Ok(line) } else { Err(MassLineError::NotFinite) }
    }

    /// Plain mean of the real parts over the band, (m/s²)/N: the mass line as it was read before
    /// fits. `None` when the accelerances end before the band does.
    pub fn mean_real(&self, h: impl IntoIterator<Item = Complex<R>>) -> Option<R> {
        let mut sum = R::zero();
        let mut count = 0;
        for (_, h) in self.rows.iter().zip(h.into_iter().skip(self.skipped)) {
            sum += h.re;
            count += 1;
        }
        (count == self.rows.len()).then(|| sum / R::of(count as f64))
    }

    fn coefficients(&self, projection: &[R; MAX_TERMS], residual: R) -> MassLine<R> {
        let zero = R::zero();
        let equations = self.rows.len() * if self.complex { 2 } else { 1 };
        let spread = (residual / R::of((equations - self.terms) as f64)).sqrt();
        let mut line = MassLine { coefficients: [zero; MAX_TERMS], sigma: [zero; MAX_TERMS] };
        for i in 0..self.terms {
            let mut value = zero;
            let mut variance = zero;
            for k in i..self.terms {
                value += self.inverse[i][k] * projection[k];
                variance += self.inverse[i][k] * self.inverse[i][k];
            }
            line.coefficients[i] = value * self.scale[i];
            line.sigma[i] = variance.sqrt() * spread * self.scale[i];
        }
        line
    }
}

/// By how much the formal standard deviation of a mass line is too small because an exponential
/// window `e^(−σt)` over a record correlates neighbouring lines: `√(B_n T)` with
/// `B_n = ∫w⁴ / (∫w²)²`. `decay` is σ in 1/s, `record` T in s; one without a window.
pub fn window_correlation<R: Real>(decay: R, record: R) -> R {
    let x = decay * record;
    if x <= R::zero() {
        return R::one();
    }
    // ∫w⁴ = (1 − e^−4x) / 4σ and ∫w² = (1 − e^−2x) / 2σ; the first factors into the second.
    let e = (x * R::of(-2.0)).exp();
    (x * (R::one() + e) / (R::one() - e)).sqrt()
}

/// Writes the scaled and weighted design of the lines within the band; gives the number of lines
/// before the band, within it, and `ω_r²`, the product of the first and last `ω`.
fn fill<R: Real>(
    lines: impl IntoIterator<Item = Line<R>>,
    band: [R; 2],
    decay: R,
    workspace: &mut [BasisRow<R>],
) -> Result<(usize, usize, R), MassLineError> {
    let (mut skipped, mut count) = (0, 0);
    let mut sum = R::zero();
    let mut previous: Option<R> = None;
    let mut first = R::zero();
    for line in lines {
        if previous.is_some_and(|before| line.frequency <= before) {
            return Err(MassLineError::NotAscending);
        }
        previous = Some(line.frequency);
        if !(line.frequency.finite() && line.weight.finite() && line.weight >= R::zero()) {
            return Err(MassLineError::NotFinite);
        }
        if line.frequency < band[0] {
            skipped += 1;
        } else if line.frequency <= band[1] {
            let row = workspace.get_mut(count).ok_or(MassLineError::WorkspaceTooSmall)?;
            let omega = line.frequency * R::two_pi();
            if count == 0 {
                first = omega;
            }
            row.root_weight = line.weight.sqrt();
            // The plain s² until the scale is known.
            row.re[1] = decay * decay - omega * omega;
            row.im[1] = decay * omega * R::of(2.0);
            sum += line.weight;
            count += 1;
        } else {
            break;
        }
    }
    let rows = workspace.get_mut(..count).unwrap_or_default();
    let Some(last) = rows.last() else {
        return Err(MassLineError::BandTooNarrow);
    };
    if sum <= R::zero() || !sum.finite() {
        return Err(MassLineError::NotFinite);
    }
    // A band that begins at 0 Hz is scaled by its last line alone.
    let last = (last.re[1] * last.re[1] + last.im[1] * last.im[1]).sqrt();
    let from = (decay * decay + first * first).sqrt();
    let reference = if from > R::zero() { from * last.sqrt() } else { last };
    if reference <= R::zero() || !reference.finite() {
        return Err(MassLineError::BandTooNarrow);
    }
    let to_mean_one = (R::of(count as f64) / sum).sqrt();
    for row in rows {
        row.root_weight *= to_mean_one;
        let w = row.root_weight;
        let (re, im) = (row.re[1] / reference, row.im[1] / reference);
        // At s = 0 the suspension's term has no value: such a line says nothing.
        let norm = re * re + im * im;
        let over = if norm > R::zero() { w / norm } else { R::zero() };
        row.re = [w, re * over, re * w];
        row.im = [R::zero(), -im * over, im * w];
    }
    Ok((skipped, count, reference))
}

/// Turns the design into its orthonormal factor, in place, and gives the inverse of the triangular
/// one: modified Gram-Schmidt with a second pass, which is as good as Householder. Terms that are
/// not fitted become zero. `None` when the columns are not independent.
fn orthonormalise<R: Real>(
    rows: &mut [BasisRow<R>],
    terms: usize,
    complex: bool,
) -> Option<[[R; MAX_TERMS]; MAX_TERMS]> {
    let zero = R::zero();
    for row in rows.iter_mut() {
        if !complex {
            row.im = [zero; MAX_TERMS];
        }
        for k in terms..MAX_TERMS {
            (row.re[k], row.im[k]) = (zero, zero);
        }
    }
    let dot = |rows: &[BasisRow<R>], i: usize, k: usize| {
        rows.iter().fold(zero, |sum, r| sum + r.re[i] * r.re[k] + r.im[i] * r.im[k])
    };
    let mut factor = [[zero; MAX_TERMS]; MAX_TERMS];
    for k in 0..terms {
        let before = dot(rows, k, k).sqrt();
        for _pass in 0..2 {
            for i in 0..k {
                let part = dot(rows, i, k);
                factor[i][k] += part;
                for r in rows.iter_mut() {
                    r.re[k] -= part * r.re[i];
                    r.im[k] -= part * r.im[i];
                }
            }
        }
        let norm = dot(rows, k, k).sqrt();
        // What is left of a dependent column is rounding.
        if norm <= before * R::default_epsilon() * R::of(10.0) || !norm.finite() {
            return None;
        }
        factor[k][k] = norm;
        for r in rows.iter_mut() {
            r.re[k] /= norm;
            r.im[k] /= norm;
        }
    }
    let mut inverse = [[zero; MAX_TERMS]; MAX_TERMS];
    for k in 0..terms {
        inverse[k][k] = R::one() / factor[k][k];
        for i in (0..k).rev() {
            let mut sum = zero;
            for j in i + 1..=k {
                sum += factor[i][j] * inverse[j][k];
            }
            inverse[i][k] = -sum / factor[i][i];
        }
    }
    Some(inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    /// The rig's lines: 4 kS/s over 2048 scans.
    const RESOLUTION: f64 = 4000.0 / 2048.0;

    fn lines<R: Real>() -> impl Iterator<Item = Line<R>> + Clone {
        // The force spectrum of a soft tap falls towards high lines.
        (0..128).map(|k| {
            let frequency = RESOLUTION * f64::from(k);
            Line { frequency: R::of(frequency), weight: R::of(3.0 / (1.0 + frequency / 100.0)) }
        })
    }

    fn model<R: Real>(abc: [f64; 3], decay: f64) -> Vec<Complex<R>> {
        let line = MassLine { coefficients: abc, sigma: [0.0; 3] };
        let at = |l: Line<f64>| {
            let s = Complex::new(decay, 2.0 * core::f64::consts::PI * l.frequency);
            let h = line.at(s);
            Complex::new(R::of(h.re), R::of(h.im))
        };
        lines::<f64>().map(at).collect()
    }

    fn fit<R: Real + Default>(
        h: &[Complex<R>],
        decay: f64,
        terms: Terms,
    ) -> Result<MassLine<R>, MassLineError> {
        let mut workspace = [BasisRow::default(); 64];
        let band = [R::of(10.0), R::of(120.0)];
        MassLineBasis::new(lines(), band, R::of(decay), terms, &mut workspace)?
            .fit(h.iter().copied())
    }

    proptest! {
        #[test]
        fn the_three_terms_come_back(
            a in -3.0..3.0_f64,
            b in -2000.0..2000.0_f64,
            c in -1e-6..1e-6_f64,
            decay in prop_oneof![Just(0.0), 5.0..20.0_f64],
        ) {
            let exact = fit(&model::<f64>([a, b, c], decay), decay, Terms::Abc).unwrap();
            // Rounding times the condition 9 of the scaled basis; scales of B and C are those of
            // the largest term within the band: ω from 63 to 750 rad/s.
            let error = [exact.coefficients[0] - a, exact.coefficients[1] - b, exact.coefficients[2] - c];
            prop_assert!(error[0].abs() < 1e-12 && error[1].abs() < 1e-8 && error[2].abs() < 1e-17);
            let single = fit(&model::<f32>([a, b, c], decay), decay, Terms::Abc).unwrap();
            // Theory, section 10: 1e-6 of the largest accelerance, here below 4.
            prop_assert!((f64::from(single.accelerance()) - a).abs() < 8e-6);
        }
    }

    #[test]
    fn without_its_term_the_suspension_stays_in_the_mass_line() {
        let h = model::<f64>([1.0, 500.0, 0.0], 10.0);
        let a = fit(&h, 10.0, Terms::A).unwrap();
        let ab = fit(&h, 10.0, Terms::Ab).unwrap();
        assert!((a.accelerance() - 1.0).abs() > 1e-3 && a.coefficients[1..] == [0.0, 0.0]);
        assert!((ab.accelerance() - 1.0).abs() < 1e-12 && ab.coefficients[2] == 0.0);
        assert!(a.sigma[0] > 100.0 * ab.sigma[0]);
    }

    #[test]
    fn the_standard_deviation_is_that_of_many_fits() {
        // Uniform noise of ±0.1 on both parts from a linear congruence: deviation 0.1/√3.
        let mut state = 1_u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5) * 0.2
        };
        let clean = model::<f64>([1.0, 100.0, 1e-7], 10.0);
        let mut workspace = [BasisRow::default(); 64];
        let flat = lines::<f64>().map(|l| Line { weight: 1.0, ..l });
        let basis =
            MassLineBasis::new(flat, [10.0, 120.0], 10.0, Terms::Abc, &mut workspace).unwrap();
        let (mut sum, mut squares, mut formal) = (0.0, 0.0, 0.0);
        let runs = 2000;
        for _ in 0..runs {
            let noisy: Vec<_> = clean.iter().map(|h| h + Complex::new(noise(), noise())).collect();
            let line = basis.fit(noisy).unwrap();
            sum += line.accelerance();
            squares += line.accelerance() * line.accelerance();
            formal += line.sigma[0];
        }
        let runs = f64::from(runs);
        let mean: f64 = sum / runs;
        let sigma = (squares / runs - mean * mean).sqrt();
        // A deviation over 2000 runs is known to 1.6 %; four of those.
        assert!((formal / runs / sigma - 1.0).abs() < 0.064, "{} {sigma}", formal / runs);
        assert!((mean - 1.0).abs() < 4.0 * sigma / runs.sqrt());
    }

    #[test]
    fn a_band_with_as_many_equations_as_unknowns_is_too_narrow() {
        let mut workspace = [BasisRow::default(); 64];
        let mut with = |band: [f64; 2], decay| {
            MassLineBasis::new(lines(), band, decay, Terms::Abc, &mut workspace).map(|b| b.lines())
        };
        let upto = |k: f64| [RESOLUTION, RESOLUTION * k];
        assert_eq!(with(upto(3.0), 0.0), Err(MassLineError::BandTooNarrow));
        assert_eq!(with(upto(4.0), 0.0), Ok(4));
        assert_eq!(with(upto(1.0), 10.0), Err(MassLineError::BandTooNarrow));
        assert_eq!(with(upto(2.0), 10.0), Ok(2));
        assert_eq!(with([1000.0, 2000.0], 10.0), Err(MassLineError::BandTooNarrow));
        assert_eq!(with([120.0, 10.0], 10.0), Err(MassLineError::BandTooNarrow));
    }

    #[test]
    fn a_line_at_zero_hertz_says_nothing_about_the_suspension() {
        let mut workspace = [BasisRow::default(); 64];
        let basis =
            MassLineBasis::new(lines(), [0.0, 100.0], 0.0, Terms::Ab, &mut workspace).unwrap();
        let h: Vec<_> = model::<f64>([1.0, 0.0, 0.0], 1e-9);
        assert!((basis.fit(h).unwrap().accelerance() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bad_numbers_are_refused() {
        let mut h = model::<f32>([1.0, 0.0, 0.0], 10.0);
        h[0] = Complex::new(f32::NAN, 0.0);
        assert!(fit(&h, 10.0, Terms::Abc).is_ok(), "outside the band");
        h[20].im = f32::INFINITY;
        assert_eq!(fit(&h, 10.0, Terms::Abc), Err(MassLineError::NotFinite));
        assert_eq!(fit(&h[..40], 10.0, Terms::Abc), Err(MassLineError::LinesMissing));
        let mut workspace = [BasisRow::default(); 64];
        let mut with = |spoil: fn(&mut Line<f32>)| {
            let lines = lines().enumerate().map(|(k, mut line)| {
                if k == 20 {
                    spoil(&mut line);
                }
                line
            });
            let band = [10.0, 120.0];
            MassLineBasis::new(lines, band, 10.0, Terms::Abc, &mut workspace).err()
        };
        assert_eq!(with(|_| {}), None);
        assert_eq!(with(|l| l.weight = f32::NAN), Some(MassLineError::NotFinite));
        assert_eq!(with(|l| l.weight = -1.0), Some(MassLineError::NotFinite));
        assert_eq!(with(|l| l.frequency = 1.0), Some(MassLineError::NotAscending));
        let nothing = lines::<f32>().map(|l| Line { weight: 0.0, ..l });
        let band = [10.0, 120.0];
        let found = MassLineBasis::new(nothing, band, 10.0, Terms::Abc, &mut workspace).err();
        assert_eq!(found, Some(MassLineError::NotFinite));
        let small = &mut [BasisRow::default(); 8];
        let found = MassLineBasis::new(lines::<f32>(), band, 10.0, Terms::Abc, small).err();
        assert_eq!(found, Some(MassLineError::WorkspaceTooSmall));
    }

    #[test]
    fn the_window_correlation_is_the_quotient_of_its_integrals() {
        let (decay, record) = (10.0, 0.512);
        let steps = 200_000;
        let dt = record / f64::from(steps);
        let integral = |power: f64| -> f64 {
            (0..steps).map(|k| (-decay * power * (f64::from(k) + 0.5) * dt).exp() * dt).sum()
        };
        let expected = (integral(4.0) / integral(2.0).powi(2) * record).sqrt();
        // Midpoint rule with 200 000 steps.
        assert!((window_correlation(decay, record) - expected).abs() < 1e-8);
        assert_eq!(window_correlation(0.0, record), 1.0);
    }
}
