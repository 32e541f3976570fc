//! From a soup of triangles to a solid: the steps of the repair in their order.

use crate::census::Census;
use crate::edges::Edges;
use crate::families::{Family, families, shell_numbers};
use crate::fate::Fate;
use crate::holes::{Hole, close_all, holes};
use crate::nesting::{Nesting, Shell};
use crate::sheets::{Sheets, shell_of_each};
use crate::tangles::{Tangled, untangle};
use crate::{orientation, relief, scuffs, seams, sight, sound, volume, walls, weld};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::{Crossing, crossings};
use fibar_solid::{Solid, SolidError};
use std::collections::{BTreeMap, BTreeSet};

/// How far a repair may go.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Rims this near are sewn together, mm.
    pub seam_mm: f64,
    /// Holes reaching farther than this from their middle stay open, and the mesh is refused, mm.
    pub largest_hole_mm: f64,
}

/// What stands in the way of a solid.
#[derive(Debug)]
pub enum Obstacle {
    /// Edges without exactly two triangles remain.
    Edges(Census),
    /// A hole is wider than allowed.
    Hole { count: usize, middle: glam::DVec3, radius: f64 },
    /// The surface passes through itself.
    Crossings(Vec<Crossing>),
    /// It encloses nothing.
    Nothing,
    /// Manifold refused.
    Solid(SolidError),
}

impl From<SolidError> for Obstacle {
    fn from(error: SolidError) -> Obstacle {
        Obstacle::Solid(error)
    }
}

/// Closes a mesh; notes in `fate` what was done to it. Every side of the result has two triangles that agree and every vertex one
/// fan of them, so that Manifold takes it as it is.
pub fn close(soup: &TriangleMesh, limits: Limits, fate: &mut Fate) -> Result<TriangleMesh, Obstacle> {
    if let Some(sound) = close_sound(soup, fate) {
        return Ok(sound);
    }
    let open = Sheets::of(&settle(soup, limits, fate));
    if open.is_closed() {
        return solidify(&open, None, fate);
    }
    let holes = holes_within(&open, limits)?;
    let mut sketch = fate.clone();
    let closed = close_holes(&open.mesh, &holes, &mut sketch)?;
    let found = crossings(&closed.mesh);
    let crossed = crossed_by_own_caps(&closed, &found, open.mesh.triangles.len());
    if let Some(solid) = solidify_relief(&open, &holes, &crossed, fate) {
        return Ok(solid);
    }
    *fate = sketch;
    solidify(&closed, Some(found), fate)
}

/// The first triangles of shells that pass through a cap of their own; caps come after all others.
fn crossed_by_own_caps(closed: &Sheets, found: &[Crossing], caps: usize) -> Vec<u32> {
    let mut with_caps =
        found.iter().map(|crossing| crossing.triangles).filter(|pair| pair[1] as usize >= caps).peekable();
    if with_caps.peek().is_none() {
        return Vec::new();
    }
    let shells = closed.shells();
    let shell_of = shell_of_each(&shells, closed.mesh.triangles.len());
    let crossed =
        with_caps.map(|pair| pair.map(|t| shell_of[t as usize])).filter(|[one, other]| one == other);
    let crossed: BTreeSet<u32> = crossed.map(|[shell, _]| shell).collect();
    crossed.into_iter().map(|shell| shells[shell as usize][0]).collect()
}

/// The solid of a mesh in which sheets stand on flat backs, if there are such that caps pass through.
fn solidify_relief(open: &Sheets, holes: &[Hole], crossed: &[u32], fate: &mut Fate) -> Option<TriangleMesh> {
    let relief = (!crossed.is_empty()).then(|| relief::stand(open, holes, crossed))??;
    let sheets = Sheets::of(&relief.mesh);
    let mut sketch = fate.clone();
    sketch.backs_added = relief.backs;
    sketch.holes_closed = relief.caps;
    sketch.cap_area =
        volume::area_of(&sheets.mesh, open.mesh.triangles.len() as u32..sheets.mesh.triangles.len() as u32);
    let solid = sheets.is_closed().then(|| solidify(&sheets, None, &mut sketch).ok())??;
    *fate = sketch;
    Some(solid)
}

