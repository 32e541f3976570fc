//! Symmetric positive definite systems of six unknowns, by Cholesky's factors.

/// Six by six, rows first.
pub type Matrix6 = [[f64; 6]; 6];

/// `L` of `L Lᵀ`; `None` unless the matrix is positive definite.
pub struct Cholesky(Matrix6);

impl Cholesky {
    /// Factors a symmetric matrix; only its lower half is read.
    pub fn of(matrix: &Matrix6) -> Option<Cholesky> {
        let mut lower = [[0.0; 6]; 6];
        for i in 0..6 {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| lower[i][k] * lower[j][k]).sum();
                let rest = matrix[i][j] - known;
                lower[i][j] = if i != j {
                    rest / lower[j][j]
                } else if rest > 1e-14 * matrix[i][i] {
                    rest.sqrt()
                } else {
                    return None;
                };
            }
        }
        Some(Cholesky(lower))
    }

    /// `x` of `L Lᵀ x = right`.
    pub fn solve(&self, right: [f64; 6]) -> [f64; 6] {
        let lower = &self.0;
        let mut x = right;
        for i in 0..6 {
            let known: f64 = (0..i).map(|k| lower[i][k] * x[k]).sum();
            x[i] = (x[i] - known) / lower[i][i];
        }
        for i in (0..6).rev() {
            let known: f64 = (i + 1..6).map(|k| lower[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / lower[i][i];
        }
        x
    }

    /// The inverse of the factored matrix.
    pub fn inverse(&self) -> Matrix6 {
        std::array::from_fn(|column| {
            let mut unit = [0.0; 6];
            unit[column] = 1.0;
            self.solve(unit)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::Random;

    #[test]
    fn a_matrix_times_its_inverse_is_one() {
        let mut random = Random::new(5);
        for _ in 0..100 {
            let root: Matrix6 = std::array::from_fn(|_| std::array::from_fn(|_| random.within(-1.0..1.0)));
            let product =
                |a: &Matrix6, b: &Matrix6, i: usize, j: usize| (0..6).map(|k| a[i][k] * b[k][j]).sum::<f64>();
            let transposed: Matrix6 = std::array::from_fn(|i| std::array::from_fn(|j| root[j][i]));
            let spd: Matrix6 =
                std::array::from_fn(|i| std::array::from_fn(|j| product(&root, &transposed, i, j)));
            let Some(factors) = Cholesky::of(&spd) else { continue };
            let inverse = factors.inverse();
            let size = inverse.iter().flatten().fold(1.0_f64, |most, x| most.max(x.abs()));
            for (i, j) in (0..36).map(|k| (k / 6, k % 6)) {
                let expected = f64::from(u8::from(i == j));
                assert!((product(&spd, &inverse, i, j) - expected).abs() < 1e-12 * size * size);
            }
        }
    }

    #[test]
    fn singular_matrices_have_no_factors() {
        assert!(Cholesky::of(&[[0.0; 6]; 6]).is_none());
        assert!(Cholesky::of(&[[1.0; 6]; 6]).is_none());
        assert!(Cholesky::of(&[[f64::NAN; 6]; 6]).is_none());
    }
}
