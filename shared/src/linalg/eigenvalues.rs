//! Eigenvalues of a real matrix, in its own memory.

use nalgebra::Complex;

use crate::real::Real;

/// Largest number of steps for an eigenvalue; two or three are usual.
const MOST_STEPS: usize = 30;

/// The eigenvalues of the first `n` rows and columns of a matrix, which is overwritten; zeros follow them. `None` when
/// an element is not finite or the steps do not end.
///
/// Elimination to Hessenberg form, then QR steps with double shifts (Martin, Peters and Wilkinson 1970: `elmhes` and
/// `hqr` of EISPACK). It needs no memory besides the matrix.
pub(crate) fn eigenvalues<R: Real, const N: usize>(
    a: &mut [[R; N]; N],
    n: usize,
) -> Option<[Complex<R>; N]> {
    let zero = R::zero();
    let mut values = [Complex::new(zero, zero); N];
    if n > N || !a.iter().flatten().all(|v| v.finite()) {
        return None;
    }
    to_hessenberg(a, n);
    let size = a.iter().flatten().fold(zero, |sum, v| sum + v.abs());
    // The rows before `end` still have to be done; they are shifted by `shift`.
    let (mut end, mut shift, mut steps) = (n, zero, 0);
    while end > 0 {
        let last = end - 1;
        let start = start_of_block(a, last, size);
        let x = a[last][last];
        if start == last {
            values[last] = Complex::new(x + shift, zero);
            (end, steps) = (last, 0);
            continue;
        }
        let y = a[last - 1][last - 1];
        let w = a[last][last - 1] * a[last - 1][last];
        if start + 1 == last {
            let pair = of_two(x, y, w);
            (values[last - 1], values[last]) = (pair[0] + shift, pair[1] + shift);
            (end, steps) = (last - 1, 0);
            continue;
        }
        if steps == MOST_STEPS {
            return None;
        }
        let mut shifts = [x, y, w];
        if steps == 10 || steps == 20 {
            // An exceptional shift ends a cycle.
            shift += x;
            (0..end).for_each(|i| a[i][i] -= x);
            let s = a[last][last - 1].abs() + a[last - 1][last - 2].abs();
            shifts = [s * R::of(0.75), s * R::of(0.75), s * s * R::of(-0.4375)];
        }
        steps += 1;
        double_step(a, start, last, shifts);
    }
    values.iter().all(|z| z.re.finite() && z.im.finite()).then_some(values)
}

/// Elimination with pivots.
fn to_hessenberg<R: Real, const N: usize>(a: &mut [[R; N]; N], n: usize) {
    for m in 1..n.saturating_sub(1) {
        let larger = |p: usize, q: usize| if a[q][m - 1].abs() > a[p][m - 1].abs() { q } else { p };
        let pivot = (m..n).reduce(larger).unwrap_or(m);
        let x = a[pivot][m - 1];
        if x == R::zero() {
            continue;
        }
        if pivot != m {
            a.swap(pivot, m);
            a.iter_mut().for_each(|row| row.swap(pivot, m));
        }
        for i in m + 1..n {
            let y = a[i][m - 1] / x;
            if y == R::zero() {
                continue;
            }
            a[i][m - 1] = R::zero();
            for j in m..n {
                let above = a[m][j];
                a[i][j] -= y * above;
            }
            a.iter_mut().take(n).for_each(|row| row[m] += y * row[i]);
        }
    }
}

/// Where the block begins that ends with this row and has no negligible element beside its diagonal.
fn start_of_block<R: Real, const N: usize>(a: &mut [[R; N]; N], last: usize, size: R) -> usize {
    for l in (1..=last).rev() {
        let beside = a[l - 1][l - 1].abs() + a[l][l].abs();
        let beside = if beside == R::zero() { size } else { beside };
        if a[l][l - 1].abs() <= R::default_epsilon() * beside {
            a[l][l - 1] = R::zero();
            return l;
        }
    }
    0
}

/// The eigenvalues of the last two rows: `x` and `y` on the diagonal, `w` the product of the others.
fn of_two<R: Real>(x: R, y: R, w: R) -> [Complex<R>; 2] {
    let zero = R::zero();
    let p = (y - x) * R::of(0.5);
    let q = p * p + w;
    let z = q.abs().sqrt();
    if q < zero {
        return [Complex::new(x + p, z), Complex::new(x + p, -z)];
    }
    let z = if p < zero { p - z } else { p + z };
    let other = if z == zero { x } else { x - w / z };
    [Complex::new(x + z, zero), Complex::new(other, zero)]
}

