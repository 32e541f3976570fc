//! Poses from three points: Lambda Twist (Persson & Nordberg, ECCV 2018, "Lambda Twist: An Accurate Fast Robust
//! Perspective Three Point (P3P) Solver").
//!
//! Notation, after the paper: `x_i` points on the object, `y_i` unit bearings to them, `λ_i` their distances from the
//! camera, so that `R x_i + t = λ_i y_i`; `a_ij = |x_i − x_j|²`, `c_ij = y_i · y_j`. The distances obey
//! `λ_i² + λ_j² − 2 c_ij λ_i λ_j = a_ij`: three quadrics. A combination of two that is degenerate (a root of a cubic) splits
//! into two planes, and each plane meets the third quadric in up to two places: at most four poses.

use crate::pose::Pose;
use glam::{DMat3, DVec3};

/// At most four poses.
#[derive(Clone, Copy, Debug, Default)]
pub struct Solutions {
    poses: [Option<Pose>; 4],
}

impl Solutions {
    /// The poses found.
    pub fn iter(&self) -> impl Iterator<Item = &Pose> {
        self.poses.iter().flatten()
    }
}

/// All poses of an object whose points, mm, lie on three unit bearings in front of the camera. None for points on a line.
pub fn solve(bearings: [DVec3; 3], points: [DVec3; 3]) -> Solutions {
    let mut solutions = Solutions::default();
    let Some(edges) = Edges::of(points) else { return solutions };
    let quadrics = Quadrics::of(bearings, points);
    for (slot, distances) in quadrics.distances().into_iter().enumerate() {
        let refined = distances.and_then(|start| quadrics.refine(start));
        solutions.poses[slot] = refined.map(|lambda| edges.pose(bearings, points[0], lambda));
    }
    solutions
}

/// The object's triangle, ready to be turned into a camera's frame.
struct Edges {
    inverse: DMat3,
}

impl Edges {
    fn of([x1, x2, x3]: [DVec3; 3]) -> Option<Edges> {
        let (d12, d13) = (x1 - x2, x1 - x3);
        let normal = d12.cross(d13);
        let flat = normal.length_squared() <= 1e-18 * d12.length_squared() * d13.length_squared();
        (!flat).then(|| Edges { inverse: DMat3::from_cols(d12, d13, normal).inverse() })
    }

    /// `R = Y X⁻¹`, `t = λ_1 y_1 − R x_1` (paper, section 3.8).
    fn pose(&self, y: [DVec3; 3], x1: DVec3, lambda: DVec3) -> Pose {
        let z = [y[0] * lambda.x, y[1] * lambda.y, y[2] * lambda.z];
        let (d12, d13) = (z[0] - z[1], z[0] - z[2]);
        let rotation = DMat3::from_cols(d12, d13, d12.cross(d13)) * self.inverse;
        Pose { rotation, translation: z[0] - rotation * x1 }
    }
}

struct Quadrics {
    a12: f64,
    a13: f64,
    a23: f64,
    c12: f64,
    c13: f64,
    c23: f64,
}

impl Quadrics {
    fn of([y1, y2, y3]: [DVec3; 3], [x1, x2, x3]: [DVec3; 3]) -> Quadrics {
        Quadrics {
            a12: x1.distance_squared(x2),
            a13: x1.distance_squared(x3),
            a23: x2.distance_squared(x3),
            c12: y1.dot(y2),
            c13: y1.dot(y3),
            c23: y2.dot(y3),
        }
    }

    /// Positive distances on the two planes of the degenerate quadric (section 3.5 to 3.7).
    fn distances(&self) -> [Option<DVec3>; 4] {
        let degenerate = self.degenerate();
        let (values, vectors) = eigenpairs(&degenerate);
        let slope = (-values[1] / values[0]).max(0.0).sqrt();
        let [p, q] = self.on_plane(vectors, slope);
        let [r, s] = self.on_plane(vectors, -slope);
        [p, q, r, s]
    }

    /// `D_0 = η D_1 + γ D_2` with `det D_0 = 0` (eq. (9) to (11) there).
    fn degenerate(&self) -> DMat3 {
        let Quadrics { a12, a13, a23, c12, c13, c23 } = *self;
        let (g, h) = self.root();
        let (m00, m11, m22) = (a23 * (h - g), (a23 - a12) * h + a13 * g, g * (a13 - a23) - a12 * h);
        let (m01, m02, m12) = (-a23 * c12 * h, a23 * c13 * g, -c23 * (a13 * g - a12 * h));
        DMat3::from_cols(DVec3::new(m00, m01, m02), DVec3::new(m01, m11, m12), DVec3::new(m02, m12, m22))
    }

