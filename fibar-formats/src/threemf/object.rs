//! `resources`: groups of properties, and objects made of a mesh or of components.

use super::inspector::Inspector;
use super::mesh::{self, open_only};
use super::number::{colour, id, index, matrix};
use super::rule::Rule;
use super::xml::{Namespace, Xml};
use crate::Limits;
use crate::builder::MeshBuilder;
use crate::error::ReadError;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeMap;

/// Groups of properties by id.
pub type Groups = BTreeMap<u32, Group>;

/// A group of properties that objects and triangles reference.
pub enum Group {
    /// Base materials, with their display colours.
    Base(Vec<Option<[f64; 4]>>),
    /// A group of colours.
    Colours(Vec<Option<[f64; 4]>>),
    /// Of an extension: its members are not known.
    Foreign,
}

impl Group {
    /// Whether it has such a member.
    pub fn holds(&self, place: u32) -> bool {
        match self {
            Group::Base(members) | Group::Colours(members) => (place as usize) < members.len(),
            Group::Foreign => true,
        }
    }

    fn colour(&self, place: u32) -> Option<[f64; 4]> {
        match self {
            Group::Base(members) | Group::Colours(members) => *members.get(place as usize)?,
            Group::Foreign => None,
        }
    }
}

/// An object.
pub struct Object {
    /// Its name, or part number.
    pub name: Option<String>,
    /// Function in the model.
    pub kind: Kind,
    /// Colour for screens, sRGB and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
    /// What it is made of.
    pub shape: Shape,
}

/// The function of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Is printed.
    Model,
    /// Holds others up: `support` and `solidsupport`.
    Support,
    /// A surface without volume.
    Surface,
    /// Not printed.
    Other,
}

/// What an object is made of.
pub enum Shape {
    /// Triangles, in the units of the model.
    Mesh(TriangleMesh),
    /// Other objects.
    Components(Vec<Reference>),
}

/// An object in its place.
pub struct Reference {
    /// The part of the package that defines it, if not this one.
    pub path: Option<String>,
    /// Its id.
    pub object: u32,
    /// To where it is used.
    pub transform: DAffine3,
}

/// The objects of a model part.
#[derive(Default)]
pub struct Resources {
    /// In the order of their definition.
    pub objects: Vec<Object>,
    /// Place in `objects` by id.
    pub by_id: BTreeMap<u32, usize>,
    groups: Groups,
    /// Thumbnails that objects name.
    pub thumbnails: Vec<String>,
}

impl Resources {
    /// Reads the open `resources` element.
    pub fn read(xml: &mut Xml, limits: &Limits, inspector: &Inspector) -> Result<Resources, ReadError> {
        xml.allow(&[])?;
        let mut resources = Resources::default();
        while xml.open_child()? {
            match (xml.element.namespace, xml.element.name()) {
                (Namespace::Core, "object") => resources.read_object(xml, limits)?,
                (Namespace::Core, "basematerials") => {
                    // The schema wants materials first; reading does not depend on it.
                    let id = resources.new_id(xml)?;
                    let group = Group::Base(read_colours(xml, "base", "displaycolor")?);
                    resources.groups.insert(id, group);
                }
                (Namespace::Materials, "colorgroup") => {
                    let id = resources.new_id(xml)?;
                    let group = Group::Colours(read_colours(xml, "color", "color")?);
                    resources.groups.insert(id, group);
                }
                (Namespace::Core | Namespace::None, _) => return Err(xml.misplaced()),
                _ => {
                    if xml.element.get("id").is_some() {
                        let id = resources.new_id(xml)?;
                        resources.groups.insert(id, Group::Foreign);
                        inspector.note(format!("<{}> is passed over", xml.element.name()));
                    }
                    xml.skip()?;
                }
            }
        }
        Ok(resources)
    }

    /// The id of the open element, which no resource has yet.
    fn new_id(&self, xml: &Xml) -> Result<u32, ReadError> {
        let text = xml.require("id")?;
        let id = id(text).ok_or_else(|| xml.error(format!("`{text}` is no id")).breaking(Rule::ID))?;
        if self.by_id.contains_key(&id) || self.groups.contains_key(&id) {
            return Err(xml.error(format!("the id {id} is there already")).breaking(Rule::ID_UNIQUE));
        }
        Ok(id)
    }

    fn read_object(&mut self, xml: &mut Xml, limits: &Limits) -> Result<(), ReadError> {
        xml.allow(&["id", "type", "thumbnail", "partnumber", "name", "pid", "pindex"])?;
        let id = self.new_id(xml)?;
        let type_name = xml.element.get("type").unwrap_or("model").to_string();
        let kind = kind_of(&type_name).ok_or_else(|| {
            xml.error(format!("there is no type `{type_name}`")).breaking(Rule::OBJECT_TYPE)
        })?;
        let name = xml.element.get("name").or(xml.element.get("partnumber")).map(str::to_string);
        self.thumbnails.extend(xml.element.get("thumbnail").map(str::to_string));
        let has_property = xml.element.get("pid").is_some() || xml.element.get("pindex").is_some();
        let (pid, colour) = self.property(xml)?;
        let is_solid = matches!(type_name.as_str(), "model" | "solidsupport");
        let is_model = kind == Kind::Model;
        let mut shape = None;
        while xml.open_child()? {
            match (xml.element.namespace, xml.element.name()) {
                (Namespace::Core, "metadatagroup") if shape.is_none() => xml.skip()?,
                (Namespace::Core, "mesh") if shape.is_none() => {
                    let context = mesh::Context { id, groups: &self.groups, pid, is_solid, is_model };
                    shape = Some(Shape::Mesh(mesh::read(xml, MeshBuilder::new(limits), &context)?));
                }
                (Namespace::Core, "components") if shape.is_none() => {
                    if has_property {
                        xml.breach(Rule::COMPONENTS_PID, "its object has pid or pindex")?;
                    }
                    shape = Some(Shape::Components(self.read_components(xml)?));
                }
                (Namespace::Core | Namespace::None, _) => return Err(xml.misplaced()),
                _ => xml.skip()?,
            }
        }
        let missing =
            || xml.error(format!("object {id} has neither mesh nor components")).breaking(Rule::SCHEMA);
        self.by_id.insert(id, self.objects.len());
        self.objects.push(Object { name, kind, colour, shape: shape.ok_or_else(missing)? });
        Ok(())
    }

