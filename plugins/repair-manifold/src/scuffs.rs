//! Scuffs: places, small beside their shell, where a surface passes through itself, as scans have them by the hundred.
//!
//! All of them are cut out at once and the holes closed; what still crosses then is cut out with a ring of triangles more, and so on
//! (after Attene 2010, "A lightweight approach to repairing digitized polygon meshes"). What is not small, and what
//! would take more than discs out of the surface, is left to `tangles`.

use crate::distance::farthest;
use crate::holes::{close_all, holes};
use crate::sheets::{Sheets, shell_of_each};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::{Crossing, crossings_between};
use fibar_geometry::overlaps::LOOSE;
use glam::DVec3;
use std::collections::BTreeMap;

/// A surface whose scuffs are gone.
pub struct Smoothed {
    /// Still closed.
    pub mesh: TriangleMesh,
    /// Scuffs cut out.
    pub cut: usize,
    /// Greatest distance of a vertex that was cut out from the new surface, mm.
    pub displacement: f64,
}

/// How often what still crosses is cut out, each time with a ring more.
const ROUNDS: usize = 6;
/// A scuff reaches no farther than this share of its shell's box.
pub const SMALL: f64 = 0.1;

/// Smooths a closed surface that crosses itself here, where it does within a share of its shell's box; nothing if it does so nowhere.
pub fn smooth(mesh: &TriangleMesh, found: &[Crossing], share: f64) -> Option<Smoothed> {
    if found.is_empty() {
        return None;
    }
    let mut surface = Surface::of(mesh.clone(), found.to_vec());
    let (mut cut, mut lost) = (0, Vec::new());
    for rings in 0..ROUNDS {
        let scuffs = surface.discs_of(surface.scuffs(rings, share));
        if scuffs.is_empty() {
            if surface.left.is_empty() { break } else { continue }
        }
        if let Some((next, gone)) = surface.without(&scuffs) {
            // Later rounds cut again where earlier ones did not suffice.
            cut = cut.max(scuffs.len());
            lost.extend(gone);
            surface = next;
        }
    }
    let displacement = displacement(&lost, &surface.mesh);
    (cut > 0).then_some(Smoothed { mesh: surface.mesh, cut, displacement })
}

/// A box around something.
#[derive(Clone, Copy)]
struct Span {
    low: DVec3,
    high: DVec3,
}

impl Span {
    fn of(mesh: &TriangleMesh, triangles: &[u32]) -> Span {
        let corners = triangles.iter().flat_map(|&t| mesh.corners(t as usize));
        let nothing = Span { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        corners.fold(nothing, |all, v| Span { low: all.low.min(v), high: all.high.max(v) })
    }

    fn size(&self) -> f64 {
        self.low.distance(self.high)
    }
}

/// A closed surface in shells, and where it crosses itself within one of them.
struct Surface {
    mesh: TriangleMesh,
    shell_of: Vec<u32>,
    sizes: Vec<f64>,
    left: Vec<Crossing>,
}

/// Triangles that are to go, and the reach of their box.
struct Scuff {
    triangles: Vec<u32>,
    size: f64,
}

impl Surface {
    fn of(mesh: TriangleMesh, mut left: Vec<Crossing>) -> Surface {
        let shells = Sheets::of(&mesh).shells();
        let shell_of = shell_of_each(&shells, mesh.triangles.len());
        let sizes = shells.iter().map(|shell| Span::of(&mesh, shell).size()).collect();
        left.retain(|crossing| {
            shell_of[crossing.triangles[0] as usize] == shell_of[crossing.triangles[1] as usize]
        });
        Surface { mesh, shell_of, sizes, left }
    }

    /// Crossing triangles with so many rings around them, those together that hang together; the small ones.
    fn scuffs(&self, rings: usize, share: f64) -> Vec<Scuff> {
        let mut away = vec![false; self.mesh.triangles.len()];
        self.left.iter().flat_map(|crossing| crossing.triangles).for_each(|t| away[t as usize] = true);
        (0..rings).for_each(|_| grow(&self.mesh, &mut away));
        let groups = connected(&self.mesh, &away, &self.left);
        let scuffs = groups
            .into_iter()
            .map(|triangles| Scuff { size: Span::of(&self.mesh, &triangles).size(), triangles });
        scuffs
            .filter(|scuff| {
                scuff.size <= share * self.sizes[self.shell_of[scuff.triangles[0] as usize] as usize]
            })
            .collect()
    }

