//! Points of the surface as it came, each held by the triangle that stands for it now.

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// Points on the sides and insides of large triangles are this many times as many as there are triangles, about.
const DENSITY: f64 = 6.0;
/// But for that many at least.
const FEWEST: f64 = 20_000.0;

/// A point of the surface as it came.
#[derive(Clone, Copy, Debug)]
pub struct Witness {
    /// Where it is, mm.
    pub place: DVec3,
    /// How far from the new surface it may come to lie, mm.
    pub reach: f64,
}

/// All witnesses, and who holds them.
pub struct Witnesses {
    /// By number.
    pub all: Vec<Witness>,
    /// What is allowed where none is near, mm.
    pub reach: f64,
    held: Vec<Vec<u32>>,
    /// Where in `sources` begins on which triangles each stood.
    starts: Vec<u32>,
    sources: Vec<u32>,
}

impl Witnesses {
    /// Every vertex, and points of a lattice on triangles that are larger than its spacing.
    pub fn of(mesh: &TriangleMesh, reach: f64) -> Witnesses {
        let held = vec![Vec::new(); mesh.triangles.len()];
        let mut found = Witnesses { all: Vec::new(), reach, held, starts: vec![0], sources: Vec::new() };
        let spacing = spacing(mesh);
        let mut fans = vec![Vec::new(); mesh.vertices.len()];
        for (t, triangle) in (0u32..).zip(&mesh.triangles) {
            triangle.iter().for_each(|&v| fans[v as usize].push(t));
        }
        let mut has_own = vec![false; mesh.vertices.len()];
        for t in 0..mesh.triangles.len() {
            for v in mesh.triangles[t] {
                if !std::mem::replace(&mut has_own[v as usize], true) {
                    found.add(Witness { place: mesh.vertices[v as usize], reach }, t, &fans[v as usize]);
                }
            }
            lattice(mesh.corners(t), spacing, |place| {
                found.add(Witness { place, reach }, t, &[t as u32]);
            });
        }
        found
    }

    fn add(&mut self, witness: Witness, triangle: usize, sources: &[u32]) {
        self.held[triangle].push(self.all.len() as u32);
        self.all.push(witness);
        self.sources.extend(sources);
        self.starts.push(self.sources.len() as u32);
    }

    /// The triangles of the surface as it came that a witness lies on.
    pub fn stood_on(&self, witness: u32) -> &[u32] {
        let [start, end] = [witness, witness + 1].map(|k| self.starts[k as usize] as usize);
        &self.sources[start..end]
    }

    /// Who a triangle stands for.
    pub fn held_by(&self, triangle: u32) -> &[u32] {
        &self.held[triangle as usize]
    }

    /// Takes the witnesses of a triangle away from it.
    pub fn release(&mut self, triangle: u32) {
        self.held[triangle as usize] = Vec::new();
    }

    /// Gives a witness to a triangle.
    pub fn hand(&mut self, witness: u32, triangle: u32) {
        self.held[triangle as usize].push(witness);
    }
}

fn spacing(mesh: &TriangleMesh) -> f64 {
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        0.5 * (b - a).cross(c - a).length()
    };
    let total: f64 = (0..mesh.triangles.len()).map(area).sum();
    (total / (DENSITY * mesh.triangles.len() as f64).max(FEWEST)).sqrt()
}

/// Points at most `spacing` apart, along rows parallel to the longest side; corners are left out.
fn lattice(corners: [DVec3; 3], spacing: f64, mut add: impl FnMut(DVec3)) {
    let side = |k: usize| corners[k].distance(corners[(k + 1) % 3]);
    let longest = (0..3).max_by(|&i, &j| side(i).total_cmp(&side(j))).expect("three sides");
    if side(longest) <= spacing {
        return;
    }
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    let height = (b - a).cross(c - a).length() / side(longest);
    let rows = (height / spacing).ceil().max(1.0) as u32;
    for row in 0..rows {
        let up = f64::from(row) / f64::from(rows);
        let (from, to) = (a.lerp(c, up), b.lerp(c, up));
        let steps = (from.distance(to) / spacing).ceil().max(1.0) as u32;
        let first = u32::from(row == 0);
        // The last place of a row is on the side of a neighbour, or its own row's end.
        for step in first..=steps - first {
            add(from.lerp(to, f64::from(step) / f64::from(steps)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_of_a_triangle_is_far_from_a_witness() {
        let check = |corners: [[f64; 3]; 3], spacing: f64, most: usize| {
            let corners = corners.map(DVec3::from);
            let mut places: Vec<DVec3> = corners.into();
            lattice(corners, spacing, |place| places.push(place));
            assert!(places.len() <= most, "{}", places.len());
            for (i, j) in (0..=40).flat_map(|i| (0..=40 - i).map(move |j| (i, j))) {
                let (u, v) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                let point = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
                let near = places.iter().map(|p| p.distance(point)).fold(f64::INFINITY, f64::min);
                assert!(near <= spacing, "{point} is {near} from any");
            }
        };
        check([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [3.0, 8.0, 1.0]], 1.0, 90);
        check([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 0.01, 0.0]], 1.0, 230);
        check([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0]], 1.0, 3);
    }
}
