//! The mass line: the constant part of an accelerance between the suspension and the elastic modes.
//!
//! ```text
//! H(s) = A + B / s² + C s²        s = σ + iω
//! ```
//! A is the accelerance of the free rigid body, B comes from suspension and gravity, C is the residual of the
//! elastic modes. The coefficients are real; σ is that of the exponential window. Theory, section 5.
//!
//! The design matrix is the same for all channels of a hit, so [`MassLineBasis`] factors it once, and
//! [`MassLineBasis::fit`] costs about twenty multiplications per bin and channel.
#![allow(clippy::needless_range_loop, reason = "triangular matrices read better by their indices")]

mod band;
mod responses;

pub use band::{ABOVE_SUSPENSION, BELOW_ELASTIC, FoundBand, find_band};
pub use responses::{FitSettings, PLATEAU_LIMIT, ResponseFits};

use nalgebra::Complex;

use crate::real::Real;

/// Largest number of terms.
pub const MAX_TERMS: usize = 3;

/// The terms that are fitted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
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
    /// Every choice.
    pub const ALL: [Self; 3] = [Self::A, Self::Ab, Self::Abc];

    /// Their names in files and reports.
    pub const NAMES: [&'static str; 3] = [Self::A.name(), Self::Ab.name(), Self::Abc.name()];

    /// The name in files and reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::A => "a",
            Self::Ab => "ab",
            Self::Abc => "abc",
        }
    }

    /// The terms of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|terms| terms.name() == name)
    }

    /// Number of terms: 1, 2 or 3.
    pub fn count(self) -> usize {
        match self {
            Self::A => 1,
            Self::Ab => 2,
            Self::Abc => 3,
        }
    }
}

/// One bin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin<R> {
    /// Frequency, Hz.
    pub frequency: R,
    /// Weight of the residual, proportional to the inverse variance: for white sensor noise the auto spectrum
    /// of the force, `G_FF`. Only ratios of weights matter.
    pub weight: R,
}

/// Why there is no mass line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MassLineError {
    /// The band does not contain more equations than unknowns: code `band_too_narrow`.
    BandTooNarrow,
    /// A frequency, weight or accelerance is NaN or infinite, a weight is negative or all are zero:
    /// code `data_not_finite`.
    NotFinite,
    /// The frequencies are not in ascending order.
    NotAscending,
    /// The workspace has fewer rows than the band has bins.
    WorkspaceTooSmall,
    /// The accelerances end before the band does.
    LinesMissing,
}

impl core::fmt::Display for MassLineError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::BandTooNarrow => "the band holds too few bins for the mass line",
            Self::NotFinite => "a bin is not finite",
            Self::NotAscending => "the frequencies do not ascend",
            Self::WorkspaceTooSmall => "the band holds more bins than there is memory for",
            Self::LinesMissing => "the accelerance ends before the band does",
        })
    }
}

impl core::error::Error for MassLineError {}

/// One bin of the factored design; the workspace of [`MassLineBasis`] is a slice of these.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BasisRow<R> {
    /// Real parts, orthonormal over the real and imaginary rows of all bins. The first is the square root of
    /// the bin's weight over a constant.
    re: [R; MAX_TERMS],
    /// Imaginary parts of the second and third term; the constant is real.
    im: [R; MAX_TERMS - 1],
}

impl<R: Real> BasisRow<R> {
    /// Imaginary part of a term's column.
    fn im(&self, term: usize) -> R {
        if term == 0 { R::zero() } else { self.im[term - 1] }
    }
}

impl BasisRow<f32> {
    /// All zeros, for a static workspace.
    pub const EMPTY: Self = Self { re: [0.0; MAX_TERMS], im: [0.0; MAX_TERMS - 1] };
}

impl BasisRow<f64> {
    /// All zeros, for a static workspace.
    pub const EMPTY: Self = Self { re: [0.0; MAX_TERMS], im: [0.0; MAX_TERMS - 1] };
}

