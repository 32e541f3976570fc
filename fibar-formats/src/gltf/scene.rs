//! The nodes of a scene, put together: one part per node with a mesh.

use super::accessor::{Source, missing};
use super::document::{Document, Node, Primitive};
use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use crate::{Limits, MeshFile, Part};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

const MM_PER_METRE: f64 = 1000.0;
/// +Y up becomes +Z up: (x, y, z) → (x, −z, y).
const Z_UP_FROM_Y_UP: DMat3 = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y);

/// Reads the document's scene; without one, every node that is no child.
pub fn read(document: &Document, buffers: &[Vec<u8>], limits: &Limits) -> Result<MeshFile, ReadError> {
    let source = Source { document, buffers, most: limits.triangles.saturating_mul(3) };
    let mut work = Work { source, mesh: MeshBuilder::new(limits), file: MeshFile::default() };
    let mut visited = vec![false; document.nodes.0.len()];
    let up = DAffine3::from_mat3(Z_UP_FROM_Y_UP);
    // A stack of its own: a nest of nodes may be deep.
    let mut open: Vec<(usize, DAffine3)> = roots(document)?.into_iter().rev().map(|k| (k, up)).collect();
    while let Some((index, scene_from_parent)) = open.pop() {
        let node = document.nodes.0.get(index).ok_or_else(|| missing("nodes", index))?;
        let inside = |error: ReadError| match error.part {
            None => error.inside(format!("nodes[{index}]")),
            Some(_) => error,
        };
        if std::mem::replace(&mut visited[index], true) {
            return Err(inside(ReadError::new(Place::File, "it has two parents, or holds itself")));
        }
        let scene_from_node = scene_from_parent * transform(node);
        work.push_node(node, scene_from_node).map_err(inside)?;
        open.extend(node.children.0.iter().rev().map(|&child| (child, scene_from_node)));
    }
    let mesh = work.mesh.finish();
    Ok(MeshFile { mesh, mm_per_unit: Some(MM_PER_METRE), ..work.file })
}

fn roots(document: &Document) -> Result<Vec<usize>, ReadError> {
    if let Some(index) = document.scene.or((!document.scenes.0.is_empty()).then_some(0)) {
        let scene = document.scenes.0.get(index).ok_or_else(|| missing("scenes", index))?;
        return Ok(scene.nodes.0.clone());
    }
    let mut is_child = vec![false; document.nodes.0.len()];
    for &child in document.nodes.0.iter().flat_map(|node| &node.children.0) {
        *is_child.get_mut(child).ok_or_else(|| missing("nodes", child))? = true;
    }
    Ok((0..is_child.len()).filter(|&k| !is_child[k]).collect())
}

/// To the parent: a matrix by columns, or translation · rotation · scale.
fn transform(node: &Node) -> DAffine3 {
    if let Some(matrix) = &node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(matrix));
    }
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = DQuat::from_xyzw(x, y, z, w);
    let rotation = if rotation.length() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    let scale = DVec3::from(node.scale.unwrap_or([1.0; 3]));
    DAffine3::from_scale_rotation_translation(scale, rotation, node.translation.unwrap_or([0.0; 3]).into())
}

/// What has been put together so far.
struct Work<'a> {
    source: Source<'a>,
    mesh: MeshBuilder,
    file: MeshFile,
}

impl Work<'_> {
    fn push_node(&mut self, node: &Node, scene_from_node: DAffine3) -> Result<(), ReadError> {
        let Some(index) = node.mesh else { return Ok(()) };
        let document = self.source.document;
        let mesh = document.meshes.0.get(index).ok_or_else(|| missing("meshes", index))?;
        if node.skin.is_some() {
            self.note("skins are left out: a skinned mesh is read as it rests");
        }
        let first = self.mesh.triangle_count();
        for (k, primitive) in mesh.primitives.0.iter().enumerate() {
            let inside = |error: ReadError| match error.part {
                None => error.inside(format!("meshes[{index}].primitives[{k}]")),
                Some(_) => error,
            };
            self.push_primitive(primitive, scene_from_node).map_err(inside)?;
        }
        let name = node.name.as_ref().or(mesh.name.as_ref()).cloned().unwrap_or_default();
        let material = mesh.primitives.0.iter().find_map(|primitive| primitive.material);
        let colour = material.and_then(|k| self.colour(k));
        let triangles = first..self.mesh.triangle_count();
        if !triangles.is_empty() {
            self.file.parts.push(Part { name, colour, triangles });
        }
        Ok(())
    }

    fn push_primitive(&mut self, primitive: &Primitive, scene_from_node: DAffine3) -> Result<(), ReadError> {
        let mode = primitive.mode.unwrap_or(4);
        let Some(position) = primitive.attributes.position.filter(|_| (4..=6).contains(&mode)) else {
            self.note("points, lines and primitives without positions are left out");
            return Ok(());
        };
        let positions = self.source.positions(position)?;
        let count = positions.len() as u32;
        let corners = match primitive.indices {
            Some(index) => self.source.indices(index)?,
            None => (0..count).collect(),
        };
        let first = self.mesh.vertex_count() as u32;
        for position in positions {
            self.mesh.push_vertex(scene_from_node.transform_point3(position), Place::File)?;
        }
        let is_mirrored = scene_from_node.matrix3.determinant() < 0.0;
        for [a, b, c] in triangles(mode, &corners) {
            if let Some(stray) = [a, b, c].into_iter().find(|&corner| corner >= count) {
                let message = format!("vertex {stray} does not exist, there are {count}");
                return Err(ReadError::new(Place::File, message));
            }
            let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
            self.mesh.push_triangle(corners.map(|corner| first + corner), Place::File)?;
        }
        Ok(())
    }

    /// A material's base colour; glTF has it linear, parts have it in sRGB.
    fn colour(&self, material: usize) -> Option<[f64; 4]> {
        let [r, g, b, a] = self.source.document.materials.0.get(material)?.surface.as_ref()?.base_colour?;
        let encode = |x: f64| {
            let x = x.clamp(0.0, 1.0);
            let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 };
            (encoded * 1e6).round() / 1e6
        };
        Some([encode(r), encode(g), encode(b), a.clamp(0.0, 1.0)])
    }

    fn note(&mut self, note: &str) {
        if !self.file.notes.iter().any(|other| other == note) {
            self.file.notes.push(note.into());
        }
    }
}

/// Corners by triangles: a list (mode 4), a strip (5) or a fan (6).
fn triangles(mode: u32, corners: &[u32]) -> Vec<[u32; 3]> {
    let at = |k: usize| corners[k];
    let count = corners.len();
    match mode {
        4 => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
        5 => (2..count)
            .map(|k| if k % 2 == 0 { [at(k - 2), at(k - 1), at(k)] } else { [at(k - 1), at(k - 2), at(k)] })
            .collect(),
        _ => (2..count).map(|k| [at(0), at(k - 1), at(k)]).collect(),
    }
}
