//! The part of a body that is deeper than a given distance: what is inside a skin.
//!
//! Outline: wherever the surface is smooth and nothing is in the way, the layer under it is one solid, with an inner triangle for each
//! outer one (`layer.rs`). Every triangle elsewhere gets the convex hull of itself and of what lies within the distance behind it. The
//! body less all of these is the inset. Behind a corner that is convex or nearly flat, a hull has one point along the
//! normal of each triangle around it; behind any other, a polyhedral ball. Both hold the true ball sector, so that the skin is
//! nowhere thinner than asked; it is nowhere thicker than 1.071 times as much plus the simplification. Parts of the
//! body thinner than two skins have no inside: there the inset is simply empty.
//!
//! Why not a level set or moved vertices: `docs/decisions/skin-by-hulls.md`.

use crate::behind::solids_behind;
use crate::layer::Layer;
use crate::nearness::nearer;
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

/// What rounding may take from the skin, relative to it.
const ROUNDING: f64 = 1e-10;
/// Hulls united at a time; neighbours by Morton order, so that they meet early.
const CHUNK: usize = 32;

/// The body without its skin. Same bytes for any number of threads: chunks are fixed and joined in order.
pub fn inset(body: &Solid, options: InsetOptions) -> Result<Solid, SolidError> {
    let InsetOptions { thickness, simplify } = options;
    if !(thickness > 0.0 && simplify >= 0.0 && thickness.is_finite() && simplify.is_finite()) {
        return Err(SolidError::Argument(format!("a skin of {thickness} mm is none")));
    }
    let mesh = body.to_mesh()?;
    let depth = thickness + simplify;
    let layer = Layer::under(&mesh, depth);
    let order = morton_order(&mesh, layer.rest);
    let cells = Solid::from_mesh(&layer.cells)?;
    let others = unite(solids_behind(&mesh, &order, depth)?)?;
    simplified(body.subtract([&cells, &others])?, &mesh, options)
}

/// With less detail, and nowhere nearer to the surface than the skin is thick: Manifold's simplification may go further than it is told.
fn simplified(inside: Solid, body: &TriangleMesh, options: InsetOptions) -> Result<Solid, SolidError> {
    for share in [1.0, 0.5, 0.25] {
        let simpler = inside.simplify(options.simplify * share)?;
        let mesh = simpler.to_mesh()?;
        let triangles: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).map(|t| mesh.corners(t)).collect();
        if nearer(body, &triangles, options.thickness * (1.0 - ROUNDING), |_, _| true).is_empty() {
            return Ok(simpler);
        }
    }
    Ok(inside)
}

/// Union in a fixed tree: chunks first, then pairs.
fn unite(solids: Vec<Solid>) -> Result<Solid, SolidError> {
    let mut level: Vec<Solid> = solids.par_chunks(CHUNK).map(Solid::union).collect::<Result<_, _>>()?;
    while level.len() > 1 {
        level = level.par_chunks(2).map(Solid::union).collect::<Result<_, _>>()?;
    }
    Ok(level.pop().unwrap_or_else(Solid::empty))
}

/// Some triangles in the order of their centres along a Morton curve of 2¹⁰ cells a side.
fn morton_order(mesh: &TriangleMesh, mut order: Vec<usize>) -> Vec<usize> {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let cell = (high - low).max(DVec3::splat(f64::MIN_POSITIVE)) / 1023.0;
    let key = |t: usize| {
        let centre = mesh.corners(t).iter().sum::<DVec3>() / 3.0;
        let q = ((centre - low) / cell).as_uvec3();
        spread(q.x) | spread(q.y) << 1 | spread(q.z) << 2
    };
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
    use crate::ball::ball_corners;
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
        let horn = Solid::hull(&[DVec3::X * 30.0, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]).unwrap();
        let hollow = ball(10.0, 14).subtract([&ball(9.0, 12)]).unwrap();
        let thin = ball(10.0, 14).subtract([&ball(9.0, 12).translate(DVec3::Y * 0.6).unwrap()]).unwrap();
        let bodies = [
            round.subtract([&pit]).unwrap(),
            round.clone(),
            cube.subtract([&corner]).unwrap(),
            Solid::union([&round, &horn]).unwrap(),
            hollow,
            thin,
        ];
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
