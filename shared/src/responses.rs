//! Vectors and matrices over the responses of all sensors.
//!
//! A *response* is the reading of one axis of one triaxial sensor. Responses are numbered sensor by sensor,
//! x, y, z, so response `k` is axis `k % 3` of sensor `k / 3`. Capacities are in sensors: a layout with room
//! for `S` of them has `3 S` responses.

use core::ops::{Index, IndexMut};

use nalgebra::{Matrix3, SMatrix, SVector};

use crate::Real;

/// One number for each response: column `i` is sensor `i`. `v[k]` is response `k`.
pub type Responses<R, const S: usize> = SMatrix<R, 3, S>;

/// A matrix with a row for each response and `N` columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseRows<R, const S: usize, const N: usize>(pub [Responses<R, S>; N]);

/// A square matrix over the responses: `[j][b][i][a]` is the element of axis `a` of sensor `i` with axis `b`
/// of sensor `j`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponseSquare<R, const S: usize>([[[[R; 3]; S]; 3]; S]);

impl<R: Real, const S: usize, const N: usize> ResponseRows<R, S, N> {
    /// All zeros.
    pub fn zeros() -> Self {
        Self([Responses::zeros(); N])
    }

    /// The product with a vector.
    pub fn times(&self, right: &SVector<R, N>) -> Responses<R, S> {
        let mut sum = Responses::<R, S>::zeros();
        for (column, factor) in self.0.iter().zip(right) {
            add_multiple(sum.as_mut_slice(), column.as_slice(), *factor);
        }
        sum
    }

    /// The product with a matrix.
    pub fn times_matrix<const M: usize>(&self, right: &SMatrix<R, N, M>) -> ResponseRows<R, S, M> {
        let mut product = ResponseRows::zeros();
        for (to, column) in product.0.iter_mut().zip(right.column_iter()) {
            *to = self.times(&column.into_owned());
        }
        product
    }

    /// Sets the three rows of sensor `i`.
    pub fn set_sensor(&mut self, i: usize, rows: &SMatrix<R, 3, N>) {
        for (column, of_sensor) in self.0.iter_mut().zip(rows.column_iter()) {
            column.set_column(i, &of_sensor);
        }
    }
}

impl<R: Copy, const S: usize, const N: usize> ResponseRows<R, S, N> {
    /// The row of one response.
    pub fn row(&self, response: usize) -> [R; N] {
        core::array::from_fn(|column| self.0[column][response])
    }
}

impl<R: Real, const S: usize> ResponseSquare<R, S> {
    /// All zeros.
    pub fn zeros() -> Self {
        Self([[[[R::zero(); 3]; S]; 3]; S])
    }

    /// A diagonal matrix.
    pub fn from_diagonal(diagonal: &Responses<R, S>) -> Self {
        Self::from_fn(|i, j| if i == j { diagonal[i] } else { R::zero() })
    }

    /// A matrix from a function of row and column.
    pub fn from_fn(mut element: impl FnMut(usize, usize) -> R) -> Self {
        let mut matrix = Self::zeros();
        for (j, column) in matrix.columns_mut().enumerate() {
            for (i, to) in column.iter_mut().enumerate() {
                *to = element(i, j);
            }
        }
        matrix
    }

    /// The product with a vector.
    pub fn times(&self, right: &Responses<R, S>) -> Responses<R, S> {
        let mut sum = Responses::<R, S>::zeros();
        for (column, factor) in self.as_slice().chunks_exact(3 * S).zip(right) {
            add_multiple(sum.as_mut_slice(), column, *factor);
        }
        sum
    }

    /// One column.
    pub fn column(&self, response: usize) -> Responses<R, S> {
        let column = self.as_slice().chunks_exact(3 * S).nth(response);
        column.map_or_else(Responses::zeros, Responses::from_column_slice)
    }

    /// Adds `left rightᵀ`.
    pub fn add_outer(&mut self, left: &Responses<R, S>, right: &Responses<R, S>) {
        for (column, factor) in self.columns_mut().zip(right) {
            add_multiple(column, left.as_slice(), *factor);
        }
    }

