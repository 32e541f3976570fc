//! The container: one JSON chunk that describes, one binary chunk that holds positions, normals and indices.

use crate::material;
use crate::shaded::ShadedMesh;
use fibar_core::material::Role;
use fibar_plugin::StageError;
use serde_json::{Value, json};

/// One solid to draw.
pub struct Part {
    /// `core-led0`, `skin`, …
    pub name: String,
    /// Decides the material.
    pub role: Role,
    /// Its mesh.
    pub mesh: ShadedMesh,
}

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The whole file.
pub fn pack(parts: &[Part]) -> Result<Vec<u8>, StageError> {
    let mut buffer = Buffer::default();
    let material_of = |part: &Part| roles(parts).take_while(|role| *role != part.role).count();
    let meshes: Vec<Value> = parts.iter().map(|part| mesh(part, material_of(part), &mut buffer)).collect();
    let node = |(k, part): (usize, &Part)| json!({ "name": part.name, "mesh": k });
    let mut nodes: Vec<Value> = parts.iter().enumerate().map(node).collect();
    nodes.push(json!({ "name": "fibar object", "children": (0..parts.len()).collect::<Vec<_>>() }));
    let description = json!({
        "asset": { "version": "2.0", "generator": "fibar export-gltf" },
        "extensionsUsed": material::EXTENSIONS,
        "scene": 0,
        "scenes": [{ "nodes": [parts.len()] }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": roles(parts).map(material::of).collect::<Vec<_>>(),
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    container(&description.to_string(), &buffer.bytes)
}

/// The roles that occur, in their own order.
fn roles(parts: &[Part]) -> impl Iterator<Item = Role> {
    Role::ALL.into_iter().filter(|role| parts.iter().any(|part| part.role == *role))
}

fn mesh(part: &Part, material: usize, buffer: &mut Buffer) -> Value {
    let ShadedMesh { positions, normals, triangles } = &part.mesh;
    let position = buffer.push_vectors(positions);
    let (low, high) = bounds(positions);
    buffer.accessors[position]["min"] = json!(low);
    buffer.accessors[position]["max"] = json!(high);
    let normal = buffer.push_vectors(normals);
    let indices = buffer.push_indices(triangles);
    json!({
        "name": part.name,
        "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal },
            "indices": indices,
            "material": material,
        }],
    })
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let first = positions[0];
    positions.iter().fold((first, first), |(low, high), p| {
        ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
    })
}

/// The binary chunk under construction, with the views and accessors into it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn push_vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bytes = vectors.iter().flatten().flat_map(|x| x.to_le_bytes());
        self.push(bytes, VERTICES, json!({ "componentType": FLOAT, "type": "VEC3", "count": vectors.len() }))
    }

    fn push_indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let bytes = triangles.iter().flatten().flat_map(|v| v.to_le_bytes());
        let count = triangles.len() * 3;
        self.push(bytes, INDICES, json!({ "componentType": UNSIGNED_INT, "type": "SCALAR", "count": count }))
    }

    /// Appends data with a view of its own; every component is four bytes, so alignment comes by itself.
    fn push(&mut self, bytes: impl Iterator<Item = u8>, target: u32, mut accessor: Value) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({ "buffer": 0, "byteOffset": offset, "byteLength": length, "target": target }));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

fn container(description: &str, binary: &[u8]) -> Result<Vec<u8>, StageError> {
    let padding = " ".repeat(description.len().next_multiple_of(4) - description.len());
    let text_length = description.len() + padding.len();
    let total = 12 + 8 + text_length + 8 + binary.len();
    let total = u32::try_from(total).map_err(|_| {
        StageError::resource("the solids do not fit into the 4 GB of a GLB file")
            .hint("make them with coarser triangles")
    })?;
    let mut bytes = Vec::with_capacity(total as usize);
    bytes.extend(b"glTF");
    bytes.extend(2u32.to_le_bytes());
    bytes.extend(total.to_le_bytes());
    bytes.extend((text_length as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(description.as_bytes());
    bytes.extend(padding.as_bytes());
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    Ok(bytes)
}
