//! The items of the build, put together: components in their places, one part per mesh of type `model`.

use super::inspector::Inspector;
use super::model::Model;
use super::object::{Kind, Object, Reference, Shape};
use super::rule::Rule;
use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use crate::{Limits, MeshFile, Part};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;

/// Components within components; a deeper nest is no design.
const MOST_DEPTH: usize = 200;

/// Where an object is defined, and its place there. An empty path is the root.
type Key<'m> = (&'m str, usize);

/// All models, with what is below each of their objects.
pub struct Assembly<'m> {
    root: &'m Model,
    others: &'m BTreeMap<String, Model>,
    start: &'m str,
    totals: BTreeMap<Key<'m>, Total>,
}

/// What an object holds, itself and all components below.
#[derive(Clone, Copy)]
struct Total {
    triangles: u64,
    has_other: bool,
    has_unprinted: bool,
    depth: usize,
}

impl<'m> Assembly<'m> {
    /// Sums up every object, in the order of definition: components come after what they reference.
    pub fn new(
        root: &'m Model,
        others: &'m BTreeMap<String, Model>,
        start: &'m str,
    ) -> Result<Assembly<'m>, ReadError> {
        let mut assembly = Assembly { root, others, start, totals: BTreeMap::new() };
        let models = others.iter().map(|(path, model)| (path.as_str(), model)).chain([("", root)]);
        for (path, model) in models {
            for (place, object) in model.resources.objects.iter().enumerate() {
                let total = assembly.total(path, object)?;
                assembly.totals.insert((path, place), total);
            }
        }
        Ok(assembly)
    }

    fn total(&self, path: &'m str, object: &'m Object) -> Result<Total, ReadError> {
        let components = match &object.shape {
            Shape::Mesh(mesh) => {
                let is_printed = object.kind == Kind::Model;
                return Ok(Total {
                    triangles: if is_printed { mesh.triangles.len() as u64 } else { 0 },
                    has_other: object.kind == Kind::Other,
                    has_unprinted: !is_printed,
                    depth: 0,
                });
            }
            Shape::Components(components) => components,
        };
        let mut sum = Total { triangles: 0, has_other: false, has_unprinted: false, depth: 0 };
        for component in components {
            let (key, _) = self.find(path, component, Rule::COMPONENT)?;
            let below = self.totals[&key];
            sum.triangles = sum.triangles.saturating_add(below.triangles);
            sum.has_other |= below.has_other;
            sum.has_unprinted |= below.has_unprinted;
            sum.depth = sum.depth.max(below.depth + 1);
        }
        if sum.depth > MOST_DEPTH {
            let message = format!("components are nested more than {MOST_DEPTH} deep");
            return Err(ReadError::new(Place::File, message).inside(self.part(path)));
        }
        Ok(sum)
    }

    /// The object that a reference in `path` means.
    fn find(
        &self,
        path: &'m str,
        reference: &'m Reference,
        rule: Rule,
    ) -> Result<(Key<'m>, &'m Object), ReadError> {
        let missing = || {
            let message = format!("object {} does not exist", reference.object);
            ReadError::new(Place::File, message).inside(self.part(path)).breaking(rule)
        };
        let (path, model) = match &reference.path {
            Some(other) => self.others.get_key_value(other).map(|(p, m)| (p.as_str(), m)),
            None if path.is_empty() => Some(("", self.root)),
            None => self.others.get_key_value(path).map(|(p, m)| (p.as_str(), m)),
        }
        .ok_or_else(missing)?;
        let place = *model.resources.by_id.get(&reference.object).ok_or_else(missing)?;
        Ok(((path, place), &model.resources.objects[place]))
    }

    fn part(&self, path: &'m str) -> &'m str {
        if path.is_empty() { self.start } else { path }
    }

    /// Everything that the build names, in units of the root.
    pub fn build(&self, limits: &Limits, inspector: &Inspector) -> Result<MeshFile, ReadError> {
        let mut work = Work { mesh: MeshBuilder::new(limits), parts: Vec::new() };
        for item in &self.root.items {
            let (key, object) = self.find("", item, Rule::ITEM)?;
            let total = self.totals[&key];
            if total.has_other {
                let message = format!("item {} is or holds an object of type `other`", item.object);
                let error = ReadError::new(Place::File, message).inside(self.start);
                return Err(error.breaking(Rule::OTHER));
            }
            if total.has_unprinted {
                inspector
                    .note("supports and surfaces are left out: only objects of type `model` are read".into());
            }
            work.mesh.announce_triangles(total.triangles, Place::File)?;
            let transform = item.transform * self.scale(key.0);
            self.push(&mut work, key, object, transform, &[])?;
        }
        let mm_per_unit = Some(self.root.mm_per_unit);
        Ok(MeshFile { mesh: work.mesh.finish(), mm_per_unit, parts: work.parts, notes: Vec::new() })
    }

    /// From the units of another part to those of the root.
    fn scale(&self, path: &str) -> DAffine3 {
        let scale = self.others.get(path).map_or(1.0, |model| model.mm_per_unit / self.root.mm_per_unit);
        DAffine3::from_scale(DVec3::splat(scale))
    }

    /// Appends an object and what is below it. `names` are those of the objects that hold it.
    fn push(
        &self,
        work: &mut Work,
        key: Key<'m>,
        object: &'m Object,
        root_from_object: DAffine3,
        names: &[&'m str],
    ) -> Result<(), ReadError> {
        if self.totals[&key].triangles == 0 {
            return Ok(());
        }
        let names: Vec<&str> = names.iter().copied().chain(object.name.as_deref()).collect();
        let components = match &object.shape {
            Shape::Mesh(mesh) => return work.push_mesh(mesh, object, root_from_object, &names),
            Shape::Components(components) => components,
        };
        for component in components {
            let (below, object) = self.find(key.0, component, Rule::COMPONENT)?;
            let mut transform = component.transform;
            if below.0 != key.0 {
                transform *= self.scale(below.0);
            }
            self.push(work, below, object, root_from_object * transform, &names)?;
        }
        Ok(())
    }
}

/// What has been put together so far.
struct Work {
    mesh: MeshBuilder,
    parts: Vec<Part>,
}

impl Work {
    fn push_mesh(
        &mut self,
        mesh: &TriangleMesh,
        object: &Object,
        root_from_mesh: DAffine3,
        names: &[&str],
    ) -> Result<(), ReadError> {
        let (vertices, first_triangle) = (self.mesh.vertex_count() as u32, self.mesh.triangle_count());
        for &vertex in &mesh.vertices {
            self.mesh.push_vertex(root_from_mesh.transform_point3(vertex), Place::File)?;
        }
        // Section 3.3: a mirror does not turn a shape inside out.
        let is_mirrored = root_from_mesh.matrix3.determinant() < 0.0;
        for &[a, b, c] in &mesh.triangles {
            let corners = if is_mirrored { [a, c, b] } else { [a, b, c] };
            self.mesh.push_triangle(corners.map(|corner| corner + vertices), Place::File)?;
        }
        // The innermost name is the part's own.
        let name = names.last().copied().unwrap_or_default().to_string();
        let triangles = first_triangle..self.mesh.triangle_count();
        self.parts.push(Part { name, colour: object.colour, triangles });
        Ok(())
    }
}
