//! Reliefs: sheets that are seen whole from one side, as range images are, stood on a flat back.
//!
//! What such a sheet encloses it does not say, and a cap over its outline passes through it wherever it bends away. Walls down from
//! the outline to a plane behind the sheet, and what the outline surrounds in that plane, never do. Holes within the outline are closed
//! by what they are seen to be.

use crate::cap::cap;
use crate::drawing::{Plane, fill};
use crate::holes::{Hole, close_all};
use crate::sheets::Sheets;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::places::first_at_place;
use fibar_geometry::half_edges::OPEN;
use glam::{DVec2, DVec3};

/// Sheets on their backs.
pub struct Relief {
    /// Closed; the triangles of the sheets come first, in their order.
    pub mesh: TriangleMesh,
    /// Outlines that got walls and a back.
    pub backs: usize,
    /// Holes within outlines that were closed.
    pub caps: usize,
}

/// A sheet is a relief if no more than this share of its area faces away.
const AWAY: f64 = 0.02;
/// The vector area of sheets that stand on backs is at least this share of their area.
const ONE_SIDED: f64 = 0.3;
/// A back lies behind the farthest point of its sheet by this share of the sheet's box.
const BEHIND: f64 = 0.02;

/// Stands sheets on flat backs and closes the holes of all others: all that are open if one view shows them all, else those that these
/// triangles belong to and that some view shows. Nothing if there are none, or an outline crosses itself.
pub fn stand(sheets: &Sheets, holes: &[Hole], crossed: &[u32]) -> Option<Relief> {
    let pieces = Pieces::of(sheets);
    let planes = pieces.planes(&sheets.mesh, crossed)?;
    let lowest = pieces.lowest(&sheets.mesh, &planes);
    let piece = |hole: &Hole| pieces.of_vertex[hole.rim[0] as usize] as usize;
    let (standing, others): (Vec<&Hole>, Vec<&Hole>) =
        holes.iter().partition(|hole| planes[piece(hole)].is_some());
    let mut relief = Relief { mesh: sheets.mesh.clone(), backs: 0, caps: others.len() };
    close_all(&others.into_iter().cloned().collect::<Vec<_>>(), &mut relief.mesh);
    for hole in standing {
        let Some(plane) = planes[piece(hole)] else { continue };
        for ring in rings(hole, &mut relief.mesh) {
            let drawn: Vec<DVec2> =
                ring.iter().map(|&v| plane.draw(relief.mesh.vertices[v as usize]).0).collect();
            if signed_area(&drawn) < 0.0 {
                relief.add_back(&ring, drawn, &plane, lowest[piece(hole)])?;
            } else {
                relief.close(&ring, drawn);
            }
        }
    }
    Some(relief)
}

impl Relief {
    /// Walls down from an outline, and its back.
    fn add_back(&mut self, ring: &[u32], drawn: Vec<DVec2>, plane: &Plane, height: f64) -> Option<()> {
        let first = self.mesh.vertices.len() as u32;
        let count = ring.len();
        self.mesh.vertices.extend(drawn.iter().map(|&at| plane.lift(at, height)));
        for k in 0..count {
            let next = (k + 1) % count;
            let [under, beside] = [k, next].map(|k| first + k as u32);
            self.mesh.triangles.extend([[ring[k], ring[next], beside], [ring[k], beside, under]]);
        }
        let back = fill(&[drawn], &[])?;
        self.mesh.triangles.extend(back.into_iter().map(|[a, b, c]| [a, c, b].map(|k| first + k as u32)));
        self.backs += 1;
        Some(())
    }

    /// Closes a hole by what it is seen to be, or else by the cap of least area.
    fn close(&mut self, ring: &[u32], drawn: Vec<DVec2>) {
        let places = || ring.iter().map(|&v| self.mesh.vertices[v as usize]).collect::<Vec<DVec3>>();
        let triangles = fill(&[drawn], &[]).unwrap_or_else(|| cap(&places()));
        self.mesh.triangles.extend(triangles.into_iter().map(|t| t.map(|k| ring[k])));
        self.caps += 1;
    }
}

/// Parts of the surface that hang together.
struct Pieces {
    of_triangle: Vec<u32>,
    of_vertex: Vec<u32>,
    is_open: Vec<bool>,
}

