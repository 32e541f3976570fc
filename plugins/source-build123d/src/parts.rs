//! `fibar.parts/1`: which triangles of the mesh belong to which solid of the script or assembly.

use serde::Serialize;

/// The solids of a mesh, in the order of their triangles.
#[derive(Debug, PartialEq, Serialize)]
pub struct Parts {
    format: &'static str,
    /// One entry per solid.
    pub parts: Vec<Part>,
}

/// One solid.
#[derive(Debug, PartialEq, Serialize)]
pub struct Part {
    /// Its name, or that of its assembly; empty if neither has one.
    pub label: String,
    /// Red, green, blue (sRGB) and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
    /// Its first triangle in the mesh.
    pub first_triangle: usize,
    /// How many triangles it has.
    pub triangles: usize,
    /// Volume inside the triangles, mm³.
    pub volume_mm3: f64,
    /// Edges that are not shared by exactly two triangles, one in each direction; 0 for a watertight solid.
    pub open_edges: usize,
}

impl Parts {
    /// These parts, in the order of their triangles.
    pub fn new(parts: Vec<Part>) -> Parts {
        Parts { format: "fibar.parts/1", parts }
    }

    /// Pretty JSON.
    pub fn to_json(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(self).expect("parts are plain data");
        bytes.push(b'\n');
        bytes
    }
}
