//! The layer of a given depth under a surface, in one piece wherever it is as simple as the surface itself.
//!
//! Every vertex has a partner behind it, deep enough under all triangles around it (`miter.rs`); every triangle and the one
//! between its corners' partners enclose a cell, and neighbouring cells share their sides. Where that goes well, all cells together are
//! one solid with as many inner triangles as outer ones. Where it does not, the triangles are left for others to deal with:
//!
//! - a partner would be too deep: in grooves of more than 40° it would have to be far from both sides;
//! - the inner triangle is turned over, comes nearer to any part of the surface than the depth, or passes through something.
//!
//! **Why nothing less deep is left out.** Let q be the point of the surface nearest to p, less than the depth away. If every triangle
//! that is left out is further from q than the depth plus the longest partner, the way from q to p starts within a cell and cannot
//! leave the cells: not through an inner triangle, as all of those are at least the depth away from the whole surface, and not through a
//! side wall, which is too far away. Otherwise the triangles at q are among those in [`Layer::rest`].

use crate::miter::{miter, unit_normal};
use crate::nearness::nearer;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::crossings;
use fibar_geometry::distance::Surface;
use fibar_geometry::half_edges::twins;
use glam::DVec3;
use rayon::prelude::*;

/// A layer, and what is missing of it.
pub struct Layer {
    /// The cells together, closed and without crossings; empty if there are none.
    pub cells: TriangleMesh,
    /// The triangles, ascending, behind which something may be missing.
    pub rest: Vec<usize>,
}

/// Partners may be this many times the depth away from their vertices, …
const LONGEST: f64 = 2.0;
/// … and this many from the surface, so that the skin is nowhere much too thick: just less than a ball's 1.071.
const DEEPEST: f64 = 1.064;
/// What rounding may take from a depth, relative to it.
const ROUNDING: f64 = 1e-10;

impl Layer {
    /// The layer under a closed mesh whose triangles share vertices by index and do not cross.
    pub fn under(mesh: &TriangleMesh, depth: f64) -> Layer {
        let twins = twins(mesh);
        let Ok(surface) = Surface::unsigned(mesh) else {
            return Layer { cells: TriangleMesh::default(), rest: Vec::new() };
        };
        let partners = partners(mesh, &surface, depth);
        let mut is_sound = upright(mesh, &partners);
        let near = too_near(mesh, &partners, &is_sound, depth);
        forget(&mut is_sound, &near);
        loop {
            drop_pinches(mesh, &twins, &mut is_sound);
            let cells = Cells::of(mesh, &partners, &is_sound, &twins);
            let bad = cells.crossed(mesh.triangles.len());
            if bad.is_empty() {
                let rest = rest(mesh, &partners, &is_sound, depth);
                return Layer { cells: cells.alone(mesh.triangles.len(), &is_sound), rest };
            }
            forget(&mut is_sound, &bad);
        }
    }
}

fn forget(is_sound: &mut [bool], bad: &[usize]) {
    bad.iter().for_each(|&triangle| is_sound[triangle] = false);
}

