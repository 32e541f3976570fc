//! What the runner leaves behind, read without trust: `manifest.json` beside raw buffers, or the reason for their absence.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::StageError;
use glam::DVec3;
use serde::Deserialize;
use std::path::Path;

/// A shape as solids.
#[derive(Debug, PartialEq)]
pub struct Shape {
    /// In the order of the script or assembly; at least one.
    pub solids: Vec<Solid>,
    /// The unit of length that a STEP file declares; it has been converted to mm.
    pub unit: Option<String>,
}

/// One solid, its faces not yet welded.
#[derive(Debug, PartialEq)]
pub struct Solid {
    /// Its name, empty if it has none.
    pub label: String,
    /// Red, green, blue (sRGB) and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
    /// Triangles, mm.
    pub mesh: TriangleMesh,
}

/// Why there is no shape.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Refusal {
    /// What is at fault.
    pub kind: RefusalKind,
    /// What is wrong, where.
    pub message: String,
    /// What to try.
    pub hint: Option<String>,
    /// The name of the script parameter at fault.
    pub parameter: Option<String>,
}

/// What is at fault.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RefusalKind {
    /// The user's script.
    Script,
    /// A parameter for it.
    Parameter,
    /// The file.
    File,
    /// Its size, and so perhaps its unit.
    Size,
    /// There are no solids in it.
    NoSolid,
    /// The Python environment.
    Environment,
}

#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Manifest {
    Solids { parts: Vec<Entry>, unit: Option<String> },
    Refused(Refusal),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    label: String,
    colour: Option<[f64; 4]>,
    vertices: usize,
    triangles: usize,
}

/// Reads the folder that the runner filled: a shape, or its own words on why there is none. Anything else is a fault.
pub fn read(folder: &Path) -> Result<Result<Shape, Refusal>, StageError> {
    let text = std::fs::read(folder.join("manifest.json"))?;
    let manifest =
        serde_json::from_slice(&text).map_err(|e| fault(format!("its manifest cannot be read: {e}")))?;
    match manifest {
        Manifest::Refused(refusal) => Ok(Err(refusal)),
        Manifest::Solids { parts, unit } => {
            let (vertices, triangles) =
                (std::fs::read(folder.join("vertices.f64"))?, std::fs::read(folder.join("triangles.u32"))?);
            solids(parts, &vertices, &triangles).map(|solids| Ok(Shape { solids, unit }))
        }
    }
}

const VERTEX_BYTES: usize = 24;
const TRIANGLE_BYTES: usize = 12;

fn solids(entries: Vec<Entry>, mut vertices: &[u8], mut triangles: &[u8]) -> Result<Vec<Solid>, StageError> {
    let mut solids = Vec::with_capacity(entries.len());
    for entry in entries {
        let mesh = TriangleMesh {
            vertices: take(&mut vertices, entry.vertices, VERTEX_BYTES)?
                .chunks_exact(VERTEX_BYTES)
                .map(vertex)
                .collect(),
            triangles: take(&mut triangles, entry.triangles, TRIANGLE_BYTES)?
                .chunks_exact(TRIANGLE_BYTES)
                .map(triangle)
                .collect(),
        };
        check(&mesh)?;
        solids.push(Solid { label: entry.label, colour: entry.colour, mesh });
    }
    if solids.is_empty() || !vertices.is_empty() || !triangles.is_empty() {
        return Err(fault("its buffers hold more than its manifest says".into()));
    }
    Ok(solids)
}

fn take<'a>(buffer: &mut &'a [u8], count: usize, bytes: usize) -> Result<&'a [u8], StageError> {
    let taken = count.checked_mul(bytes).and_then(|size| buffer.split_at_checked(size));
    let (taken, rest) = taken.ok_or_else(|| fault("its buffers hold less than its manifest says".into()))?;
    *buffer = rest;
    Ok(taken)
}

fn vertex(bytes: &[u8]) -> DVec3 {
    let coordinate =
        |k: usize| f64::from_ne_bytes(bytes[8 * k..8 * k + 8].try_into().expect("slices of eight bytes"));
    DVec3::new(coordinate(0), coordinate(1), coordinate(2))
}

fn triangle(bytes: &[u8]) -> [u32; 3] {
    [0, 1, 2].map(|k| u32::from_ne_bytes(bytes[4 * k..4 * k + 4].try_into().expect("slices of four bytes")))
}

fn check(mesh: &TriangleMesh) -> Result<(), StageError> {
    if mesh.triangles.is_empty() || !mesh.vertices.iter().all(|v| v.is_finite()) {
        return Err(fault("a solid has no triangles, or corners that are not finite".into()));
    }
    let known = |v: &u32| (*v as usize) < mesh.vertices.len();
    if !mesh.triangles.iter().flatten().all(known) {
        return Err(fault("a triangle has corners that do not exist".into()));
    }
    Ok(())
}

fn fault(message: String) -> StageError {
    StageError::internal(format!("the CAD kernel's process left something odd: {message}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(manifest: &str, vertices: &[f64], triangles: &[u32], expected: &str) {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
        write("manifest.json", manifest.as_bytes());
        write("vertices.f64", &vertices.iter().flat_map(|x| x.to_ne_bytes()).collect::<Vec<u8>>());
        write("triangles.u32", &triangles.iter().flat_map(|x| x.to_ne_bytes()).collect::<Vec<u8>>());
        let found = match read(folder.path()) {
            Ok(Ok(shape)) => format!("{} solids", shape.solids.len()),
            Ok(Err(refusal)) => format!("refused: {}", refusal.message),
            Err(error) => error.to_string(),
        };
        assert!(found.contains(expected), "{found:?} does not say {expected:?}");
    }

    #[test]
    fn buffers_are_believed_only_as_far_as_they_hold() {
        let three = |counts: &str| {
            format!(r#"{{"solids":{{"parts":[{{"label":"a","colour":null,{counts}}}],"unit":null}}}}"#)
        };
        let good = three(r#""vertices":3,"triangles":1"#);
        let corners = [0., 0., 0., 1., 0., 0., 0., 1., 0.];
        check(&good, &corners, &[0, 1, 2], "1 solids");
        check(&good, &corners[..8], &[0, 1, 2], "less than");
        check(&good, &corners, &[0, 1, 2, 0, 1, 2], "more than");
        check(&good, &corners, &[0, 1, 3], "do not exist");
        check(&good, &[0., 0., 0., 1., f64::NAN, 0., 0., 1., 0.], &[0, 1, 2], "not finite");
        check(&three(r#""vertices":3,"triangles":0"#), &corners, &[], "no triangles");
        check(
            &three(&format!(r#""vertices":{},"triangles":1"#, usize::MAX)),
            &corners,
            &[0, 1, 2],
            "less than",
        );
        check(r#"{"solids":{"parts":[],"unit":null}}"#, &[], &[], "more than");
        check(r#"{"refused":{"kind":"no-solid","message":"only a face"}}"#, &[], &[], "refused: only a face");
        check(r#"{"refused":{"kind":"mood","message":""}}"#, &[], &[], "cannot be read");
        check("{", &[], &[], "cannot be read");
    }
}