    /// The group of the open object, and the colour that it names in it.
    fn property(&self, xml: &Xml) -> Result<(Option<u32>, Option<[f64; 4]>), ReadError> {
        let (pid, pindex) = (xml.element.get("pid"), xml.element.get("pindex"));
        if pid.is_none() && pindex.is_some() {
            xml.breach(Rule::PINDEX, "it has no pid")?;
        }
        let Some(text) = pid else { return Ok((None, None)) };
        let Some((pid, group)) = id(text).and_then(|pid| Some((pid, self.groups.get(&pid)?))) else {
            xml.breach(Rule::PROPERTY, format!("group `{text}` does not exist"))?;
            return Ok((None, None));
        };
        let Some(text) = pindex else { return Ok((Some(pid), None)) };
        let place = index(text).filter(|&place| group.holds(place));
        if place.is_none() {
            xml.breach(Rule::PROPERTY, format!("property `{text}` does not exist"))?;
        }
        Ok((Some(pid), place.and_then(|place| group.colour(place))))
    }

    fn read_components(&self, xml: &mut Xml) -> Result<Vec<Reference>, ReadError> {
        xml.allow(&[])?;
        let mut components = Vec::new();
        while open_only(xml, "component")? {
            xml.allow(&["objectid", "transform"])?;
            let reference = read_reference(xml)?;
            if reference.path.is_none() && !self.by_id.contains_key(&reference.object) {
                let message = format!("object {} is not defined before", reference.object);
                return Err(xml.error(message).breaking(Rule::COMPONENT));
            }
            components.push(reference);
            xml.close()?;
        }
        match components.is_empty() {
            true => Err(xml.error("there is no component").breaking(Rule::SCHEMA)),
            false => Ok(components),
        }
    }
}

/// `objectid`, `transform` and the production extension's `path` of a component or item.
pub fn read_reference(xml: &Xml) -> Result<Reference, ReadError> {
    let text = xml.require("objectid")?;
    let object = id(text).ok_or_else(|| xml.error(format!("`{text}` is no id")).breaking(Rule::ID))?;
    let transform =
        match xml.element.get("transform") {
            None => DAffine3::IDENTITY,
            Some(text) => affine(matrix(text).ok_or_else(|| {
                xml.error("its transform does not have twelve numbers").breaking(Rule::MATRIX)
            })?),
        };
    let determinant = transform.matrix3.determinant();
    if determinant == 0.0 || !determinant.is_finite() {
        return Err(xml.error("its transform makes the object flat (3MF Core 3.3)"));
    }
    let path = xml.element.get_in(Namespace::Production, "path").map(str::to_string);
    Ok(Reference { path, object, transform })
}

/// Section 3.3 writes points as rows: (x y z 1) times four rows of three.
fn affine(m: [f64; 12]) -> DAffine3 {
    let row = |k: usize| DVec3::new(m[3 * k], m[3 * k + 1], m[3 * k + 2]);
    DAffine3 { matrix3: DMat3::from_cols(row(0), row(1), row(2)), translation: row(3) }
}

fn kind_of(name: &str) -> Option<Kind> {
    match name {
        "model" => Some(Kind::Model),
        "solidsupport" | "support" => Some(Kind::Support),
        "surface" => Some(Kind::Surface),
        "other" => Some(Kind::Other),
        _ => None,
    }
}

/// The members of a group of materials or colours.
fn read_colours(xml: &mut Xml, member: &str, attribute: &str) -> Result<Vec<Option<[f64; 4]>>, ReadError> {
    let namespace = xml.element.namespace;
    let mut colours = Vec::new();
    while xml.open_child()? {
        if (xml.element.namespace, xml.element.name()) != (namespace, member) {
            return Err(xml.misplaced());
        }
        if namespace == Namespace::Core {
            xml.allow(&["name", "displaycolor"])?;
            if xml.element.get("name").is_none() || xml.element.get("displaycolor").is_none() {
                xml.breach(Rule::BASE, "its name or displaycolor is missing")?;
            }
        }
        let text = xml.element.get(attribute);
        let value = text.and_then(colour);
        if text.is_some() && value.is_none() {
            xml.breach(Rule::COLOUR, format!("`{}` is no colour", text.unwrap_or_default()))?;
        }
        colours.push(value);
        xml.close()?;
    }
    match colours.is_empty() {
        true => Err(xml.error("the group is empty").breaking(Rule::SCHEMA)),
        false => Ok(colours),
    }
}
