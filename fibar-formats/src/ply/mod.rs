//! PLY, ASCII and binary of either byte order: `vertex` with x, y, z, and `face` with a list of corners.
//!
//! Other elements and properties are read past. The header is in `header.rs`, numbers come from `numbers.rs`.

mod header;
mod numbers;

use crate::error::{Place, ReadError};
use crate::polygon::push_fan;
use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use header::{Element, Property, Shape};
use numbers::Numbers;

/// Reads a PLY file.
pub fn read(bytes: &[u8]) -> Result<TriangleMesh, ReadError> {
    let (header, mut numbers) = header::read(bytes)?;
    let mut mesh = TriangleMesh::default();
    for element in &header {
        check_count(element, &numbers)?;
        match element.name.as_str() {
            "vertex" => read_vertices(&mut mesh, element, &mut numbers)?,
            "face" => read_faces(&mut mesh, element, &mut numbers)?,
            _ => (0..element.count).try_for_each(|_| read_row(element, &mut numbers).map(drop))?,
        }
    }
    match numbers.remaining() {
        0 => Ok(mesh),
        surplus => Err(ReadError::new(numbers.place(), format!("{surplus} bytes follow the last element"))),
    }
}

/// A count that the rest of the file cannot hold is refused before anything is allocated for it.
fn check_count(element: &Element, numbers: &Numbers) -> Result<(), ReadError> {
    let least: u64 = element.properties.iter().map(|p| numbers.least_bytes(p)).sum();
    let needed = u64::from(element.count) * least.max(1);
    if needed <= numbers.remaining() as u64 {
        return Ok(());
    }
    let Element { name, count, line, .. } = element;
    let message =
        format!("{count} × `{name}` need {needed} bytes at least, {} are there", numbers.remaining());
    Err(ReadError::new(Place::Line(*line), message)
        .try_this("the file is cut short; copy or export it again"))
}

fn read_vertices(mesh: &mut TriangleMesh, element: &Element, numbers: &mut Numbers) -> Result<(), ReadError> {
    let find = |name: &str| {
        let index =
            element.properties.iter().position(|p| p.name == name && matches!(p.shape, Shape::Scalar(_)));
        index.ok_or_else(|| {
            ReadError::new(Place::Line(element.line), format!("`vertex` has no property `{name}`"))
        })
    };
    let axes = [find("x")?, find("y")?, find("z")?];
    for _ in 0..element.count {
        let row = read_row(element, numbers)?;
        let vertex = DVec3::from_array(axes.map(|axis| row[axis][0]));
        if !vertex.is_finite() {
            return Err(ReadError::new(numbers.place(), "a vertex is not finite"));
        }
        mesh.vertices.push(vertex);
    }
    Ok(())
}

fn read_faces(mesh: &mut TriangleMesh, element: &Element, numbers: &mut Numbers) -> Result<(), ReadError> {
    let is_corners = |p: &Property| p.name == "vertex_indices" || p.name == "vertex_index";
    let corners = element.properties.iter().position(is_corners).ok_or_else(|| {
        ReadError::new(Place::Line(element.line), "`face` has no property list `vertex_indices`")
    })?;
    for _ in 0..element.count {
        let row = read_row(element, numbers)?;
        // A fraction is no index: it becomes −1, which no vertex has.
        let index = |x: &f64| if x.fract() == 0.0 { *x as i64 } else { -1 };
        let polygon: Vec<i64> = row[corners].iter().map(index).collect();
        push_fan(&mut mesh.triangles, &polygon, mesh.vertices.len(), numbers.place())?;
    }
    Ok(())
}

/// The values of one row: a list per property, of length one for a scalar.
fn read_row(element: &Element, numbers: &mut Numbers) -> Result<Vec<Vec<f64>>, ReadError> {
    element.properties.iter().map(|property| read_property(property, numbers)).collect()
}

fn read_property(property: &Property, numbers: &mut Numbers) -> Result<Vec<f64>, ReadError> {
    match property.shape {
        Shape::Scalar(kind) => Ok(vec![numbers.next(kind)?]),
        Shape::List { count, item } => {
            let length = numbers.next(count)?;
            if length < 0.0 || length.fract() != 0.0 || length > numbers.remaining() as f64 {
                let message =
                    format!("a list of {length} × `{}` does not fit the rest of the file", property.name);
                return Err(ReadError::new(numbers.place(), message));
            }
            (0..length as usize).map(|_| numbers.next(item)).collect()
        }
    }
}