/// The factored design matrix of the fit: `W^½ [1, ω_r²/s², s²/ω_r²] = Q R` with orthonormal Q.
///
/// ```
/// # use massline_shared::mass_line::{BasisRow, Bin, MassLineBasis, Terms};
/// # use massline_shared::nalgebra::Complex;
/// // Bins 2 Hz apart; A = 0.8 (m/s²)/N on a suspension mode below 3 Hz.
/// let frequencies = || (1..80).map(|k| 2.0 * f64::from(k));
/// let h = |f: f64| {
///     let s = Complex::new(10.0, std::f64::consts::TAU * f);
///     Complex::new(0.8, 0.0) + Complex::new(250.0, 0.0) / (s * s)
/// };
/// let bins = frequencies().map(|frequency| Bin { frequency, weight: 1.0 });
/// let mut memory = [BasisRow::<f64>::EMPTY; 80];
/// let basis = MassLineBasis::new(bins, [10.0, 120.0], 10.0, Terms::Abc, &mut memory)?;
/// let fitted = basis.fit(frequencies().map(h))?;
/// assert!((fitted.accelerance() - 0.8).abs() < 1e-12);
/// // The plain mean of the real parts is biased by the suspension.
/// assert!((basis.mean_real(frequencies().map(h)).unwrap() - 0.8).abs() > 1e-3);
/// # Ok::<(), massline_shared::mass_line::MassLineError>(())
/// ```
#[derive(Debug)]
pub struct MassLineBasis<'a, R> {
    rows: &'a [BasisRow<R>],
    design: MassLineDesign<R>,
}

/// A [`MassLineBasis`] without its rows, which stay in the workspace: the part stored between two steps.
#[derive(Clone, Copy, Debug)]
pub struct MassLineDesign<R> {
    /// Number of bins within the band.
    bins: usize,
    /// Number of bins before the band.
    skipped: usize,
    terms: usize,
    /// True when the imaginary parts are fitted as well.
    complex: bool,
    /// Mean of the weights, by which they were divided.
    mean_weight: R,
    /// Norm of the square roots of these weights, by which the first column of Q was divided.
    root_weight: R,
    /// `R⁻¹`, upper triangular.
    inverse: [[R; MAX_TERMS]; MAX_TERMS],
    /// Factors from the scaled coefficients to A, B and C.
    scale: [R; MAX_TERMS],
}

/// Coefficients of the model; those of terms that were not fitted are zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassLine<R> {
    /// A in (m/s²)/N, B in (m/s⁴)/N, C in m/N.
    pub coefficients: [R; MAX_TERMS],
    /// Formal standard deviations from the scatter of the bins about the model, in the same units.
    /// With an exponential window they are too small by the factor [`window_correlation`].
    pub sigma: [R; MAX_TERMS],
}

impl<R: Real> MassLine<R> {
    /// The accelerance A of the free rigid body, (m/s²)/N.
    pub fn accelerance(&self) -> R {
        self.coefficients[0]
    }

    /// Value of the model at `s`, rad/s.
    pub fn at(&self, s: Complex<R>) -> Complex<R> {
        let square = s * s;
        let inverse = Complex::new(R::one(), R::zero()) / square;
        let [a, b, c] = self.coefficients;
        Complex::new(a + inverse.re * b + square.re * c, inverse.im * b + square.im * c)
    }
}

impl<'a, R: Real> MassLineBasis<'a, R> {
    /// Factors the design matrix of all `bins` within `band` (Hz, both ends included).
    ///
    /// `decay` is σ in 1/s. When it is zero or only A is fitted, only the real parts are used, otherwise real
    /// and imaginary parts. The bins must be in ascending order. `workspace` needs a row for every bin of
    /// the band.
    ///
    /// # Errors
    /// See [`MassLineError`].
    pub fn new(
        bins: impl IntoIterator<Item = Bin<R>>,
        band: [R; 2],
        decay: R,
        terms: Terms,
        workspace: &'a mut [BasisRow<R>],
    ) -> Result<Self, MassLineError> {
        if ![band[0], band[1], decay].iter().all(|v| v.finite()) {
            return Err(MassLineError::NotFinite);
        }
        // With the constant alone, the imaginary parts contain no unknown.
        let complex = decay != R::zero() && terms != Terms::A;
        let FilledDesign { skipped, count, reference, mean_weight } =
            fill(bins, band, decay, workspace)?;
        let terms = terms.count();
        let equations = if complex { 2 * count } else { count };
        if equations <= terms {
            return Err(MassLineError::BandTooNarrow);
        }
        let rows = workspace.get_mut(..count).ok_or(MassLineError::WorkspaceTooSmall)?;
        let inverse = orthonormalise(rows, terms, complex).ok_or(MassLineError::BandTooNarrow)?;
        let scale = [R::one(), reference, R::one() / reference];
        let root_weight = R::one() / inverse[0][0];
        let bins = rows.len();
        let design = MassLineDesign {
            bins,
            skipped,
            terms,
            complex,
            mean_weight,
            root_weight,
            inverse,
            scale,
        };
        Ok(Self { rows, design })
    }

    /// Number of bins within the band.
    pub fn bins(&self) -> usize {
        self.rows.len()
    }

    /// The design without its rows.
    pub fn design(&self) -> MassLineDesign<R> {
        self.design
    }

