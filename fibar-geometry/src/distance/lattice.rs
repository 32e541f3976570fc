//! A cubic lattice of points in a box, and how to interpolate what is sampled on it.

use glam::{DVec3, IVec3};

/// Points `origin + spacing·(i, j, k)`; numbered with i fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The point of number 0, mm.
    pub origin: DVec3,
    /// Between neighbours, mm.
    pub spacing: f64,
    /// How many points along each axis, at least 4.
    pub counts: [usize; 3],
}

impl Lattice {
    /// The lattice that covers a box with `margin` mm to spare on every side.
    pub fn around((low, high): (DVec3, DVec3), margin: f64, spacing: f64) -> Lattice {
        let cells = ((high - low + 2.0 * margin) / spacing).ceil().max(DVec3::splat(3.0));
        let surplus = cells * spacing - (high - low);
        let counts = cells.to_array().map(|n| n as usize + 1);
        Lattice { origin: low - 0.5 * surplus, spacing, counts }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.counts.iter().product()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Place of a point, mm.
    pub fn place(&self, number: usize) -> DVec3 {
        let [nx, ny, _] = self.counts;
        let (i, j, k) = (number % nx, number / nx % ny, number / (nx * ny));
        self.origin + self.spacing * DVec3::new(i as f64, j as f64, k as f64)
    }

    /// Value and gradient (per mm) between the samples, linear along each axis. Places outside take the nearest of the box.
    pub fn interpolate_linear(&self, samples: &[f64], place: DVec3) -> (f64, DVec3) {
        let (corner, t) = self.cell(place);
        let [nx, ny, _] = self.counts;
        let first = (corner.z as usize * ny + corner.y as usize) * nx + corner.x as usize;
        // Along x on the four edges of the cell, then along y on two faces, then along z.
        let edge = |row: usize| {
            let [a, b] = [samples[first + row], samples[first + row + 1]];
            (a + t.x * (b - a), b - a)
        };
        let face = |row: usize| {
            let ((a, ax), (b, bx)) = (edge(row), edge(row + nx));
            (a + t.y * (b - a), ax + t.y * (bx - ax), b - a)
        };
        let ((a, ax, ay), (b, bx, by)) = (face(0), face(nx * ny));
        let slope = DVec3::new(ax + t.z * (bx - ax), ay + t.z * (by - ay), b - a);
        (a + t.z * (b - a), slope / self.spacing)
    }

    /// Whether the value between samples is certainly `least` or more, where samples change by no more than 1 per mm: by one corner.
    pub fn surely_reaches(&self, samples: &[f64], place: DVec3, least: f64) -> bool {
        const DIAGONAL: f64 = 1.733; // a little more than √3
        let (corner, _) = self.cell(place);
        let [nx, ny, _] = self.counts;
        samples[(corner.z as usize * ny + corner.y as usize) * nx + corner.x as usize]
            >= least + DIAGONAL * self.spacing
    }

    /// As [`interpolate_linear`](Self::interpolate_linear) by Catmull–Rom cubics: the gradient is continuous, the error of fourth order in the spacing.
    pub fn interpolate_cubic(&self, samples: &[f64], place: DVec3) -> (f64, DVec3) {
        self.interpolate_cubic_of(|n| samples[n], place)
    }

    /// The same of samples that are asked for one by one, by number.
    pub fn interpolate_cubic_of(&self, sample: impl Fn(usize) -> f64, place: DVec3) -> (f64, DVec3) {
        let (corner, t) = self.cell(place);
        self.weigh(sample, corner - IVec3::ONE, t.to_array().map(catmull_rom))
    }

    /// The lowest corner of the cell around a place, and where in the cell it lies, 0 to 1. Cells at the border are left
    /// out, so that every stencil fits.
    fn cell(&self, place: DVec3) -> (IVec3, DVec3) {
        let [nx, ny, nz] = self.counts.map(|n| n as f64);
        let last = DVec3::new(nx - 2.0, ny - 2.0, nz - 2.0);
        let at = ((place - self.origin) / self.spacing).clamp(DVec3::ONE, last);
        // Nothing is negative: cutting off is rounding down.
        let corner = at.min(last - 1.0).as_ivec3();
        (corner, at - corner.as_dvec3())
    }

    /// The tensor product of weights (and their slopes) per axis, applied to the samples from `corner` on.
    fn weigh<const N: usize>(
        &self,
        sample: impl Fn(usize) -> f64,
        corner: IVec3,
        [(wx, sx), (wy, sy), (wz, sz)]: [([f64; N], [f64; N]); 3],
    ) -> (f64, DVec3) {
        let [nx, ny, _] = self.counts;
        let first = (corner.z as usize * ny + corner.y as usize) * nx + corner.x as usize;
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        for k in 0..N {
            for j in 0..N {
                let row: [f64; N] = std::array::from_fn(|i| sample(first + (k * ny + j) * nx + i));
                let along = (0..N).fold(0.0, |sum, i| sum + wx[i] * row[i]);
                let rise = (0..N).fold(0.0, |sum, i| sum + sx[i] * row[i]);
                value += wy[j] * wz[k] * along;
                slope += DVec3::new(wy[j] * wz[k] * rise, sy[j] * wz[k] * along, wy[j] * sz[k] * along);
            }
        }
        (value, slope / self.spacing)
    }
}

/// Weights of the four samples around `t` and their derivatives (Catmull & Rom 1974).
fn catmull_rom(t: f64) -> ([f64; 4], [f64; 4]) {
    let weights = [
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    ];
    let slopes =
        [(-1.5 * t + 2.0) * t - 0.5, (4.5 * t - 5.0) * t, (-4.5 * t + 4.0) * t + 0.5, (1.5 * t - 1.0) * t];
    (weights, slopes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice::around((DVec3::splat(-3.0), DVec3::new(4.0, 5.0, 6.0)), 2.0, 0.75)
    }

    fn check(
        interpolate: impl Fn(&Lattice, &[f64], DVec3) -> (f64, DVec3),
        f: impl Fn(DVec3) -> (f64, DVec3),
        tolerance: f64,
    ) {
        let lattice = lattice();
        let samples: Vec<f64> = (0..lattice.len()).map(|n| f(lattice.place(n)).0).collect();
        for k in 0..50 {
            let p = DVec3::new(-3.0 + 0.14 * k as f64, 5.0 - 0.16 * k as f64, -3.0 + 0.18 * k as f64);
            let ((value, slope), (exact, gradient)) = (interpolate(&lattice, &samples, p), f(p));
            assert!((value - exact).abs() < tolerance, "{p}: {value} is not {exact}");
            assert!((slope - gradient).length() < 10.0 * tolerance, "{p}: {slope} is not {gradient}");
        }
    }

    fn plane(p: DVec3) -> (f64, DVec3) {
        let n = DVec3::new(0.3, -2.0, 1.1);
        (n.dot(p) + 0.7, n)
    }

    fn bowl(p: DVec3) -> (f64, DVec3) {
        (p.length_squared(), 2.0 * p)
    }

    #[test]
    fn linear_is_exact_for_planes_and_cubic_for_bowls() {
        check(Lattice::interpolate_linear, plane, 1e-12);
        check(Lattice::interpolate_cubic, plane, 1e-12);
        check(Lattice::interpolate_cubic, bowl, 1e-12);
        check(Lattice::interpolate_linear, bowl, 3.0 * 0.75 * 0.75 / 4.0);
    }

    #[test]
    fn what_surely_reaches_does() {
        let lattice = lattice();
        let samples: Vec<f64> = (0..lattice.len()).map(|n| lattice.place(n).length()).collect();
        let mut sure = 0;
        for k in 0..500 {
            let t = f64::from(k);
            let p = DVec3::new(libm::sin(t) * 4.0, libm::sin(1.7 * t) * 5.0, libm::cos(2.3 * t) * 6.0);
            let least = f64::from(k % 50) * 0.1;
            if lattice.surely_reaches(&samples, p, least) {
                assert!(lattice.interpolate_linear(&samples, p).0 >= least, "{p}: {least}");
                sure += 1;
            }
        }
        assert!(sure > 200, "{sure}");
    }

    #[test]
    fn places_outside_take_the_nearest_of_the_box() {
        let lattice = lattice();
        let samples: Vec<f64> = (0..lattice.len()).map(|n| plane(lattice.place(n)).0).collect();
        let far = lattice.interpolate_linear(&samples, DVec3::splat(1e9)).0;
        assert!(far.is_finite() && (far - plane(DVec3::new(6.0, 7.0, 8.0)).0).abs() < 4.0, "{far}");
    }
}
