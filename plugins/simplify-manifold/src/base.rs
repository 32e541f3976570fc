//! What must stay: the flat base with its plane, and the extremes of the box around the body.
//!
//! Triangles wholly at the lowest height are the base. Vertices inside it move in its plane; those on its rim only along the rim;
//! those beside it never into it.

use crate::web::{Ring, Web};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// The base, and which vertices are never moved.
pub struct Base {
    /// Whether a triangle is part of the base.
    triangles: Vec<bool>,
    exists: bool,
    fixed: Vec<bool>,
    low: DVec3,
    high: DVec3,
}

/// How a vertex stands to the base, in the order of who gives way to whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Footing {
    Free,
    Inside,
    Rim,
    /// Where rims meet.
    Knot,
}

/// Where an edge may collapse to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Room {
    Nowhere,
    /// To its end of this number only.
    End(usize),
    /// Anywhere in the plane of the base.
    Plane(f64),
    Anywhere,
}

impl Base {
    /// The base of a body, and its extremes.
    pub fn of(mesh: &TriangleMesh) -> Base {
        let (low, high) = mesh.bounds().unwrap_or_default();
        let lies = |t: &[u32; 3]| t.iter().all(|&v| mesh.vertices[v as usize].z == low.z);
        let triangles: Vec<bool> = mesh.triangles.iter().map(lies).collect();
        let mut fixed = vec![false; mesh.vertices.len()];
        for extreme in extremes(mesh) {
            fixed[extreme] = true;
        }
        Base { exists: triangles.contains(&true), triangles, fixed, low, high }
    }

    /// Where an edge of the surface may collapse to.
    pub fn room(&self, web: &Web, edge: [u32; 2], ring: &Ring) -> Room {
        let footing = edge.map(|v| self.footing(web, v));
        let fixed = edge.map(|v| self.fixed[v as usize]);
        if footing[0].min(footing[1]) >= Footing::Rim && !self.is_rim(web, ring) {
            return Room::Nowhere;
        }
        let by_footing = match footing {
            [Footing::Knot, Footing::Knot] => Room::Nowhere,
            [a, b] if a > b => Room::End(0),
            [a, b] if a < b => Room::End(1),
            [Footing::Free, _] => Room::Anywhere,
            _ => Room::Plane(self.low.z),
        };
        match (by_footing, fixed) {
            (room, [false, false]) => room,
            (_, [true, true]) | (Room::Nowhere, _) => Room::Nowhere,
            (Room::End(end), fixed) => {
                if fixed[end] {
                    Room::End(end)
                } else {
                    Room::Nowhere
                }
            }
            (_, fixed) => Room::End(usize::from(fixed[1])),
        }
    }

    /// The next place within the box; none where it would stand on the base without belonging to it.
    pub fn admit(&self, place: DVec3, room: Room) -> Option<DVec3> {
        let place = place.clamp(self.low, self.high);
        let sinks = room == Room::Anywhere && self.exists && place.z <= self.low.z;
        (!sinks).then_some(place)
    }

    /// The first end of an edge stands for both from now on.
    pub fn merge(&mut self, [keep, lose]: [u32; 2]) {
        self.fixed[keep as usize] |= self.fixed[lose as usize];
    }

    fn footing(&self, web: &Web, vertex: u32) -> Footing {
        let fan = web.fan(vertex);
        let base: Vec<u32> = fan.iter().copied().filter(|&t| self.triangles[t as usize]).collect();
        if base.is_empty() {
            return Footing::Free;
        }
        if base.len() == fan.len() {
            return Footing::Inside;
        }
        let mut others: Vec<u32> =
            base.iter().flat_map(|&t| web.triangles[t as usize]).filter(|&v| v != vertex).collect();
        others.sort_unstable();
        let rims = others.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).count();
        if rims == 2 { Footing::Rim } else { Footing::Knot }
    }

    /// Whether the edge of a ring is a side of the base, and not of its last triangle.
    fn is_rim(&self, web: &Web, ring: &Ring) -> bool {
        let in_base: Vec<u32> = ring.gone.iter().copied().filter(|&t| self.triangles[t as usize]).collect();
        let [own] = in_base[..] else { return false };
        let corners = web.triangles[own as usize];
        let shares_side =
            |t: u32| web.triangles[t as usize].iter().filter(|v| corners.contains(v)).count() == 2;
        ring.kept.iter().any(|&t| self.triangles[t as usize] && shares_side(t))
    }
}

/// For each side of the box a vertex on it: of several the one that is farthest out in the other directions, too.
fn extremes(mesh: &TriangleMesh) -> impl Iterator<Item = usize> + '_ {
    let sides = (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]);
    sides.filter_map(|(axis, sign)| {
        let rank = |v: &DVec3| [sign * v[axis], v[(axis + 1) % 3], v[(axis + 2) % 3]];
        let compare = |a: &DVec3, b: &DVec3| {
            let pairs = rank(a).into_iter().zip(rank(b));
            pairs.map(|(x, y)| x.total_cmp(&y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
        };
        let vertices = mesh.vertices.iter().enumerate();
        vertices.max_by(|(_, a), (_, b)| compare(a, b)).map(|(v, _)| v)
    })
}
