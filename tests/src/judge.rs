//! What a mesh is, whoever made it: closed or not, its bodies, cavities, handles and volume, and where it passes through itself.
//!
//! Shares nothing with the stages that make or mend meshes.

use crate::broken::{Shape, Truth};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_ruler::bvh::Bvh;
use glam::DVec3;
use std::collections::BTreeMap;

/// A mesh passes through itself only where it does so deeper than this, mm: less is the rounding of files.
pub const DEPTH: f64 = 1e-4;

/// What a mesh is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// Whether every side has as many triangles in one direction as in the other.
    pub is_closed: bool,
    /// Whether every side has just one of each, and every vertex one fan of triangles.
    pub is_manifold: bool,
    /// Its shells and handles.
    pub shape: Shape,
    /// Volume, mm³.
    pub volume: f64,
    /// Pairs of triangles that pass through each other.
    pub crossings: usize,
}

impl Judgement {
    /// Judges a mesh.
    pub fn of(mesh: &TriangleMesh) -> Judgement {
        let sides = sides(mesh);
        let twins = twins(mesh, &sides);
        let fans = fans(mesh, &twins);
        let shells = shells(mesh, &twins);
        let volumes: Vec<f64> = shells.iter().map(|shell| volume(mesh, shell)).collect();
        let euler = fans as i64 - (3 * mesh.triangles.len() / 2) as i64 + mesh.triangles.len() as i64;
        let genus = Some(shells.len() as i64 - euler / 2);
        let bodies = volumes.iter().filter(|volume| **volume > 0.0).count();
        Judgement {
            is_closed: !mesh.triangles.is_empty()
                && sides
                    .iter()
                    .all(|(&[a, b], along)| sides.get(&[b, a]).is_some_and(|back| back.len() == along.len())),
            is_manifold: twins.iter().all(Option::is_some) && fans == used_vertices(mesh),
            shape: Shape { bodies, cavities: shells.len() - bodies, genus },
            volume: volumes.iter().sum(),
            crossings: crossings(mesh).len(),
        }
    }
}

/// Volumes may be off by this share.
const VOLUME: f64 = 0.005;

impl Judgement {
    /// Why this is no solid, if it is none.
    pub fn is_wrong(&self) -> Option<String> {
        if !self.is_closed {
            return Some("not closed".into());
        }
        if self.volume <= 0.0 {
            return Some("inside out".into());
        }
        (self.crossings > 0).then(|| format!("passes through itself {} times", self.crossings))
    }

    /// In what this is not what it should be: no solid, or its volume, bodies, cavities, handles.
    pub fn differs_from(&self, truth: &Truth) -> Option<String> {
        let off = self.volume / truth.volume - 1.0;
        let counts = |shape: &Shape| [(shape.bodies, "bodies"), (shape.cavities, "cavities")];
        let differing = || {
            let pairs = counts(&self.shape).into_iter().zip(counts(&truth.shape));
            let mut differing = pairs.filter(|(is, should)| is.0 != should.0);
            differing.next().map(|(is, should)| format!("{} {}, not {}", is.0, is.1, should.0))
        };
        let genus = || {
            let should = truth.shape.genus.filter(|genus| Some(*genus) != self.shape.genus)?;
            Some(format!("{} handles, not {should}", self.shape.genus.unwrap_or_default()))
        };
        let volume = || (off.abs() > VOLUME).then(|| format!("volume {:+.1} %", 100.0 * off));
        self.is_wrong().or_else(volume).or_else(differing).or_else(genus)
    }
}

/// A mesh moved to where another is: `repair-manifold` puts its own on the table, in the middle.
pub fn placed(mut mesh: TriangleMesh, reference: &TriangleMesh) -> TriangleMesh {
    let middle = |(low, high): (DVec3, DVec3)| ((low + high) / 2.0).with_z(low.z);
    if let (Some(here), Some(there)) = (mesh.bounds(), reference.bounds()) {
        let by = middle(there) - middle(here);
        mesh.vertices.iter_mut().for_each(|v| *v += by);
    }
    mesh
}

/// Half-edges, 3 · triangle + corner, by their ends.
fn sides(mesh: &TriangleMesh) -> BTreeMap<[u32; 2], Vec<u32>> {
    let mut sides: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for (t, [a, b, c]) in (0u32..).zip(&mesh.triangles) {
        for (k, ends) in (0..).zip([[*a, *b], [*b, *c], [*c, *a]]) {
            sides.entry(ends).or_default().push(3 * t + k);
        }
    }
    sides
}

