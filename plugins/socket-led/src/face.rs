//! The flat face that takes the LEDs, and the frame in which it is the plane z = 0 with the body above it.
//!
//! Frame of a face: the origin is the centroid of its area, w points into the body, u is level (+X where w is upright), v = w × u.
//! The base of the body keeps the body's own frame.

use crate::params::Params;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::StageError;
use glam::{DMat3, DVec2, DVec3};

/// Where a face lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    origin: DVec3,
    /// Columns u, v, w.
    body_from_face: DMat3,
}

/// Triangles that look the same way at the same height.
struct Patch {
    area: f64,
    centroid: DVec3,
    normal: DVec3,
}

impl Face {
    /// The base in z = 0.
    pub const BASE: Face = Face { origin: DVec3::ZERO, body_from_face: DMat3::IDENTITY };

    /// The face that the parameters choose.
    pub fn choose(body: &TriangleMesh, params: &Params) -> Result<Face, StageError> {
        let Some(wish) = params.face_normal.map(DVec3::from) else { return Ok(Face::BASE) };
        let Some(wish) = wish.try_normalize() else {
            return Err(StageError::user("the normal of the face has no direction")
                .param("/face_normal")
                .hint("[0, 0, -1] is the base, [1, 0, 0] looks towards +X"));
        };
        let patches = patches(body, wish, params);
        let value = |p: &Patch| match params.face_near_mm {
            Some(place) => -p.centroid.distance(DVec3::from(place)),
            None => p.area,
        };
        let best = patches.iter().max_by(|a, b| value(a).total_cmp(&value(b)));
        best.map(Face::of).ok_or_else(|| no_face(body, wish, params))
    }

    fn of(patch: &Patch) -> Face {
        let w = -patch.normal;
        let u = DVec3::Z.cross(w).try_normalize().unwrap_or(DVec3::X);
        Face { origin: patch.centroid, body_from_face: DMat3::from_cols(u, w.cross(u), w) }
    }

    /// The body in the face's frame.
    pub fn lay_down(&self, body: &TriangleMesh) -> TriangleMesh {
        let face_from_body = self.body_from_face.transpose();
        let lay = |vertex: &DVec3| face_from_body * (*vertex - self.origin);
        TriangleMesh { vertices: body.vertices.iter().map(lay).collect(), triangles: body.triangles.clone() }
    }

    /// A place above the face in the body's frame, mm.
    pub fn place(&self, on_face: DVec2, height: f64) -> DVec3 {
        self.origin + self.body_from_face * on_face.extend(height)
    }

    /// Unit vector into the body.
    pub fn inwards(&self) -> DVec3 {
        self.body_from_face.z_axis
    }
}

/// The flat faces that look along `wish`: triangles that do so to `face_tilt_deg`, parted by height along it.
fn patches(body: &TriangleMesh, wish: DVec3, params: &Params) -> Vec<Patch> {
    let slope = libm::cos(params.face_tilt_deg.to_radians());
    let facing = flat_triangles(body).filter(|(normal, _)| normal.dot(wish) >= slope * normal.length());
    let mut facing: Vec<(DVec3, DVec3)> = facing.collect();
    facing.sort_by(|a, b| a.1.dot(wish).total_cmp(&b.1.dot(wish)));
    let apart = |a: &(DVec3, DVec3), b: &(DVec3, DVec3)| (b.1 - a.1).dot(wish) <= params.flatness_mm;
    facing.chunk_by(apart).map(Patch::of).collect()
}

impl Patch {
    /// From normals as long as twice the area, and centroids.
    fn of(triangles: &[(DVec3, DVec3)]) -> Patch {
        let weigh = |sum: (f64, DVec3, DVec3), (normal, middle): &(DVec3, DVec3)| {
            let area = 0.5 * normal.length();
            (sum.0 + area, sum.1 + *middle * area, sum.2 + *normal)
        };
        let (area, moment, normal) = triangles.iter().fold((0.0, DVec3::ZERO, DVec3::ZERO), weigh);
        Patch { area, centroid: moment / area, normal: normal.normalize() }
    }
}