    /// A root `(γ, η)` of `det (η D_1 + γ D_2)`, a homogeneous cubic.
    fn root(&self) -> (f64, f64) {
        let Quadrics { a12, a13, a23, c12, c13, c23 } = *self;
        let (s12, s13, s23) = (1.0 - c12 * c12, 1.0 - c13 * c13, 1.0 - c23 * c23);
        let blob = c12 * c23 * c13 - 1.0;
        let p3 = a13 * (a23 * s13 - a13 * s23);
        let p2 = 2.0 * blob * a23 * a13 + a13 * (2.0 * a12 + a13) * s23 + a23 * (a23 - a12) * s13;
        let p1 = a23 * (a13 - a23) * s12 - a12 * a12 * s23 - 2.0 * a12 * (blob * a23 + a13 * s23);
        let p0 = a12 * (a12 * s23 - a23 * s12);
        let vanishes = p3.abs() <= 1e-12 * p0.abs().max(p1.abs()).max(p2.abs());
        if vanishes { (1.0, 0.0) } else { (cubic_root([p0, p1, p2, p3]), 1.0) }
    }

    /// Distances on one of the planes, `λ · (v_1 − slope v_2) = 0`.
    fn on_plane(&self, [v1, v2]: [DVec3; 2], slope: f64) -> [Option<DVec3>; 2] {
        let normal = v1 - v2 * slope;
        if normal.x.abs() > 1e-9 { self.on_oblique_plane(normal) } else { self.on_upright_plane(normal) }
    }

    /// `λ_1 = w_0 λ_2 + w_1 λ_3`, then a quadratic in `τ = λ_3 / λ_2` (section 3.7).
    fn on_oblique_plane(&self, normal: DVec3) -> [Option<DVec3>; 2] {
        let Quadrics { a12, a13, a23, c12, c13, c23 } = *self;
        let (w0, w1) = (-normal.y / normal.x, -normal.z / normal.x);
        let a = (a13 - a12) * w1 * w1 + 2.0 * a12 * c13 * w1 - a12;
        let b = -2.0 * a13 * c12 * w1 + 2.0 * a12 * c13 * w0 - 2.0 * w0 * w1 * (a12 - a13);
        let c = (a13 - a12) * w0 * w0 - 2.0 * a13 * c12 * w0 + a13;
        quadratic_roots(a, b, c).map(|tau| {
            let tau = tau.filter(|t| *t > 0.0)?;
            let l2 = (a23 / (tau * (tau - 2.0 * c23) + 1.0)).sqrt();
            let l1 = w0 * l2 + w1 * tau * l2;
            (l1 > 0.0).then_some(DVec3::new(l1, l2, tau * l2))
        })
    }

    /// The plane of a symmetric view: `τ` is given, `λ_1` follows from the quadric of points 1 and 2.
    fn on_upright_plane(&self, normal: DVec3) -> [Option<DVec3>; 2] {
        let Quadrics { a12, a23, c12, c23, .. } = *self;
        let tau = -normal.y / normal.z;
        let l2 = (a23 / (tau * (tau - 2.0 * c23) + 1.0)).sqrt();
        quadratic_roots(1.0, -2.0 * c12 * l2, l2 * l2 - a12)
            .map(|l1| l1.filter(|l1| *l1 > 0.0 && tau > 0.0).map(|l1| DVec3::new(l1, l2, tau * l2)))
    }

    /// Gauss–Newton on the three quadrics (section 3.8); `None` for distances that do not obey them afterwards.
    fn refine(&self, mut l: DVec3) -> Option<DVec3> {
        let scale = self.a12.max(self.a13).max(self.a23);
        let mut residual = self.residual(l);
        for _ in 0..3 {
            if residual.abs().max_element() <= 1e-12 * scale {
                break;
            }
            let step = self.jacobian(l).inverse() * (residual * 0.5);
            // Where roots coincide the matrix is singular and the start is as good as it gets.
            let small = step.length_squared() <= 1e-4 * l.length_squared();
            if !small {
                break;
            }
            l -= step;
            residual = self.residual(l);
        }
        (residual.abs().max_element() <= 1e-6 * scale).then_some(l)
    }

    fn residual(&self, l: DVec3) -> DVec3 {
        let Quadrics { a12, a13, a23, c12, c13, c23 } = *self;
        let quadric = |p: f64, q: f64, c: f64, a: f64| p * p + q * q - 2.0 * c * p * q - a;
        DVec3::new(quadric(l.x, l.y, c12, a12), quadric(l.x, l.z, c13, a13), quadric(l.y, l.z, c23, a23))
    }

    /// Half the derivative of the residual.
    fn jacobian(&self, l: DVec3) -> DMat3 {
        let Quadrics { c12, c13, c23, .. } = *self;
        DMat3::from_cols(
            DVec3::new(l.x - c12 * l.y, l.x - c13 * l.z, 0.0),
            DVec3::new(l.y - c12 * l.x, 0.0, l.y - c23 * l.z),
            DVec3::new(0.0, l.z - c13 * l.x, l.z - c23 * l.y),
        )
    }
}

/// Eigenvalues of a symmetric matrix of determinant 0 other than that 0, the greater in size first, with unit vectors.
fn eigenpairs(m: &DMat3) -> ([f64; 2], [DVec3; 2]) {
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let trace = x.x + y.y + z.z;
    let minors = x.x * y.y - x.y * x.y + x.x * z.z - x.z * x.z + y.y * z.z - y.z * y.z;
    let spread = (trace * trace - 4.0 * minors).max(0.0).sqrt();
    let first = 0.5 * (trace + spread.copysign(trace));
    let second = if first == 0.0 { 0.0 } else { minors / first };
    ([first, second], [null_vector(m, first), null_vector(m, second)])
}