/// For each half-edge the one that runs back along it, where there is just one.
fn twins(mesh: &TriangleMesh, sides: &BTreeMap<[u32; 2], Vec<u32>>) -> Vec<Option<u32>> {
    let mut twins = vec![None; 3 * mesh.triangles.len()];
    for (&[a, b], along) in sides {
        if let ([one], Some([other])) = (along.as_slice(), sides.get(&[b, a]).map(Vec::as_slice)) {
            twins[*one as usize] = Some(*other);
        }
    }
    twins
}

/// How many fans of triangles, each around a vertex, there are.
fn fans(mesh: &TriangleMesh, twins: &[Option<u32>]) -> usize {
    let corners = 3 * mesh.triangles.len();
    let mut groups = Groups::new(corners);
    for (one, other) in (0u32..).zip(twins).filter_map(|(one, twin)| twin.map(|other| (one, other))) {
        // The start of a half-edge is the end of its twin.
        groups.join(one as usize, after(other) as usize);
    }
    groups.count()
}

fn after(half_edge: u32) -> u32 {
    half_edge / 3 * 3 + (half_edge + 1) % 3
}

fn used_vertices(mesh: &TriangleMesh) -> usize {
    let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    used.len()
}

/// Triangles that hang together over sides, in the order of their first ones.
fn shells(mesh: &TriangleMesh, twins: &[Option<u32>]) -> Vec<Vec<u32>> {
    let mut groups = Groups::new(mesh.triangles.len());
    for (one, other) in (0u32..).zip(twins).filter_map(|(one, twin)| twin.map(|other| (one, other))) {
        groups.join(one as usize / 3, other as usize / 3);
    }
    let mut shells: BTreeMap<usize, Vec<u32>> = BTreeMap::new();
    (0..mesh.triangles.len()).for_each(|t| shells.entry(groups.of(t)).or_default().push(t as u32));
    shells.into_values().collect()
}

fn volume(mesh: &TriangleMesh, shell: &[u32]) -> f64 {
    let origin = mesh.vertices.first().copied().unwrap_or_default();
    let part = |&t: &u32| {
        let [a, b, c] = mesh.corners(t as usize).map(|corner| corner - origin);
        a.dot(b.cross(c)) / 6.0
    };
    shell.iter().map(part).sum()
}

/// Things that belong together (Tarjan 1975).
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Groups {
        Groups((0..count).collect())
    }

    fn of(&mut self, mut thing: usize) -> usize {
        while self.0[thing] != thing {
            self.0[thing] = self.0[self.0[thing]];
            thing = self.0[thing];
        }
        thing
    }

    fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.of(one), self.of(other));
        self.0[one.max(other)] = one.min(other);
    }

    fn count(&mut self) -> usize {
        (0..self.0.len()).filter(|&thing| self.of(thing) == thing).count()
    }
}

/// Pairs of triangles of which a side of one passes through the other, both of its ends and the place deeper than [`DEPTH`].
pub fn crossings(mesh: &TriangleMesh) -> Vec<[u32; 2]> {
    let grid = Grid::of(mesh);
    let mut near: Vec<[u32; 2]> = grid.pairs().filter(|pair| boxes_meet(mesh, *pair)).collect();
    near.sort_unstable();
    near.dedup();
    near.retain(|&[a, b]| passes(mesh, a, b) || passes(mesh, b, a));
    near
}

fn ends(corners: &[DVec3; 3]) -> [DVec3; 2] {
    [corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2])]
}

fn boxes_meet(mesh: &TriangleMesh, pair: [u32; 2]) -> bool {
    let [one, other] = pair.map(|t| ends(&mesh.corners(t as usize)));
    one[0].cmple(other[1]).all() && other[0].cmple(one[1]).all()
}