    /// The surface without scuffs and without the scraps that come off with them, its holes closed, and what places were lost;
    /// nothing unless it crosses less.
    fn without(&self, scuffs: &[Scuff]) -> Option<(Surface, Vec<DVec3>)> {
        let keep = self.kept_of(scuffs);
        let kept: Vec<u32> = (0..keep.len() as u32).filter(|&t| keep[t as usize]).collect();
        let triangles = kept.iter().map(|&t| self.mesh.triangles[t as usize]).collect();
        let sheets = Sheets::of(&TriangleMesh { vertices: self.mesh.vertices.clone(), triangles });
        let mut closed = sheets.mesh.clone();
        close_all(&holes(&sheets), &mut closed);
        if !Sheets::of(&closed).is_closed() {
            return None;
        }
        let left = self.left_of(&kept, &closed);
        let next = Surface::of(closed, left);
        let gone = (0..keep.len()).filter(|&t| !keep[t]).flat_map(|t| self.mesh.corners(t)).collect();
        (next.left.len() < self.left.len()).then_some((next, gone))
    }

    /// Which triangles stay where scuffs go, and the scraps with them.
    fn kept_of(&self, scuffs: &[Scuff]) -> Vec<bool> {
        let mut keep = vec![true; self.mesh.triangles.len()];
        scuffs.iter().flat_map(|scuff| &scuff.triangles).for_each(|&t| keep[t as usize] = false);
        let reach = scuffs.iter().map(|scuff| scuff.size).fold(0.0, f64::max);
        let kept: Vec<u32> = (0..keep.len() as u32).filter(|&t| keep[t as usize]).collect();
        self.scraps(&kept, reach).into_iter().for_each(|scrap| keep[scrap as usize] = false);
        keep
    }

    /// Leaves out scuffs that would take more than discs out of the surface, and so part what hangs together.
    fn discs_of(&self, scuffs: Vec<Scuff>) -> Vec<Scuff> {
        let keep = self.kept_of(&scuffs);
        let away: Vec<bool> = keep.iter().map(|keep| !keep).collect();
        let mut is_disc = vec![true; keep.len()];
        for patch in connected(&self.mesh, &away, &[]) {
            if euler(&self.mesh, &patch) != 1 {
                patch.iter().for_each(|&t| is_disc[t as usize] = false);
            }
        }
        scuffs.into_iter().filter(|scuff| scuff.triangles.iter().all(|&t| is_disc[t as usize])).collect()
    }

    /// What still crosses in a surface whose first triangles are those kept, caps after them: of those kept it is known.
    fn left_of(&self, kept: &[u32], closed: &TriangleMesh) -> Vec<Crossing> {
        let mut left: Vec<Crossing> =
            self.left.iter().filter_map(|crossing| renumbered(crossing, kept)).collect();
        let mut groups = vec![0; closed.triangles.len()];
        groups[kept.len()..].fill(LOOSE);
        left.extend(crossings_between(closed, &groups));
        left
    }