/// Normal, as long as twice the area, and centroid of every triangle that has an area.
fn flat_triangles(body: &TriangleMesh) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
    let of = |t: usize| {
        let [a, b, c] = body.corners(t);
        ((b - a).cross(c - a), (a + b + c) / 3.0)
    };
    (0..body.triangles.len()).map(of).filter(|(normal, _)| *normal != DVec3::ZERO)
}

/// Says what looks nearly that way.
fn no_face(body: &TriangleMesh, wish: DVec3, params: &Params) -> StageError {
    let towards = |n: &(DVec3, DVec3)| n.0.normalize().dot(wish);
    let nearest = flat_triangles(body).max_by(|a, b| towards(a).total_cmp(&towards(b)));
    let message = format!("the body has no face that looks along {wish:.3} to {}°", params.face_tilt_deg);
    let error = match nearest {
        Some((normal, middle)) => {
            let off = libm::acos(normal.normalize().dot(wish).clamp(-1.0, 1.0)).to_degrees();
            let found = normal.normalize();
            StageError::user(format!("{message}; the nearest looks along {found:.3}, {off:.1}° off"))
                .place_mm(middle.to_array())
        }
        None => StageError::user(message),
    };
    error.param("/face_normal").hint("a larger face_tilt_deg takes faces that lean")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{frustum, moved};

    fn with(normal: [f64; 3]) -> Params {
        Params { face_normal: Some(normal), ..Params::default() }
    }

    #[test]
    fn a_face_becomes_the_floor() {
        let check = |normal: [f64; 3], near: Option<[f64; 3]>, origin: [f64; 3]| {
            let body = moved(frustum(20.0, 20.0, 40.0), DVec3::new(5.0, 0.0, 0.0));
            let face = Face::choose(&body, &Params { face_near_mm: near, ..with(normal) }).unwrap();
            assert!(face.origin.distance(DVec3::from(origin)) < 1e-9, "{face:?}");
            assert!(face.inwards().distance(-DVec3::from(normal).normalize()) < 1e-9);
            let (low, high) = face.lay_down(&body).bounds().unwrap();
            assert!(low.z.abs() < 1e-9 && (high.z - 40.0).abs() < 1e-9, "{low} {high}");
            assert!((face.body_from_face.determinant() - 1.0).abs() < 1e-12);
        };
        check([0.0, 0.0, -1.0], None, [5.0, 0.0, 0.0]);
        check([0.0, 0.0, 2.0], None, [5.0, 0.0, 40.0]);
        check([1.0, 0.0, 0.0], Some([0.0; 3]), [25.0, 0.0, 20.0]);
        check([0.0, -1.0, 0.0], None, [5.0, -20.0, 20.0]);
    }

    #[test]
    fn of_steps_the_largest_or_the_nearest() {
        let mut steps = frustum(10.0, 10.0, 10.0);
        let wide = moved(frustum(20.0, 20.0, 30.0), DVec3::X * 60.0);
        steps.triangles.extend(wide.triangles.iter().map(|t| t.map(|v| v + 8)));
        steps.vertices.extend(wide.vertices);
        let up = with([0.0, 0.0, 1.0]);
        assert_eq!(Face::choose(&steps, &up).unwrap().origin.z, 30.0);
        let near = Params { face_near_mm: Some([0.0, 0.0, 12.0]), ..up };
        assert_eq!(Face::choose(&steps, &near).unwrap().origin.z, 10.0);
    }

    #[test]
    fn a_face_that_is_not_there_is_told_with_the_nearest() {
        let error = Face::choose(&frustum(20.0, 20.0, 40.0), &with([1.0, 0.0, 0.3])).unwrap_err().to_string();
        assert!(error.contains("16.7° off"), "{error}");
        let error = Face::choose(&frustum(20.0, 20.0, 40.0), &with([0.0; 3])).unwrap_err().to_string();
        assert!(error.contains("no direction"), "{error}");
    }
}
