//! The cases as data, and the comparison under their tolerance rules.

use core::marker::PhantomData;

use massline_shared::capacity::Capacity;
use massline_shared::{Real, ResponseRows};

include!(concat!(env!("OUT_DIR"), "/cases.rs"));

/// Called with case, path, whether it passes, and the largest error as a fraction of the tolerance.
pub type Report<'a> = dyn FnMut(&str, &str, bool, f64) + 'a;

/// One golden case.
#[derive(Debug)]
pub struct Case {
    /// The file's name without `.json`.
    pub id: &'static str,
    /// The method that is computed, see the schema.
    pub method: &'static str,
    /// Inputs and expected outputs under `inputs.` and `expected.`.
    pub arrays: &'static [Array],
    /// The tolerances that apply.
    pub rules: &'static [Rule],
}

/// Numbers or texts under a dotted path.
#[derive(Debug)]
pub struct Array {
    /// For example `inputs.sensors.R`.
    pub path: &'static str,
    /// Shape, row-major; empty for a single number.
    pub shape: &'static [usize],
    /// The values.
    pub values: Values,
}

/// The values of an array.
#[derive(Clone, Copy, Debug)]
pub enum Values {
    /// Any numbers; NaN where the file says `null`.
    Real(&'static [f64]),
    /// Whole numbers below 65536.
    Whole(&'static [u16]),
    /// Names.
    Text(&'static [&'static str]),
}

impl Values {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Self::Real(values) => values.len(),
            Self::Whole(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number at an index, row-major.
    pub fn get(&self, index: usize) -> Option<f64> {
        match self {
            Self::Real(values) => values.get(index).copied(),
            Self::Whole(values) => values.get(index).copied().map(f64::from),
            Self::Text(_) => None,
        }
    }

    /// All numbers, row-major.
    pub fn iter(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        (0..self.len()).filter_map(|index| self.get(index))
    }
}

/// A tolerance: `|got − expected| ≤ abs + rel · max|expected|`.
#[derive(Debug)]
pub struct Rule {
    /// Path below `expected`; `*.` stands for every member.
    pub path: &'static str,
    /// Absolute tolerance: one number for all values or one for each.
    pub abs: Option<&'static [f64]>,
    /// Tolerance relative to the largest expected value.
    pub rel: Option<f64>,
    /// Replaces `abs` in single precision.
    pub abs_f32: Option<&'static [f64]>,
    /// Replaces `rel` in single precision.
    pub rel_f32: Option<f64>,
    /// The number must be at least this.
    pub min: Option<f64>,
    /// Columns may have either sign.
    pub columns_up_to_sign: bool,
    /// The names may come in any order.
    pub set: bool,
}

impl Rule {
    /// The tolerance of the number at an index, in the precision `R`; `largest` is the largest expected magnitude.
    fn tolerance<R>(&self, index: usize, largest: f64) -> f64 {
        let single = size_of::<R>() == size_of::<f32>();
        let abs = if single { self.abs_f32.or(self.abs) } else { self.abs };
        let rel = if single { self.rel_f32.or(self.rel) } else { self.rel };
        let abs = abs.and_then(|list| if list.len() == 1 { list.first() } else { list.get(index) });
        abs.copied().unwrap_or(0.0) + rel.unwrap_or(0.0) * largest
    }
}

impl Case {
    /// The case of this name.
    pub fn find(id: &str) -> Option<&'static Self> {
        CASES.iter().find(|case| case.id == id)
    }

    /// The array at a path, for example `inputs.hits.q`.
    pub fn array(&self, path: &str) -> Option<&'static Array> {
        self.arrays.iter().find(|array| array.path == path)
    }

    /// The values of the array at a path.
    pub fn real(&self, path: &str) -> Option<Values> {
        self.array(path).map(|array| array.values)
    }

    /// The single number at a path.
    pub fn number(&self, path: &str) -> Option<f64> {
        self.real(path)?.get(0)
    }