/// A QR step with both shifts on the rows from `start` to `last`.
fn double_step<R: Real, const N: usize>(
    a: &mut [[R; N]; N],
    start: usize,
    last: usize,
    shifts: [R; 3],
) {
    let zero = R::zero();
    let (first, mut v) = first_column(a, start, last, shifts);
    for i in first..last - 1 {
        a[i + 2][i] = zero;
        if i > first {
            a[i + 2][i - 1] = zero;
        }
    }
    for k in first..last {
        let three = k + 1 != last;
        let mut scale = zero;
        if k != first {
            v = [a[k][k - 1], a[k + 1][k - 1], if three { a[k + 2][k - 1] } else { zero }];
            scale = v[0].abs() + v[1].abs() + v[2].abs();
            if scale != zero {
                v = v.map(|v| v / scale);
            }
        }
        let norm = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        let s = if v[0] < zero { -norm } else { norm };
        if s == zero {
            continue;
        }
        if k != first {
            a[k][k - 1] = -s * scale;
        } else if start != first {
            a[k][k - 1] = -a[k][k - 1];
        }
        let p = v[0] + s;
        let left = [p / s, v[1] / s, v[2] / s];
        let (q, r) = (v[1] / p, v[2] / p);
        for j in k..=last {
            let mut sum = a[k][j] + q * a[k + 1][j];
            if three {
                sum += r * a[k + 2][j];
                a[k + 2][j] -= sum * left[2];
            }
            a[k + 1][j] -= sum * left[1];
            a[k][j] -= sum * left[0];
        }
        for row in a.iter_mut().take(last.min(k + 3) + 1).skip(start) {
            let mut sum = left[0] * row[k] + left[1] * row[k + 1];
            if three {
                sum += left[2] * row[k + 2];
                row[k + 2] -= sum * r;
            }
            row[k + 1] -= sum * q;
            row[k] -= sum;
        }
    }
}

/// The row where a step can begin, and the first column that it makes there.
fn first_column<R: Real, const N: usize>(
    a: &[[R; N]; N],
    start: usize,
    last: usize,
    [x, y, w]: [R; 3],
) -> (usize, [R; 3]) {
    let mut m = last - 2;
    loop {
        let z = a[m][m];
        let (r, s) = (x - z, y - z);
        let v =
            [(r * s - w) / a[m + 1][m] + a[m][m + 1], a[m + 1][m + 1] - z - r - s, a[m + 2][m + 1]];
        let size = v[0].abs() + v[1].abs() + v[2].abs();
        let v = v.map(|v| v / size);
        if m == start {
            return (m, v);
        }
        let small = a[m][m - 1].abs() * (v[1].abs() + v[2].abs());
        let large = v[0].abs() * (a[m - 1][m - 1].abs() + z.abs() + a[m + 1][m + 1].abs());
        if small <= R::default_epsilon() * large {
            return (m, v);
        }
        m -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SMatrix;
    use std::vec::Vec;

    #[test]
    fn the_eigenvalues_are_those_of_another_decomposition() {
        let by_size =
            |a: &Complex<f64>, b: &Complex<f64>| (a.re, a.im).partial_cmp(&(b.re, b.im)).unwrap();
        for seed in 1..60_u32 {
            let mut state = seed;
            let mut number = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 8) / f64::from(1 << 23) - 1.0
            };
            let mut rows = [[0.0; 7]; 7];
            // Some matrices have zeros, which split them.
            rows.iter_mut().flatten().for_each(|v| {
                let value = number();
                *v = if seed % 3 == 0 && value < 0.0 { 0.0 } else { value };
            });
            let matrix = SMatrix::<f64, 6, 6>::from_fn(|i, j| rows[i][j]);
            // nalgebra's decomposition is the reference.
            let mut expected: Vec<_> = matrix.complex_eigenvalues().iter().copied().collect();
            let values = eigenvalues(&mut rows, 6).unwrap();
            assert_eq!(values[6], Complex::new(0.0, 0.0));
            let mut values: Vec<_> = values[..6].to_vec();
            expected.sort_by(by_size);
            values.sort_by(by_size);
            // The nearest, because nearly equal real parts may be in another order; the square root of the rounding for
            // eigenvalues that are nearly double.
            for value in &values {
                let nearest = expected.iter().map(|e| (e - value).norm()).fold(1.0, f64::min);
                assert!(nearest < 1e-7, "{seed}: {value} of {expected:?}");
            }
            let sum = |values: &[Complex<f64>]| values.iter().map(|z| z.re).sum::<f64>();
            assert!((sum(&values) - matrix.trace()).abs() < 1e-12);
        }
    }

    #[test]
    fn small_and_wild_matrices_end() {
        assert_eq!(eigenvalues(&mut [[3.0_f32; 1]; 1], 1).unwrap()[0].re, 3.0);
        let turned = eigenvalues(&mut [[0.0_f64, 1.0], [-4.0, 0.0]], 2).unwrap();
        assert_eq!(turned, [Complex::new(0.0, 2.0), Complex::new(0.0, -2.0)]);
        assert!(eigenvalues(&mut [[f32::NAN; 3]; 3], 3).is_none());
        assert!(eigenvalues(&mut [[0.0_f32; 2]; 2], 3).is_none());
        // A cyclic shift, on which steps without exceptional shifts do not end.
        let mut cyclic = [[0.0_f64; 4]; 4];
        (0..4).for_each(|k| cyclic[(k + 1) % 4][k] = 1.0);
        let values = eigenvalues(&mut cyclic, 4).unwrap();
        assert!(values.iter().all(|z| (z.norm() - 1.0).abs() < 1e-12), "{values:?}");
    }
}
