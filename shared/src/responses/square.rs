//! Square matrices over the responses of all sensors.

use core::ops::{Index, IndexMut};

use nalgebra::Matrix3;

use super::{Responses, add_multiple};
use crate::capacity::{Capacity, Item, ResponsePairs};
use crate::real::Real;

/// A square matrix over the responses, column by column.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseSquare<T: Item + Copy, C: Capacity>(C::ResponsePairs<T>);

impl<R: Real, C: Capacity> ResponseSquare<R, C> {
    /// All zeros for this many sensors.
    pub fn zeros(sensors: usize) -> Self {
        Self(C::response_pairs(sensors, R::zero()))
    }

    /// A diagonal matrix.
    pub fn from_diagonal(diagonal: &Responses<R, C>) -> Self {
        let element = |i, j| if i == j { diagonal[i] } else { R::zero() };
        Self::from_fn(diagonal.sensors(), element)
    }

    /// A matrix for this many sensors from a function of row and column.
    pub fn from_fn(sensors: usize, mut element: impl FnMut(usize, usize) -> R) -> Self {
        let mut matrix = Self::zeros(sensors);
        for (j, column) in matrix.columns_mut().enumerate() {
            for (i, to) in column.iter_mut().enumerate() {
                *to = element(i, j);
            }
        }
        matrix
    }

    /// Number of rows: the responses that there is room for.
    pub fn rows(&self) -> usize {
        self.0.responses()
    }

    /// The product with a vector.
    pub fn times(&self, right: &Responses<R, C>) -> Responses<R, C> {
        let mut sum = Responses::zeros(right.sensors());
        for (column, factor) in self.columns().zip(right.iter()) {
            add_multiple(sum.as_mut_slice(), column, *factor);
        }
        sum
    }

    /// One column.
    pub fn column(&self, response: usize) -> Responses<R, C> {
        let column = &self.as_slice()[self.rows() * response..];
        Responses::from_fn(self.rows() / 3, |k| column[k])
    }

    /// Adds `left rightᵀ`.
    pub fn add_outer(&mut self, left: &Responses<R, C>, right: &Responses<R, C>) {
        for (column, factor) in self.columns_mut().zip(right.iter()) {
            add_multiple(column, left.as_slice(), *factor);
        }
    }

    /// The 3 × 3 block of the responses of sensor `i` with those of sensor `j`.
    pub fn block(&self, i: usize, j: usize) -> Matrix3<R> {
        let rows = self.rows();
        let columns = &self.as_slice()[3 * j * rows..][..3 * rows];
        Matrix3::from_fn(|a, b| columns[b * rows + 3 * i + a])
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Responses<R, C> {
        Responses::from_fn(self.rows() / 3, |k| self[(k, k)])
    }

    /// Sum of the diagonal.
    pub fn trace(&self) -> R {
        (0..self.rows()).fold(R::zero(), |sum, k| sum + self[(k, k)])
    }

    /// All elements, column by column.
    pub fn as_slice(&self) -> &[R] {
        self.0.as_ref()
    }

    /// All elements, column by column, mutable.
    pub fn as_mut_slice(&mut self) -> &mut [R] {
        self.0.as_mut()
    }

    fn columns(&self) -> impl Iterator<Item = &[R]> {
        // A matrix without rows has no columns.
        self.as_slice().chunks_exact(self.rows().max(1))
    }

    fn columns_mut(&mut self) -> impl Iterator<Item = &mut [R]> {
        let rows = self.rows().max(1);
        self.as_mut_slice().chunks_exact_mut(rows)
    }

    /// The matrix with `change` applied to every element.
    pub fn map<Q: Real>(&self, change: impl Fn(R) -> Q) -> ResponseSquare<Q, C> {
        let mut changed = ResponseSquare::<Q, C>::zeros(self.rows() / 3);
        let elements = changed.as_mut_slice().iter_mut().zip(self.as_slice());
        elements.for_each(|(to, from)| *to = change(*from));
        changed
    }

    /// True when no element is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.as_slice().iter().all(|v| v.finite())
    }

    /// True when every element is zero.
    pub fn is_zero(&self) -> bool {
        self.as_slice().iter().all(|v| *v == R::zero())
    }

    /// Adds `vector vectorᵀ` to the lower triangle.
    pub fn add_square(&mut self, vector: &Responses<R, C>) {
        let vector = vector.as_slice();
        for (j, column) in self.columns_mut().enumerate() {
            add_multiple(&mut column[j..], &vector[j..], vector[j]);
        }
    }

