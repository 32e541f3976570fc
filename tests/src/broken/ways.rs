//! Ways to break a mesh.

use super::shapes::moved;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Random numbers that are the same in every run.
pub struct Dice(ChaCha8Rng);

impl Dice {
    /// Dice of this seed.
    pub fn new(seed: u64) -> Dice {
        Dice(ChaCha8Rng::seed_from_u64(seed))
    }

    /// From 0 to 1.
    pub fn share(&mut self) -> f64 {
        f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// Less than `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.0.next_u64() % count as u64) as usize
    }

    fn direction(&mut self) -> DVec3 {
        DVec3::new(self.share() - 0.5, self.share() - 0.5, self.share() - 0.5) * 2.0
    }
}

/// Without the triangles whose middle is like this.
pub fn without(mut mesh: TriangleMesh, is_away: impl Fn(DVec3) -> bool) -> TriangleMesh {
    let keep: Vec<bool> = (0..mesh.triangles.len()).map(|t| !is_away(middle(&mesh, t))).collect();
    let mut keep = keep.into_iter();
    mesh.triangles.retain(|_| keep.next().expect("one for each triangle"));
    mesh
}

fn middle(mesh: &TriangleMesh, triangle: usize) -> DVec3 {
    mesh.corners(triangle).iter().sum::<DVec3>() / 3.0
}

/// Without this share of its triangles.
pub fn sieved(mut mesh: TriangleMesh, share: f64, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    mesh.triangles.retain(|_| dice.share() >= share);
    mesh
}

/// This share of the triangles turned.
pub fn flipped(mut mesh: TriangleMesh, share: f64, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    mesh.triangles.iter_mut().filter(|_| dice.share() < share).for_each(|triangle| triangle.swap(1, 2));
    mesh
}

/// Every triangle with corners of its own, in random order and from a random corner on.
pub fn shuffled(mesh: &TriangleMesh, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    let mut triangles = mesh.triangles.clone();
    for k in (1..triangles.len()).rev() {
        triangles.swap(k, dice.below(k + 1));
        triangles[k].rotate_left(dice.below(3));
    }
    soup(&TriangleMesh { vertices: mesh.vertices.clone(), triangles })
}

/// Every triangle with corners of its own, as in an STL file.
pub fn soup(mesh: &TriangleMesh) -> TriangleMesh {
    let vertices = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect();
    let triangles = (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    TriangleMesh { vertices, triangles }
}

/// A soup whose corners each lie up to so far beside their place, mm.
pub fn jittered(mesh: &TriangleMesh, reach: f64, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    let mut soup = soup(mesh);
    soup.vertices.iter_mut().for_each(|v| *v += dice.direction() * reach / 3_f64.sqrt());
    soup
}

/// Coordinates rounded to multiples of a step, mm, as in a file of few digits.
pub fn rounded(mut mesh: TriangleMesh, step: f64) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v = (*v / step).round() * step);
    mesh
}

/// This share of the triangles twice.
pub fn doubled(mut mesh: TriangleMesh, share: f64, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    let again: Vec<[u32; 3]> = mesh.triangles.iter().filter(|_| dice.share() < share).copied().collect();
    mesh.triangles.extend(again);
    mesh
}

/// With triangles of no area: a corner twice, or three corners in a row along a side.
pub fn with_degenerate(mut mesh: TriangleMesh, count: usize, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    for k in 0..count {
        let [a, b, c] = mesh.triangles[dice.below(mesh.triangles.len())];
        mesh.triangles.push(if k % 2 == 0 { [a, a, b] } else { [b, c, c] });
    }
    mesh
}

/// This share of the triangles in two, by a corner in the middle of one side that the neighbour knows nothing of.
pub fn with_t_junctions(mut mesh: TriangleMesh, share: f64, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    for t in 0..mesh.triangles.len() {
        if dice.share() < share {
            let [a, b, c] = mesh.triangles[t];
            let number = mesh.vertices.len() as u32;
            mesh.vertices.push((mesh.vertices[a as usize] + mesh.vertices[b as usize]) / 2.0);
            mesh.triangles[t] = [a, number, c];
            mesh.triangles.push([number, b, c]);
        }
    }
    mesh
}

/// Slivers without area that close a T-junction: both neighbours of a side, and a needle between.
pub fn with_needles(mut mesh: TriangleMesh, share: f64, seed: u64) -> TriangleMesh {
    let before = mesh.vertices.len();
    let sides: Vec<[u32; 3]> = mesh.triangles.clone();
    mesh = with_t_junctions(mesh, share, seed);
    let mut dice = Dice::new(seed);
    let cut = sides.into_iter().filter(|_| dice.share() < share);
    let needles = cut.zip(before as u32..).map(|([a, b, _], number)| [a, b, number]);
    mesh.triangles.extend(needles.collect::<Vec<_>>());
    mesh
}

/// So many triangles that hang on a side of the mesh by one of theirs, and stick out by this much, mm.
pub fn with_flaps(mut mesh: TriangleMesh, count: usize, reach: f64, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    let triangles = mesh.triangles.len();
    for _ in 0..count {
        let t = dice.below(triangles);
        let [a, b, c] = mesh.corners(t);
        let number = mesh.vertices.len() as u32;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        mesh.vertices.push((a + b) / 2.0 + reach * (normal + 0.1 * dice.direction()));
        mesh.triangles.push([mesh.triangles[t][0], mesh.triangles[t][1], number]);
    }
    mesh
}

/// So many triangles without a neighbour, here and there outside.
pub fn with_strays(mut mesh: TriangleMesh, count: usize, seed: u64) -> TriangleMesh {
    let mut dice = Dice::new(seed);
    let (low, high) = mesh.bounds().unwrap_or_default();
    for _ in 0..count {
        let first = mesh.vertices.len() as u32;
        let place = DVec3::new(low.x + dice.share() * (high.x - low.x), high.y + 5.0, low.z + dice.share());
        mesh.vertices.extend([place, place + dice.direction(), place + dice.direction()]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

/// The vertex that reaches farthest along a direction, drawn to a place.
pub fn with_spike(mut mesh: TriangleMesh, along: DVec3, to: DVec3) -> TriangleMesh {
    let height = |v: &DVec3| v.dot(along);
    let top = (0..mesh.vertices.len())
        .max_by(|&a, &b| height(&mesh.vertices[a]).total_cmp(&height(&mesh.vertices[b])));
    mesh.vertices[top.expect("a mesh has vertices")] = to;
    mesh
}

/// Cut at a plane through its middle across x, the halves moved apart, mm: their rims no longer meet.
pub fn torn(mesh: &TriangleMesh, gap: f64) -> TriangleMesh {
    let left = without(soup(mesh), |p| p.x > 0.0);
    let right = without(soup(mesh), |p| p.x <= 0.0);
    super::shapes::together(&[left, moved(right, [gap, 0.0, 0.0])])
}
