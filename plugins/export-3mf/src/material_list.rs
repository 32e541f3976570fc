//! The base materials of the file: one per role, and one more for the skin of every part that has a colour of its own.
//!
//! A display colour is for screens (3MF Core 5.1): what is printed is the role's material, which the name tells.

use crate::part::Part;
use fibar_core::material::Role;

/// A base material.
#[derive(Clone, Debug, PartialEq)]
pub struct Base {
    /// `skin: VeroPureWhite RGD837`, `skin of roof: VeroPureWhite RGD837`.
    pub name: String,
    /// sRGB with alpha, 0–255.
    pub colour: [u8; 4],
}

/// The base materials of these parts: those of the roles first, in their order.
pub fn bases(parts: &[Part]) -> Vec<Base> {
    let of_role = |role: &Role| Base {
        name: format!("{}: {}", role.name(), role.material().name),
        colour: role.material().colour_srgba,
    };
    let mut bases: Vec<Base> = Role::ALL.iter().map(of_role).collect();
    for base in parts.iter().filter_map(own_base) {
        if !bases.contains(&base) {
            bases.push(base);
        }
    }
    bases
}

/// Place of a part's material among the bases.
pub fn index(part: &Part, bases: &[Base]) -> usize {
    let own = own_base(part).and_then(|own| bases.iter().position(|base| *base == own));
    own.unwrap_or(part.role_index())
}

fn own_base(part: &Part) -> Option<Base> {
    let (colour, label) = (part.colour?, part.label.as_ref()?);
    let byte = |channel: f64| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
    let name = format!("{} of {label}: {}", part.role.name(), part.role.material().name);
    (part.role == Role::Skin).then(|| Base { name, colour: colour.map(byte) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::part::tests::tetrahedron;

    #[test]
    fn only_the_skin_of_a_coloured_part_has_a_material_of_its_own() {
        let coloured = |role, label: &str| Part {
            label: Some(label.into()),
            colour: Some([1.0, 0.5, 0.0, 1.0]),
            ..tetrahedron(role)
        };
        let parts = [coloured(Role::Skin, "roof"), coloured(Role::Filler, "roof"), tetrahedron(Role::Skin)];
        let bases = bases(&parts);
        assert_eq!(
            bases[5..],
            [Base { name: "skin of roof: VeroPureWhite RGD837".into(), colour: [255, 128, 0, 255] }]
        );
        assert_eq!(parts.each_ref().map(|part| index(part, &bases)), [5, 4, 3]);
    }
}
