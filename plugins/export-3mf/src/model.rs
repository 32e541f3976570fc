//! `3D/3dmodel.model`: the XML of the core specification.

use crate::material_list::{Base, bases, index};
use crate::names::escape;
use crate::package::PackedFile;
use crate::part::Part;
use crate::precision::SingleMesh;
use rayon::prelude::*;
use std::fmt::Write;

/// Id of the base materials.
const MATERIALS: usize = 1;
/// Id of the first object.
pub const FIRST_OBJECT: usize = 2;
/// Name of the whole.
pub const NAME: &str = "fibar object";

const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
/// PrusaSlicer applies the build item's transform to all volumes only where this namespace and version are given.
const SLIC3R: &str = r#" xmlns:slic3rpe="http://schemas.slic3r.org/3mf/2017/06""#;
const SLIC3R_VERSION: &str = r#"<metadata name="slic3rpe:Version3mf">1</metadata>"#;

/// One object per part, with its base material, and one object that holds them all as components.
pub fn of_components(parts: &[Part], shift: [f64; 3]) -> PackedFile {
    let bases = bases(parts);
    let objects =
        parts.par_iter().enumerate().map(|(k, part)| object(FIRST_OBJECT + k, part, index(part, &bases)));
    let objects: Vec<String> = objects.collect();
    let whole = FIRST_OBJECT + parts.len();
    let mut xml = opening("", "", &bases);
    xml.extend(objects);
    let _ = write!(xml, r#"<object id="{whole}" type="model" name="{NAME}"><components>"#);
    for k in 0..parts.len() {
        let _ = write!(xml, r#"<component objectid="{}"/>"#, FIRST_OBJECT + k);
    }
    xml.push_str("</components></object>\n");
    xml.push_str(&closing(whole, shift));
    PackedFile { name: "3D/3dmodel.model", text: xml }
}

/// One object with the meshes of all parts after each other, each triangle with its base material; the ranges are in
/// [`crate::slicer_config`].
pub fn of_volumes(parts: &[Part], shift: [f64; 3]) -> PackedFile {
    let bases = bases(parts);
    let starts = parts.iter().scan(0, |next, part| {
        let start = *next;
        *next += part.mesh.vertices.len() as u32;
        Some(start)
    });
    let starts: Vec<u32> = starts.collect();
    let vertices: Vec<String> = parts.par_iter().map(|part| vertices(&part.mesh)).collect();
    let triangle_lists = parts.par_iter().zip(&starts).map(|(part, start)| {
        let material = format!(r#" pid="{MATERIALS}" p1="{}""#, index(part, &bases));
        triangles(&part.mesh, *start, &material)
    });
    let triangle_lists: Vec<String> = triangle_lists.collect();
    let mut xml = opening(SLIC3R, SLIC3R_VERSION, &bases);
    let _ = write!(
        xml,
        r#"<object id="{FIRST_OBJECT}" type="model" name="{NAME}" pid="{MATERIALS}" pindex="0"><mesh><vertices>"#
    );
    xml.extend(vertices);
    xml.push_str("</vertices><triangles>");
    xml.extend(triangle_lists);
    xml.push_str("</triangles></mesh></object>\n");
    xml.push_str(&closing(FIRST_OBJECT, shift));
    PackedFile { name: "3D/3dmodel.model", text: xml }
}

fn opening(namespaces: &str, metadata: &str, bases: &[Base]) -> String {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = write!(xml, r#"<model unit="millimeter" xml:lang="en-US" xmlns="{CORE}"{namespaces}>"#);
    let _ = write!(xml, "\n{metadata}<resources><basematerials id=\"{MATERIALS}\">");
    for Base { name, colour: [r, g, b, a] } in bases {
        let name = escape(name);
        let _ = write!(xml, r##"<base name="{name}" displaycolor="#{r:02X}{g:02X}{b:02X}{a:02X}"/>"##);
    }
    xml.push_str("</basematerials>\n");
    xml
}

fn closing(object: usize, [x, y, z]: [f64; 3]) -> String {
    format!(
        "</resources><build><item objectid=\"{object}\" transform=\"1 0 0 0 1 0 0 0 1 {x} {y} {z}\"/></build></model>\n"
    )
}

fn object(id: usize, part: &Part, material: usize) -> String {
    let name = escape(&part.name);
    let mut xml =
        format!(r#"<object id="{id}" type="model" name="{name}" pid="{MATERIALS}" pindex="{material}">"#);
    xml.push_str("<mesh><vertices>");
    xml.push_str(&vertices(&part.mesh));
    xml.push_str("</vertices><triangles>");
    xml.push_str(&triangles(&part.mesh, 0, ""));
    xml.push_str("</triangles></mesh></object>\n");
    xml
}

/// Shortest decimals that read back as the same single-precision number.
fn vertices(mesh: &SingleMesh) -> String {
    let mut xml = String::with_capacity(mesh.vertices.len() * 56);
    for [x, y, z] in &mesh.vertices {
        let _ = write!(xml, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#);
    }
    xml
}

fn triangles(mesh: &SingleMesh, start: u32, material: &str) -> String {
    let mut xml = String::with_capacity(mesh.triangles.len() * (48 + material.len()));
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|v| v + start);
        let _ = write!(xml, r#"<triangle v1="{a}" v2="{b}" v3="{c}"{material}/>"#);
    }
    xml
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::tetrahedron;
    use fibar_core::material::Role;

    #[track_caller]
    fn check(xml: &str, counts: &[(&str, usize)]) {
        for (text, count) in counts {
            assert_eq!(xml.matches(text).count(), *count, "{text} in {xml}");
        }
    }

    #[test]
    fn components_have_an_object_each_and_volumes_share_one() {
        let parts = [tetrahedron(Role::Core), tetrahedron(Role::Skin)];
        let spec = of_components(&parts, [1.0, 2.5, 0.0]).text;
        check(
            &spec,
            &[("<object ", 3), ("<mesh>", 2), ("<component ", 2), ("<vertex ", 8), ("<triangle ", 8)],
        );
        check(
            &spec,
            &[(r#"name="skin" pid="1" pindex="3""#, 1), (r#"transform="1 0 0 0 1 0 0 0 1 1 2.5 0""#, 1)],
        );
        check(&spec, &[(r#"<vertex x="0.1" y="0.25" z="1.5"/>"#, 2), ("slic3rpe", 0)]);
        let prusa = of_volumes(&parts, [0.0; 3]).text;
        check(
            &prusa,
            &[
                ("<object ", 1),
                ("<vertex ", 8),
                ("<triangle ", 8),
                (r#"v1="4" v2="6" v3="5" pid="1" p1="3""#, 1),
            ],
        );
        check(&prusa, &[(r#"<metadata name="slic3rpe:Version3mf">1</metadata>"#, 1)]);
    }
}