/// What closed sheets enclose, of which the crossings may be known.
fn solidify(
    sheets: &Sheets,
    found: Option<Vec<Crossing>>,
    fate: &mut Fate,
) -> Result<TriangleMesh, Obstacle> {
    let mut mesh = sheets.mesh.clone();
    let nesting = Nesting::of(sheets, &mut mesh);
    fate.shells = nesting.shells.len();
    fate.shells_turned = nesting.turned;
    fate.flat_shells_removed = nesting.flat;
    fate.volume_before = volume::signed_volume(&mesh);
    if nesting.shells.is_empty() {
        return Err(Obstacle::Nothing);
    }
    // Without the flat ones the triangles have other numbers.
    let found = found.filter(|_| nesting.flat == 0).unwrap_or_else(|| crossings(&mesh));
    fate.crossings = found.len();
    let Some(smoothed) = scuffs::smooth(&mesh, &found, scuffs::SMALL) else {
        return unite(mesh, &nesting.shells, &found, fate);
    };
    fate.tangles_cut += smoothed.cut;
    fate.displacement = fate.displacement.max(smoothed.displacement);
    let mut mesh = smoothed.mesh;
    let shells = Nesting::of(&Sheets::of(&mesh), &mut mesh).shells;
    let found = crossings(&mesh);
    unite(mesh, &shells, &found, fate)
}

/// Welds, sews, and settles which side of each triangle is outside.
fn settle(soup: &TriangleMesh, limits: Limits, fate: &mut Fate) -> TriangleMesh {
    let welded = weld::weld(soup);
    fate.vertices_welded = soup.vertices.len() - welded.mesh.vertices.len();
    fate.degenerate_removed = welded.degenerate;
    fate.duplicates_removed = welded.duplicate;
    let mut mesh = welded.mesh;
    if Edges::of(&mesh).are_all_shared_by_two() {
        return mesh;
    }
    let sewn = seams::sew(&mut mesh, limits.seam_mm);
    fate.vertices_sewn = sewn.merged;
    fate.sides_divided = sewn.divided;
    fate.displacement = sewn.displacement;
    fate.triangles_turned = orientation::orient(&mut mesh);
    fate.walls_removed = walls::remove(&mut mesh);
    fate.triangles_turned += orientation::orient(&mut mesh) + sight::turn_by_sight(&mut mesh);
    mesh
}

/// The holes of open sheets, if none is too wide.
fn holes_within(sheets: &Sheets, limits: Limits) -> Result<Vec<Hole>, Obstacle> {
    let found = holes(sheets);
    let widest = found.iter().max_by(|a, b| a.radius.total_cmp(&b.radius));
    if let Some(hole) = widest.filter(|hole| hole.radius > limits.largest_hole_mm) {
        return Err(Obstacle::Hole { count: found.len(), middle: hole.middle, radius: hole.radius });
    }
    // A rim of two half-edges closes by pairing them: there is no hole.
    Ok(found.into_iter().filter(|hole| hole.rim.len() > 2).collect())
}

fn close_holes(open: &TriangleMesh, holes: &[Hole], fate: &mut Fate) -> Result<Sheets, Obstacle> {
    let mut closed = open.clone();
    fate.cap_area = close_all(holes, &mut closed);
    fate.holes_closed = holes.len();
    let sheets = Sheets::of(&closed);
    if sheets.is_closed() { Ok(sheets) } else { Err(Obstacle::Edges(Census::of(&closed))) }
}

/// The mesh itself, welded, if it needs no repair: most do not, and to prove that takes less than to look for what to mend.
fn close_sound(soup: &TriangleMesh, fate: &mut Fate) -> Option<TriangleMesh> {
    // What is sound has no triangle that collapses, stands twice or back to back.
    let welded = soup.indexed();
    let volume = volume::signed_volume(&welded);
    if volume <= 0.0 || !sound::is_sound(&welded) {
        return None;
    }
    fate.vertices_welded = soup.vertices.len() - welded.vertices.len();
    fate.shells = 1;
    (fate.bodies, fate.bodies_left) = (1, 1);
    fate.volume_before = volume;
    Some(welded)
}

