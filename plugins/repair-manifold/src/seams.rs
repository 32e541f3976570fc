//! Seams: rims that almost meet. Near vertices of rims become one, and a side that a rim's vertex lies on is divided there.
//!
//! Only rims are touched, and nothing moves by more than the width asked for.

use crate::edges::Edges;
use crate::weld::is_degenerate;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// What closing the seams did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sewn {
    /// Vertices that became another.
    pub merged: usize,
    /// Sides that were divided.
    pub divided: usize,
    /// Greatest distance a vertex moved, mm.
    pub displacement: f64,
}

/// Closes seams up to a width, mm.
pub fn sew(mesh: &mut TriangleMesh, width: f64) -> Sewn {
    const ROUNDS: usize = 8;
    let mut sewn = Sewn::default();
    for _ in 0..ROUNDS {
        let (merged, displacement) = merge_near(mesh, width);
        let divided = divide_sides(mesh, width);
        sewn.merged += merged;
        sewn.divided += divided;
        sewn.displacement = sewn.displacement.max(displacement);
        if merged + divided == 0 {
            break;
        }
    }
    sewn
}

/// Vertices on rims, and the rims' half-edges.
fn rims(mesh: &TriangleMesh) -> (BTreeSet<u32>, Vec<u32>) {
    let edges = Edges::of(mesh);
    let open = edges.iter().filter(|(_, uses)| uses.len() == 1);
    let (ends, sides): (Vec<[u32; 2]>, Vec<u32>) = open.map(|(ends, uses)| (ends, uses[0].half_edge)).unzip();
    (ends.into_iter().flatten().collect(), sides)
}

/// Merges each vertex of a rim into the nearest earlier one within reach; returns how many, and how far.
fn merge_near(mesh: &mut TriangleMesh, width: f64) -> (usize, f64) {
    let (vertices, _) = rims(mesh);
    let mut kept = Cells::new(width);
    let mut becomes: BTreeMap<u32, u32> = BTreeMap::new();
    let mut displacement: f64 = 0.0;
    for vertex in vertices {
        let place = mesh.vertices[vertex as usize];
        match kept.nearest(place, mesh) {
            Some((distance, other)) if distance <= width => {
                becomes.insert(vertex, other);
                displacement = displacement.max(distance);
            }
            _ => kept.insert(place, vertex),
        }
    }
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = becomes.get(corner).copied().unwrap_or(*corner);
    }
    mesh.triangles.retain(|triangle| !is_degenerate(*triangle));
    (becomes.len(), displacement)
}

/// Divides each side of a rim at the vertices of rims that lie on it; returns how many sides were divided.
fn divide_sides(mesh: &mut TriangleMesh, width: f64) -> usize {
    let (vertices, sides) = rims(mesh);
    let along_x: Vec<(f64, u32)> = {
        let mut sorted: Vec<_> = vertices.iter().map(|&v| (mesh.vertices[v as usize].x, v)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        sorted
    };
    let mut divided = BTreeSet::new();
    for side in sides {
        let (triangle, k) = (side as usize / 3, side as usize % 3);
        let [from, to, tip] = [0, 1, 2].map(|step| mesh.triangles[triangle][(k + step) % 3]);
        // A triangle divided along one side waits for the next round with its others.
        if divided.contains(&triangle) {
            continue;
        }
        let on = vertices_on(mesh, [from, to], &along_x, width);
        if !on.is_empty() && !on.contains(&tip) {
            let stops: Vec<u32> = std::iter::once(from).chain(on).chain([to]).collect();
            let fan: Vec<[u32; 3]> = stops.windows(2).map(|pair| [pair[0], pair[1], tip]).collect();
            mesh.triangles[triangle] = fan[0];
            mesh.triangles.extend(&fan[1..]);
            divided.insert(triangle);
        }
    }
    divided.len()
}

/// Vertices within reach of the inside of a side, in its direction.
fn vertices_on(mesh: &TriangleMesh, [from, to]: [u32; 2], along_x: &[(f64, u32)], width: f64) -> Vec<u32> {
    let (start, end) = (mesh.vertices[from as usize], mesh.vertices[to as usize]);
    let (arm, length) = (end - start).normalize_and_length();
    let first = along_x.partition_point(|(x, _)| *x < start.x.min(end.x) - width);
    let near = along_x[first..].iter().take_while(|(x, _)| *x <= start.x.max(end.x) + width);
    let mut on: Vec<(f64, u32)> = near
        .filter(|(_, v)| *v != from && *v != to)
        .map(|&(_, v)| ((mesh.vertices[v as usize] - start).dot(arm), v))
        .filter(|&(t, v)| {
            let off = mesh.vertices[v as usize].distance(start + t * arm);
            off <= width && t > width && t < length - width
        })
        .collect();
    on.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    on.into_iter().map(|(_, v)| v).collect()
}

/// Vertices by the cell of a grid that they lie in.
struct Cells {
    size: f64,
    cells: BTreeMap<[i64; 3], Vec<u32>>,
}

impl Cells {
    fn new(size: f64) -> Cells {
        Cells { size: size.max(f64::MIN_POSITIVE), cells: BTreeMap::new() }
    }

    fn cell(&self, place: DVec3) -> [i64; 3] {
        (place / self.size).floor().to_array().map(|x| x as i64)
    }

    fn insert(&mut self, place: DVec3, vertex: u32) {
        self.cells.entry(self.cell(place)).or_default().push(vertex);
    }

    /// The nearest vertex in the cells around a place, if there is any.
    fn nearest(&self, place: DVec3, mesh: &TriangleMesh) -> Option<(f64, u32)> {
        let [x, y, z] = self.cell(place);
        let offsets = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
        let cells = offsets.filter_map(|[i, j, k]| {
            let key = [x.saturating_add(i), y.saturating_add(j), z.saturating_add(k)];
            self.cells.get(&key)
        });
        let near = cells.flatten().map(|&v| (mesh.vertices[v as usize].distance(place), v));
        near.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::block;
    use crate::sheets::Sheets;

    /// A box whose lid is moved a little, and whose lid has a vertex in the middle of a side, is closed by seams this wide.
    fn check(gap: f64, width: f64, closed: bool) {
        let mut mesh = block([0.0; 3], [10.0, 10.0, 10.0]);
        mesh.triangles.truncate(10); // without the face z = 10 …
        let first = mesh.vertices.len() as u32;
        let lid = [[0.0, 0.0], [5.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
        mesh.vertices.extend(lid.map(|[x, y]| DVec3::new(x, y + gap, 10.0)));
        mesh.triangles.extend([[0, 1, 4], [1, 3, 4], [1, 2, 3]].map(|t: [u32; 3]| t.map(|v| v + first)));
        let sewn = sew(&mut mesh, width);
        assert_eq!(Sheets::of(&mesh).is_closed(), closed, "{gap} mm, sewn {width} mm wide: {sewn:?}");
        assert!(sewn.displacement <= width);
    }

    #[test]
    fn seams_close_up_to_their_width() {
        check(0.0, 1e-6, true);
        check(0.004, 0.01, true);
        check(0.02, 0.01, false);
    }
}
