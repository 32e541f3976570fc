//! Readers of the mesh files people have: bytes in, triangles or a located error out. None of them touches a file.
//!
//! Files are streamed: what is held of one does not grow with it, its mesh aside (and glTF's buffers, which are looked into at
//! random). Counts are checked against the bytes that are there before anything is allocated for them.

mod gltf;
mod obj;
mod off;
mod ply;
mod stl;
pub mod threemf;

mod builder;
mod error;
mod stream;
mod words;

pub use error::{Place, ReadError};

use builder::MeshBuilder;
use fibar_core::artefact::mesh::TriangleMesh;
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use stream::Stream;

/// A mesh file as it is written: nothing is welded, mended or placed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// All triangles, in the file's unit; +Z up where the format says what is up.
    pub mesh: TriangleMesh,
    /// Length of a 1, mm, where the format says it.
    pub mm_per_unit: Option<f64>,
    /// Named objects, where the format has them, in the order of their triangles.
    pub parts: Vec<Part>,
    /// What was left out or let pass.
    pub notes: Vec<String>,
}

/// An object of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its name; empty if it has none.
    pub name: String,
    /// Red, green, blue (sRGB) and opacity from 0 to 1.
    pub colour: Option<[f64; 4]>,
    /// Its triangles.
    pub triangles: Range<usize>,
}

/// How much a file may ask for, and get away with.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Most triangles; each takes up to 84 bytes.
    pub triangles: u64,
    /// Breaches of 3MF rules that `repair-manifold` can mend, or that change nothing here, become notes.
    pub mends_3mf: bool,
    /// Corners of exactly equal coordinates become one where the format knows no shared ones (STL), in the order of their first use.
    pub shares_corners: bool,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits { triangles: 10_000_000, mends_3mf: false, shares_corners: false }
    }
}

/// The formats, by the extensions of their files.
pub const EXTENSIONS: [&str; 7] = ["stl", "obj", "ply", "off", "3mf", "glb", "gltf"];

/// Reads a mesh in the format that `extension` names (any case). What it holds beyond the mesh is bounded.
pub fn read<R: Read + Seek>(mut source: R, extension: &str, limits: &Limits) -> Result<MeshFile, ReadError> {
    let length = source.seek(SeekFrom::End(0)).and_then(|length| source.rewind().map(|()| length));
    let length = length.map_err(|e| ReadError::new(Place::File, format!("it cannot be read: {e}")))?;
    if length == 0 {
        return Err(ReadError::new(Place::File, "it is empty").try_this("export the object again"));
    }
    let file = match extension.to_ascii_lowercase().as_str() {
        "obj" => read_bare(obj::read, &mut source, length, limits),
        "stl" => read_bare(stl::read, &mut source, length, limits),
        "ply" => read_bare(ply::read, &mut source, length, limits),
        "off" => read_bare(off::read, &mut source, length, limits),
        "3mf" => threemf::read(source, length, limits),
        "glb" | "gltf" => gltf::read(&mut source, length, limits),
        other => Err(ReadError::new(Place::File, format!("`.{other}` is not a mesh format known here"))
            .try_this(format!("use .{}", EXTENSIONS.join(", .")))),
    }?;
    if file.mesh.triangles.is_empty() {
        let error = ReadError::new(Place::File, "it holds no triangle");
        return Err(error.try_this("export the object as a mesh"));
    }
    Ok(file)
}

/// A format that knows triangles, but neither units nor parts.
fn read_bare(
    read: impl Fn(Stream, &mut MeshBuilder) -> Result<(), ReadError>,
    source: &mut dyn Read,
    length: u64,
    limits: &Limits,
) -> Result<MeshFile, ReadError> {
    let mut mesh = MeshBuilder::new(limits);
    read(Stream::new(source, length), &mut mesh)?;
    Ok(MeshFile { mesh: mesh.finish(), ..MeshFile::default() })
}

#[cfg(test)]
mod tests;
