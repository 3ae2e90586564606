//! Packed symmetric matrices: lower triangle row by row, and its Cholesky factor.

use crate::Real;

/// Length of the triangle of this number of rows; also the offset of a row.
pub(super) const fn triangle(rows: usize) -> usize {
    rows * (rows + 1) / 2
}

/// One row of a triangle, up to its diagonal.
pub(super) fn row<R>(packed: &[R], i: usize) -> &[R] {
    &packed[triangle(i)..triangle(i + 1)]
}

/// Replaces a matrix by its Cholesky factor. `None` when a pivot is not above `least` or not finite.
pub(super) fn factor<R: Real>(packed: &mut [R], rows: usize, least: R) -> Option<()> {
    for i in 0..rows {
        let (above, own) = packed.split_at_mut(triangle(i));
        let own = &mut own[..=i];
        for j in 0..i {
            let other = row(above, j);
            own[j] = (own[j] - product(&own[..j], &other[..j])) / other[j];
        }
        let pivot = own[i] - product(&own[..i], &own[..i]);
        if !(pivot > least && pivot.finite()) {
            return None;
        }
        own[i] = pivot.sqrt();
    }
    Some(())
}

/// Solves `L Lᵀ x = b` in place.
pub(super) fn solve<R: Real>(factor: &[R], x: &mut [R]) {
    for i in 0..x.len() {
        let own = row(factor, i);
        x[i] = (x[i] - product(&own[..i], &x[..i])) / own[i];
    }
    for i in (0..x.len()).rev() {
        let own = row(factor, i);
        let value = x[i] / own[i];
        x[i] = value;
        for (to, l) in x.iter_mut().zip(&own[..i]) {
            *to -= *l * value;
        }
    }
}

/// Adds to `diagonal` the diagonal of the inverse `(L Lᵀ)⁻¹` for its first unknowns. The factor is replaced by
/// its inverse, with `scratch` for one row.
pub(super) fn inverse_diagonal<R: Real>(
    factor: &mut [R],
    rows: usize,
    scratch: &mut [R],
    diagonal: &mut [R],
) {
    for i in 0..rows {
        let (above, own) = factor.split_at_mut(triangle(i));
        let (own, sums) = (&mut own[..=i], &mut scratch[..i]);
        sums.fill(R::zero());
        for (k, l) in own[..i].iter().enumerate() {
            for (sum, value) in sums.iter_mut().zip(row(above, k)) {
                *sum += *l * *value;
            }
        }
        let pivot = own[i].recip();
        own[i] = pivot;
        for (to, sum) in own.iter_mut().zip(sums) {
            *to = -*sum * pivot;
        }
        for (to, value) in diagonal.iter_mut().zip(own.iter()) {
            *to += *value * *value;
        }
    }
}

/// Inner product, four terms at a time.
pub(super) fn product<R: Real>(a: &[R], b: &[R]) -> R {
    let (a, rest_of_a) = a.as_chunks::<4>();
    let (b, rest_of_b) = b.as_chunks::<4>();
    let mut sums = [R::zero(); 4];
    for (a, b) in a.iter().zip(b) {
        for k in 0..4 {
            sums[k] += a[k] * b[k];
        }
    }
    let sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    rest_of_a.iter().zip(rest_of_b).fold(sum, |sum, (a, b)| sum + *a * *b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `[[4, 2, 0.4], [2, 5, 1], [0.4, 1, 3]]`.
    const MATRIX: [f64; 6] = [4.0, 2.0, 5.0, 0.4, 1.0, 3.0];

    #[test]
    fn a_factor_solves_and_inverts() {
        let mut matrix = MATRIX;
        factor(&mut matrix, 3, 0.0).unwrap();
        let mut x = [4.0 + 4.0 + 1.2, 2.0 + 10.0 + 3.0, 0.4 + 2.0 + 9.0];
        solve(&matrix, &mut x);
        // Only rounding is left.
        assert!(x.iter().zip([1.0, 2.0, 3.0]).all(|(x, e)| (x - e).abs() < 1e-14), "{x:?}");
        let mut columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        columns.iter_mut().for_each(|column| solve(&matrix, column));
        let mut diagonal = [0.0; 2];
        inverse_diagonal(&mut matrix, 3, &mut [0.0; 3], &mut diagonal);
        assert!((0..2).all(|k| (diagonal[k] - columns[k][k]).abs() < 1e-15), "{diagonal:?}");
    }

    #[test]
    fn a_singular_matrix_has_no_factor() {
        assert!(factor(&mut [1.0, 1.0, 1.0], 2, 0.0).is_none());
        assert!(factor(&mut [f64::NAN], 1, 0.0).is_none());
    }
}
