//! The `mesh` of an object: vertices, triangles, and what section 4.1 asks of them.

use super::number::{index, number};
use super::object::{Group, Groups};
use super::rule::Rule;
use super::xml::{Namespace, Xml};
use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use std::collections::BTreeSet;

/// What the object around a mesh says.
pub struct Context<'c> {
    /// Id of the object.
    pub id: u32,
    /// Groups of properties defined so far.
    pub groups: &'c Groups,
    /// Default group of properties.
    pub pid: Option<u32>,
    /// The mesh must be a solid: the type is `model` or `solidsupport`.
    pub is_solid: bool,
    /// The type is `model`.
    pub is_model: bool,
}

/// Reads the open `mesh` element.
pub fn read(xml: &mut Xml, builder: MeshBuilder, context: &Context) -> Result<TriangleMesh, ReadError> {
    xml.allow(&[])?;
    let mut mesh = builder;
    let mut stage = 0;
    while xml.open_child()? {
        match (xml.element.namespace, xml.element.name(), stage) {
            (Namespace::Core, "vertices", 0) => read_vertices(xml, &mut mesh)?,
            (Namespace::Core, "triangles", 1) => read_triangles(xml, &mut mesh, context)?,
            (Namespace::TriangleSets, "trianglesets", 2) => {
                read_sets(xml, mesh.triangle_count())?;
                continue;
            }
            (Namespace::Core | Namespace::None, ..) => return Err(xml.misplaced()),
            _ => {
                xml.skip()?;
                continue;
            }
        }
        stage += 1;
    }
    if stage < 2 {
        return Err(xml.error("the mesh has no vertices or no triangles").breaking(Rule::SCHEMA));
    }
    if context.is_model && mesh.triangle_count() < 4 {
        xml.breach(Rule::FOUR_TRIANGLES, format!("it has {}", mesh.triangle_count()))?;
    }
    let mesh = mesh.finish();
    if context.is_solid {
        check_edges(xml, &mesh, context.id)?;
    }
    Ok(mesh)
}

fn read_vertices(xml: &mut Xml, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    xml.allow(&[])?;
    while open_only(xml, "vertex")? {
        xml.allow(&["x", "y", "z"])?;
        let coordinate = |name: &str| {
            let text = xml.require(name)?;
            number(text).ok_or_else(|| xml.error(format!("`{text}` is no number")).breaking(Rule::NUMBER))
        };
        let vertex = DVec3::new(coordinate("x")?, coordinate("y")?, coordinate("z")?);
        mesh.push_vertex(vertex, Place::File).map_err(|error| xml.error(error.message.clone()))?;
        xml.close()?;
    }
    match mesh.vertex_count() {
        0..3 => Err(xml.error("a mesh has three vertices at least").breaking(Rule::SCHEMA)),
        _ => Ok(()),
    }
}

fn read_triangles(xml: &mut Xml, mesh: &mut MeshBuilder, context: &Context) -> Result<(), ReadError> {
    xml.allow(&[])?;
    while open_only(xml, "triangle")? {
        xml.allow(&["v1", "v2", "v3", "p1", "p2", "p3", "pid"])?;
        let corners = [corner(xml, "v1", mesh)?, corner(xml, "v2", mesh)?, corner(xml, "v3", mesh)?];
        check_properties(xml, context)?;
        let [a, b, c] = corners;
        if a == b || b == c || c == a {
            xml.breach(Rule::DISTINCT, format!("its corners are {a}, {b}, {c}"))?;
        } else {
            mesh.push_triangle(corners, Place::File).map_err(|error| xml.error(error.message.clone()))?;
        }
        xml.close()?;
    }
    match mesh.triangle_count() {
        0 => Err(xml.error("a mesh has a triangle at least").breaking(Rule::SCHEMA)),
        _ => Ok(()),
    }
}

fn corner(xml: &Xml, name: &str, mesh: &MeshBuilder) -> Result<u32, ReadError> {
    let text = xml.require(name)?;
    let count = mesh.vertex_count();
    match index(text) {
        Some(corner) if (corner as usize) < count => Ok(corner),
        Some(corner) => {
            let message = format!("vertex {corner} does not exist, there are {count}");
            Err(xml.error(message).breaking(Rule::INDEX))
        }
        None => Err(xml.error(format!("`{text}` is no index")).breaking(Rule::INDEX)),
    }
}

