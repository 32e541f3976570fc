//! A solid: a closed, oriented mesh that booleans may be asked of.

use crate::SolidError;
use crate::bridge::ffi;
use crate::specks::drop_specks;
use cxx::UniquePtr;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;

/// A valid solid, possibly empty. Every operation gives a valid solid or an error, never an invalid one.
///
/// Evaluated eagerly: what an operation costs, it costs there.
pub struct Solid(UniquePtr<ffi::Manifold>);

// SAFETY: an evaluated Manifold is immutable but for caches, which upstream guards by mutexes and atomics; its
// documentation allows const access from many threads, and nothing here hands out mutable access.
unsafe impl Send for Solid {}
unsafe impl Sync for Solid {}

impl Solid {
    /// The empty solid.
    pub fn empty() -> Solid {
        Solid::from_mesh(&TriangleMesh::default()).expect("no triangle breaks no rule")
    }

    /// Takes a mesh whose triangles share vertices by index; coincident vertices are not merged.
    pub fn from_mesh(mesh: &TriangleMesh) -> Result<Solid, SolidError> {
        let vertices: Vec<f64> = mesh.vertices.iter().flat_map(|v| v.to_array()).collect();
        let triangles: Vec<u64> = mesh.triangles.iter().flatten().map(|&v| u64::from(v)).collect();
        checked(ffi::solid_from_mesh(&vertices, &triangles))
    }

    /// Convex hull; empty when the points span no volume.
    pub fn hull(points: &[DVec3]) -> Result<Solid, SolidError> {
        let flat: Vec<f64> = points.iter().flat_map(|v| v.to_array()).collect();
        let hull = checked(ffi::hull_of_points(&flat))?;
        // Manifold gives a flat hull for flat points.
        if hull.volume() > 0.0 { Ok(hull) } else { Ok(Solid::empty()) }
    }

    /// The surface: one vertex per place of the 2-manifold, triangles counter-clockwise from outside.
    pub fn to_mesh(&self) -> Result<TriangleMesh, SolidError> {
        let buffers = ffi::mesh_of(&self.0)?;
        let vertices = buffers.vertices.chunks_exact(3).map(DVec3::from_slice).collect();
        let triangles = buffers.triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        Ok(TriangleMesh { vertices, triangles })
    }

    /// Whether it encloses nothing.
    pub fn is_empty(&self) -> bool {
        self.triangle_count() == 0
    }

    /// Number of triangles of its surface.
    pub fn triangle_count(&self) -> usize {
        ffi::triangle_count(&self.0)
    }

    /// Enclosed volume, mm³.
    pub fn volume(&self) -> f64 {
        ffi::volume_of(&self.0)
    }

    /// Area of its surface, mm².
    pub fn surface_area(&self) -> f64 {
        ffi::surface_area_of(&self.0)
    }

    /// Number of handles: `1 − (vertices − edges + triangles) / 2` over the whole surface, so negative for several shells.
    pub fn genus(&self) -> i32 {
        ffi::genus_of(&self.0)
    }

    /// Lengths below which Manifold takes features for noise, mm.
    pub fn tolerance(&self) -> f64 {
        ffi::tolerance_of(&self.0)
    }

    /// Least and greatest coordinates, mm; `None` when empty.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        (!self.is_empty()).then(|| (ffi::lower_corner(&self.0).into(), ffi::upper_corner(&self.0).into()))
    }

    /// What is in any of the solids.
    pub fn union<'a>(solids: impl IntoIterator<Item = &'a Solid>) -> Result<Solid, SolidError> {
        combine(solids, ffi::Operation::Union)
    }

    /// What is in both.
    pub fn intersect(&self, other: &Solid) -> Result<Solid, SolidError> {
        combine([self, other], ffi::Operation::Intersection)
    }

    /// What is in `self` and in none of the others.
    pub fn subtract<'a>(&'a self, others: impl IntoIterator<Item = &'a Solid>) -> Result<Solid, SolidError> {
        combine(std::iter::once(self).chain(others), ffi::Operation::Difference)
    }

    /// Moves it by a vector, mm.
    pub fn translate(&self, by: DVec3) -> Result<Solid, SolidError> {
        checked(ffi::translated(&self.0, by.into()))
    }

    /// Keeps the part where `normal · x ≥ offset`, mm along the unit normal.
    pub fn trim(&self, normal: DVec3, offset: f64) -> Result<Solid, SolidError> {
        checked(ffi::trimmed(&self.0, normal.into(), offset))
    }

    /// Drops detail below a length, mm: collapses short edges and flat vertices.
    pub fn simplify(&self, tolerance: f64) -> Result<Solid, SolidError> {
        checked(ffi::simplified(&self.0, tolerance))
    }

    /// Sets the length below which later operations take features for noise, mm.
    pub fn with_tolerance(&self, tolerance: f64) -> Result<Solid, SolidError> {
        checked(ffi::with_tolerance(&self.0, tolerance))
    }

    /// Its disconnected shells. A cavity is a shell of its own, with a negative volume.
    pub fn components(&self) -> Result<Vec<Solid>, SolidError> {
        let pile = ffi::components_of(&self.0)?;
        Ok(pile.iter().map(|part| Solid(ffi::copy_of(part))).collect())
    }

    /// Without shells that enclose less than a volume, mm³: flakes are left out, cavities filled.
    pub fn without_specks(&self, volume: f64) -> Result<Solid, SolidError> {
        match drop_specks(&self.to_mesh()?, volume) {
            Some(mesh) => Solid::from_mesh(&mesh),
            None => Ok(self.clone()),
        }
    }

    /// Minkowski difference with a convex body that holds the origin: the places at which that body fits inside.
    ///
    /// One hull per triangle and their union: minutes for meshes of 10⁴ triangles.
    pub fn erode(&self, ball: &Solid) -> Result<Solid, SolidError> {
        checked(ffi::eroded(&self.0, &ball.0))
    }
}

