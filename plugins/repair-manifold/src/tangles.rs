//! Tangles: places where one shell passes through itself.
//!
//! First a tangle is cut out by a box: within it the surface may fall apart into strands that only overlap, such as two
//! arms of a loop, and their union is what the shell was meant to enclose ([`strands`](crate::strands)). Where none does, as at a spike
//! that leaves through the opposite wall, the triangles around all crossings are taken away and the holes are closed
//! ([`scuffs`](crate::scuffs)), or, if that leaves no less, around one tangle after the other. Either way the result is judged anew.

use crate::distance::farthest;
use crate::holes::{close_all, holes};
use crate::scuffs;
use crate::sheets::Sheets;
use crate::strands::part;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::{Crossing, crossings};
use fibar_solid::SolidError;
use glam::DVec3;
use std::collections::BTreeSet;

/// A shell without tangles.
pub struct Untangled {
    /// Closed.
    pub mesh: TriangleMesh,
    /// Tangles taken apart into strands.
    pub parted: usize,
    /// Tangles cut away.
    pub cut: usize,
    /// Greatest distance of a vertex that was cut away from the new surface, mm.
    pub displacement: f64,
}

/// Why a shell stayed tangled.
pub enum Tangled {
    /// These crossings remain.
    Crossings(Vec<Crossing>),
    /// A boolean failed.
    Solid(SolidError),
}

impl From<SolidError> for Tangled {
    fn from(error: SolidError) -> Tangled {
        Tangled::Solid(error)
    }
}

/// Untangles a closed shell.
pub fn untangle(shell: &TriangleMesh) -> Result<Untangled, Tangled> {
    let mut done = Untangled { mesh: shell.clone(), parted: 0, cut: 0, displacement: 0.0 };
    let mut left = crossings(&done.mesh);
    while !left.is_empty() {
        // Each step leaves less: so this ends.
        left = match done.part_one(&left)? {
            Some(less) => less,
            None => match done.cut_all(&left).or_else(|| done.cut_one(&left)) {
                Some(less) => less,
                None => return Err(Tangled::Crossings(left)),
            },
        };
    }
    Ok(done)
}

impl Untangled {
    /// Parts the first tangle that falls apart; gives what still crosses.
    fn part_one(&mut self, left: &[Crossing]) -> Result<Option<Vec<Crossing>>, SolidError> {
        for tangle in tangles(left) {
            let Some(mesh) = part(&self.mesh, &tangle, left)? else { continue };
            let less = crossings(&mesh);
            if less.len() < left.len() {
                self.parted += 1;
                self.mesh = mesh;
                return Ok(Some(less));
            }
        }
        Ok(None)
    }

    /// Cuts all out at once.
    fn cut_all(&mut self, left: &[Crossing]) -> Option<Vec<Crossing>> {
        let smoothed = scuffs::smooth(&self.mesh, left, f64::INFINITY)?;
        let less = crossings(&smoothed.mesh);
        (less.len() < left.len()).then(|| {
            self.note_cut(smoothed.mesh, smoothed.cut, smoothed.displacement);
            less
        })
    }

    /// Cuts away the first tangle that can be, ever more triangles around its crossings, until the closed hole crosses less.
    fn cut_one(&mut self, left: &[Crossing]) -> Option<Vec<Crossing>> {
        const RINGS: usize = 4;
        for tangle in tangles(left) {
            let within = tangle.grown(0.01);
            let here = |c: &&Crossing| within.meets(&Tangle { low: c.place, high: c.place });
            let mut away: BTreeSet<u32> =
                left.iter().filter(here).flat_map(|crossing| crossing.triangles).collect();
            for _ in 0..RINGS {
                if let Some((mesh, less)) = close_without(&self.mesh, &away, left.len()) {
                    let displacement = distance_of(&self.mesh, &away, &mesh);
                    self.note_cut(mesh, 1, displacement);
                    return Some(less);
                }
                away = with_neighbours(&self.mesh, &away);
            }
        }
        None
    }

    fn note_cut(&mut self, mesh: TriangleMesh, cut: usize, displacement: f64) {
        self.mesh = mesh;
        self.cut += cut;
        self.displacement = self.displacement.max(displacement);
    }
}

/// A box around crossings that belong together.
#[derive(Clone, Debug)]
pub struct Tangle {
    /// Its lowest corner, mm.
    pub low: DVec3,
    /// Its highest corner, mm.
    pub high: DVec3,
}

impl Tangle {
    /// The box with a margin of this share of its diagonal.
    pub fn grown(&self, by: f64) -> Tangle {
        let margin = self.low.distance(self.high) * by;
        Tangle { low: self.low - margin, high: self.high + margin }
    }

