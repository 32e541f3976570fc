//! Patches of a surface that certainly do not pass through themselves: seen along an axis all their triangles turn the same way and
//! none covers another. (What Volino & Magnenat-Thalmann 1994 ask of a region; here by exact predicates, and with the outline proved.)

use crate::half_edges::OPEN;
use crate::outline::goes_around_once;
use crate::overlaps::LOOSE;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DVec2, DVec3};

/// Smaller patches are not worth their proof.
const SMALLEST: usize = 32;
/// A patch that passes over itself is halved so often, to save the parts that do not.
const HALVINGS: usize = 6;

/// The number of each triangle's patch, or [`LOOSE`]; two triangles of a patch do not cross. Twins as of [`crate::half_edges::twins`].
pub fn patches(mesh: &TriangleMesh, twins: &[u32]) -> Vec<u32> {
    let facings: Vec<Facing> = (0..mesh.triangles.len()).map(|t| Facing::of(mesh.corners(t))).collect();
    let mut grower = Grower { facings: &facings, twins, taken: vec![false; facings.len()] };
    let mut sorted = Sorted { mesh, twins, patches: vec![LOOSE; facings.len()], next: 0 };
    for (seed, facing) in (0..).zip(&facings) {
        if let Some(view) = facing.first().filter(|_| !grower.taken[seed as usize]) {
            let patch = grower.grow(seed, view);
            if patch.len() >= SMALLEST {
                sorted.prove(&patch, view, HALVINGS);
            }
        }
    }
    sorted.patches
}

/// A direction along an axis, to look against: twice the axis, one more if from below.
#[derive(Clone, Copy, PartialEq)]
struct View(u8);

impl View {
    /// A point as it is seen; what faces the viewer turns counter-clockwise.
    fn project(self, point: DVec3) -> DVec2 {
        let axis = usize::from(self.0 / 2);
        let (x, y) = (point[(axis + 1) % 3], point[(axis + 2) % 3]);
        let seen = if self.0.is_multiple_of(2) { DVec2::new(x, y) } else { DVec2::new(y, x) };
        seen + DVec2::ZERO // −0 is 0
    }
}

/// The views that see a triangle, a bit each: it certainly faces them, and no other axis much better.
#[derive(Clone, Copy)]
struct Facing(u8);

impl Facing {
    #[inline]
    fn of([a, b, c]: [DVec3; 3]) -> Facing {
        // Each component of the normal is a 2 × 2 determinant of differences: off by (3 + 16 ε) ε of the sum of its products at most
        // (Shewchuk 1997), ε = 2⁻⁵³, and by what gets lost below the smallest numbers.
        const ROUNDING: f64 = 4e-16;
        const SLANT: f64 = 0.5;
        let (u, v) = ((b - a).to_array(), (c - a).to_array());
        let component = |axis: usize| {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let (left, right) = (u[next] * v[last], u[last] * v[next]);
            (left - right, (left.abs() + right.abs()) * ROUNDING + f64::MIN_POSITIVE)
        };
        let components = [component(0), component(1), component(2)];
        let [x, y, z] = components.map(|(normal, _)| normal.abs());
        let least = SLANT * x.max(y).max(z);
        let mut views = 0;
        for (axis, (normal, doubt)) in components.into_iter().enumerate() {
            let is_seen = (normal.abs() > doubt) & (normal.abs() >= least);
            views |= u8::from(is_seen) << (2 * axis + usize::from(normal < 0.0));
        }
        Facing(views)
    }

    fn first(self) -> Option<View> {
        (self.0 != 0).then(|| View(self.0.trailing_zeros() as u8))
    }

    fn is_seen(self, View(view): View) -> bool {
        self.0 >> view & 1 == 1
    }
}

/// Grows regions of triangles that hang together and face one way.
struct Grower<'a> {
    facings: &'a [Facing],
    twins: &'a [u32],
    taken: Vec<bool>,
}

impl Grower<'_> {
    /// All that is seen as the seed is and hangs on it.
    fn grow(&mut self, seed: u32, view: View) -> Vec<u32> {
        self.taken[seed as usize] = true;
        let mut patch = vec![seed];
        let mut done = 0;
        while let Some(&triangle) = patch.get(done) {
            done += 1;
            for &twin in &self.twins[3 * triangle as usize..3 * triangle as usize + 3] {
                let other = (twin / 3) as usize;
                if twin != OPEN && self.facings[other].is_seen(view) && !self.taken[other] {
                    self.taken[other] = true;
                    patch.push(other as u32);
                }
            }
        }
        patch
    }
}