    /// Replaces the first `count` rows and columns by their inverse and the rest by zeros, with the Cholesky
    /// factor; only the lower triangle is read. `None` when they are not positive definite; the content is
    /// then undefined.
    pub fn invert(&mut self, count: usize) -> Option<()> {
        let rows = self.rows();
        let count = count.min(rows);
        self.factor(count)?;
        self.invert_factor(count);
        // C⁻ᵀ C⁻¹; C⁻¹ is zero above the diagonal. Overwritten elements are no longer needed.
        for j in 0..count {
            let (column, later) = self.column_and_later(j, count);
            for i in j..count {
                let other = if i == j { &*column } else { &later[rows * (i - j - 1)..][..count] };
                let products = column[i..].iter().zip(&other[i..]);
                column[i] = products.fold(R::zero(), |sum, (a, b)| sum + *a * *b);
            }
        }
        for j in 0..rows {
            for i in j..rows {
                let value = if i < count { self[(i, j)] } else { R::zero() };
                self[(i, j)] = value;
                self[(j, i)] = value;
            }
        }
        Some(())
    }

    /// Replaces the lower triangle by C, where C Cᵀ is the matrix.
    fn factor(&mut self, count: usize) -> Option<()> {
        let rows = self.rows();
        for k in 0..count {
            let (column, later) = self.column_and_later(k, count);
            let pivot = column[k];
            if !(pivot > R::zero() && pivot.finite()) {
                return None;
            }
            let scale = pivot.sqrt().recip();
            column[k..].iter_mut().for_each(|v| *v *= scale);
            for (j, other) in (k + 1..count).zip(later.chunks_exact_mut(rows)) {
                add_multiple(&mut other[j..count], &column[j..], -column[j]);
            }
        }
        Some(())
    }

    /// Replaces C by C⁻¹.
    fn invert_factor(&mut self, count: usize) {
        let rows = self.rows();
        for j in (0..count).rev() {
            let (column, later) = self.column_and_later(j, count);
            column[j] = column[j].recip();
            let scale = -column[j];
            column[j + 1..].iter_mut().for_each(|v| *v *= scale);
            // The later columns are finished: multiplies with them, starting from the last row.
            for (k, other) in (j + 1..count).zip(later.chunks_exact(rows)).rev() {
                let factor = column[k];
                column[k] = factor * other[k];
                add_multiple(&mut column[k + 1..], &other[k + 1..count], factor);
            }
        }
    }

    /// The first `count` elements of column `j`, and all later columns.
    fn column_and_later(&mut self, j: usize, count: usize) -> (&mut [R], &mut [R]) {
        let rows = self.rows();
        let (to_here, later) = self.as_mut_slice().split_at_mut(rows * (j + 1));
        (&mut to_here[rows * j..][..count], later)
    }
}

impl<R: Real, C: Capacity> Index<(usize, usize)> for ResponseSquare<R, C> {
    type Output = R;

    fn index(&self, (i, j): (usize, usize)) -> &R {
        &self.as_slice()[self.rows() * j + i]
    }
}

impl<R: Real, C: Capacity> IndexMut<(usize, usize)> for ResponseSquare<R, C> {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut R {
        let rows = self.rows();
        &mut self.as_mut_slice()[rows * j + i]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Fixed;

    #[test]
    fn the_inverse_is_that_of_the_first_rows() {
        // AᵀA + I is positive definite.
        let a = |i: usize, j: usize| ((i * 5 + j * j) % 7) as f64 - 3.0;
        let element = |i: usize, j: usize| {
            (0..6).map(|k| a(k, i) * a(k, j)).sum::<f64>() + if i == j { 1.0 } else { 0.0 }
        };
        let square = ResponseSquare::<f64, Fixed<2, 1>>::from_fn(2, element);
        let mut inverse = square.clone();
        inverse.invert(5).unwrap();
        for i in 0..6 {
            for j in 0..6 {
                let product: f64 = (0..5).map(|k| square[(i, k)] * inverse[(k, j)]).sum();
                let expected = if i < 5 { f64::from(u8::from(i == j)) } else { product };
                // The tolerance covers rounding times the condition, about a thousand.
                assert!((product - expected).abs() < 1e-11, "{i} {j}: {product}");
            }
        }
        assert!(square.map(|v| -v).invert(6).is_none());
    }
}