    /// Triangles of pieces, no larger than this, that no longer hang on the largest piece of their shell.
    fn scraps(&self, kept: &[u32], reach: f64) -> Vec<u32> {
        let triangles = kept.iter().map(|&t| self.mesh.triangles[t as usize]).collect();
        let rest = Sheets::of(&TriangleMesh { vertices: self.mesh.vertices.clone(), triangles });
        let mut largest: BTreeMap<u32, usize> = BTreeMap::new();
        let pieces: Vec<Vec<u32>> = rest
            .shells()
            .into_iter()
            .map(|piece| piece.into_iter().map(|k| kept[k as usize]).collect())
            .collect();
        let shell = |piece: &[u32]| self.shell_of[piece[0] as usize];
        for piece in &pieces {
            let most = largest.entry(shell(piece)).or_default();
            *most = piece.len().max(*most);
        }
        let is_scrap = |piece: &&Vec<u32>| {
            piece.len() < largest[&shell(piece)] && Span::of(&self.mesh, piece).size() <= reach
        };
        pieces.iter().filter(is_scrap).flatten().copied().collect()
    }
}

/// Vertices less edges and more triangles of a patch: 1 for a disc.
fn euler(mesh: &TriangleMesh, patch: &[u32]) -> i64 {
    let triangles = || patch.iter().map(|&t| mesh.triangles[t as usize]);
    let mut edges: Vec<[u32; 2]> = triangles()
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut vertices: Vec<u32> = triangles().flatten().collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices.len() as i64 - edges.len() as i64 + patch.len() as i64
}

/// A crossing by the places of its triangles in a list, if both are in it.
fn renumbered(crossing: &Crossing, kept: &[u32]) -> Option<Crossing> {
    let [one, other] = crossing.triangles.map(|t| kept.binary_search(&t).ok());
    Some(Crossing { triangles: [one? as u32, other? as u32], place: crossing.place })
}

/// Adds the triangles that share a corner with one marked.
fn grow(mesh: &TriangleMesh, marked: &mut [bool]) {
    let mut touched = vec![false; mesh.vertices.len()];
    for (triangle, _) in mesh.triangles.iter().zip(marked.iter()).filter(|(_, marked)| **marked) {
        triangle.iter().for_each(|&v| touched[v as usize] = true);
    }
    for (triangle, marked) in mesh.triangles.iter().zip(marked) {
        *marked |= triangle.iter().any(|&v| touched[v as usize]);
    }
}

/// Marked triangles in groups that share corners or cross.
fn connected(mesh: &TriangleMesh, marked: &[bool], crossings: &[Crossing]) -> Vec<Vec<u32>> {
    let mut parents: BTreeMap<u32, u32> = BTreeMap::new();
    fn root(parents: &mut BTreeMap<u32, u32>, mut of: u32) -> u32 {
        while let Some(&parent) = parents.get(&of).filter(|&&parent| parent != of) {
            of = parent;
        }
        of
    }
    let mut join = |a: u32, b: u32| {
        let (a, b) = (root(&mut parents, a), root(&mut parents, b));
        parents.insert(a.max(b), a.min(b));
        parents.entry(a.min(b)).or_insert(a.min(b));
    };
    let all = || {
        (0u32..)
            .zip(&mesh.triangles)
            .zip(marked)
            .filter(|(_, marked)| **marked)
            .map(|((t, triangle), _)| (t, triangle))
    };
    for (_, &[a, b, c]) in all() {
        join(a, b);
        join(b, c);
    }
    for crossing in crossings {
        let [one, other] = crossing.triangles.map(|t| mesh.triangles[t as usize][0]);
        join(one, other);
    }
    let mut groups: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (t, triangle) in all() {
        groups.entry(root(&mut parents, triangle[0])).or_default().push(t);
    }
    groups.into_values().collect()
}

/// Greatest distance of places from a surface, by its triangles around them; never too small.
fn displacement(places: &[DVec3], mesh: &TriangleMesh) -> f64 {
    let Some(first) = places.first() else { return 0.0 };
    let (low, high) = mesh.bounds().unwrap_or((*first, *first));
    let cell = (high - low).max_element().max(f64::MIN_POSITIVE) / 50.0;
    let key = |v: DVec3| ((v - low) / cell).floor().as_ivec3().to_array();
    let cells: std::collections::BTreeSet<[i32; 3]> = places.iter().map(|place| key(*place)).collect();
    let is_near = |t: &usize| {
        let corners = mesh.corners(*t).map(key);
        (0..27).any(|k| {
            let by = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            corners.iter().any(|corner| {
                cells.contains(&std::array::from_fn::<i32, 3, _>(|axis| corner[axis] + by[axis]))
            })
        })
    };
    let near = (0..mesh.triangles.len()).filter(is_near).map(|t| mesh.triangles[t]).collect::<Vec<_>>();
    farthest(places.iter().copied(), &mesh.part(&near))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, moved, together};
    use crate::volume::signed_volume;
    use fibar_geometry::crossings::crossings;

    #[test]
    fn only_discs_are_cut_out() {
        let surface = Surface::of(ball(10.0, 12), Vec::new());
        let discs_of = |triangles: Vec<u32>| {
            let size = Span::of(&surface.mesh, &triangles).size();
            surface.discs_of(vec![Scuff { triangles, size }]).len()
        };
        let near = |place: DVec3, is_near: &dyn Fn(DVec3) -> bool| {
            let count = surface.mesh.triangles.len() as u32;
            let middle = |t: u32| surface.mesh.corners(t as usize).iter().sum::<DVec3>() / 3.0 - place;
            (0..count).filter(|&t| is_near(middle(t))).collect::<Vec<u32>>()
        };
        assert_eq!(discs_of(vec![7]), 1);
        assert_eq!(discs_of(near(10.0 * DVec3::Z, &|from| from.length() < 3.0)), 1);
        assert_eq!(discs_of(near(DVec3::ZERO, &|from| from.z.abs() < 2.0)), 0);
    }

    #[test]
    fn small_crossings_are_cut_out_and_nothing_else() {
        let whole = together(&[ball(10.0, 40), moved(ball(5.0, 30), [30.0, 0.0, 0.0])]);
        assert!(smooth(&whole, &crossings(&whole), SMALL).is_none());
        let mut scuffed = whole.clone();
        // A pit drawn aside below the surface, and a needle into it.
        for pit in [500, 3000, 6000] {
            let distance = |v: &usize| (whole.vertices[pit].distance(whole.vertices[*v]) - 0.8).abs();
            let needle =
                (0..whole.vertices.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            scuffed.vertices[pit] = whole.vertices[needle] * 0.97;
            scuffed.vertices[needle] = whole.vertices[needle] * 0.94;
        }
        let found = crossings(&scuffed);
        assert!(!found.is_empty());
        let smoothed = smooth(&scuffed, &found, SMALL).expect("something crossed");
        assert!(crossings(&smoothed.mesh).is_empty());
        let off = signed_volume(&smoothed.mesh) / signed_volume(&whole) - 1.0;
        assert!(off.abs() < 3e-3 && smoothed.displacement < 2.0 && smoothed.cut > 0, "{off}");
    }
}
