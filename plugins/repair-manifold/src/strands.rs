//! Strands: parts of a shell that overlap within a box and hang together only outside of it.

use crate::edges::origin;
use crate::heads::Heads;
use crate::tangles::Tangle;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::{Crossing, crossings};
use fibar_geometry::half_edges::{OPEN, next, twins};
use fibar_solid::{Solid, SolidError};
use glam::DVec3;

/// Parts a tangle into strands, if within some box around it they hang together nowhere.
pub fn part(
    mesh: &TriangleMesh,
    tangle: &Tangle,
    found: &[Crossing],
) -> Result<Option<TriangleMesh>, SolidError> {
    let twins = twins(mesh);
    let mut made = None;
    for margin in [0.3, 0.05, 1.0] {
        let around = tangle.grown(margin);
        if !falls_apart(mesh, &twins, &around, found) {
            continue;
        }
        let block = block(&around)?;
        if block.is_empty() {
            continue;
        }
        let solid = match made.take() {
            Some(solid) => solid,
            None => Solid::from_mesh(mesh)?,
        };
        let strands = solid.intersect(&block)?.components()?;
        let is_sound = |strand: &Solid| {
            Ok::<bool, SolidError>(strand.volume() > 0.0 && crossings(&strand.to_mesh()?).is_empty())
        };
        let sound: Vec<bool> = strands.iter().map(is_sound).collect::<Result<_, _>>()?;
        if strands.len() > 1 && sound.iter().all(|&sound| sound) {
            let rest = solid.subtract([&block])?;
            return Ok(Some(Solid::union(strands.iter().chain([&rest]))?.to_mesh()?));
        }
        made = Some(solid);
    }
    Ok(None)
}

fn block(around: &Tangle) -> Result<Solid, SolidError> {
    let corner = |k: usize| {
        DVec3::from_array(std::array::from_fn(|axis| [around.low, around.high][k >> axis & 1][axis]))
    };
    Solid::hull(&(0..8).map(corner).collect::<Vec<_>>())
}

/// Whether what crosses within a box belongs to pieces of the surface that hang together nowhere in it. Only then is it worth cutting.
fn falls_apart(mesh: &TriangleMesh, twins: &[u32], around: &Tangle, found: &[Crossing]) -> bool {
    let place = |half_edge: u32| mesh.vertices[origin(mesh, half_edge) as usize];
    let near = (0..mesh.triangles.len() as u32).filter(|&t| {
        let [a, b, c] = mesh.corners(t as usize);
        around.meets(&Tangle { low: a.min(b).min(c), high: a.max(b).max(c) })
    });
    let mut heads = Heads::new(mesh.triangles.len());
    for half_edge in near.flat_map(|t| 3 * t..3 * t + 3) {
        let twin = twins[half_edge as usize];
        if twin != OPEN && enters([place(half_edge), place(next(half_edge))], around) {
            heads.join(half_edge / 3, twin / 3);
        }
    }
    let mut here = found.iter().filter(|c| around.meets(&Tangle { low: c.place, high: c.place }));
    here.all(|crossing| heads.of(crossing.triangles[0]) != heads.of(crossing.triangles[1]))
}

/// Whether a piece of a line is in a box somewhere.
fn enters([from, to]: [DVec3; 2], around: &Tangle) -> bool {
    let way = to - from;
    let (mut first, mut last) = (0.0f64, 1.0f64);
    for axis in 0..3 {
        let [low, high] = [around.low[axis] - from[axis], around.high[axis] - from[axis]];
        if way[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (near, far) = (low / way[axis], high / way[axis]);
        first = first.max(near.min(far));
        last = last.min(near.max(far));
    }
    first <= last
}