    fn rule(&self, path: &str) -> Option<(usize, &'static Rule)> {
        self.rules.iter().enumerate().find(|(_, rule)| match rule.path.strip_prefix("*.") {
            Some(rest) => path.split_once('.').is_some_and(|(_, below)| below == rest),
            None => rule.path == path,
        })
    }
}

/// Compares computed values with the expected values of one case.
pub struct Check<'a, 'b, R> {
    /// The case.
    pub case: &'static Case,
    report: &'a mut Report<'b>,
    /// A bit for every rule that a value was compared under.
    answered: u64,
    precision: PhantomData<R>,
}

impl<'a, 'b, R: Real> Check<'a, 'b, R> {
    /// A check of this case.
    pub fn new(case: &'static Case, report: &'a mut Report<'b>) -> Self {
        Self { case, report, answered: 0, precision: PhantomData }
    }

    /// The numbers of an input in the precision `R`.
    pub fn input(&self, name: &str) -> Option<impl Iterator<Item = R> + Clone + use<R>> {
        let values = self.find(&["inputs.", name])?;
        Some((0..values.len()).map(move |i| R::of(values.get(i).unwrap_or(f64::NAN))))
    }

    /// A single number of the inputs.
    pub fn input_number(&self, name: &str) -> Option<R> {
        self.input(name)?.next()
    }

    /// The numbers of an input whose array has exactly `N` of them; otherwise `None`.
    pub fn input_array<const N: usize>(&self, name: &str) -> Option<[R; N]> {
        let values = self.find(&["inputs.", name])?;
        (values.len() == N)
            .then(|| core::array::from_fn(|i| R::of(values.get(i).unwrap_or(f64::NAN))))
    }

    /// Compares numbers, row-major, with `expected.{path}`; does nothing without a rule for it.
    pub fn numbers(&mut self, path: &str, got: &[R]) {
        self.numbers_within(path, got, 1.0);
    }

    /// As [`Check::numbers`], with this many times the tolerance of the file.
    pub fn numbers_within(&mut self, path: &str, got: &[R], slack: f64) {
        let Some((index, rule)) = self.case.rule(path) else {
            return;
        };
        self.answered |= 1 << index;
        let Some(expected) = self.case.arrays.iter().find(|a| below_expected(a.path, path)) else {
            return self.fail(path);
        };
        if expected.values.len() != got.len() || got.is_empty() {
            return self.fail(path);
        }
        let worst = compare(expected, rule, got) / slack;
        (self.report)(self.case.id, path, worst <= 1.0, worst);
    }

    /// Compares complex numbers, row-major: the modulus of each error with the tolerance.
    pub fn complex_numbers(&mut self, path: &str, got: &[nalgebra::Complex<R>]) {
        let Some((index, rule)) = self.case.rule(path) else {
            return;
        };
        self.answered |= 1 << index;
        let part = |end: &str| {
            let is = |a: &&Array| a.path.strip_suffix(end).is_some_and(|a| below_expected(a, path));
            self.case.arrays.iter().find(is).map(|a| a.values)
        };
        let (Some(re), Some(im)) = (part(".re"), part(".im")) else { return self.fail(path) };
        if re.len() != got.len() || im.len() != got.len() || got.is_empty() {
            return self.fail(path);
        }
        let expected = re.iter().zip(im.iter());
        let largest = expected.clone().map(|(re, im)| libm::hypot(re, im)).fold(0.0, f64::max);
        let worst = expected.zip(got).enumerate().map(|(i, ((re, im), got))| {
            let error = libm::hypot(got.re.to_f64() - re, got.im.to_f64() - im);
            ratio(error, rule.tolerance::<R>(i, largest))
        });
        let worst = worst.fold(0.0, f64::max);
        (self.report)(self.case.id, path, worst <= 1.0, worst);
    }