impl Pieces {
    fn of(sheets: &Sheets) -> Pieces {
        let shells = sheets.shells();
        let mut of_triangle = vec![0; sheets.mesh.triangles.len()];
        let mut of_vertex = vec![0; sheets.mesh.vertices.len()];
        let mut is_open = vec![false; shells.len()];
        for (number, &t) in (0..).zip(&shells).flat_map(|(n, shell)| shell.iter().map(move |t| (n, t))) {
            let twins = &sheets.twins[3 * t as usize..3 * t as usize + 3];
            is_open[number as usize] |= twins.contains(&OPEN);
            of_triangle[t as usize] = number;
            sheets.mesh.triangles[t as usize].iter().for_each(|&v| of_vertex[v as usize] = number);
        }
        Pieces { of_triangle, of_vertex, is_open }
    }

    /// The planes that pieces are drawn in; nothing if none is.
    fn planes(&self, mesh: &TriangleMesh, crossed: &[u32]) -> Option<Vec<Option<Plane>>> {
        let origin = mesh.bounds()?.0;
        let count = self.is_open.len();
        let all: Vec<usize> = (0..count).filter(|&piece| self.is_open[piece]).collect();
        if let Some(way) = self.view(mesh, &all) {
            let plane = |piece: usize| self.is_open[piece].then(|| Plane::across(origin, way));
            return Some((0..count).map(plane).collect());
        }
        let mut planes = vec![None; count];
        for piece in crossed.iter().map(|&t| self.of_triangle[t as usize] as usize) {
            planes[piece] = self.view(mesh, &[piece]).map(|way| Plane::across(origin, way));
        }
        planes.iter().any(Option::is_some).then_some(planes)
    }

    /// Where the back of each piece lies, mm.
    fn lowest(&self, mesh: &TriangleMesh, planes: &[Option<Plane>]) -> Vec<f64> {
        let mut lowest = vec![f64::INFINITY; self.is_open.len()];
        let mut boxes = vec![[DVec3::INFINITY, DVec3::NEG_INFINITY]; self.is_open.len()];
        for (&place, &piece) in mesh.vertices.iter().zip(&self.of_vertex) {
            let piece = piece as usize;
            if let Some(plane) = &planes[piece] {
                lowest[piece] = lowest[piece].min(plane.draw(place).1);
            }
            let [low, high] = &mut boxes[piece];
            (*low, *high) = (low.min(place), high.max(place));
        }
        lowest
            .into_iter()
            .zip(boxes)
            .map(|(lowest, [low, high])| lowest - BEHIND * low.distance(high))
            .collect()
    }

    /// The direction to look against: the least area of some pieces faces away from it, and of each hardly any.
    fn view(&self, mesh: &TriangleMesh, some: &[usize]) -> Option<DVec3> {
        let mut is_asked = vec![false; self.is_open.len()];
        some.iter().for_each(|&piece| is_asked[piece] = true);
        let normal = |t: usize| {
            let [a, b, c] = mesh.corners(t);
            (self.of_triangle[t], (b - a).cross(c - a))
        };
        let asked = (0..mesh.triangles.len()).filter(|&t| is_asked[self.of_triangle[t] as usize]);
        let normals: Vec<(u32, DVec3)> = asked.map(normal).collect();
        let mean: DVec3 = normals.iter().map(|(_, normal)| normal).sum();
        // What is seen from one side has no other.
        if mean.length() < ONE_SIDED * normals.iter().map(|(_, normal)| normal.length()).sum::<f64>() {
            return None;
        }
        let along = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * mean.dot(axis).signum());
        let middle = middle_of(normals.iter().filter_map(|(_, normal)| normal.try_normalize()).collect());
        let ways = [along[0], along[1], along[2], mean, middle].into_iter().filter_map(DVec3::try_normalize);
        let judged = ways.filter_map(|way| Some((self.facing_away(&normals, way)?, way)));
        judged.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, way)| way)
    }

    /// The area that faces away from a direction, mm², if that is a small share of each piece's.
    fn facing_away(&self, normals: &[(u32, DVec3)], toward: DVec3) -> Option<f64> {
        let mut areas = vec![[0.0; 2]; self.is_open.len()];
        for &(piece, normal) in normals {
            let [all, away] = &mut areas[piece as usize];
            *all += normal.length();
            *away += if normal.dot(toward) > 0.0 { 0.0 } else { normal.length() };
        }
        let is_relief = areas.iter().all(|[all, away]| *away <= AWAY * all);
        is_relief.then(|| areas.iter().map(|[_, away]| away).sum())
    }
}

