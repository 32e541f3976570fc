//! Tangles: places where one shell passes through itself.
//!
//! First the tangle is cut out by a box: within it the surface usually falls apart into strands that only overlap, such as two
//! arms of a loop, and their union is what the shell was meant to enclose. Where it does not, as at a spike that leaves through the
//! opposite wall, the triangles around the crossings are taken away and the hole is closed (after Attene 2010, "A lightweight
//! approach to repairing digitized polygon meshes"). Either way the result is judged anew by exact predicates.

use crate::holes::{close_all, holes};
use crate::sheets::Sheets;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::{Crossing, crossings};
use fibar_solid::{Solid, SolidError};
use glam::DVec3;
use std::collections::BTreeSet;

/// A shell without tangles.
pub struct Untangled {
    /// What it encloses.
    pub solid: Solid,
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
    let mut done = Untangled { solid: Solid::from_mesh(shell)?, parted: 0, cut: 0, displacement: 0.0 };
    let mut mesh = shell.clone();
    let mut left = crossings(&mesh);
    while let Some(tangle) = tangles(&left).into_iter().next() {
        // Each step has to leave less: so this ends.
        let less = |solid: &Solid| Ok::<_, SolidError>(crossings(&solid.to_mesh()?).len() < left.len());
        let parted = part(&done.solid, &tangle)?;
        done.solid = match parted {
            Some(parted) if less(&parted)? => {
                done.parted += 1;
                parted
            }
            _ => match cut_away(&mesh, &left, &tangle)? {
                Some((solid, displacement)) => {
                    done.cut += 1;
                    done.displacement = done.displacement.max(displacement);
                    solid
                }
                None => return Err(Tangled::Crossings(left)),
            },
        };
        mesh = done.solid.to_mesh()?;
        left = crossings(&mesh);
    }
    Ok(done)
}

/// A box around crossings that belong together.
#[derive(Clone, Debug)]
struct Tangle {
    low: DVec3,
    high: DVec3,
}

impl Tangle {
    fn grown(&self, by: f64) -> Tangle {
        let margin = self.low.distance(self.high) * by;
        Tangle { low: self.low - margin, high: self.high + margin }
    }

    fn meets(&self, other: &Tangle) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn block(&self) -> Result<Solid, SolidError> {
        let corner = |k: usize| {
            DVec3::from_array(std::array::from_fn(|axis| [self.low, self.high][k >> axis & 1][axis]))
        };
        Solid::hull(&(0..8).map(corner).collect::<Vec<_>>())
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

/// Parts a tangle into strands, if within some box around it they hang together nowhere.
fn part(solid: &Solid, tangle: &Tangle) -> Result<Option<Solid>, SolidError> {
    for margin in [0.3, 0.05, 1.0] {
        let block = tangle.grown(margin).block()?;
        if block.is_empty() {
            continue;
        }
        let strands = solid.intersect(&block)?.components()?;
        let is_sound = |strand: &Solid| {
            Ok::<bool, SolidError>(strand.volume() > 0.0 && crossings(&strand.to_mesh()?).is_empty())
        };
        let sound: Vec<bool> = strands.iter().map(is_sound).collect::<Result<_, _>>()?;
        if strands.len() > 1 && sound.iter().all(|&sound| sound) {
            let rest = solid.subtract([&block])?;
            return Ok(Some(Solid::union(strands.iter().chain([&rest]))?));
        }
    }
    Ok(None)
}

/// Takes the triangles around the crossings of a tangle away, ever more of them, until the closed hole crosses less; with how far
/// what went lies from the new surface, mm.
fn cut_away(
    mesh: &TriangleMesh,
    left: &[Crossing],
    tangle: &Tangle,
) -> Result<Option<(Solid, f64)>, SolidError> {
    const RINGS: usize = 4;
    let within = tangle.grown(0.01);
    let here = |c: &&Crossing| within.meets(&Tangle { low: c.place, high: c.place });
    let mut away: BTreeSet<u32> = left.iter().filter(here).flat_map(|crossing| crossing.triangles).collect();
    for _ in 0..RINGS {
        if let Some(solid) = close_without(mesh, &away, left.len())? {
            let displacement = distance_of(mesh, &away, &solid)?;
            return Ok(Some((solid, displacement)));
        }
        away = with_neighbours(mesh, &away);
    }
    Ok(None)
}

/// The shell without some triangles, its holes closed; nothing if it would be worse than before.
fn close_without(
    mesh: &TriangleMesh,
    away: &BTreeSet<u32>,
    crossings_before: usize,
) -> Result<Option<Solid>, SolidError> {
    let kept = (0u32..).zip(&mesh.triangles).filter(|(t, _)| !away.contains(t));
    let rest = TriangleMesh {
        vertices: mesh.vertices.clone(),
        triangles: kept.map(|(_, triangle)| *triangle).collect(),
    };
    let sheets = Sheets::of(&rest);
    // What was cut off by the cut is a scrap of the tangle: the largest sheet is the shell.
    let Some(shell) = sheets.shells().into_iter().max_by_key(Vec::len) else { return Ok(None) };
    let triangles = shell.into_iter().map(|t| sheets.mesh.triangles[t as usize]).collect();
    let sheets = Sheets::of(&TriangleMesh { vertices: sheets.mesh.vertices, triangles });
    let mut closed = sheets.mesh.clone();
    close_all(&holes(&sheets), &mut closed);
    let sheets = Sheets::of(&closed);
    let better = sheets.is_closed() && crossings(&sheets.mesh).len() < crossings_before;
    Ok(if better { Some(Solid::from_mesh(&sheets.mesh)?) } else { None })
}

fn with_neighbours(mesh: &TriangleMesh, triangles: &BTreeSet<u32>) -> BTreeSet<u32> {
    let touched: BTreeSet<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    let touches = |(_, triangle): &(u32, &[u32; 3])| triangle.iter().any(|v| touched.contains(v));
    (0u32..).zip(&mesh.triangles).filter(touches).map(|(t, _)| t).collect()
}

/// Greatest distance of the corners of some triangles from a solid's surface, mm.
fn distance_of(mesh: &TriangleMesh, triangles: &BTreeSet<u32>, solid: &Solid) -> Result<f64, SolidError> {
    let surface = solid.to_mesh()?;
    let corners: BTreeSet<u32> = triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
    let places = corners.iter().map(|&v| mesh.vertices[v as usize]);
    Ok(crate::distance::farthest(places, &surface))
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
        let mesh = done.solid.to_mesh().unwrap();
        assert!(crossings(&mesh).is_empty());
        // Where the arms cross they share about 2 × 2 × 1.7 mm.
        let shared = signed_volume(&shell) - done.solid.volume();
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
        assert!(crossings(&done.solid.to_mesh().unwrap()).is_empty());
        assert!((done.solid.volume() - whole).abs() < 0.02 * whole, "{} of {whole}", done.solid.volume());
    }
}
