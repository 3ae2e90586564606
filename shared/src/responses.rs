//! Vectors and matrices over the responses of all sensors.
//!
//! A *response* is the reading of one axis of one triaxial sensor. Responses are numbered sensor by sensor,
//! x, y, z, so response `k` is axis `k % 3` of sensor `k / 3`. A [`Fixed`](crate::capacity::Fixed) capacity
//! has three for each sensor that there is room for; those beyond the last sensor are zero.

mod square;

pub use square::ResponseSquare;

use core::array::from_fn;
use core::ops::{AddAssign, Div, Index, IndexMut, Mul, MulAssign, Neg, Sub, SubAssign};

use nalgebra::{SMatrix, SVector};

use crate::capacity::{Capacity, Item};
use crate::real::Real;

/// One value for each response: `v[k]` is that of response `k`.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses<T: Item + Copy, C: Capacity>(C::Responses<T>);

/// A matrix with a row for each response and `N` columns.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseRows<T: Item + Copy, C: Capacity, const N: usize>(pub [Responses<T, C>; N]);

impl<T: Item + Copy, C: Capacity> Responses<T, C> {
    /// The values that `value_of` gives for each response of this many sensors.
    pub fn from_fn(sensors: usize, value_of: impl FnMut(usize) -> T) -> Self {
        Self(C::responses(sensors, value_of))
    }

    /// The same value for each response of this many sensors.
    pub fn repeat(sensors: usize, value: T) -> Self {
        Self::from_fn(sensors, |_| value)
    }

    /// Number of sensors that there is room for.
    pub fn sensors(&self) -> usize {
        self.as_slice().len() / 3
    }

    /// All values.
    pub fn as_slice(&self) -> &[T] {
        self.0.as_ref()
    }

    /// All values, mutable.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        self.0.as_mut()
    }

    /// Iterates over all values.
    pub fn iter(&self) -> core::slice::Iter<'_, T> {
        self.as_slice().iter()
    }

    /// Iterates over all values, mutable.
    pub fn iter_mut(&mut self) -> core::slice::IterMut<'_, T> {
        self.as_mut_slice().iter_mut()
    }

    /// The values of a sensor's three axes.
    ///
    /// # Panics
    /// When there is no room for this sensor.
    pub fn of_sensor(&self, sensor: usize) -> [T; 3] {
        from_fn(|axis| self[3 * sensor + axis])
    }

    /// Sets the values of a sensor's three axes.
    ///
    /// # Panics
    /// When there is no room for this sensor.
    pub fn set_sensor(&mut self, sensor: usize, values: [T; 3]) {
        self.as_mut_slice()[3 * sensor..][..3].copy_from_slice(&values);
    }

    /// What `change` makes of every value.
    pub fn map<Q: Item + Copy>(&self, mut change: impl FnMut(T) -> Q) -> Responses<Q, C> {
        let values = self.as_slice();
        Responses::from_fn(self.sensors(), |k| change(values[k]))
    }

    /// What `combine` makes of every value and the one of the same response in `other`.
    ///
    /// # Panics
    /// When `other` is for fewer sensors.
    pub fn zip_map<P: Item + Copy, Q: Item + Copy>(
        &self,
        other: &Responses<P, C>,
        mut combine: impl FnMut(T, P) -> Q,
    ) -> Responses<Q, C> {
        let (values, others) = (self.as_slice(), other.as_slice());
        Responses::from_fn(self.sensors(), |k| combine(values[k], others[k]))
    }
}

impl<R: Real, C: Capacity> Responses<R, C> {
    /// All zeros for this many sensors.
    pub fn zeros(sensors: usize) -> Self {
        Self::repeat(sensors, R::zero())
    }

    /// Sum of all values.
    pub fn sum(&self) -> R {
        self.iter().fold(R::zero(), |sum, value| sum + *value)
    }

    /// Product with another vector.
    pub fn dot(&self, other: &Self) -> R {
        crate::linalg::dot(self.as_slice(), other.as_slice())
    }

    /// Sum of the squares.
    pub fn norm_squared(&self) -> R {
        self.dot(self)
    }

    /// Root of the sum of the squares.
    pub fn norm(&self) -> R {
        self.norm_squared().sqrt()
    }

    /// The largest absolute value; zero without sensors.
    pub fn largest(&self) -> R {
        self.iter().fold(R::zero(), |largest, value| largest.max(value.abs()))
    }

    /// True when no value is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.iter().all(|value| value.finite())
    }

    /// Adds a multiple of another vector.
    pub fn add_multiple(&mut self, other: &Self, factor: R) {
        add_multiple(self.as_mut_slice(), other.as_slice(), factor);
    }
}

impl<T: Item + Copy, C: Capacity, const N: usize> From<[[T; 3]; N]> for Responses<T, C> {
    /// From the values of each sensor's three axes.
    ///
    /// # Panics
    /// When a fixed capacity has room for more sensors.
    fn from(values: [[T; 3]; N]) -> Self {
        Self::from_fn(N, |k| values[k / 3][k % 3])
    }
}

impl<'r, T: Item + Copy, C: Capacity> IntoIterator for &'r Responses<T, C> {
    type Item = &'r T;
    type IntoIter = core::slice::Iter<'r, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<T: Item + Copy, C: Capacity> Index<usize> for Responses<T, C> {
    type Output = T;