/// The union of all bodies, each without its cavities. Shells that touch no other and are not tangled are kept as they are.
fn unite(
    mesh: TriangleMesh,
    shells: &[Shell],
    found: &[Crossing],
    fate: &mut Fate,
) -> Result<TriangleMesh, Obstacle> {
    fate.bodies = shells.iter().filter(|shell| shell.volume > 0.0).count();
    let families = families(&mesh, shells, found);
    if let [Family { members, is_loose: true }] = families.as_slice()
        && members.len() == shells.len()
    {
        fate.bodies_left = fate.bodies;
        return Ok(mesh);
    }
    let mut united = TriangleMesh::default();
    for family in families {
        let part = match family.is_loose {
            true => alone(&mesh, family.members.iter().map(|&number| &shells[number])),
            false => union_of(&mesh, shells, &family.members, found, fate)?,
        };
        let first = united.vertices.len() as u32;
        united.vertices.extend(part.vertices);
        united.triangles.extend(part.triangles.into_iter().map(|t| t.map(|v| v + first)));
    }
    let shells = Sheets::of(&united).shells().into_iter();
    let volumes = shells.map(|shell| volume::signed_volume_of(&united, shell));
    fate.bodies_left = volumes.filter(|volume| *volume > 0.0).count();
    Ok(united)
}

/// The union of some bodies without their cavities.
fn union_of(
    mesh: &TriangleMesh,
    shells: &[Shell],
    members: &[usize],
    found: &[Crossing],
    fate: &mut Fate,
) -> Result<TriangleMesh, Obstacle> {
    let shell_of = shell_numbers(mesh, shells);
    let of = |crossing: &Crossing| crossing.triangles.map(|t| shell_of[t as usize]);
    let tangled: BTreeSet<usize> = found.iter().map(of).filter(|[a, b]| a == b).map(|[a, _]| a).collect();
    let mut solids = BTreeMap::new();
    for &number in members {
        let filled = filled(mesh, &shells[number], tangled.contains(&number), fate)?;
        if members.len() == 1 {
            return Ok(filled);
        }
        solids.insert(number, Solid::from_mesh(&filled)?);
    }
    let bodies = members.iter().filter(|&&number| shells[number].volume > 0.0).map(|&number| {
        let is_cavity = |k: &&usize| shells[**k].volume < 0.0 && shells[**k].parent == Some(number);
        solids[&number].subtract(members.iter().filter(is_cavity).map(|k| &solids[k]))
    });
    let bodies = bodies.collect::<Result<Vec<Solid>, SolidError>>()?;
    Ok(Solid::union(&bodies)?.to_mesh()?)
}

/// Some shells as a mesh of their own.
fn alone<'a>(mesh: &TriangleMesh, shells: impl IntoIterator<Item = &'a Shell>) -> TriangleMesh {
    let triangles =
        shells.into_iter().flat_map(|shell| &shell.triangles).map(|&t| mesh.triangles[t as usize]);
    mesh.part(&triangles.collect::<Vec<_>>())
}

/// The surface of what a shell encloses, a cavity as if it were a body.
fn filled(
    mesh: &TriangleMesh,
    shell: &Shell,
    tangled: bool,
    fate: &mut Fate,
) -> Result<TriangleMesh, Obstacle> {
    let mut alone = alone(mesh, [shell]);
    if shell.volume < 0.0 {
        alone.triangles.iter_mut().for_each(orientation::turn);
    }
    if !tangled {
        return Ok(alone);
    }
    match untangle(&alone) {
        Ok(done) => {
            fate.tangles_parted += done.parted;
            fate.tangles_cut += done.cut;
            fate.displacement = fate.displacement.max(done.displacement);
            Ok(done.mesh)
        }
        Err(Tangled::Crossings(left)) => Err(Obstacle::Crossings(left)),
        Err(Tangled::Solid(error)) => Err(error.into()),
    }
}