/// The middle of the smallest ball around some unit vectors (Bădoiu & Clarkson 2003): the direction farthest from facing any away.
fn middle_of(ways: Vec<DVec3>) -> DVec3 {
    const ROUNDS: u32 = 100;
    let mut middle = ways.iter().sum::<DVec3>() / ways.len().max(1) as f64;
    for round in 0..ROUNDS {
        let farthest = ways.iter().min_by(|a, b| a.dot(middle).total_cmp(&b.dot(middle)));
        middle += farthest.map_or(DVec3::ZERO, |way| (*way - middle) / f64::from(round + 2));
    }
    middle
}

/// A hole's rim in rings that do not touch themselves: where it comes to a place twice its two vertices become one.
fn rings(hole: &Hole, mesh: &mut TriangleMesh) -> Vec<Vec<u32>> {
    let places: Vec<DVec3> = hole.rim.iter().map(|&v| mesh.vertices[v as usize]).collect();
    let first = first_at_place(&places);
    let (mut rings, mut open): (Vec<Vec<u32>>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut becomes = Vec::new();
    for (k, &same) in first.iter().enumerate() {
        if same as usize != k {
            becomes.push((hole.rim[k], hole.rim[same as usize]));
            if let Some(at) = open.iter().position(|&earlier| first[earlier] == same) {
                rings.push(open.drain(at..).map(|k| hole.rim[first[k] as usize]).collect());
            }
        }
        open.push(k);
    }
    rings.push(open.into_iter().map(|k| hole.rim[first[k] as usize]).collect());
    becomes.sort_unstable();
    let renamed = |v: u32| becomes.binary_search_by_key(&v, |pair| pair.0).map_or(v, |k| becomes[k].1);
    if !becomes.is_empty() {
        mesh.triangles.iter_mut().flatten().for_each(|v| *v = renamed(*v));
    }
    rings.retain(|ring| ring.len() > 2);
    rings
}

fn signed_area(ring: &[DVec2]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closing::{Limits, close};
    use crate::fate::Fate;
    use crate::volume::signed_volume;
    use fibar_geometry::crossings::crossings;
    use glam::DMat3;

    const CELLS: u32 = 24;

    /// A sheet of unit cells over a square, in waves, without some triangles.
    fn waves(missing: &[usize]) -> TriangleMesh {
        let row = CELLS + 1;
        let height = |x: f64, y: f64| 4.0 * libm::sin(0.6 * x) + 3.0 * libm::cos(0.5 * y);
        let place = |v: u32| {
            let (x, y) = (f64::from(v % row), f64::from(v / row));
            DVec3::new(x, y, height(x, y))
        };
        let cells = (0..CELLS * CELLS).map(|c| c % CELLS + c / CELLS * row);
        let all = cells.flat_map(|v| [[v, v + 1, v + row + 1], [v, v + row + 1, v + row]]);
        let kept = all.enumerate().filter(|(t, _)| !missing.contains(t)).map(|(_, triangle)| triangle);
        TriangleMesh { vertices: (0..row * row).map(place).collect(), triangles: kept.collect() }
    }

    /// Waves without some triangles, turned, get a back and this many caps; they fill what whole ones fill.
    fn check(missing: &[usize], turn: DMat3, caps: usize) {
        let whole = waves(&[]);
        let (low, high) = whole.bounds().unwrap();
        let behind = low.z - BEHIND * low.distance(high);
        let over = |t: usize| {
            let [a, b, c] = whole.corners(t);
            (b - a).cross(c - a).z / 2.0 * ((a.z + b.z + c.z) / 3.0 - behind)
        };
        let expected: f64 = (0..whole.triangles.len()).map(over).sum();
        let mut mesh = waves(missing);
        mesh.vertices.iter_mut().for_each(|v| *v = turn * *v);
        let mut fate = Fate::default();
        let solid =
            close(&mesh, Limits { seam_mm: 0.005, largest_hole_mm: 1e4 }, &mut fate).expect("it stands");
        assert_eq!([fate.backs_added, fate.holes_closed, fate.tangles_cut], [1, caps, 0], "{missing:?}");
        assert!(Sheets::of(&solid).is_closed() && crossings(&solid).is_empty());
        let off = signed_volume(&solid) / expected - 1.0;
        assert!(off.abs() < 1e-9, "{off}");
    }

    #[test]
    fn waves_stand_on_a_back() {
        check(&[], DMat3::IDENTITY, 0);
        check(&[600, 601], DMat3::IDENTITY, 1);
        check(&[], DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2), 0);
        // A hole that touches the outline in one vertex.
        check(&[480], DMat3::IDENTITY, 1);
    }
}
