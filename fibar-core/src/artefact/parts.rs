//! `parts.json`: which triangles of a mesh belong to which object of the user's file, and what it is called.
//!
//! The mesh is the `mesh` that the same stage wrote. Later stages change triangles, not places: whoever needs the parts of a
//! body or of its solids finds them again by where the parts are.

use super::document;
use super::mesh::TriangleMesh;
use serde::{Deserialize, Serialize};

/// The parts of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parts {
    /// `"fibar.parts/1"`.
    pub format: String,
    /// In the order of their triangles, which they share out without gap.
    pub parts: Vec<Part>,
}

/// One part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Its name, or that of what it belongs to; empty if neither has one.
    pub label: String,
    /// Red, green, blue (sRGB) and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
    /// Its first triangle in the mesh.
    pub first_triangle: usize,
    /// How many triangles it has.
    pub triangles: usize,
    /// Volume inside the triangles, mm³; negative if it is inside out.
    pub volume_mm3: f64,
    /// Edges that are not shared by exactly two triangles, one in each direction; none where that was not counted.
    pub open_edges: Option<usize>,
}

impl Parts {
    /// A document of the current format.
    pub fn new(parts: Vec<Part>) -> Parts {
        Parts { format: "fibar.parts/1".into(), parts }
    }

    /// Whether any part has a name.
    pub fn are_named(&self) -> bool {
        self.parts.iter().any(|part| !part.label.is_empty())
    }
}

impl Part {
    /// The triangles of the part with the vertices that they use.
    ///
    /// The error says that the mesh is not the one that the part belongs to.
    pub fn mesh(&self, whole: &TriangleMesh) -> Result<TriangleMesh, String> {
        let end = self.first_triangle.checked_add(self.triangles);
        let triangles = end.and_then(|end| whole.triangles.get(self.first_triangle..end));
        let triangles =
            triangles.ok_or_else(|| format!("the mesh has no triangles for the part \"{}\"", self.label))?;
        let mut place = vec![u32::MAX; whole.vertices.len()];
        let mut mesh = TriangleMesh::default();
        for triangle in triangles {
            mesh.triangles.push(triangle.map(|corner| {
                let place = &mut place[corner as usize];
                if *place == u32::MAX {
                    *place = mesh.vertices.len() as u32;
                    mesh.vertices.push(whole.vertices[corner as usize]);
                }
                *place
            }));
        }
        Ok(mesh)
    }
}

document!(Parts, "fibar.parts/1", |document| {
    let mut next = 0usize;
    for (k, part) in document.parts.iter().enumerate() {
        if part.first_triangle != next {
            return Err(format!("parts[{k}] begins at triangle {}, not {next}", part.first_triangle));
        }
        if part.triangles == 0 || !part.volume_mm3.is_finite() {
            return Err(format!("parts[{k}] has no triangles, or no volume"));
        }
        next = next
            .checked_add(part.triangles)
            .ok_or_else(|| format!("parts[{k}] has more triangles than can be counted"))?;
        let is_colour = |colour: [f64; 4]| colour.iter().all(|channel| (0.0..=1.0).contains(channel));
        if !part.colour.is_none_or(is_colour) {
            return Err(format!("parts[{k}].colour must be four numbers from 0 to 1"));
        }
    }
    Ok(())
});

#[cfg(test)]
mod tests {
    use super::*;
    use crate::artefact::Document;
    use glam::DVec3;

    fn part(first_triangle: usize, triangles: usize) -> Part {
        let colour = Some([1.0, 0.5, 0.0, 1.0]);
        Part { label: "a".into(), colour, first_triangle, triangles, volume_mm3: 1.0, open_edges: None }
    }

    #[test]
    fn parts_share_out_the_triangles() {
        let check =
            |parts: Vec<Part>, says: &str| match Parts::from_json(&Parts::new(parts.clone()).to_json()) {
                Ok(read) => assert_eq!((read.parts, says), (parts, "")),
                Err(error) => assert!(!says.is_empty() && error.to_string().contains(says), "{error}"),
            };
        check(vec![], "");
        check(vec![part(0, 2), part(2, 1)], "");
        check(vec![part(0, 2), part(1, 1)], "parts[1] begins at triangle 1, not 2");
        check(vec![part(0, 0)], "parts[0] has no triangles");
        check(vec![part(0, usize::MAX), part(usize::MAX, 1)], "more triangles than");
        check(vec![Part { colour: Some([2.0; 4]), ..part(0, 1) }], "colour");
    }

    #[test]
    fn a_part_takes_its_own_vertices_along() {
        let whole = TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 1, 2], [3, 1, 2]],
        };
        let mesh = part(1, 1).mesh(&whole).unwrap();
        assert_eq!(
            mesh,
            TriangleMesh { vertices: vec![DVec3::Z, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] }
        );
        assert!(part(1, 2).mesh(&whole).is_err() && part(usize::MAX, 2).mesh(&whole).is_err());
    }
}
