//! The user's parts as regions of the body: what skin and filler are divided by, so that they keep the parts' names.
//!
//! Parts come as triangles of the mesh before its repair; the repair moves but does not turn. Parts of one name are one
//! region, and where parts overlap the first keeps the place.

use fibar_core::artefact::Document;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::{Part, Parts};
use fibar_plugin::{Job, StageError};
use fibar_solid::{Solid, SolidError};
use glam::DVec3;

/// How far body and parts may differ in size, mm: rounding, nothing else.
const SAME_SIZE_MM: f64 = 1e-6;
/// Pieces that come from rounding where faces of body and part coincide, mm³.
const SPECK_MM3: f64 = 1e-6;
/// Share of a solid that may belong to no part.
const MOST_LEFT_OVER: f64 = 1e-3;

/// A name with its colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// What the user calls it; none for all parts without a name.
    pub name: Option<String>,
    /// Red, green, blue (sRGB) and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
}

/// The regions of a body.
#[derive(Default)]
pub struct Regions {
    labels: Vec<Label>,
    /// A solid for each label; none where a single label has the whole body.
    solids: Vec<Solid>,
}

/// A piece of a solid, and whose it is.
pub type Piece = (Option<Label>, Solid);

impl Regions {
    /// From the inputs `parts` and `mesh`; none without named parts.
    pub fn read(job: &Job, body: &TriangleMesh) -> Result<Regions, StageError> {
        let Some(bytes) = job.read_optional("parts")? else { return Ok(Regions::default()) };
        let parts = Parts::from_json(&bytes)?;
        if !parts.are_named() {
            return Ok(Regions::default());
        }
        let mesh = job.read_optional("mesh")?.ok_or_else(|| {
            StageError::user("parts are wired without the mesh that they belong to").hint("wire `mesh`, too")
        })?;
        Regions::of(&parts, &TriangleMesh::from_ply(&mesh)?, body)
    }

    /// The regions of a body that is `mesh`, moved.
    pub fn of(parts: &Parts, mesh: &TriangleMesh, body: &TriangleMesh) -> Result<Regions, StageError> {
        let mut labels: Vec<Label> = Vec::new();
        for part in &parts.parts {
            let label = label(part);
            if !labels.iter().any(|other| other.name == label.name) {
                labels.push(label);
            }
        }
        if labels.len() < 2 {
            return Ok(Regions { labels, solids: Vec::new() });
        }
        let origin = body_origin(mesh, body)?;
        let solids = labels.iter().map(|label| region(label, parts, mesh, origin));
        let solids = solids.collect::<Result<_, StageError>>()?;
        Ok(Regions { labels, solids })
    }

    /// Cuts a solid; empty pieces are left out. What lies in no region stays with the last one, if it is little.
    pub fn divide(&self, what: &str, solid: &Solid) -> Result<Vec<Piece>, StageError> {
        let Some((last, others)) = self.labels.split_last() else { return Ok(vec![(None, solid.clone())]) };
        if self.solids.is_empty() {
            return Ok(vec![(Some(last.clone()), solid.clone())]);
        }
        let failed = |error: SolidError| StageError::internal(format!("dividing the {what}: {error}"));
        let (mut rest, mut pieces) = (solid.clone(), Vec::new());
        for (label, region) in others.iter().zip(&self.solids) {
            pieces.push((Some(label.clone()), rest.intersect(region).map_err(failed)?));
            rest = rest.subtract([region]).map_err(failed)?;
        }
        let left_over = rest.subtract([&self.solids[others.len()]]).map_err(failed)?.volume();
        if left_over > MOST_LEFT_OVER * solid.volume() {
            let message = format!("{left_over:.3} mm³ of the {what} belong to none of the named parts");
            let hint = "parts keep their names only in a body that is not smoothed; leave `parts` unwired to do without";
            return Err(StageError::input(message).hint(hint));
        }
        pieces.push((Some(last.clone()), rest));
        for (_, piece) in &mut pieces {
            *piece = piece.without_specks(SPECK_MM3).map_err(failed)?;
        }
        pieces.retain(|(_, piece)| !piece.is_empty());
        Ok(pieces)
    }
}

fn label(part: &Part) -> Label {
    Label { name: (!part.label.is_empty()).then(|| part.label.clone()), colour: part.colour }
}

/// Where the body's origin lies in the mesh: the middle of the box in x and y; in z what puts the tops together, for the
/// bottom may have been cut off.
fn body_origin(mesh: &TriangleMesh, body: &TriangleMesh) -> Result<DVec3, StageError> {
    let empty = || StageError::input("the mesh or the body is empty");
    let ((low, high), (body_low, body_high)) =
        (mesh.bounds().ok_or_else(empty)?, body.bounds().ok_or_else(empty)?);
    let difference = (high - low - (body_high - body_low)).truncate().abs().max_element();
    if difference > SAME_SIZE_MM {
        let message = format!("the body is {difference:.4} mm wider or narrower than its named parts");
        let hint =
            "parts keep their names only in a body that is not smoothed; leave `parts` unwired to do without";
        return Err(StageError::input(message).hint(hint));
    }
    let z = high.z - body_high.z;
    // To the bit where nothing was cut off, so that faces coincide.
    let z = if (z - low.z).abs() < SAME_SIZE_MM { low.z } else { z };
    Ok(((low + high) * 0.5).with_z(z))
}

