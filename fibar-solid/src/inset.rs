//! The part of a body that is deeper than a given distance: what is inside a skin.
//!
//! Outline: every triangle gets the convex hull of itself and of what lies within the distance behind it; the body less
//! the union of those hulls is the inset. Behind a corner that is convex or nearly flat, that is one point along the
//! normal of each triangle around it; behind any other, a polyhedral ball. Both hold the true ball sector, so that the skin is
//! nowhere thinner than asked; it is nowhere thicker than 1.071 times as much plus the simplification. Parts of the
//! body thinner than two skins have no inside: there the inset is simply empty.
//!
//! Why not a level set or moved vertices: `docs/decisions/skin-by-hulls.md`.

use crate::ball::ball_corners;
use crate::{Solid, SolidError};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use rayon::prelude::*;

/// What to leave as skin.
#[derive(Clone, Copy, Debug)]
pub struct InsetOptions {
    /// Least thickness of the skin, mm.
    pub thickness: f64,
    /// Detail of the inset's surface to drop, mm; the skin is made thicker by as much beforehand.
    pub simplify: f64,
}

/// Corner normals further than this from their mean need a ball: 1/cos 20° is just less than a ball's 1.071.
const SHARP_COSINE: f64 = 0.939_692_620_785_908_4;
/// Sine of the angle by which rounding may lift a neighbour above a face.
const FLAT: f64 = 1e-12;
/// 42 corners, which stand off the true ball by 7 %.
const BALL_FREQUENCY: usize = 2;
/// Hulls united at a time; neighbours by Morton order, so that they meet early.
const CHUNK: usize = 32;

/// The body without its skin. Same bytes for any number of threads: chunks are fixed and joined in order.
pub fn inset(body: &Solid, options: InsetOptions) -> Result<Solid, SolidError> {
    let InsetOptions { thickness, simplify } = options;
    if !(thickness > 0.0 && simplify >= 0.0 && thickness.is_finite() && simplify.is_finite()) {
        return Err(SolidError::Argument(format!("a skin of {thickness} mm is none")));
    }
    let mesh = body.to_mesh()?;
    let corners = Corners::new(&mesh, thickness + simplify)?;
    let order = morton_order(&mesh);
    let hulls: Result<Vec<Solid>, SolidError> =
        order.par_iter().map(|&triangle| corners.hull_behind(&mesh, triangle)).collect();
    body.subtract([&unite(hulls?)?])?.simplify(simplify)
}

/// Union in a fixed tree: chunks first, then pairs.
fn unite(solids: Vec<Solid>) -> Result<Solid, SolidError> {
    let mut level: Vec<Solid> = solids.par_chunks(CHUNK).map(Solid::union).collect::<Result<_, _>>()?;
    while level.len() > 1 {
        level = level.par_chunks(2).map(Solid::union).collect::<Result<_, _>>()?;
    }
    Ok(level.pop().unwrap_or_else(Solid::empty))
}

/// What lies behind each vertex, as offsets from it.
struct Corners {
    offsets: Vec<Vec<DVec3>>,
}

impl Corners {
    fn new(mesh: &TriangleMesh, depth: f64) -> Result<Corners, SolidError> {
        let ball: Vec<DVec3> = ball_corners(BALL_FREQUENCY)?.into_iter().map(|v| v * depth).collect();
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); mesh.vertices.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| around[v as usize].push(t));
        }
        let offsets = around.iter().zip(&mesh.vertices).map(|(triangles, vertex)| {
            let normals: Vec<DVec3> = triangles.iter().map(|&t| unit_normal(mesh.corners(t))).collect();
            let ring = triangles.iter().flat_map(|&t| mesh.corners(t)).map(|corner| corner - *vertex);
            offsets_behind(&normals, ring, depth, &ball)
        });
        Ok(Corners { offsets: offsets.collect() })
    }

    fn hull_behind(&self, mesh: &TriangleMesh, triangle: usize) -> Result<Solid, SolidError> {
        let mut points = Vec::new();
        for v in mesh.triangles[triangle] {
            let place = mesh.vertices[v as usize];
            points.push(place);
            points.extend(self.offsets[v as usize].iter().map(|offset| place + *offset));
        }
        Solid::hull(&points)
    }
}

/// Offsets whose hull with the origin holds the sector of the ball of radius `depth` behind a corner with these normals,
/// `ring` being the corners around it as seen from it.
///
/// Normals within the angle ψ of their mean span a spherical polygon; its flat hull is at least `r·cos ψ` away, so that
/// points at `r = depth / cos ψ` reach far enough. A convex corner has nothing behind it that is not behind its
/// triangles, so that it needs neither more depth nor a ball.
fn offsets_behind(
    normals: &[DVec3],
    mut ring: impl Iterator<Item = DVec3>,
    depth: f64,
    ball: &[DVec3],
) -> Vec<DVec3> {
    let along = |reach: f64| normals.iter().map(|normal| -*normal * reach).collect();
    let is_sound = normals.iter().all(|normal| *normal != DVec3::ZERO);
    if is_sound
        && ring.all(|corner| normals.iter().all(|normal| normal.dot(corner) <= FLAT * corner.length()))
    {
        return along(depth);
    }
    let mean = normals.iter().sum::<DVec3>().normalize_or_zero();
    let cosine = normals.iter().map(|normal| normal.dot(mean)).fold(1.0, f64::min);
    if is_sound && cosine >= SHARP_COSINE { along(depth / cosine) } else { ball.to_vec() }
}

