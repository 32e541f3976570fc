//! Families: shells that touch each other or lie in each other, and so must be united together or may be left alone.

use crate::heads::Heads;
use crate::nesting::Shell;
use fibar_core::artefact::mesh::TriangleMesh;
use fibar_geometry::crossings::{self, Crossing};

/// Some shells.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Their numbers, in order.
    pub members: Vec<usize>,
    /// Whether none touches another or itself. Of such a family bodies that lie within bodies, and whatever lies in those, are no
    /// members: they fill nothing that is not filled.
    pub is_loose: bool,
}

/// Number of the shell of each triangle.
pub fn shell_numbers(mesh: &TriangleMesh, shells: &[Shell]) -> Vec<usize> {
    let mut numbers = vec![0; mesh.triangles.len()];
    for (number, shell) in shells.iter().enumerate() {
        shell.triangles.iter().for_each(|&t| numbers[t as usize] = number);
    }
    numbers
}

/// The families of nested shells with these crossings; all that are loose are one.
pub fn families(mesh: &TriangleMesh, shells: &[Shell], found: &[Crossing]) -> Vec<Family> {
    let mut heads = Heads::new(shells.len());
    let contacts = contacts(mesh, shells, found);
    let parents = shells.iter().enumerate().filter_map(|(number, shell)| Some([number, shell.parent?]));
    for [one, other] in contacts.iter().copied().chain(parents) {
        heads.join(one as u32, other as u32);
    }
    let heads: Vec<usize> = (0..shells.len()).map(|number| heads.of(number as u32) as usize).collect();
    let mut is_loose = vec![true; shells.len()];
    contacts.iter().for_each(|[one, _]| is_loose[heads[*one]] = false);
    let members =
        |keep: &dyn Fn(usize) -> bool| (0..shells.len()).filter(|&k| keep(k)).collect::<Vec<usize>>();
    let loose = members(&|k| is_loose[heads[k]] && !is_swallowed(k, shells));
    let tight = (0..shells.len()).filter(|&k| heads[k] == k && !is_loose[k]);
    let tight = tight.map(|top| Family { members: members(&|k| heads[k] == top), is_loose: false });
    let loose = Some(Family { members: loose, is_loose: true }).filter(|family| !family.members.is_empty());
    loose.into_iter().chain(tight).collect()
}

/// Whether a shell lies in material: in a body, as a body, or in what lies there.
fn is_swallowed(mut number: usize, shells: &[Shell]) -> bool {
    while let Some(parent) = shells[number].parent {
        if shells[number].volume > 0.0 && shells[parent].volume > 0.0 {
            return true;
        }
        number = parent;
    }
    false
}

/// Pairs of shells that touch, or one twice if it crosses itself.
fn contacts(mesh: &TriangleMesh, shells: &[Shell], found: &[Crossing]) -> Vec<[usize; 2]> {
    let numbers = shell_numbers(mesh, shells);
    let mut contacts: Vec<[usize; 2]> =
        found.iter().map(|crossing| crossing.triangles.map(|t| numbers[t as usize])).collect();
    let boxes_meet =
        || (0..shells.len()).any(|a| (a + 1..shells.len()).any(|b| shells[a].may_touch(&shells[b])));
    if shells.len() > 1 && boxes_meet() {
        let groups: Vec<u32> = numbers.iter().map(|&number| number as u32).collect();
        let pairs = crossings::contacts(mesh, &groups).into_iter();
        contacts.extend(pairs.map(|pair| pair.map(|t| numbers[t as usize])));
    }
    contacts.iter_mut().for_each(|pair| pair.sort_unstable());
    contacts.sort_unstable();
    contacts.dedup();
    contacts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{ball, block, inverted, moved, together};
    use crate::nesting::Nesting;
    use crate::sheets::Sheets;
    use fibar_geometry::crossings::crossings;

    fn check(parts: &[TriangleMesh], expected: &[(&[usize], bool)]) {
        let mut mesh = together(parts);
        let nesting = Nesting::of(&Sheets::of(&mesh), &mut mesh);
        let found: Vec<(Vec<usize>, bool)> = families(&mesh, &nesting.shells, &crossings(&mesh))
            .into_iter()
            .map(|family| (family.members, family.is_loose))
            .collect();
        let expected: Vec<(Vec<usize>, bool)> =
            expected.iter().map(|(m, loose)| (m.to_vec(), *loose)).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn who_touches_nobody_is_left_alone() {
        let cube = |x: f64, half: f64| moved(block([-half; 3], [half; 3]), [x, 0.0, 0.0]);
        check(&[cube(0.0, 1.0)], &[(&[0], true)]);
        check(&[cube(0.0, 1.0), cube(5.0, 1.0)], &[(&[0, 1], true)]);
        check(&[cube(0.0, 1.0), cube(5.0, 1.0), cube(5.5, 1.0)], &[(&[0], true), (&[1, 2], false)]);
        check(&[cube(0.0, 1.0), cube(2.0, 1.0)], &[(&[0, 1], false)]);
        check(&[cube(0.0, 3.0), inverted(cube(0.0, 2.0)), cube(0.0, 1.0)], &[(&[0, 1, 2], true)]);
        check(&[cube(0.0, 3.0), cube(0.0, 2.0), inverted(cube(0.0, 1.0))], &[(&[0], true)]);
        check(&[ball(3.0, 8), ball(1.0, 4), cube(3.0, 0.5)], &[(&[0, 1, 2], false)]);
    }
}