    /// The 3 × 3 block of the responses of sensor `i` with those of sensor `j`.
    pub fn block(&self, i: usize, j: usize) -> Matrix3<R> {
        Matrix3::from(core::array::from_fn::<_, 3, _>(|b| self.0[j][b][i]))
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Responses<R, S> {
        Responses::from_fn(|axis, i| self.0[i][axis][i][axis])
    }

    /// All elements, column by column.
    pub fn as_slice(&self) -> &[R] {
        self.0.as_flattened().as_flattened().as_flattened()
    }

    /// All elements, column by column, mutable.
    pub fn as_mut_slice(&mut self) -> &mut [R] {
        self.0.as_flattened_mut().as_flattened_mut().as_flattened_mut()
    }

    fn columns_mut(&mut self) -> impl Iterator<Item = &mut [R]> {
        self.as_mut_slice().chunks_exact_mut(3 * S)
    }

    /// The matrix with `change` applied to every element.
    pub fn map<Q: Real>(&self, change: impl Fn(R) -> Q) -> ResponseSquare<Q, S> {
        ResponseSquare(self.0.map(|a| a.map(|b| b.map(|c| c.map(&change)))))
    }

    /// True when no element is NaN or infinite.
    pub fn is_finite(&self) -> bool {
        self.as_slice().iter().all(|v| v.finite())
    }

    /// Adds `vector vectorᵀ` to the lower triangle.
    pub fn add_square(&mut self, vector: &Responses<R, S>) {
        let vector = vector.as_slice();
        for (j, column) in self.columns_mut().enumerate() {
            add_multiple(&mut column[j..], &vector[j..], vector[j]);
        }
    }

    /// Replaces the first `count` rows and columns by their inverse and the rest by zeros, with the Cholesky
    /// factor; only the lower triangle is read. `None` when they are not positive definite; the content is
    /// then undefined.
    pub fn invert(&mut self, count: usize) -> Option<()> {
        let count = count.min(3 * S);
        self.factor(count)?;
        self.invert_factor(count);
        // C⁻ᵀ C⁻¹; C⁻¹ is zero above the diagonal. Overwritten elements are no longer needed.
        for j in 0..count {
            let (column, later) = self.column_and_later(j, count);
            for i in j..count {
                let other = if i == j { &*column } else { &later[3 * S * (i - j - 1)..][..count] };
                let products = column[i..].iter().zip(&other[i..]);
                column[i] = products.fold(R::zero(), |sum, (a, b)| sum + *a * *b);
            }
        }
        for j in 0..3 * S {
            for i in j..3 * S {
                let value = if i < count { self[(i, j)] } else { R::zero() };
                self[(i, j)] = value;
                self[(j, i)] = value;
            }
        }
        Some(())
    }

    /// Replaces the lower triangle by C, where C Cᵀ is the matrix.
    fn factor(&mut self, count: usize) -> Option<()> {
        for k in 0..count {
            let (column, later) = self.column_and_later(k, count);
            let pivot = column[k];
            if !(pivot > R::zero() && pivot.finite()) {
                return None;
            }
            let scale = pivot.sqrt().recip();
            column[k..].iter_mut().for_each(|v| *v *= scale);
            for (j, other) in (k + 1..count).zip(later.chunks_exact_mut(3 * S)) {
                add_multiple(&mut other[j..count], &column[j..], -column[j]);
            }
        }
        Some(())
    }

    /// Replaces C by C⁻¹.
    fn invert_factor(&mut self, count: usize) {
        for j in (0..count).rev() {
            let (column, later) = self.column_and_later(j, count);
            column[j] = column[j].recip();
            let scale = -column[j];
            column[j + 1..].iter_mut().for_each(|v| *v *= scale);
            // The later columns are finished: multiplies with them, starting from the last row.
            for (k, other) in (j + 1..count).zip(later.chunks_exact(3 * S)).rev() {
                let factor = column[k];
                column[k] = factor * other[k];
                add_multiple(&mut column[k + 1..], &other[k + 1..count], factor);
            }
        }
    }

    /// The first `count` elements of column `j`, and all later columns.
    fn column_and_later(&mut self, j: usize, count: usize) -> (&mut [R], &mut [R]) {
        let (to_here, later) = self.as_mut_slice().split_at_mut(3 * S * (j + 1));
        (&mut to_here[3 * S * j..][..count], later)
    }
}

impl<R: Real, const S: usize> Index<(usize, usize)> for ResponseSquare<R, S> {
    type Output = R;

    fn index(&self, (i, j): (usize, usize)) -> &R {
        &self.as_slice()[3 * S * j + i]
    }
}

impl<R: Real, const S: usize> IndexMut<(usize, usize)> for ResponseSquare<R, S> {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut R {
        &mut self.as_mut_slice()[3 * S * j + i]
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
    use nalgebra::SVector;

    #[test]
    fn products_are_those_of_plain_matrices() {
        let element = |i: usize, j: usize| (i * 7 + j * 3) as f64 % 5.0 - 2.0;
        let square = ResponseSquare::<f64, 2>::from_fn(element);
        let plain = SMatrix::<f64, 6, 6>::from_fn(element);
        let vector = Responses::<f64, 2>::from_fn(|axis, i| (3 * i + axis) as f64);
        let as_plain = SVector::<f64, 6>::from_column_slice(vector.as_slice());
        // Small integers are exact.
        assert_eq!(square.times(&vector).as_slice(), (plain * as_plain).as_slice());
        assert_eq!(square[(4, 1)], plain[(4, 1)]);
        assert_eq!(square.block(1, 0), plain.fixed_view::<3, 3>(3, 0).into_owned());
        let mut outer = square;
        outer.add_outer(&vector, &vector);
        let expected = plain + as_plain * as_plain.transpose();
        assert!(outer.as_slice().iter().eq(expected.iter()));
        assert_eq!(outer.diagonal().as_slice(), expected.diagonal().as_slice());
        assert_eq!(
            ResponseSquare::from_diagonal(&vector).times(&vector),
            vector.component_mul(&vector)
        );
        let rows = ResponseRows::<f64, 2, 2>([vector, vector * 2.0]);
        assert_eq!(rows.times(&SVector::from([1.0, -1.0])), -vector);
        assert_eq!(rows.row(4), [4.0, 8.0]);
    }

    #[test]
    fn the_inverse_is_that_of_the_first_rows() {
        // AᵀA + I is positive definite.
        let a = |i: usize, j: usize| ((i * 5 + j * j) % 7) as f64 - 3.0;
        let element = |i: usize, j: usize| {
            (0..6).map(|k| a(k, i) * a(k, j)).sum::<f64>() + if i == j { 1.0 } else { 0.0 }
        };
        let square = ResponseSquare::<f64, 2>::from_fn(element);
        let mut inverse = square;
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