/// Zero for a triangle without area.
fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Triangles in the order of their centres along a Morton curve of 2¹⁰ cells a side.
fn morton_order(mesh: &TriangleMesh) -> Vec<usize> {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let cell = (high - low).max(DVec3::splat(f64::MIN_POSITIVE)) / 1023.0;
    let key = |t: usize| {
        let centre = mesh.corners(t).iter().sum::<DVec3>() / 3.0;
        let q = ((centre - low) / cell).as_uvec3();
        spread(q.x) | spread(q.y) << 1 | spread(q.z) << 2
    };
    let mut order: Vec<usize> = (0..mesh.triangles.len()).collect();
    order.sort_by_cached_key(|&t| (key(t), t));
    order
}

/// Bits of a number below 2¹⁰, two zeros between them.
fn spread(x: u32) -> u32 {
    (0..10).fold(0, |bits, k| bits | (x >> k & 1) << (3 * k))
}

#[cfg(test)]
mod tests {
    use super::*;
    use fibar_geometry::distance::Surface;

    fn block(low: [f64; 3], high: [f64; 3]) -> Solid {
        let corner =
            |k: usize| DVec3::from_array(std::array::from_fn(|axis| [low, high][k >> axis & 1][axis]));
        Solid::hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
    }

    /// Least distance of the inset's vertices and face centres from the body's surface.
    fn thinnest(body: &Solid, inside: &Solid) -> f64 {
        let surface = Surface::new(&body.to_mesh().unwrap()).unwrap();
        let mesh = inside.to_mesh().unwrap();
        let centres = (0..mesh.triangles.len()).map(|t| mesh.corners(t).iter().sum::<DVec3>() / 3.0);
        let depth = |p: DVec3| -surface.signed_distance(p);
        mesh.vertices.iter().copied().chain(centres).map(depth).fold(f64::MAX, f64::min)
    }

    fn ball(radius: f64, frequency: usize) -> Solid {
        Solid::hull(&ball_corners(frequency).unwrap().into_iter().map(|v| v * radius).collect::<Vec<_>>())
            .unwrap()
    }

    #[test]
    fn a_convex_body_keeps_its_corners_sharp() {
        let inside =
            inset(&block([0.0; 3], [10.0; 3]), InsetOptions { thickness: 0.5, simplify: 0.0 }).unwrap();
        assert!((inside.volume() - 729.0).abs() < 1e-9, "{inside:?}");
        assert!(thinnest(&block([0.0; 3], [10.0; 3]), &inside) >= 0.5 - 1e-9);
    }

    #[test]
    fn the_skin_is_never_thinner_than_asked() {
        let (cube, corner) = (block([0.0; 3], [10.0; 3]), block([5.0; 3], [11.0; 3]));
        let round = ball(10.0, 6);
        let pit = ball(6.0, 5).translate(DVec3::new(0.0, 0.0, 9.0)).unwrap();
        let bodies = [round.clone(), round.subtract([&pit]).unwrap(), cube.subtract([&corner]).unwrap()];
        for body in &bodies {
            for simplify in [0.0, 0.005] {
                let inside = inset(body, InsetOptions { thickness: 0.4, simplify }).unwrap();
                let skin = thinnest(body, &inside);
                assert!(skin >= 0.4 - 1e-9, "{body:?}: {skin}");
                let mean = (body.volume() - inside.volume()) / body.surface_area();
                assert!(mean < 0.4 * 1.08 + 0.01, "{body:?}: {mean} mm on average");
            }
        }
    }

    #[test]
    fn a_sheet_of_less_than_two_skins_has_no_inside() {
        let sheet = block([0.0; 3], [10.0, 10.0, 0.79]);
        assert!(inset(&sheet, InsetOptions { thickness: 0.4, simplify: 0.0 }).unwrap().is_empty());
        let plug = block([3.0, 3.0, -2.0], [7.0, 7.0, 3.0]);
        let body = Solid::union([&sheet, &plug]).unwrap();
        let inside = inset(&body, InsetOptions { thickness: 0.4, simplify: 0.0 }).unwrap();
        assert_eq!(inside.components().unwrap().len(), 1);
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let body = ball(7.0, 5);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = InsetOptions { thickness: 0.4, simplify: 0.002 };
            pool.install(|| inset(&body, options).unwrap().to_mesh().unwrap().to_ply())
        };
        let once = run(1);
        assert!((0..4).all(|_| run(3) == once));
    }
}