/// Patches that are proved.
struct Sorted<'a> {
    mesh: &'a TriangleMesh,
    twins: &'a [u32],
    patches: Vec<u32>,
    next: u32,
}

impl Sorted<'_> {
    /// Keeps what of some triangles, all seen in a view, is proved not to cover itself.
    fn prove(&mut self, triangles: &[u32], view: View, halvings: usize) {
        let number = self.next;
        self.next += 1;
        triangles.iter().for_each(|&t| self.patches[t as usize] = number);
        let outline = self.outline(triangles, number);
        if goes_around_once(&outline, |v| view.project(self.mesh.vertices[v as usize])) {
            return;
        }
        if halvings == 0 || triangles.len() < 2 * SMALLEST {
            triangles.iter().for_each(|&t| self.patches[t as usize] = LOOSE);
            return;
        }
        // The nearer and the farther half of a patch that grew from a seed.
        let (one, other) = triangles.split_at(triangles.len() / 2);
        self.prove(one, view, halvings - 1);
        self.prove(other, view, halvings - 1);
    }

    fn outline(&self, triangles: &[u32], number: u32) -> Vec<[u32; 2]> {
        let is_inner = |half_edge: u32| {
            let twin = self.twins[half_edge as usize];
            twin != OPEN && self.patches[twin as usize / 3] == number
        };
        let sides = triangles.iter().flat_map(|&t| {
            let [a, b, c] = self.mesh.triangles[t as usize];
            [(3 * t, [a, b]), (3 * t + 1, [b, c]), (3 * t + 2, [c, a])]
        });
        sides.filter(|(half_edge, _)| !is_inner(*half_edge)).map(|(_, side)| side).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::half_edges::twins;

    /// A sheet of `count`² cells over a square, lifted and moved by a function of its coordinates in cells.
    fn sheet(count: u32, place: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
        let row = count + 1;
        let vertices = (0..row * row).map(|v| place(f64::from(v % row), f64::from(v / row))).collect();
        let cells = (0..count * count).map(|c| c % count + c / count * row);
        let triangles = cells.flat_map(|v| [[v, v + 1, v + row + 1], [v, v + row + 1, v + row]]).collect();
        TriangleMesh { vertices, triangles }
    }

    /// Number of patches, and of triangles in none.
    fn check(mesh: &TriangleMesh, expected: [usize; 2]) {
        let patches = patches(mesh, &twins(mesh));
        let mut numbers: Vec<u32> = patches.iter().copied().filter(|&number| number != LOOSE).collect();
        let loose = patches.len() - numbers.len();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!([numbers.len(), loose], expected);
    }

    #[test]
    fn a_patch_is_seen_whole_from_somewhere() {
        check(&sheet(20, |x, y| DVec3::new(x, y, 0.3 * x)), [1, 0]);
        check(&sheet(20, |x, y| DVec3::new(y, x, 0.3 * x)), [1, 0]);
        check(&sheet(4, |x, y| DVec3::new(x, y, 0.0)), [1, 0]);
        check(&sheet(3, |x, y| DVec3::new(x, y, 0.0)), [0, 18]);
        check(&sheet(20, |_, y| DVec3::new(0.0, y, 0.0)), [0, 800]);
        // A roof, and a ramp that goes around twice.
        check(&sheet(20, |x, y| DVec3::new(x.min(10.0), y, 10.0 - (x - 10.0).max(0.0))), [2, 0]);
        let ramp = |x: f64, y: f64| {
            let (sine, cosine) = libm::sincos(0.15 * x);
            DVec3::new((9.0 + 0.05 * y) * cosine, (9.0 + 0.05 * y) * sine, 0.2 * x)
        };
        let mesh = sheet(80, ramp);
        let patches = patches(&mesh, &twins(&mesh));
        assert!(patches.iter().any(|&number| number != LOOSE));
        // 42 cells further on one stands above oneself.
        let above = |t: usize| if t / 2 % 80 < 38 { Some(t + 84) } else { None };
        let pairs = (0..patches.len()).filter_map(|t| Some([t, above(t)?].map(|t| patches[t])));
        assert!(pairs.into_iter().all(|[one, other]| one != other || one == LOOSE));
    }
}