impl Clone for Solid {
    fn clone(&self) -> Self {
        Solid(ffi::copy_of(&self.0))
    }
}

impl std::fmt::Debug for Solid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Solid({} triangles, {} mm³)", self.triangle_count(), self.volume())
    }
}

fn combine<'a>(
    solids: impl IntoIterator<Item = &'a Solid>,
    operation: ffi::Operation,
) -> Result<Solid, SolidError> {
    let mut pile = ffi::new_pile();
    solids.into_iter().for_each(|solid| ffi::push(pile.pin_mut(), &solid.0));
    checked(ffi::combined(&pile, operation))
}

/// Turns exceptions and error statuses into errors.
fn checked(made: Result<UniquePtr<ffi::Manifold>, cxx::Exception>) -> Result<Solid, SolidError> {
    let solid = made?;
    match SolidError::from_status(ffi::status_of(&solid)?) {
        None => Ok(Solid(solid)),
        Some(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(low: DVec3, high: DVec3) -> Solid {
        let corner =
            |k: usize| DVec3::from_array(std::array::from_fn(|axis| [low, high][k >> axis & 1][axis]));
        Solid::hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap()
    }

    /// Volume mm³, area mm², genus and shells of a solid.
    fn check(solid: &Solid, volume: f64, area: f64, genus: i32, shells: usize) {
        assert!((solid.volume() - volume).abs() < 1e-9, "{solid:?}");
        assert!((solid.surface_area() - area).abs() < 1e-9, "{solid:?}");
        assert_eq!((solid.genus(), solid.components().unwrap().len()), (genus, shells), "{solid:?}");
        let again = Solid::from_mesh(&solid.to_mesh().unwrap()).unwrap();
        assert_eq!((again.volume(), again.triangle_count()), (solid.volume(), solid.triangle_count()));
    }

    #[test]
    fn booleans_give_the_volumes_of_sets() {
        let cube = block(DVec3::ZERO, DVec3::splat(3.0));
        let drill = block(DVec3::new(1.0, 1.0, -1.0), DVec3::new(2.0, 2.0, 4.0));
        let core = block(DVec3::ONE, DVec3::splat(2.0));
        check(&cube, 27.0, 54.0, 0, 1);
        check(&cube.subtract([&drill]).unwrap(), 24.0, 64.0, 1, 1);
        check(&cube.intersect(&drill).unwrap(), 3.0, 14.0, 0, 1);
        check(&Solid::union([&cube, &drill]).unwrap(), 29.0, 62.0, 0, 1);
        check(&Solid::union([&core, &core.translate(DVec3::X * 5.0).unwrap()]).unwrap(), 2.0, 12.0, -1, 2);
        check(&cube.subtract([&core]).unwrap(), 26.0, 60.0, -1, 2);
        check(&cube.trim(DVec3::Z, 1.0).unwrap(), 18.0, 42.0, 0, 1);
        check(&cube.erode(&core.translate(DVec3::splat(-1.5)).unwrap()).unwrap(), 8.0, 24.0, 0, 1);
        assert_eq!(cube.bounds(), Some((DVec3::ZERO, DVec3::splat(3.0))));
    }

    #[test]
    fn nothing_is_a_solid_too() {
        let cube = block(DVec3::ZERO, DVec3::ONE);
        let nothing = [
            Solid::empty(),
            Solid::union([]).unwrap(),
            cube.intersect(&cube.translate(DVec3::X * 2.0).unwrap()).unwrap(),
            cube.trim(DVec3::Z, 2.0).unwrap(),
            Solid::hull(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE - DVec3::Z]).unwrap(),
        ];
        for solid in nothing {
            assert!(solid.is_empty() && solid.bounds().is_none() && solid.volume() == 0.0);
            assert_eq!(solid.to_mesh().unwrap(), TriangleMesh::default());
        }
    }

    #[test]
    fn broken_meshes_are_errors_not_empty_solids() {
        let check = |break_it: &dyn Fn(&mut TriangleMesh), expected: SolidError| {
            let mut mesh = block(DVec3::ZERO, DVec3::ONE).to_mesh().unwrap();
            break_it(&mut mesh);
            assert_eq!(Solid::from_mesh(&mesh).unwrap_err(), expected);
        };
        check(&|mesh| mesh.triangles.truncate(11), SolidError::NotManifold);
        check(&|mesh| mesh.triangles[0].swap(0, 1), SolidError::NotManifold);
        check(&|mesh| mesh.triangles[0][0] = 99, SolidError::VertexOutOfBounds);
        check(&|mesh| mesh.vertices[3].y = f64::NAN, SolidError::NonFiniteVertex);
        check(&|mesh| mesh.vertices[3].y = f64::INFINITY, SolidError::NonFiniteVertex);
    }

    #[test]
    fn an_error_inside_manifold_is_a_value() {
        let mesh = TriangleMesh { vertices: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]; 3] };
        assert!(Solid::from_mesh(&mesh).is_err());
        assert!(Solid::hull(&[DVec3::splat(f64::NAN); 9]).is_ok_and(|solid| solid.is_empty()));
    }
}
