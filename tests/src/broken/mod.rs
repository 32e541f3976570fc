//! Meshes broken in known ways, with what a repair must make of them.

pub mod shapes;
pub mod ways;

mod large;
mod many;
mod simple;

use crate::judge::{Judgement, filled_volume};
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// A mesh to repair.
#[derive(Clone)]
pub struct Case {
    /// Name of its file.
    pub name: &'static str,
    /// What is wrong with it.
    pub what: &'static str,
    /// The mesh as people get it; coordinates are those of single precision.
    pub mesh: TriangleMesh,
    /// What must come out.
    pub truth: Truth,
}

/// What is known of the object that a broken mesh stands for.
#[derive(Clone)]
pub struct Truth {
    /// The mesh before it was broken, where there was one.
    pub sound: Option<TriangleMesh>,
    /// Volume, mm³.
    pub volume: f64,
    /// Bodies, cavities and handles.
    pub shape: Shape,
}

/// How a solid hangs together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Outward shells.
    pub bodies: usize,
    /// Inward shells.
    pub cavities: usize,
    /// Handles of all shells together; unknown for some.
    pub genus: Option<i64>,
}

/// Sound meshes, every single fault, combinations; none of 50,000 triangles.
pub fn cases() -> Vec<Case> {
    [simple::sound(), simple::open(), simple::wrong(), many::shells(), many::crossing(), large::combined()]
        .concat()
}

/// Meshes of a hundred thousand triangles and more.
pub fn large_cases() -> Vec<Case> {
    large::large()
}

impl Case {
    /// A sound mesh, and what became of it.
    fn new(name: &'static str, what: &'static str, sound: &TriangleMesh, mesh: TriangleMesh) -> Case {
        let sound = single(sound.clone());
        let seen = Judgement::of(&sound);
        let truth = Truth { volume: seen.volume, shape: seen.shape, sound: Some(sound) };
        Case { name, what, mesh: single(mesh), truth }
    }

    /// A closed mesh that overlaps itself, and what became of it: whatever its shells surround is one body.
    fn overlapping(
        names: [&'static str; 2],
        genus: Option<i64>,
        filled: &TriangleMesh,
        mesh: TriangleMesh,
    ) -> Case {
        let shape = Shape { bodies: 1, cavities: 0, genus };
        let volume = filled_volume(&single(filled.clone()));
        let [name, what] = names;
        Case { name, what, mesh: single(mesh), truth: Truth { volume, shape, sound: None } }
    }
}

/// Coordinates as a file of single precision keeps them.
fn single(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.vertices.iter_mut().for_each(|v| *v = DVec3::from_array(v.to_array().map(|x| f64::from(x as f32))));
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_sound_is_sound_and_names_are_names() {
        let cases = cases();
        let mut names: Vec<&str> = cases.iter().map(|case| case.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), cases.len());
        for case in &cases {
            let Some(sound) = &case.truth.sound else { continue };
            let seen = Judgement::of(sound);
            assert!(seen.is_manifold && seen.crossings == 0 && seen.volume > 0.0, "{}: {seen:?}", case.name);
        }
    }
}
