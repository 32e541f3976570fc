//! Parts of the user's file that stay free of markers: by their label or by their colour, as a modeller painted them.
//!
//! Parts belong to the mesh that the source wrote. The body is that mesh repaired, cut off at the bottom and moved (`repair-manifold`);
//! how far it was moved is found from the boxes around both.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_core::artefact::parts::{Part, Parts};
use fibar_geometry::distance::Surface;
use fibar_plugin::StageError;
use glam::DVec3;

/// How far a place on the body may lie from where the source had it, mm: repair moves corners a little.
const MOVED: f64 = 0.05;

/// The parts without markers, in the source's frame.
pub struct ForbiddenParts {
    surfaces: Vec<Surface>,
    body_from_source: DVec3,
}

impl ForbiddenParts {
    /// The named parts of a source: its mesh and its parts.
    pub fn find(
        names: &[String],
        source: Option<(&TriangleMesh, &Parts)>,
        body: &TriangleMesh,
    ) -> Result<ForbiddenParts, StageError> {
        if names.is_empty() {
            return Ok(ForbiddenParts { surfaces: Vec::new(), body_from_source: DVec3::ZERO });
        }
        let Some((mesh, parts)) = source else {
            return Err(StageError::user(
                "keep_out_parts names parts, but the source of this object has none",
            )
            .param("/keep_out_parts")
            .hint("formats with parts are STEP, 3MF, glTF and build123d's; keep_out takes boxes"));
        };
        let mut surfaces = Vec::new();
        for (k, name) in names.iter().enumerate() {
            let named: Vec<&Part> = parts.parts.iter().filter(|part| is_called(part, name)).collect();
            if named.is_empty() {
                return Err(unknown(name, parts).param(format!("/keep_out_parts/{k}")));
            }
            for part in named {
                let mesh = part.mesh(mesh).map_err(StageError::input)?;
                surfaces.push(Surface::new(&mesh).map_err(|e| StageError::input(e.to_string()))?);
            }
        }
        Ok(ForbiddenParts { surfaces, body_from_source: offset(mesh, body)? })
    }

    /// Whether a place of the body lies on one of them.
    pub fn contains(&self, place: DVec3) -> bool {
        let place = place - self.body_from_source;
        self.surfaces.iter().any(|surface| surface.closest_within(place, MOVED).is_some())
    }
}

/// Whether a part has this label, or this colour written as `#rrggbb`.
fn is_called(part: &Part, name: &str) -> bool {
    part.label == name || part.colour.is_some_and(|c| hex(c).eq_ignore_ascii_case(name))
}

fn hex([red, green, blue, _]: [f64; 4]) -> String {
    let byte = |c: f64| (c.clamp(0.0, 1.0) * 255.0).round() as u8;
    format!("#{:02x}{:02x}{:02x}", byte(red), byte(green), byte(blue))
}

fn unknown(name: &str, parts: &Parts) -> StageError {
    let call = |part: &Part| match part.colour {
        Some(colour) => format!("\"{}\" {}", part.label, hex(colour)),
        None => format!("\"{}\"", part.label),
    };
    let known: Vec<String> = parts.parts.iter().map(call).collect();
    StageError::user(format!("the source has no part \"{name}\""))
        .hint(format!("it has {}: a label or a colour names one", known.join(", ")))
}

/// From the source's frame to the body's: the top stays at the same height over the cut, the middle of what is left over z = 0.
fn offset(source: &TriangleMesh, body: &TriangleMesh) -> Result<DVec3, StageError> {
    let nothing = || StageError::input("the body is empty");
    let (_, source_high) = source.bounds().ok_or_else(nothing)?;
    let (low, high) = body.bounds().ok_or_else(nothing)?;
    let cut = source_high.z - (high.z - low.z);
    let above = |t: usize| clipped(source.corners(t), cut);
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (left_low, left_high) =
        (0..source.triangles.len()).flat_map(above).fold(empty, |(low, high), p| (low.min(p), high.max(p)));
    let shift = (low + high - left_low - left_high) / 2.0;
    Ok(DVec3::new(shift.x, shift.y, high.z - source_high.z))
}

/// The corners of what a horizontal plane leaves of a triangle above it.
fn clipped(corners: [DVec3; 3], cut: f64) -> Vec<DVec3> {
    let mut left = Vec::new();
    for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (corners[a], corners[b])) {
        if a.z >= cut {
            left.push(a);
        }
        if (a.z < cut) != (b.z < cut) {
            left.push(a.lerp(b, (cut - a.z) / (b.z - a.z)));
        }
    }
    left
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::box_mesh;

    /// A slab 40 × 40 × 10 with a box 20 × 20 × 30 beside it, and the body that is left of it above z = 4.
    fn source() -> (TriangleMesh, Parts, TriangleMesh) {
        let mut mesh = box_mesh(DVec3::new(40.0, 40.0, 10.0));
        let mut tower = box_mesh(DVec3::new(20.0, 20.0, 30.0));
        tower.vertices.iter_mut().for_each(|v| v.x += 60.0);
        let part = |label: &str, colour, first_triangle| Part {
            label: label.into(),
            colour,
            first_triangle,
            triangles: 12,
            volume_mm3: 1.0,
            open_edges: None,
        };
        let parts = Parts::new(vec![part("slab", None, 0), part("tower", Some([1.0, 0.5, 0.0, 1.0]), 12)]);
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(tower.vertices);
        mesh.triangles.extend(tower.triangles.iter().map(|t| t.map(|v| v + first)));
        let mut body = mesh.clone();
        body.vertices.iter_mut().for_each(|v| *v = DVec3::new(v.x - 40.0, v.y - 20.0, (v.z - 4.0).max(0.0)));
        (mesh, parts, body)
    }

    #[test]
    fn places_of_the_body_are_found_on_parts_of_the_source() {
        let (mesh, parts, body) = source();
        let check = |name: &str, place: [f64; 3], on_it: bool| {
            let found = ForbiddenParts::find(&[name.into()], Some((&mesh, &parts)), &body).unwrap();
            assert_eq!(found.contains(place.into()), on_it, "{name} {place:?}");
        };
        check("tower", [30.0, -10.0, 26.0], true);
        check("#ff8000", [30.0, -10.0, 26.0], true);
        check("slab", [30.0, -10.0, 26.0], false);
        check("slab", [-20.0, 0.0, 6.0], true);
        check("tower", [-20.0, 0.0, 6.0], false);
    }

    #[test]
    fn what_is_not_there_is_named() {
        let (mesh, parts, body) = source();
        let check = |source: Option<(&TriangleMesh, &Parts)>, says: &str| {
            let error = ForbiddenParts::find(&["door".into()], source, &body).err().unwrap().to_string();
            assert!(error.contains(says), "{error:?} does not say {says:?}");
        };
        check(Some((&mesh, &parts)), "no part \"door\"");
        check(None, "the source of this object has none");
        assert!(!ForbiddenParts::find(&[], None, &body).unwrap().contains(DVec3::ZERO));
    }
}