/// All parts of a label, united, in the frame of the body.
fn region(label: &Label, parts: &Parts, mesh: &TriangleMesh, origin: DVec3) -> Result<Solid, StageError> {
    let mut solids = Vec::new();
    for part in parts.parts.iter().filter(|part| part.label == label.name.as_deref().unwrap_or_default()) {
        let mut own = part.mesh(mesh).map_err(StageError::input)?.welded();
        own.vertices.iter_mut().for_each(|vertex| *vertex -= origin);
        solids.push(Solid::from_mesh(&own).map_err(|error| not_closed(part, &error))?);
    }
    Solid::union(&solids).map_err(|error| StageError::internal(format!("uniting parts: {error}")))
}

fn not_closed(part: &Part, error: &SolidError) -> StageError {
    let message =
        format!("the part \"{}\" is not closed, so that its name would be lost: {error}", part.label);
    StageError::input(message)
        .hint("make it a solid in the CAD program, or leave `parts` unwired to do without names")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box as twelve triangles.
    fn cuboid(low: [f64; 3], high: [f64; 3]) -> TriangleMesh {
        let corner = |k: usize| {
            DVec3::from([0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] }))
        };
        Solid::hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap().to_mesh().unwrap()
    }

    fn join(named: &[(&str, TriangleMesh)]) -> (Parts, TriangleMesh) {
        let (mut whole, mut parts) = (TriangleMesh::default(), Vec::new());
        for (name, mesh) in named {
            let (first, vertices) = (whole.triangles.len(), whole.vertices.len() as u32);
            whole.vertices.extend(&mesh.vertices);
            whole.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + vertices)));
            parts.push(Part {
                label: name.to_string(),
                colour: None,
                first_triangle: first,
                triangles: mesh.triangles.len(),
                volume_mm3: 1.0,
                open_edges: Some(0),
            });
        }
        (Parts::new(parts), whole)
    }

    fn house() -> [(&'static str, TriangleMesh); 3] {
        let wall = cuboid([10.0, 20.0, 5.0], [20.0, 40.0, 15.0]);
        let chimney = cuboid([12.0, 22.0, 20.0], [14.0, 24.0, 23.0]);
        [("house", wall), ("roof", cuboid([10.0, 20.0, 15.0], [20.0, 40.0, 20.0])), ("roof", chimney)]
    }

    fn centred(low_z: f64, high_z: f64) -> TriangleMesh {
        cuboid([-5.0, -10.0, low_z], [5.0, 10.0, high_z])
    }

    /// Names and volumes of the pieces of a body.
    fn divide(body: &TriangleMesh) -> Result<Vec<(String, f64)>, String> {
        let (parts, mesh) = join(&house());
        let regions = Regions::of(&parts, &mesh, body).map_err(|e| e.to_string())?;
        let pieces = regions.divide("body", &Solid::from_mesh(body).unwrap()).map_err(|e| e.to_string())?;
        let shown =
            |(label, solid): Piece| (label.unwrap().name.unwrap(), (solid.volume() * 1e6).round() / 1e6);
        Ok(pieces.into_iter().map(shown).collect())
    }

    #[test]
    fn pieces_have_the_names_of_their_parts() {
        let whole = Solid::union(&[
            Solid::from_mesh(&centred(0.0, 15.0)).unwrap(),
            Solid::from_mesh(&cuboid([-3.0, -8.0, 15.0], [-1.0, -6.0, 18.0])).unwrap(),
        ])
        .unwrap();
        let body = whole.to_mesh().unwrap();
        assert_eq!(divide(&body).unwrap(), [("house".into(), 2000.0), ("roof".into(), 1012.0)]);
        // Two millimetres less at the bottom.
        let flattened =
            whole.trim(DVec3::Z, 2.0).unwrap().translate(DVec3::Z * -2.0).unwrap().to_mesh().unwrap();
        assert_eq!(divide(&flattened).unwrap(), [("house".into(), 1600.0), ("roof".into(), 1012.0)]);
    }

    #[test]
    fn names_are_not_lost_in_silence() {
        let wider = cuboid([-6.0, -10.0, 0.0], [6.0, 10.0, 18.0]);
        assert!(divide(&wider).unwrap_err().contains("wider or narrower than its named parts"));
        assert!(divide(&centred(0.0, 18.0)).unwrap_err().contains("belong to none of the named parts"));
        let mut open = house();
        open[1].1.triangles.pop();
        let (parts, mesh) = join(&open);
        let error = Regions::of(&parts, &mesh, &centred(0.0, 18.0)).err().unwrap().to_string();
        assert!(error.contains("the part \"roof\" is not closed"), "{error}");
    }

    #[test]
    fn one_name_needs_no_cut() {
        let (parts, mesh) = join(&[("pebble", cuboid([0.0; 3], [1.0; 3]))]);
        let body = Solid::from_mesh(&centred(0.0, 18.0)).unwrap();
        let pieces = Regions::of(&parts, &mesh, &mesh).unwrap().divide("skin", &body).unwrap();
        assert_eq!(pieces[0].0.as_ref().unwrap().name.as_deref(), Some("pebble"));
        assert_eq!((pieces.len(), pieces[0].1.volume()), (1, body.volume()));
    }
}
