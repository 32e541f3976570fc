//! Polygons of a file as triangles.

use crate::error::{Place, ReadError};

/// Appends the fan of a polygon about its first corner; right for convex ones, closed for all.
pub fn push_fan(
    triangles: &mut Vec<[u32; 3]>,
    corners: &[i64],
    vertex_count: usize,
    place: Place,
) -> Result<(), ReadError> {
    if corners.len() < 3 {
        return Err(ReadError::new(place, format!("a face needs 3 corners, has {}", corners.len())));
    }
    if let Some(stray) = corners.iter().find(|&&v| v < 0 || v as u64 >= vertex_count as u64) {
        return Err(ReadError::new(
            place,
            format!("vertex {stray} does not exist, there are {vertex_count}"),
        ));
    }
    let corner = |k: usize| corners[k] as u32;
    triangles.extend((1..corners.len() - 1).map(|k| [corner(0), corner(k), corner(k + 1)]));
    Ok(())
}