    /// Fits one channel. `h` is its accelerance at all bins passed to [`MassLineBasis::new`], in the same
    /// order; it is iterated over twice.
    ///
    /// # Errors
    /// [`MassLineError::NotFinite`] and [`MassLineError::LinesMissing`].
    pub fn fit<I>(&self, h: I) -> Result<MassLine<R>, MassLineError>
    where
        I: IntoIterator<Item = Complex<R>>,
        I::IntoIter: Clone,
    {
        let h = h.into_iter().skip(self.design.skipped);
        let zero = R::zero();
        let mut projection = [zero; MAX_TERMS];
        let mut count = 0;
        for (row, h) in self.rows.iter().zip(h.clone()) {
            let (re, im) = self.weighted(row, h);
            for (k, sum) in projection.iter_mut().enumerate() {
                *sum += row.re[k] * re + row.im(k) * im;
            }
            count += 1;
        }
        if count < self.rows.len() {
            return Err(MassLineError::LinesMissing);
        }
        let mut residual = zero;
        for (row, h) in self.rows.iter().zip(h) {
            let (mut re, mut im) = self.weighted(row, h);
            for (k, p) in projection.iter().enumerate() {
                re -= row.re[k] * *p;
                im -= row.im(k) * *p;
            }
            residual += re * re;
            if self.design.complex {
                residual += im * im;
            }
        }
        let fitted = self.coefficients(&projection, residual);
        let finite = fitted.coefficients.iter().chain(&fitted.sigma).all(|v| v.finite());
        if finite { Ok(fitted) } else { Err(MassLineError::NotFinite) }
    }

    /// Plain mean of the real parts over the band, (m/s²)/N: the traditional way to read a mass line. `None`
    /// when the accelerances end before the band does.
    pub fn mean_real(&self, h: impl IntoIterator<Item = Complex<R>>) -> Option<R> {
        let mut sum = R::zero();
        let mut count = 0;
        for (_, h) in self.rows.iter().zip(h.into_iter().skip(self.design.skipped)) {
            sum += h.re;
            count += 1;
        }
        (count == self.rows.len()).then(|| sum / R::of(count as f64))
    }

    /// An accelerance times the square root of its bin's weight.
    fn weighted(&self, row: &BasisRow<R>, h: Complex<R>) -> (R, R) {
        let root = row.re[0] * self.design.root_weight;
        (root * h.re, root * h.im)
    }

    fn coefficients(&self, projection: &[R; MAX_TERMS], residual: R) -> MassLine<R> {
        let zero = R::zero();
        let equations = self.rows.len() * if self.design.complex { 2 } else { 1 };
        let spread = (residual / R::of((equations - self.design.terms) as f64)).sqrt();
        let mut fitted = MassLine { coefficients: [zero; MAX_TERMS], sigma: [zero; MAX_TERMS] };
        for i in 0..self.design.terms {
            let mut value = zero;
            let mut variance = zero;
            for k in i..self.design.terms {
                value += self.design.inverse[i][k] * projection[k];
                variance += self.design.inverse[i][k] * self.design.inverse[i][k];
            }
            fitted.coefficients[i] = value * self.design.scale[i];
            fitted.sigma[i] = variance.sqrt() * spread * self.design.scale[i];
        }
        fitted
    }
}

impl<R: Real> MassLineDesign<R> {
    /// Sum of the weights of the bins in the band.
    pub fn total_weight(&self) -> R {
        self.mean_weight * R::of(self.bins as f64)
    }

    /// Variance of A when every bin has, in real and imaginary part, a variance of one over its weight;
    /// correlated bins are taken as independent.
    pub fn variance(&self) -> R {
        let row = &self.inverse[0][..self.terms];
        row.iter().fold(R::zero(), |sum, v| sum + *v * *v) / self.mean_weight
    }

    /// Restores the basis over the workspace in which it was computed; `None` when that is too small.
    pub fn over<'a>(&self, workspace: &'a [BasisRow<R>]) -> Option<MassLineBasis<'a, R>> {
        Some(MassLineBasis { rows: workspace.get(..self.bins)?, design: *self })
    }
}

