//! PLY, ASCII and binary of either byte order: `vertex` with x, y, z, and `face` with a list of corners.
//!
//! Other elements and properties are read past. The header is in `header.rs`, numbers come from `numbers.rs`.

mod header;
mod numbers;

use crate::builder::MeshBuilder;
use crate::error::{Place, ReadError};
use crate::stream::Stream;
use glam::DVec3;
use header::{Element, Property, Shape};
use numbers::Numbers;

/// Reads a PLY file.
pub fn read(stream: Stream, mesh: &mut MeshBuilder) -> Result<(), ReadError> {
    let (header, mut numbers) = header::read(stream)?;
    for element in &header {
        check_count(element, &numbers)?;
        match element.name.as_str() {
            "vertex" => read_vertices(mesh, element, &mut numbers)?,
            "face" => read_faces(mesh, element, &mut numbers)?,
            _ => (0..element.count).try_for_each(|_| pass_over(&element.properties, &mut numbers))?,
        }
    }
    match numbers.is_at_end()? {
        true => Ok(()),
        false => Err(ReadError::new(numbers.place(), "more bytes follow the last element")),
    }
}

/// A count that the rest of the file cannot hold is refused before anything is allocated for it.
fn check_count(element: &Element, numbers: &Numbers) -> Result<(), ReadError> {
    let least: u64 = element.properties.iter().map(|p| numbers.least_bytes(p)).sum();
    // The last number of a text may end with the file rather than with white space.
    let needed = (u64::from(element.count) * least.max(1)).saturating_sub(numbers.spare_bytes());
    if needed <= numbers.remaining() {
        return Ok(());
    }
    let Element { name, count, line, .. } = element;
    let message =
        format!("{count} × `{name}` need {needed} bytes at least, {} are there", numbers.remaining());
    Err(ReadError::new(Place::Line(*line), message)
        .try_this("the file is cut short; copy or export it again"))
}

fn read_vertices(mesh: &mut MeshBuilder, element: &Element, numbers: &mut Numbers) -> Result<(), ReadError> {
    let find = |name: &str| {
        let is_it = |p: &Property| p.name == name && matches!(p.shape, Shape::Scalar(_));
        element.properties.iter().position(is_it).ok_or_else(|| {
            ReadError::new(Place::Line(element.line), format!("`vertex` has no property `{name}`"))
        })
    };
    let axes = [find("x")?, find("y")?, find("z")?];
    for _ in 0..element.count {
        let mut vertex = [0.0; 3];
        for (k, property) in element.properties.iter().enumerate() {
            match (axes.iter().position(|&axis| axis == k), &property.shape) {
                (Some(axis), Shape::Scalar(kind)) => vertex[axis] = numbers.next(*kind)?,
                _ => pass_over(std::slice::from_ref(property), numbers)?,
            }
        }
        mesh.push_vertex(DVec3::from_array(vertex), numbers.place())?;
    }
    Ok(())
}

fn read_faces(mesh: &mut MeshBuilder, element: &Element, numbers: &mut Numbers) -> Result<(), ReadError> {
    let no_corners =
        || ReadError::new(Place::Line(element.line), "`face` has no property list `vertex_indices`");
    let is_corners = |p: &Property| p.name == "vertex_indices" || p.name == "vertex_index";
    let at = element.properties.iter().position(is_corners).ok_or_else(no_corners)?;
    let Shape::List { count, item } = element.properties[at].shape else { return Err(no_corners()) };
    mesh.announce_triangles(u64::from(element.count), Place::Line(element.line))?;
    // A fraction is no index: it becomes −1, which no vertex has.
    let index = |x: f64| if x.fract() == 0.0 { x as i64 } else { -1 };
    let mut corners = Vec::new();
    for _ in 0..element.count {
        pass_over(&element.properties[..at], numbers)?;
        corners.clear();
        for _ in 0..numbers.length(count, item)? {
            corners.push(index(numbers.next(item)?));
        }
        mesh.push_polygon(&corners, numbers.place())?;
        pass_over(&element.properties[at + 1..], numbers)?;
    }
    Ok(())
}

/// Reads values that say nothing about triangles.
fn pass_over(properties: &[Property], numbers: &mut Numbers) -> Result<(), ReadError> {
    for property in properties {
        match property.shape {
            Shape::Scalar(kind) => drop(numbers.next(kind)?),
            Shape::List { count, item } => {
                (0..numbers.length(count, item)?).try_for_each(|_| numbers.next(item).map(drop))?;
            }
        }
    }
    Ok(())
}