    fn index(&self, response: usize) -> &T {
        &self.as_slice()[response]
    }
}

impl<T: Item + Copy, C: Capacity> IndexMut<usize> for Responses<T, C> {
    fn index_mut(&mut self, response: usize) -> &mut T {
        &mut self.as_mut_slice()[response]
    }
}

impl<R: Real, C: Capacity> AddAssign<&Self> for Responses<R, C> {
    fn add_assign(&mut self, other: &Self) {
        self.iter_mut().zip(other.iter()).for_each(|(to, value)| *to += *value);
    }
}

impl<R: Real, C: Capacity> SubAssign<&Self> for Responses<R, C> {
    fn sub_assign(&mut self, other: &Self) {
        self.iter_mut().zip(other.iter()).for_each(|(to, value)| *to -= *value);
    }
}

impl<R: Real, C: Capacity> Sub for &Responses<R, C> {
    type Output = Responses<R, C>;

    fn sub(self, other: Self) -> Responses<R, C> {
        self.zip_map(other, |a, b| a - b)
    }
}

impl<R: Real, C: Capacity> MulAssign<R> for Responses<R, C> {
    fn mul_assign(&mut self, factor: R) {
        self.iter_mut().for_each(|value| *value *= factor);
    }
}

impl<R: Real, C: Capacity> Mul<R> for &Responses<R, C> {
    type Output = Responses<R, C>;

    fn mul(self, factor: R) -> Responses<R, C> {
        self.map(|value| value * factor)
    }
}

impl<R: Real, C: Capacity> Div<R> for &Responses<R, C> {
    type Output = Responses<R, C>;

    fn div(self, divisor: R) -> Responses<R, C> {
        self.map(|value| value / divisor)
    }
}

impl<R: Real, C: Capacity> Neg for &Responses<R, C> {
    type Output = Responses<R, C>;

    fn neg(self) -> Responses<R, C> {
        self.map(|value| -value)
    }
}

impl<T: Item + Copy, C: Capacity, const N: usize> ResponseRows<T, C, N> {
    /// The row of one response.
    pub fn row(&self, response: usize) -> [T; N] {
        from_fn(|column| self.0[column][response])
    }
}

impl<R: Real, C: Capacity, const N: usize> ResponseRows<R, C, N> {
    /// All zeros for this many sensors.
    pub fn zeros(sensors: usize) -> Self {
        Self(from_fn(|_| Responses::zeros(sensors)))
    }

    /// Number of sensors that there is room for.
    pub fn sensors(&self) -> usize {
        self.0.first().map_or(0, Responses::sensors)
    }

    /// The product with a vector.
    pub fn times(&self, right: &SVector<R, N>) -> Responses<R, C> {
        let mut sum = Responses::zeros(self.sensors());
        for (column, factor) in self.0.iter().zip(right) {
            sum.add_multiple(column, *factor);
        }
        sum
    }

    /// The product with a matrix.
    pub fn times_matrix<const M: usize>(&self, right: &SMatrix<R, N, M>) -> ResponseRows<R, C, M> {
        ResponseRows(from_fn(|column| self.times(&right.column(column).into_owned())))
    }

    /// Sets the three rows of a sensor.
    ///
    /// # Panics
    /// When there is no room for this sensor.
    pub fn set_sensor(&mut self, sensor: usize, rows: &SMatrix<R, 3, N>) {
        for (column, of_sensor) in self.0.iter_mut().zip(rows.column_iter()) {
            column.set_sensor(sensor, from_fn(|axis| of_sensor[axis]));
        }
    }
}

/// `sum += column · factor`.
fn add_multiple<R: Real>(sum: &mut [R], column: &[R], factor: R) {
    for (to, v) in sum.iter_mut().zip(column) {
        *to += *v * factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Fixed;

    type Two = Fixed<2, 1>;

    #[test]
    fn products_are_those_of_plain_matrices() {
        let element = |i: usize, j: usize| (i * 7 + j * 3) as f64 % 5.0 - 2.0;
        let square = ResponseSquare::<f64, Two>::from_fn(2, element);
        let plain = SMatrix::<f64, 6, 6>::from_fn(element);
        let vector = Responses::<f64, Two>::from_fn(2, |k| k as f64);
        let as_plain = SVector::<f64, 6>::from_column_slice(vector.as_slice());
        // Small integers are exact.
        assert_eq!(square.times(&vector).as_slice(), (plain * as_plain).as_slice());
        assert_eq!(square[(4, 1)], plain[(4, 1)]);
        assert_eq!(square.block(1, 0), plain.fixed_view::<3, 3>(3, 0).into_owned());
        let mut outer = square.clone();
        outer.add_outer(&vector, &vector);
        let expected = plain + as_plain * as_plain.transpose();
        assert!(outer.as_slice().iter().eq(expected.iter()));
        assert_eq!(outer.diagonal().as_slice(), expected.diagonal().as_slice());
        assert_eq!(
            ResponseSquare::from_diagonal(&vector).times(&vector),
            vector.zip_map(&vector, |a, b| a * b)
        );
        let rows = ResponseRows::<f64, Two, 2>([vector.clone(), &vector * 2.0]);
        assert_eq!(rows.times(&SVector::from([1.0, -1.0])), -&vector);
        assert_eq!(rows.row(4), [4.0, 8.0]);
    }
}
