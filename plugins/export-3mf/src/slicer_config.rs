//! `Metadata/Slic3r_PE_model.config`: which triangles are which volume, and its extruder.

use crate::model::{FIRST_OBJECT, NAME};
use crate::names::escape;
use crate::package::PackedFile;
use crate::part::Part;
use std::fmt::Write;

/// One volume per part; the extruder is the role's place, from 1: core, cladding, black, skin, filler.
pub fn of(parts: &[Part]) -> PackedFile {
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config>\n");
    let _ = writeln!(xml, r#" <object id="{FIRST_OBJECT}" instances_count="1">"#);
    let _ = writeln!(xml, r#"  <metadata type="object" key="name" value="{NAME}"/>"#);
    let mut first = 0;
    for part in parts {
        let last = first + part.mesh.triangles.len() - 1;
        xml.push_str(&volume(part, first, last));
        first = last + 1;
    }
    xml.push_str(" </object>\n</config>\n");
    PackedFile { name: "Metadata/Slic3r_PE_model.config", text: xml }
}

fn volume(part: &Part, first: usize, last: usize) -> String {
    let datum =
        |key: &str, value: &str| format!("   <metadata type=\"volume\" key=\"{key}\" value=\"{value}\"/>\n");
    let extruder = (part.role_index() + 1).to_string();
    format!(
        "  <volume firstid=\"{first}\" lastid=\"{last}\">\n{}{}{}  </volume>\n",
        datum("name", &escape(&part.name)),
        datum("volume_type", "ModelPart"),
        datum("extruder", &extruder)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::tetrahedron;
    use fibar_core::material::Role;

    #[test]
    fn volumes_follow_each_other_and_know_their_extruder() {
        let text = of(&Role::ALL.map(tetrahedron)).text;
        for (k, role) in Role::ALL.into_iter().enumerate() {
            let range = format!(r#"<volume firstid="{}" lastid="{}">"#, 4 * k, 4 * k + 3);
            let volume = &text[text.find(&range).unwrap()..];
            let volume = &volume[..volume.find("</volume>").unwrap()];
            assert!(volume.contains(&format!(r#"key="name" value="{}""#, role.name())), "{volume}");
            assert!(volume.contains(&format!(r#"key="extruder" value="{}""#, k + 1)), "{volume}");
        }
    }
}
