//! Polynomials in Bernstein form: their values lie in the hull of their coefficients.

use std::iter::Sum;
use std::ops::Mul;

/// Coefficients of the derivative of a polynomial (or point) in Bernstein form.
pub fn derivative<T: Copy + std::ops::Sub<Output = T> + Mul<f64, Output = T>>(coefficients: &[T]) -> Vec<T> {
    let degree = coefficients.len() - 1;
    coefficients.windows(2).map(|pair| (pair[1] - pair[0]) * degree as f64).collect()
}

/// Coefficients of a product, whatever product `times` means (Farouki and Rajan 1988, eq. 44).
pub fn product<A: Copy, B: Copy, C: Mul<f64, Output = C> + Sum>(
    a: &[A],
    b: &[B],
    times: impl Fn(A, B) -> C,
) -> Vec<C> {
    let (m, n) = (a.len() - 1, b.len() - 1);
    let term =
        |i: usize, j: usize| times(a[i], b[j]) * (binomial(m, i) * binomial(n, j) / binomial(m + n, i + j));
    let coefficient = |k: usize| (k.saturating_sub(n)..=k.min(m)).map(|i| term(i, k - i)).sum();
    (0..=m + n).map(coefficient).collect()
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |b, j| b * (n - j) as f64 / (j + 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(coefficients: &[f64], t: f64) -> f64 {
        let n = coefficients.len() - 1;
        let power = |x: f64, k: usize| (0..k).fold(1.0, |p, _| p * x);
        (0..=n).map(|k| coefficients[k] * binomial(n, k) * power(t, k) * power(1.0 - t, n - k)).sum()
    }

    #[test]
    fn products_and_derivatives_by_value() {
        let (a, b) = ([1.0, -2.0, 0.5, 3.0], [0.3, 4.0, -1.0]);
        let (ab, slope) = (product(&a, &b, |x, y| x * y), derivative(&a));
        for k in 0..=10 {
            let t = f64::from(k) / 10.0;
            assert!((value(&ab, t) - value(&a, t) * value(&b, t)).abs() < 1e-12);
            let step = 1e-6;
            let quotient = (value(&a, t + step) - value(&a, t - step)) / (2.0 * step);
            assert!((value(&slope, t) - quotient).abs() < 1e-6);
        }
    }
}