/// Whether a side of one triangle passes through another.
fn passes(mesh: &TriangleMesh, one: u32, other: u32) -> bool {
    let [a, b, c] = mesh.corners(one as usize);
    let [p, q, r] = mesh.corners(other as usize);
    let normal = (q - p).cross(r - p).normalize_or_zero();
    [[a, b], [b, c], [c, a]].into_iter().any(|[from, to]| {
        let (above, below) = ((from - p).dot(normal), (to - p).dot(normal));
        if above.abs() <= DEPTH || below.abs() <= DEPTH || (above > 0.0) == (below > 0.0) {
            return false;
        }
        let place = from + (to - from) * (above / (above - below));
        let within =
            |from: DVec3, to: DVec3| normal.cross(to - from).normalize_or_zero().dot(place - from) > DEPTH;
        within(p, q) && within(q, r) && within(r, p)
    })
}

/// Triangles by the cells of a grid that their boxes touch.
struct Grid {
    cells: Vec<([i32; 3], u32)>,
}

impl Grid {
    fn of(mesh: &TriangleMesh) -> Grid {
        let boxes: Vec<[DVec3; 2]> = (0..mesh.triangles.len()).map(|t| ends(&mesh.corners(t))).collect();
        let (low, high) = mesh.bounds().unwrap_or_default();
        let mean =
            boxes.iter().map(|[low, high]| low.distance(*high)).sum::<f64>() / boxes.len().max(1) as f64;
        let size = mean.max((high - low).max_element() / 200.0).max(1e-9);
        let cell = |v: DVec3| ((v - low) / size).floor().as_ivec3();
        let mut cells = Vec::new();
        for (t, [from, to]) in (0u32..).zip(&boxes) {
            let (from, to) = (cell(*from), cell(*to));
            for x in from.x..=to.x {
                for y in from.y..=to.y {
                    cells.extend((from.z..=to.z).map(|z| ([x, y, z], t)));
                }
            }
        }
        cells.sort_unstable();
        Grid { cells }
    }

    fn pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        let together = self.cells.chunk_by(|a, b| a.0 == b.0);
        together.flat_map(|cell| {
            (0..cell.len()).flat_map(move |k| cell[k + 1..].iter().map(move |other| [cell[k].1, other.1]))
        })
    }
}

/// Volume of all that any outward shell surrounds, mm³, by columns along z: exact along them, of a five-hundredth of the width across.
pub fn filled_volume(mesh: &TriangleMesh) -> f64 {
    const COLUMNS: usize = 500;
    // Turned, so that no wall is parallel to the columns.
    let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.37, 0.61, 0.23);
    let turned = mesh.vertices.iter().map(|&v| turn * v).collect();
    let mesh = &TriangleMesh { vertices: turned, triangles: mesh.triangles.clone() };
    let (low, high) = mesh.bounds().unwrap_or_default();
    let step = (high - low).truncate() / COLUMNS as f64;
    let mut columns: Vec<Vec<(f64, i32)>> = vec![Vec::new(); COLUMNS * COLUMNS];
    for t in 0..mesh.triangles.len() {
        let corners = mesh.corners(t);
        let [from, to] = ends(&corners).map(|v| ((v - low).truncate() / step).floor().as_ivec2());
        for (i, j) in (from.x..=to.x).flat_map(|i| (from.y..=to.y).map(move |j| (i, j))) {
            let place = low.truncate() + step * glam::DVec2::new(f64::from(i) + 0.431, f64::from(j) + 0.587);
            let inside = (0..COLUMNS as i32).contains(&i) && (0..COLUMNS as i32).contains(&j);
            if let Some(hit) = height_at(&corners, place).filter(|_| inside) {
                columns[i as usize * COLUMNS + j as usize].push(hit);
            }
        }
    }
    columns.iter_mut().map(|hits| filled_length(hits)).sum::<f64>() * step.x * step.y
}

/// Where a vertical line meets a triangle, and whether it goes in (1) or out (−1) there.
fn height_at(&[a, b, c]: &[DVec3; 3], place: glam::DVec2) -> Option<(f64, i32)> {
    let area = |p: glam::DVec2, q: glam::DVec2| p.perp_dot(q);
    let [p, q, r] = [a, b, c].map(|corner| corner.truncate() - place);
    let parts = [area(q, r), area(r, p), area(p, q)];
    let whole: f64 = parts.iter().sum();
    let inside = parts.iter().all(|part| *part > 0.0) || parts.iter().all(|part| *part < 0.0);
    inside.then(|| {
        ((parts[0] * a.z + parts[1] * b.z + parts[2] * c.z) / whole, if whole < 0.0 { 1 } else { -1 })
    })
}