/// Behind each vertex, if anything is there to be trusted.
fn partners(mesh: &TriangleMesh, surface: &Surface, depth: f64) -> Vec<Option<DVec3>> {
    let mut around: Vec<Vec<DVec3>> = vec![Vec::new(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let normal = unit_normal(mesh.corners(t));
        triangle.iter().for_each(|&v| around[v as usize].push(normal));
    }
    let partner = |(normals, &vertex): (&Vec<DVec3>, &DVec3)| {
        let m = if normals.contains(&DVec3::ZERO) { None } else { miter(normals) }?;
        let partner = vertex - m * depth;
        // What is no further from its vertex is no further from the surface.
        let is_near = m.length() <= DEEPEST
            || m.length() <= LONGEST && surface.nearest_within(partner, DEEPEST * depth).is_some();
        is_near.then_some(partner)
    };
    around.par_iter().zip(&mesh.vertices).map(partner).collect()
}

fn inner(mesh: &TriangleMesh, partners: &[Option<DVec3>], triangle: usize) -> Option<[DVec3; 3]> {
    let [a, b, c] = mesh.triangles[triangle].map(|v| partners[v as usize]);
    Some([a?, b?, c?])
}

/// Whose inner triangle is there and looks the same way.
fn upright(mesh: &TriangleMesh, partners: &[Option<DVec3>]) -> Vec<bool> {
    let is_upright = |t: usize| {
        inner(mesh, partners, t)
            .is_some_and(|inner| unit_normal(inner).dot(unit_normal(mesh.corners(t))) > 0.5)
    };
    (0..mesh.triangles.len()).into_par_iter().map(is_upright).collect()
}

/// Whose inner triangle comes nearer to the surface than the depth. To its own triangle it cannot.
fn too_near(mesh: &TriangleMesh, partners: &[Option<DVec3>], is_sound: &[bool], depth: f64) -> Vec<usize> {
    let sound: Vec<usize> = (0..is_sound.len()).filter(|&t| is_sound[t]).collect();
    let inner = |&t: &usize| inner(mesh, partners, t).expect("what is sound has partners");
    let inner: Vec<[DVec3; 3]> = sound.iter().map(inner).collect();
    let least = depth * (1.0 - ROUNDING);
    let near = nearer(mesh, &inner, least, |outer, k| sound[k] != outer);
    near.into_iter().map(|k| sound[k]).collect()
}

/// The triangle across a side of another; a solid's surface is closed, so that there is one.
fn across(twins: &[u32], triangle: usize, side: usize) -> usize {
    twins[3 * triangle + side] as usize / 3
}

/// Drops triangles until those that are left around a vertex are one fan: around another, walls would meet in one line.
fn drop_pinches(mesh: &TriangleMesh, twins: &[u32], is_sound: &mut [bool]) {
    loop {
        let mut begins = vec![0u32; mesh.vertices.len()];
        for t in (0..is_sound.len()).filter(|&t| is_sound[t]) {
            for (side, &vertex) in mesh.triangles[t].iter().enumerate() {
                begins[vertex as usize] += u32::from(!is_sound[across(twins, t, side)]);
            }
        }
        let is_pinched =
            |t: &usize| is_sound[*t] && mesh.triangles[*t].iter().any(|&v| begins[v as usize] > 1);
        let pinched: Vec<usize> = (0..is_sound.len()).filter(is_pinched).collect();
        if pinched.is_empty() {
            return;
        }
        forget(is_sound, &pinched);
    }
}

/// The whole surface, then the inner sides and walls of the cells.
struct Cells {
    mesh: TriangleMesh,
    /// The outer triangle that each belongs to.
    owners: Vec<u32>,
}

impl Cells {
    fn of(mesh: &TriangleMesh, partners: &[Option<DVec3>], is_sound: &[bool], twins: &[u32]) -> Cells {
        let behind = mesh.vertices.len() as u32;
        let mut cells = Cells { mesh: mesh.clone(), owners: (0..mesh.triangles.len() as u32).collect() };
        let places = partners.iter().zip(&mesh.vertices).map(|(partner, vertex)| partner.unwrap_or(*vertex));
        cells.mesh.vertices.extend(places);
        for t in (0..is_sound.len()).filter(|&t| is_sound[t]) {
            let [a, b, c] = mesh.triangles[t];
            cells.push(t, [a + behind, c + behind, b + behind]);
            for (side, [a, b]) in [[a, b], [b, c], [c, a]].into_iter().enumerate() {
                if !is_sound[across(twins, t, side)] {
                    cells.push(t, [b, a, a + behind]);
                    cells.push(t, [b, a + behind, b + behind]);
                }
            }
        }
        cells
    }

    fn push(&mut self, owner: usize, triangle: [u32; 3]) {
        self.mesh.triangles.push(triangle);
        self.owners.push(owner as u32);
    }

    /// Whose cells pass through something; the surface itself, the first `outer` triangles, is taken to be sound.
    fn crossed(&self, outer: usize) -> Vec<usize> {
        let all = crossings(&self.mesh).into_iter().map(|crossing| crossing.triangles.map(|t| t as usize));
        let mut crossed: Vec<usize> =
            all.flatten().filter(|&t| t >= outer).map(|t| self.owners[t] as usize).collect();
        crossed.sort_unstable();
        crossed.dedup();
        crossed
    }

    /// Without the triangles of the surface that have no cell, and vertices that nothing needs.
    fn alone(&self, outer: usize, is_sound: &[bool]) -> TriangleMesh {
        let kept = |(t, triangle): (usize, [u32; 3])| (t >= outer || is_sound[t]).then_some(triangle);
        let triangles = self.mesh.triangles.iter().copied().enumerate().filter_map(kept);
        self.mesh.part(&triangles.collect::<Vec<_>>())
    }
}

/// The triangles with a point that is within the depth and the longest partner of one that has no cell.
fn rest(mesh: &TriangleMesh, partners: &[Option<DVec3>], is_sound: &[bool], depth: f64) -> Vec<usize> {
    let without = |t: &usize| !is_sound[*t];
    let missing: Vec<[u32; 3]> = (0..is_sound.len()).filter(without).map(|t| mesh.triangles[t]).collect();
    let Ok(surface) = Surface::unsigned(&mesh.part(&missing)) else { return Vec::new() };
    let lengths =
        partners.iter().zip(&mesh.vertices).filter_map(|(partner, v)| Some(partner.as_ref()?.distance(*v)));
    let reach = (depth + lengths.fold(0.0, f64::max)) * (1.0 + ROUNDING);
    let is_near = |t: &usize| {
        let corners = mesh.corners(*t);
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let radius = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
        !is_sound[*t] || surface.nearest_within(middle, reach + radius).is_some()
    };
    (0..is_sound.len()).into_par_iter().filter(is_near).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Solid;
    use crate::ball::ball_corners;

    fn ball(radius: f64, frequency: usize) -> Solid {
        let corners = ball_corners(frequency).unwrap();
        Solid::hull(&corners.into_iter().map(|v| v * radius).collect::<Vec<_>>()).unwrap()
    }

    /// How many triangles have no cell or are near to such; the cells are one sound solid for each of `shells`.
    #[track_caller]
    fn check(body: &Solid, depth: f64, rest: usize, shells: usize) -> Solid {
        let mesh = body.to_mesh().unwrap();
        let layer = Layer::under(&mesh, depth);
        assert_eq!(layer.rest.len(), rest, "{body:?}");
        assert!(crossings(&layer.cells).is_empty());
        let cells = Solid::from_mesh(&layer.cells).unwrap();
        assert_eq!(cells.components().unwrap().len(), shells, "{body:?}");
        assert!(cells.subtract([body]).unwrap().volume() < 1e-9, "nothing sticks out");
        cells
    }

    #[test]
    fn a_smooth_surface_has_a_layer_all_around() {
        let round = ball(10.0, 12);
        let shell = check(&round, 0.4, 0, 2);
        let within = round.subtract([&shell]).unwrap();
        assert_eq!(within.triangle_count(), round.triangle_count());
        assert!((within.volume() / round.volume() - 0.96f64.powi(3)).abs() < 2e-4, "{within:?}");
        let block = Solid::hull(&[0, 1, 2, 3, 4, 5, 6, 7].map(|k| {
            DVec3::from_array(std::array::from_fn(|axis| if k >> axis & 1 == 0 { 0.0 } else { 3.0 }))
        }));
        let shell = check(&block.unwrap(), 1.0, 0, 2);
        assert!((shell.volume() - 26.0).abs() < 1e-9, "{shell:?}");
    }

    #[test]
    fn where_there_is_no_room_is_left_to_others() {
        let small = ball(0.39, 6);
        check(&small, 0.4, small.triangle_count(), 0);
        // Two balls that meet in a groove: only triangles there are left out.
        let both = Solid::union([&ball(5.0, 9), &ball(4.0, 8).translate(DVec3::X * 7.0).unwrap()]).unwrap();
        let layer = Layer::under(&both.to_mesh().unwrap(), 0.4);
        let near = |t: &usize| {
            both.to_mesh().unwrap().corners(*t).iter().any(|corner| (corner.x - 4.14).abs() < 2.5)
        };
        assert!(!layer.rest.is_empty() && layer.rest.iter().all(near), "{}", layer.rest.len());
        assert!(layer.rest.len() < both.triangle_count() / 2);
        let cells = Solid::from_mesh(&layer.cells).unwrap();
        assert_eq!(cells.components().unwrap().len(), 2);
    }
}