    /// Whether two have a point in common.
    pub fn meets(&self, other: &Tangle) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// Boxes around crossings whose triangles are the same or whose boxes meet.
fn tangles(crossings: &[Crossing]) -> Vec<Tangle> {
    let mut tangles: Vec<(BTreeSet<u32>, Tangle)> = Vec::new();
    for crossing in crossings {
        let mut triangles = BTreeSet::from(crossing.triangles);
        let mut around = Tangle { low: crossing.place, high: crossing.place };
        let is_same = |(known, tangle): &(BTreeSet<u32>, Tangle)| {
            crossing.triangles.iter().any(|t| known.contains(t)) || tangle.grown(0.1).meets(&around)
        };
        let (same, apart): (Vec<_>, Vec<_>) = tangles.into_iter().partition(is_same);
        tangles = apart;
        for (known, tangle) in same {
            triangles.extend(known);
            around = Tangle { low: around.low.min(tangle.low), high: around.high.max(tangle.high) };
        }
        tangles.push((triangles, around));
    }
    tangles.into_iter().map(|(_, tangle)| tangle).collect()
}

/// The shell without some triangles, its holes closed, and what crosses then; nothing if it would be worse than before.
fn close_without(
    mesh: &TriangleMesh,
    away: &BTreeSet<u32>,
    crossings_before: usize,
) -> Option<(TriangleMesh, Vec<Crossing>)> {
    let kept = (0u32..).zip(&mesh.triangles).filter(|(t, _)| !away.contains(t));
    let rest = TriangleMesh {
        vertices: mesh.vertices.clone(),
        triangles: kept.map(|(_, triangle)| *triangle).collect(),
    };
    let sheets = Sheets::of(&rest);
    // What was cut off by the cut is a scrap of the tangle: the largest sheet is the shell.
    let shell = sheets.shells().into_iter().max_by_key(Vec::len)?;
    let triangles = shell.into_iter().map(|t| sheets.mesh.triangles[t as usize]).collect();
    let sheets = Sheets::of(&TriangleMesh { vertices: sheets.mesh.vertices, triangles });
    let mut closed = sheets.mesh.clone();
    close_all(&holes(&sheets), &mut closed);
    let sheets = Sheets::of(&closed);
    let left = sheets.is_closed().then(|| crossings(&sheets.mesh))?;
    (left.len() < crossings_before).then_some((sheets.mesh, left))
}

fn with_neighbours(mesh: &TriangleMesh, triangles: &BTreeSet<u32>) -> BTreeSet<u32> {
    let touched: BTreeSet<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    let touches = |(_, triangle): &(u32, &[u32; 3])| triangle.iter().any(|v| touched.contains(v));
    (0u32..).zip(&mesh.triangles).filter(touches).map(|(t, _)| t).collect()
}

/// Greatest distance of the corners of some triangles from another surface, mm.
fn distance_of(mesh: &TriangleMesh, triangles: &BTreeSet<u32>, surface: &TriangleMesh) -> f64 {
    let corners: BTreeSet<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    farthest(corners.iter().map(|&v| mesh.vertices[v as usize]), surface)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::ball;
    use crate::volume::signed_volume;

    /// A square tube of side 2 along a path of corners, open sides capped.
    fn tube(path: &[[f64; 3]]) -> TriangleMesh {
        let mut mesh = TriangleMesh::default();
        for (k, &[x, y, z]) in path.iter().enumerate() {
            let before = DVec3::from(path[k.saturating_sub(1)]);
            let after = DVec3::from(path[(k + 1).min(path.len() - 1)]);
            let along = (after - before).with_z(0.0).normalize();
            let (side, up) = (DVec3::Z.cross(along), DVec3::Z);
            let place = DVec3::new(x, y, z);
            mesh.vertices.extend([
                place - side - up,
                place + side - up,
                place + side + up,
                place - side + up,
            ]);
        }
        let ring = |k: usize, c: usize| (4 * k + c % 4) as u32;
        for (k, c) in (0..path.len() - 1).flat_map(|k| (0..4).map(move |c| (k, c))) {
            let [a, b, d, e] = [ring(k, c), ring(k, c + 1), ring(k + 1, c + 1), ring(k + 1, c)];
            mesh.triangles.extend([[a, b, d], [a, d, e]]);
        }
        let last = path.len() - 1;
        mesh.triangles.extend([[0, 3, 2], [0, 2, 1]].map(|t: [usize; 3]| t.map(|c| ring(0, c))));
        mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [usize; 3]| t.map(|c| ring(last, c))));
        mesh
    }

    #[test]
    fn a_loop_through_itself_is_the_union_of_its_arms() {
        let path = [
            [-10.0, 0.0, 0.0],
            [10.0, 0.0, 0.1],
            [20.0, 0.0, 0.2],
            [20.0, 20.0, 0.3],
            [0.0, 20.0, 0.4],
            [0.1, 10.0, 0.3],
            [0.2, -10.0, 0.5],
        ];
        let shell = tube(&path);
        assert!(signed_volume(&shell) > 0.0);
        let before = crossings(&shell).len();
        assert!(before > 0);
        let done = untangle(&shell).ok().expect("strands come apart");
        assert_eq!((done.parted, done.cut), (1, 0));
        assert!(crossings(&done.mesh).is_empty());
        // Where the arms cross they share about 2 × 2 × 1.7 mm.
        let shared = signed_volume(&shell) - signed_volume(&done.mesh);
        assert!((5.0..8.1).contains(&shared), "{shared} mm³");
    }

    #[test]
    fn a_spike_through_the_far_wall_is_cut_away() {
        let mut shell = ball(10.0, 12);
        let top =
            (0..shell.vertices.len()).max_by(|&a, &b| shell.vertices[a].z.total_cmp(&shell.vertices[b].z));
        let whole = signed_volume(&shell);
        shell.vertices[top.unwrap()] = DVec3::new(0.3, 0.2, -14.0);
        assert!(!crossings(&shell).is_empty());
        let done = untangle(&shell).ok().expect("the spike goes");
        assert!(crossings(&done.mesh).is_empty());
        assert!(
            (signed_volume(&done.mesh) - whole).abs() < 0.02 * whole,
            "{} of {whole}",
            signed_volume(&done.mesh)
        );
    }
}