    /// Compares a matrix that is stored column by column, as in nalgebra.
    pub fn matrix<const M: usize, const N: usize>(
        &mut self,
        path: &str,
        got: &nalgebra::SMatrix<R, M, N>,
    ) {
        let transposed = got.transpose();
        self.numbers(path, transposed.as_slice());
    }

    /// Compares a matrix with one row for each response of `S` sensors.
    pub fn response_rows<C: Capacity, const N: usize>(
        &mut self,
        path: &str,
        got: &ResponseRows<R, C, N>,
    ) {
        let mut rows = heapless::Vec::<R, 128>::new();
        for response in 0..3 * got.sensors() {
            if rows.extend_from_slice(&got.row(response)).is_err() {
                return self.fail(path);
            }
        }
        self.numbers(path, &rows);
    }

    /// Compares a set of names with `expected.{path}`.
    pub fn names<'n>(&mut self, path: &str, got: impl Iterator<Item = &'n str> + Clone) {
        let Some((index, rule)) = self.case.rule(path) else {
            return;
        };
        self.answered |= 1 << index;
        let expected = self.case.arrays.iter().find(|a| below_expected(a.path, path));
        let pass = match expected.map(|array| array.values) {
            Some(Values::Text(names)) if rule.set => {
                names.iter().all(|name| got.clone().any(|g| g == *name))
                    && got.clone().all(|g| names.contains(&g))
            }
            _ => false,
        };
        (self.report)(self.case.id, path, pass, if pass { 0.0 } else { f64::INFINITY });
    }

    /// Requires no values: the case is not for this precision or machine.
    pub fn leave_out(&mut self) {
        self.answered = u64::MAX;
    }

    /// Reports a path as failed.
    pub fn fail(&mut self, path: &str) {
        (self.report)(self.case.id, path, false, f64::INFINITY);
    }

    /// Reports every rule under which nothing was compared, and the case itself when it could not be run.
    pub fn finish(mut self, complete: bool) {
        if !complete {
            self.fail("(the case could not be run)");
        }
        for (index, rule) in self.case.rules.iter().enumerate() {
            if self.answered & (1 << index) == 0 {
                self.fail(rule.path);
            }
        }
    }

    fn find(&self, parts: &[&str; 2]) -> Option<Values> {
        let [start, rest] = parts;
        let matches = |a: &&Array| a.path.strip_prefix(start).is_some_and(|r| r == *rest);
        Some(self.case.arrays.iter().find(matches)?.values)
    }
}

fn below_expected(array: &str, path: &str) -> bool {
    array.strip_prefix("expected.").is_some_and(|rest| rest == path)
}

/// The largest error as a fraction of the tolerance; infinite for a number that is not finite.
fn compare<R: Real>(expected: &Array, rule: &Rule, got: &[R]) -> f64 {
    if let Some(min) = rule.min {
        return if got.iter().all(|g| g.to_f64() >= min) { 0.0 } else { f64::INFINITY };
    }
    let largest = expected.values.iter().map(libm::fabs).fold(0.0, f64::max);
    // When the sign of a column is free, each column is compared on its own.
    let columns = if rule.columns_up_to_sign { expected.shape.last().copied() } else { None };
    let columns = columns.unwrap_or(1).max(1);
    let worst_of = |column: usize, sign: f64| {
        let pairs = expected.values.iter().zip(got).enumerate();
        pairs
            .filter(|(i, _)| i % columns == column)
            .map(|(i, (want, got))| {
                ratio(libm::fabs(sign * got.to_f64() - want), rule.tolerance::<R>(i, largest))
            })
            .fold(0.0, f64::max)
    };
    (0..columns).fold(0.0, |worst, column| {
        let mut least = worst_of(column, 1.0);
        if rule.columns_up_to_sign {
            least = least.min(worst_of(column, -1.0));
        }
        f64::max(worst, least)
    })
}

fn ratio(error: f64, tolerance: f64) -> f64 {
    if error == 0.0 {
        0.0
    } else if error.is_finite() && tolerance > 0.0 {
        error / tolerance
    } else {
        f64::INFINITY
    }
}
