//! What the roles look like.

use fibar_core::material::Role;
use serde_json::{Value, json};

/// Extensions that the materials use.
pub const EXTENSIONS: [&str; 2] = ["KHR_materials_ior", "KHR_materials_transmission"];

/// The glTF material of a role: clear ones let light through by `KHR_materials_transmission`, bent by their index.
pub fn of(role: Role) -> Value {
    let material = role.material();
    let mut value = json!({
        "name": material.name,
        "pbrMetallicRoughness": {
            "baseColorFactor": linear(material.colour_srgba),
            "metallicFactor": 0.0,
            "roughnessFactor": roughness(role),
        },
    });
    if let Some(index) = material.refractive_index {
        value["extensions"] = json!({
            "KHR_materials_ior": { "ior": index },
            "KHR_materials_transmission": { "transmissionFactor": 1.0 - opacity(material.colour_srgba) },
        });
    }
    value
}

fn roughness(role: Role) -> f64 {
    match role {
        Role::Core => 0.05,
        Role::Cladding => 0.3,
        Role::Black | Role::Skin | Role::Filler => 0.8,
    }
}

fn opacity([.., alpha]: [u8; 4]) -> f64 {
    (f64::from(alpha) / 2.55).round() / 100.0
}

/// Linear RGB of an sRGB colour (IEC 61966-2-1), opaque: what shines through is the transmission's part.
fn linear([r, g, b, _]: [u8; 4]) -> [f64; 4] {
    let channel = |byte: u8| {
        let c = f64::from(byte) / 255.0;
        let value = if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) };
        (value * 1e4).round() / 1e4
    };
    [channel(r), channel(g), channel(b), 1.0]
}
