//! Rotation-minimising frames along a curve, by double reflection (Wang et al. 2008, *Computation of rotation minimizing
//! frames*, ACM TOG 27(1), alg. 1): error falls with the fourth power of the step.

use crate::curve::Curve;
use glam::DVec3;

/// A point of the curve with an orthonormal frame; `normal × binormal = tangent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// On the curve, mm.
    pub position: DVec3,
    /// Unit tangent.
    pub tangent: DVec3,
    /// Unit normal that turns no more than the tangent forces it to.
    pub normal: DVec3,
}

impl Frame {
    /// The third axis.
    pub fn binormal(&self) -> DVec3 {
        self.tangent.cross(self.normal)
    }
}

/// Frames at rising parameters. Where the velocity vanishes the tangent is that of the nearest frame before.
pub fn frames_along(curve: &Curve, parameters: &[f64]) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::with_capacity(parameters.len());
    for &u in parameters {
        let jet = curve.jet(u);
        let frame = match frames.last() {
            None => first_frame(jet.position, jet.velocity.normalize_or(DVec3::Z)),
            Some(last) => last.carried_to(jet.position, jet.velocity.normalize_or(last.tangent)),
        };
        frames.push(frame);
    }
    frames
}

fn first_frame(position: DVec3, tangent: DVec3) -> Frame {
    Frame { position, tangent, normal: tangent.any_orthonormal_vector() }
}

impl Frame {
    /// The frame at the next point: reflected in the plane between the points, then in that between the tangents.
    fn carried_to(&self, position: DVec3, tangent: DVec3) -> Frame {
        let normal = reflect(self.normal, position - self.position);
        let carried = reflect(self.tangent, position - self.position);
        let normal = reflect(normal, tangent - carried);
        let normal = normal.reject_from_normalized(tangent).normalize_or(tangent.any_orthonormal_vector());
        Frame { position, tangent, normal }
    }
}

/// Mirror image of `v` in the plane through the origin with the given normal; `v` itself for a zero normal.
fn reflect(v: DVec3, plane_normal: DVec3) -> DVec3 {
    let square = plane_normal.length_squared();
    if square > 0.0 { v - plane_normal * (2.0 * v.dot(plane_normal) / square) } else { v }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planar_curve_keeps_its_binormal() {
        let points = [DVec3::ZERO, DVec3::X * 5.0, DVec3::new(9.0, 4.0, 0.0), DVec3::new(3.0, 9.0, 0.0)];
        let curve = Curve::clamped_uniform(3, &points).unwrap();
        let frames = frames_along(&curve, &(0..=40).map(|k| f64::from(k) / 40.0).collect::<Vec<_>>());
        let tilt = frames[0].normal.z;
        for frame in &frames {
            assert!((frame.normal.z - tilt).abs() < 1e-12);
            assert!(
                frame.normal.dot(frame.tangent).abs() < 1e-12 && (frame.normal.length() - 1.0).abs() < 1e-12
            );
        }
    }

    /// The turn of the frame about a helix is `2π·sin(pitch angle)` per turn, less whole turns.
    #[test]
    fn helix_turns_by_its_torsion() {
        let (radius, rise) = (10.0, 3.0);
        let speed = f64::hypot(radius, rise);
        let at = |t: f64| DVec3::new(radius * t.cos(), radius * t.sin(), rise * t);
        let tangent = |t: f64| DVec3::new(-radius * t.sin(), radius * t.cos(), rise) / speed;
        let toward_axis = |t: f64| DVec3::new(-t.cos(), -t.sin(), 0.0);
        let mut frame = Frame { position: at(0.0), tangent: tangent(0.0), normal: toward_axis(0.0) };
        for k in 1..=200 {
            let t = f64::from(k) / 200.0 * std::f64::consts::PI;
            frame = frame.carried_to(at(t), tangent(t));
        }
        let turned = frame.normal.dot(toward_axis(std::f64::consts::PI)).acos();
        assert!((turned - std::f64::consts::PI * rise / speed).abs() < 1e-6, "{turned}");
    }

    #[test]
    fn curve_that_stands_still_has_frames_too() {
        let curve = Curve::clamped_uniform(3, &[DVec3::ONE; 4]).unwrap();
        for frame in frames_along(&curve, &[0.0, 0.5, 1.0]) {
            assert!((frame.normal.length() - 1.0).abs() < 1e-12);
        }
    }
}