/// p1, p2, p3 and pid of a triangle.
fn check_properties(xml: &Xml, context: &Context) -> Result<(), ReadError> {
    let get = |name: &str| xml.element.get(name);
    if get("pid").is_none() && get("p1").is_none() && get("p2").is_none() && get("p3").is_none() {
        return Ok(());
    }
    if context.pid.is_none() {
        xml.breach(Rule::DEFAULT_PROPERTY, "its object has none")?;
    }
    let pid = match get("pid") {
        Some(text) => index(text),
        None => context.pid,
    };
    let Some(group) = pid.and_then(|pid| context.groups.get(&pid)) else {
        return xml.breach(Rule::PROPERTY, "its group of properties does not exist");
    };
    let mut used = Vec::with_capacity(3);
    for text in ["p1", "p2", "p3"].iter().filter_map(|name| get(name)) {
        match index(text) {
            Some(place) if group.holds(place) => used.push(place),
            _ => xml.breach(Rule::PROPERTY, format!("property `{text}` does not exist"))?,
        }
    }
    used.dedup();
    if used.len() > 1 && matches!(group, Group::Base(_)) {
        xml.breach(Rule::GRADIENT, "p1, p2 and p3 differ")?;
    }
    Ok(())
}

/// Triangle sets are checked and passed over: they have no influence on the shape.
fn read_sets(xml: &mut Xml, triangles: usize) -> Result<(), ReadError> {
    let mut identifiers = BTreeSet::new();
    while xml.open_child()? {
        let (name, identifier) = (xml.element.get("name"), xml.element.get("identifier"));
        let is_named = name.is_some_and(|n| !n.is_empty()) && identifier.is_some_and(|i| !i.is_empty());
        let is_new = identifiers.insert(identifier.unwrap_or_default().to_string());
        if !is_named || !is_new {
            xml.breach(Rule::TRIANGLE_SET, "its name or identifier is missing or there already")?;
        }
        while xml.open_child()? {
            for name in ["index", "startindex", "endindex"] {
                let Some(text) = xml.element.get(name) else { continue };
                if index(text).is_none_or(|k| k as usize >= triangles) {
                    xml.breach(Rule::TRIANGLE_SET, format!("triangle `{text}` does not exist"))?;
                }
            }
            xml.skip()?;
        }
    }
    Ok(())
}

/// Moves into the next child, which must be of this name; those of other namespaces are passed over.
pub fn open_only(xml: &mut Xml, name: &str) -> Result<bool, ReadError> {
    while xml.open_child()? {
        match xml.element.namespace {
            Namespace::Core if xml.element.name() == name => return Ok(true),
            Namespace::Core | Namespace::None => return Err(xml.misplaced()),
            _ => xml.skip()?,
        }
    }
    Ok(false)
}

/// Edges on two triangles each, which run along them in opposite directions; a positive volume.
fn check_edges(xml: &Xml, mesh: &TriangleMesh, id: u32) -> Result<(), ReadError> {
    // The lower corner in the high half; the last bit is the direction.
    let key = |a: u32, b: u32| u64::from(a.min(b)) << 32 | u64::from(a.max(b)) << 1 | u64::from(a > b);
    let mut edges: Vec<u64> =
        mesh.triangles.iter().flat_map(|&[a, b, c]| [key(a, b), key(b, c), key(c, a)]).collect();
    edges.sort_unstable();
    for same in edges.chunk_by(|a, b| a >> 1 == b >> 1) {
        let (low, high) = (same[0] >> 32, same[0] >> 1 & 0x7FFF_FFFF);
        if same.len() != 2 {
            let message =
                format!("object {id}: the edge of vertices {low} and {high} is on {} triangles", same.len());
            return xml.breach(Rule::MANIFOLD, message);
        }
        if same[0] == same[1] {
            let message =
                format!("object {id}: both triangles run along vertices {low} and {high} the same way");
            return xml.breach(Rule::ORIENTATION, message);
        }
    }
    let volume = |corners: [DVec3; 3]| corners[0].dot(corners[1].cross(corners[2])) / 6.0;
    let volume: f64 = (0..mesh.triangles.len()).map(|k| volume(mesh.corners(k))).sum();
    match volume < 0.0 {
        true => xml.breach(Rule::OUTWARD, format!("object {id}: the volume is {volume}")),
        false => Ok(()),
    }
}
