//! The body on the table: a flat base at z = 0, centred in x and y.

use fibar_core::artefact::mesh::TriangleMesh;
use fibar_plugin::StageError;
use fibar_solid::{Solid, SolidError};
use glam::DVec3;

/// Coordinates this close to the plane of the cut are rounding, mm; they become 0.
const ROUNDING_MM: f64 = 1e-9;

/// Cuts `flatten_mm` off the bottom of a closed mesh and moves the rest; centred by its bounding box. With it how far it moved, mm.
pub fn seat(closed: TriangleMesh, flatten_mm: f64) -> Result<(TriangleMesh, DVec3), StageError> {
    let (low, high) = closed.bounds().ok_or_else(|| StageError::input("the mesh encloses no volume"))?;
    let height = high.z - low.z;
    if flatten_mm >= height {
        let message = format!(
            "cutting {flatten_mm} mm off the bottom leaves nothing: the object is {height:.3} mm high"
        );
        return Err(StageError::user(message).param("/flatten_base_mm").hint("cut off less"));
    }
    if flatten_mm <= 0.0 {
        return Ok(centre(closed));
    }
    let solid = Solid::from_mesh(&closed).map_err(internal)?;
    let cut = solid.trim(DVec3::Z, low.z + flatten_mm);
    Ok(centre(cut.and_then(|cut| cut.to_mesh()).map_err(internal)?))
}

/// Moves a body onto the table, centred by its bounding box; with how far, mm.
fn centre(mut mesh: TriangleMesh) -> (TriangleMesh, DVec3) {
    let (low, high) = mesh.bounds().unwrap_or_default();
    let origin = ((low + high) * 0.5).with_z(low.z);
    for vertex in &mut mesh.vertices {
        *vertex -= origin;
        if vertex.z.abs() < ROUNDING_MM {
            vertex.z = 0.0;
        }
    }
    (mesh, -origin)
}

fn internal(error: SolidError) -> StageError {
    StageError::internal(format!("cutting the base: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_body_stands_on_a_flat_base() {
        let corners: Vec<DVec3> =
            [[0.1, 0.2, 3.0], [8.3, 0.0, 5.0], [0.0, 7.7, 5.1], [9.0, 9.0, 5.3], [4.0, 4.0, 15.0]]
                .map(DVec3::from)
                .into();
        let solid = Solid::hull(&corners).unwrap();
        let mesh = solid.to_mesh().unwrap();
        let (body, moved) = seat(mesh.clone(), 4.0).unwrap();
        let (low, high) = body.bounds().unwrap();
        assert!(low.z == 0.0 && (high.z - 8.0).abs() < 1e-12);
        assert!(((low + high).truncate()).length() < 1e-12);
        assert!((moved.z + 7.0).abs() < 1e-12);
        assert!(body.vertices.iter().filter(|v| v.z == 0.0).count() >= 3);
        let cut = Solid::from_mesh(&body).unwrap();
        assert!(cut.volume() < solid.volume() && cut.volume() > 0.3 * solid.volume());
        assert!(seat(mesh.clone(), 12.5).unwrap_err().to_string().contains("leaves nothing"));
        assert_eq!(seat(mesh, 0.0).unwrap().0.bounds().unwrap().1.z, 12.0);
    }
}