/// Length of a column within material.
fn filled_length(hits: &mut [(f64, i32)]) -> f64 {
    hits.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut depth = 0;
    let mut length = 0.0;
    for pair in hits.windows(2) {
        depth += pair[0].1;
        length += if depth > 0 { pair[1].0 - pair[0].0 } else { 0.0 };
    }
    length
}

/// Greatest distance of a vertex of one mesh from the surface of the other, mm.
pub fn farthest(from: &TriangleMesh, surface: &TriangleMesh) -> f64 {
    let triangles: Vec<[DVec3; 3]> = (0..surface.triangles.len()).map(|t| surface.corners(t)).collect();
    let tree = Bvh::of(&triangles);
    let distance =
        |v: &DVec3| tree.nearest(v, f64::INFINITY).map_or(f64::INFINITY, |contact| contact.distance);
    from.vertices.iter().map(distance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::broken::shapes::{ball, block, cells, inverted, moved, prism, together, torus};

    /// Bodies, cavities, genus, and pairs of crossing triangles.
    fn check(mesh: &TriangleMesh, expected: [usize; 4], volume: f64) {
        let seen = Judgement::of(mesh);
        let [bodies, cavities, genus, crossings] = expected;
        assert_eq!(seen.shape, Shape { bodies, cavities, genus: Some(genus as i64) });
        assert_eq!(seen.crossings, crossings);
        assert!(seen.is_closed && seen.is_manifold);
        assert!((seen.volume - volume).abs() < 1e-9 * volume, "{} mm³", seen.volume);
    }

    #[test]
    fn solids_are_told_by_shells_and_handles() {
        let cube = |low: f64, high: f64| block([low; 3], [high; 3]);
        check(&cube(0.0, 2.0), [1, 0, 0, 0], 8.0);
        check(&together(&[cube(0.0, 3.0), inverted(cube(1.0, 2.0)), cube(5.0, 6.0)]), [2, 1, 0, 0], 27.0);
        check(&cells([3, 3, 1], |[x, y, _]| x != 1 || y != 1), [1, 0, 1, 0], 8.0);
        check(&cells([5, 3, 1], |[x, y, _]| x % 2 == 0 || y != 1), [1, 0, 2, 0], 13.0);
        let square = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].map(glam::DVec2::from);
        check(&prism(&square, None, 3.0), [1, 0, 0, 0], 6.0);
        check(&prism(&square, Some(&square.map(|p| p / 2.0)), 3.0), [1, 0, 1, 0], 4.5);
    }

    #[test]
    fn what_is_open_or_crosses_is_seen() {
        let mut open = torus(10.0, 3.0, 12, 8);
        assert!(Judgement::of(&open).is_manifold);
        open.triangles.pop();
        let seen = Judgement::of(&open);
        assert!(!seen.is_closed && !seen.is_manifold);
        let cube = || block([0.0; 3], [2.0; 3]);
        assert!(Judgement::of(&together(&[cube(), moved(cube(), [1.1, 1.2, 1.3])])).crossings > 0);
        assert_eq!(Judgement::of(&together(&[cube(), moved(cube(), [2.0, 0.0, 0.0])])).crossings, 0);
        assert!(!Judgement::of(&TriangleMesh::default()).is_closed);
    }

    #[test]
    fn columns_measure_a_union() {
        let cube = |at: f64| moved(block([0.0; 3], [2.0; 3]), [at, at, at]);
        let near = |mesh: &TriangleMesh, volume: f64| {
            let filled = filled_volume(mesh);
            assert!((filled - volume).abs() < 2e-3 * volume, "{filled}, not {volume}");
        };
        near(&cube(0.0), 8.0);
        near(&together(&[cube(0.0), cube(1.0)]), 15.0);
        near(&together(&[cube(0.0), moved(cube(0.0), [3.0, 0.0, 0.0])]), 16.0);
        let round = ball(10.0, 8);
        near(&round, Judgement::of(&round).volume);
    }

    #[test]
    fn distances_reach_the_farthest_vertex() {
        let (whole, moved) = (ball(10.0, 4), moved(ball(10.0, 4), [0.0, 0.0, 0.5]));
        assert!((farthest(&moved, &whole) - 0.5).abs() < 0.05);
    }
}
