//! From a soup of triangles to a solid: the steps of the repair in their order.

use crate::census::Census;
use crate::crossings::{Crossing, crossings};
use crate::edges::Edges;
use crate::fate::Fate;
use crate::holes::holes;
use crate::nesting::{Nesting, Shell};
use crate::sheets::Sheets;
use crate::tangles::{Tangled, untangle};
use crate::{orientation, seams, sight, sound, volume, walls, weld};
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_solid::{Solid, SolidError};
use std::collections::BTreeSet;

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

/// Closes a mesh; notes in `fate` what was done to it.
pub fn close(soup: &TriangleMesh, limits: Limits, fate: &mut Fate) -> Result<Solid, Obstacle> {
    let mut mesh = settle(soup, limits, fate);
    let sheets = close_holes(&mesh, limits, fate)?;
    mesh = sheets.mesh.clone();
    let nesting = Nesting::of(&sheets, &mut mesh);
    fate.shells = nesting.shells.len();
    fate.shells_turned = nesting.turned;
    fate.flat_shells_removed = nesting.flat;
    fate.volume_before = volume::signed_volume(&mesh);
    if nesting.shells.is_empty() {
        return Err(Obstacle::Nothing);
    }
    unite(&mesh, &nesting.shells, fate)
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

fn close_holes(mesh: &TriangleMesh, limits: Limits, fate: &mut Fate) -> Result<Sheets, Obstacle> {
    let sheets = Sheets::of(mesh);
    if sheets.is_closed() {
        return Ok(sheets);
    }
    let found = holes(&sheets);
    let widest = found.iter().max_by(|a, b| a.radius.total_cmp(&b.radius));
    if let Some(hole) = widest.filter(|hole| hole.radius > limits.largest_hole_mm) {
        return Err(Obstacle::Hole { count: found.len(), middle: hole.middle, radius: hole.radius });
    }
    let mut closed = sheets.mesh;
    // A rim of two half-edges closes by pairing them: there is no hole.
    for hole in found.iter().filter(|hole| hole.rim.len() > 2) {
        fate.cap_area += hole.close(&mut closed);
        fate.holes_closed += 1;
    }
    let sheets = Sheets::of(&closed);
    if sheets.is_closed() { Ok(sheets) } else { Err(Obstacle::Edges(Census::of(&closed))) }
}

/// The mesh itself, welded, if it needs no repair and is large enough for that to matter: then no solid has to be made of it.
pub fn close_sound(soup: &TriangleMesh, fate: &mut Fate) -> Option<TriangleMesh> {
    let welded = weld::weld(soup);
    let volume = volume::signed_volume(&welded.mesh);
    if welded.degenerate + welded.duplicate > 0 || volume <= 0.0 || !sound::is_sound(&welded.mesh) {
        return None;
    }
    fate.vertices_welded = soup.vertices.len() - welded.mesh.vertices.len();
    fate.shells = 1;
    fate.volume_before = volume;
    Some(welded.mesh)
}

/// The union of all bodies, each without its cavities.
fn unite(mesh: &TriangleMesh, shells: &[Shell], fate: &mut Fate) -> Result<Solid, Obstacle> {
    let found = crossings(mesh);
    let mut shell_of = vec![0; mesh.triangles.len()];
    for (number, shell) in shells.iter().enumerate() {
        shell.triangles.iter().for_each(|&t| shell_of[t as usize] = number);
    }
    let of = |crossing: &Crossing| crossing.triangles.map(|t| shell_of[t as usize]);
    let tangled: BTreeSet<usize> = found.iter().map(of).filter(|[a, b]| a == b).map(|[a, _]| a).collect();
    fate.crossings = found.len();
    if found.is_empty() && !may_overlap(shells) {
        return Ok(Solid::from_mesh(mesh)?);
    }
    let solids = (0..shells.len())
        .map(|number| solid_of(mesh, &shells[number], tangled.contains(&number), fate))
        .collect::<Result<Vec<Solid>, Obstacle>>()?;
    let bodies = (0..shells.len()).filter(|&number| shells[number].volume > 0.0).map(|number| {
        let is_cavity =
            |&(k, shell): &(usize, &Shell)| shell.volume < 0.0 && shell.parent == Some(number) && k != number;
        let cavities = shells.iter().enumerate().filter(is_cavity).map(|(k, _)| &solids[k]);
        solids[number].subtract(cavities)
    });
    let bodies = bodies.collect::<Result<Vec<Solid>, SolidError>>()?;
    Ok(Solid::union(&bodies)?)
}

/// Whether bodies may share material though their triangles do not cross: in each other, or with faces in one plane.
fn may_overlap(shells: &[Shell]) -> bool {
    let bodies: Vec<&Shell> = shells.iter().filter(|shell| shell.volume > 0.0).collect();
    bodies.iter().enumerate().any(|(k, one)| bodies[k + 1..].iter().any(|other| one.may_touch(other)))
}

/// What a shell encloses, a cavity as if it were a body.
fn solid_of(mesh: &TriangleMesh, shell: &Shell, tangled: bool, fate: &mut Fate) -> Result<Solid, Obstacle> {
    let triangles = shell.triangles.iter().map(|&t| mesh.triangles[t as usize]).collect();
    let mut alone = weld::with_used_vertices(TriangleMesh { vertices: mesh.vertices.clone(), triangles });
    if shell.volume < 0.0 {
        alone.triangles.iter_mut().for_each(orientation::turn);
    }
    if !tangled {
        return Ok(Solid::from_mesh(&alone)?);
    }
    match untangle(&alone) {
        Ok(done) => {
            fate.tangles_parted += done.parted;
            fate.tangles_cut += done.cut;
            fate.displacement = fate.displacement.max(done.displacement);
            Ok(done.solid)
        }
        Err(Tangled::Crossings(left)) => Err(Obstacle::Crossings(left)),
        Err(Tangled::Solid(error)) => Err(error.into()),
    }
}