/// The unit vector that `m − value · 1` takes to 0: the longest cross product of two of its rows.
fn null_vector(m: &DMat3, value: f64) -> DVec3 {
    let shifted = *m - DMat3::from_diagonal(DVec3::splat(value));
    let (x, y, z) = (shifted.x_axis, shifted.y_axis, shifted.z_axis);
    let crosses = [x.cross(y), y.cross(z), z.cross(x)];
    let longest = crosses.into_iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    longest.unwrap_or(DVec3::Z).normalize_or(DVec3::Z)
}

/// Real roots of `a t² + b t + c` without cancellation.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant.is_nan() || discriminant < 0.0 {
        return [None, None];
    }
    let sum = -0.5 * (b + discriminant.sqrt().copysign(b));
    [sum / a, c / sum].map(|t| t.is_finite().then_some(t))
}

/// A real root of `p3 γ³ + p2 γ² + p1 γ + p0` by Newton's method. It starts so far out, on a side where a root must lie,
/// that after one step it runs towards the root from one side.
fn cubic_root([p0, p1, p2, p3]: [f64; 4]) -> f64 {
    let (b, c, d) = (p2 / p3, p1 / p3, p0 / p3);
    let value = |g: f64| ((g + b) * g + c) * g + d;
    let middle = -b / 3.0;
    let spread = b * b - 3.0 * c;
    let mut g = if spread > 0.0 {
        // Stationary at middle ± arm; at middle ± 2 arm it has the opposite stationary value again.
        let arm = spread.sqrt() / 3.0;
        if value(middle + arm) > 0.0 { middle - 2.0 * arm } else { middle + 2.0 * arm }
    } else {
        middle - libm::cbrt(value(middle))
    };
    for _ in 0..60 {
        let step = value(g) / ((3.0 * g + 2.0 * b) * g + c);
        if !step.is_finite() {
            break;
        }
        g -= step;
        if step.abs() <= 4.0 * f64::EPSILON * g.abs() {
            break;
        }
    }
    g
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::{Random, random_pose};

    /// Every solution must be a rotation that puts the points on their rays; returns the least distance to the truth.
    fn validate(pose: &Pose, points: [DVec3; 3]) -> f64 {
        let bearings = points.map(|x| pose.apply(x).normalize());
        let mut nearest = f64::INFINITY;
        for found in solve(bearings, points).iter() {
            assert!((found.rotation.determinant() - 1.0).abs() < 1e-6, "{found:?}");
            for (x, y) in points.into_iter().zip(bearings) {
                assert!(found.apply(x).normalize().distance(y) < 1e-6, "{found:?} misses a ray");
            }
            nearest =
                nearest.min(found.angle_to(pose) + found.translation.distance(pose.translation) / 1000.0);
        }
        nearest
    }

    #[test]
    fn the_true_pose_is_among_the_solutions() {
        let mut random = Random::new(1);
        let (mut missed, mut worst) = (0, 0.0_f64);
        for _ in 0..20_000 {
            let points = [random.in_ball(70.0), random.in_ball(70.0), random.in_ball(70.0)];
            match validate(&random_pose(&mut random, 300.0..1500.0), points) {
                error if error < 1e-4 => worst = worst.max(error),
                _ => missed += 1,
            }
        }
        assert!(missed <= 10, "{missed} of 20,000 missed (roots that coincide), worst {worst:e}");
    }

    #[test]
    fn symmetric_views_are_solved() {
        let check = |points: [[f64; 3]; 3], eye: [f64; 3]| {
            let pose = Pose::looking(eye.into(), DVec3::ZERO, 0.4);
            assert!(validate(&pose, points.map(DVec3::from)) < 1e-4, "{points:?} from {eye:?}");
        };
        let right = [[0.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 30.0, 0.0]];
        check(right, [400.0, 400.0, 600.0]);
        check(right, [400.0, 0.0, 600.0]);
        let isosceles = [[-20.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 50.0, 0.0]];
        check(isosceles, [0.0, 300.0, 500.0]);
        check(isosceles, [300.0, 0.0, 500.0]);
    }

    #[test]
    fn nonsense_has_no_pose() {
        let check = |points: [DVec3; 3], bearings: [DVec3; 3]| {
            assert_eq!(solve(bearings, points).iter().count(), 0, "{points:?}");
        };
        let rays = [DVec3::Z, DVec3::new(0.1, 0.0, 1.0).normalize(), DVec3::new(0.0, 0.1, 1.0).normalize()];
        check([DVec3::X, DVec3::X * 2.0, DVec3::X * 3.0], rays);
        check([DVec3::ONE; 3], rays);
        check([DVec3::X, DVec3::Y, DVec3::Z], [DVec3::NAN; 3]);
    }
}