/// Factor by which the formal standard deviation of a mass line is too small, because an exponential window
/// `e^(−σt)` over a record correlates neighbouring bins: `√(B_n T)` with `B_n = ∫w⁴ / (∫w²)²`. `decay` is σ
/// in 1/s, `record` T in s; one without a window.
///
/// Theory, section 5.
///
/// ```
/// # use massline_shared::mass_line::window_correlation;
/// assert_eq!(window_correlation(0.0, 0.512), 1.0);
/// // A window that has decayed at the end of the record: √(σ T).
/// let factor: f64 = window_correlation(10.0, 0.512);
/// assert!((factor - 5.12_f64.sqrt()).abs() < 1e-3);
/// ```
pub fn window_correlation<R: Real>(decay: R, record: R) -> R {
    let x = decay * record;
    if x <= R::zero() {
        return R::one();
    }
    // ∫w⁴ = (1 − e^−4x) / 4σ contains ∫w² = (1 − e^−2x) / 2σ as a factor.
    let e = (x * R::of(-2.0)).exp();
    (x * (R::one() + e) / (R::one() - e)).sqrt()
}

/// The design that [`fill`] has written.
struct FilledDesign<R> {
    /// Number of bins before the band.
    skipped: usize,
    /// Number of bins within it.
    count: usize,
    /// `ω_r²`, the product of the first and the last `|s|` in the band.
    reference: R,
    /// Mean of the weights of the bins within the band.
    mean_weight: R,
}

/// Writes the scaled and weighted design of the bins within the band.
fn fill<R: Real>(
    bins: impl IntoIterator<Item = Bin<R>>,
    band: [R; 2],
    decay: R,
    workspace: &mut [BasisRow<R>],
) -> Result<FilledDesign<R>, MassLineError> {
    let (mut skipped, mut count) = (0, 0);
    let mut sum = R::zero();
    let mut previous: Option<R> = None;
    let mut first = R::zero();
    for bin in bins {
        if previous.is_some_and(|before| bin.frequency <= before) {
            return Err(MassLineError::NotAscending);
        }
        previous = Some(bin.frequency);
        if !(bin.frequency.finite() && bin.weight.finite() && bin.weight >= R::zero()) {
            return Err(MassLineError::NotFinite);
        }
        if bin.frequency < band[0] {
            skipped += 1;
        } else if bin.frequency <= band[1] {
            let row = workspace.get_mut(count).ok_or(MassLineError::WorkspaceTooSmall)?;
            let omega = bin.frequency * R::two_pi();
            if count == 0 {
                first = omega;
            }
            row.re[0] = bin.weight.sqrt();
            // Unscaled s², until the scale is known.
            row.re[1] = decay * decay - omega * omega;
            row.im[0] = decay * omega * R::of(2.0);
            sum += bin.weight;
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
    // A band that starts at s = 0 is scaled by its last bin alone.
    let last = (last.re[1] * last.re[1] + last.im[0] * last.im[0]).sqrt();
    let from = (decay * decay + first * first).sqrt();
    let reference = if from > R::zero() { from * last.sqrt() } else { last };
    if reference <= R::zero() || !reference.finite() {
        return Err(MassLineError::BandTooNarrow);
    }
    let mean_weight = sum / R::of(count as f64);
    let to_mean_one = (R::of(count as f64) / sum).sqrt();
    for row in rows {
        let w = row.re[0] * to_mean_one;
        let (re, im) = (row.re[1] / reference, row.im[0] / reference);
        // At s = 0 the suspension term is undefined and gets no weight.
        let norm = re * re + im * im;
        let over = if norm > R::zero() { w / norm } else { R::zero() };
        row.re = [w, re * over, re * w];
        row.im = [-im * over, im * w];
    }
    Ok(FilledDesign { skipped, count, reference, mean_weight })
}

/// Replaces the design by its orthonormal factor and returns the inverse of the triangular one, by modified
/// Gram-Schmidt with a second pass, which is as good as Householder. Terms that are not fitted become zero.
/// `None` when the columns are not independent.
fn orthonormalise<R: Real>(
    rows: &mut [BasisRow<R>],
    terms: usize,
    complex: bool,
) -> Option<[[R; MAX_TERMS]; MAX_TERMS]> {
    let zero = R::zero();
    for row in rows.iter_mut() {
        if !complex {
            row.im = [zero; MAX_TERMS - 1];
        }
        row.re[terms..].fill(zero);
        row.im[terms - 1..].fill(zero);
    }
    let dot = |rows: &[BasisRow<R>], i: usize, k: usize| {
        rows.iter().fold(zero, |sum, r| sum + r.re[i] * r.re[k] + r.im(i) * r.im(k))
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
                    r.im[k - 1] -= part * r.im(i);
                }
            }
        }
        let norm = dot(rows, k, k).sqrt();
        // The remainder of a dependent column is rounding.
        if norm <= before * R::default_epsilon() * R::of(10.0) || !norm.finite() {
            return None;
        }
        factor[k][k] = norm;
        for r in rows.iter_mut() {
            r.re[k] /= norm;
            if k > 0 {
                r.im[k - 1] /= norm;
            }
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
mod tests;
