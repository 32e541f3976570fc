//! glTF 2.0: `.glb`, and `.gltf` with its buffers inside as data URIs.
//!
//! Only what has a shape is read: triangles of the scene's nodes, their names and base colours. Metres and +Y up become
//! +Z up here; the unit is told to the caller. Buffers are looked into at random, so that they are held in memory whole.

mod accessor;
mod buffer;
mod document;
mod scene;

use crate::error::{Place, ReadError};
use crate::stream::Stream;
use crate::{Limits, MeshFile};
use document::Document;
use std::io::Read;

const MAGIC: &[u8] = b"glTF";
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BINARY_CHUNK: u32 = 0x004E_4942;
/// The longest document; what is bigger belongs into buffers.
const LONGEST_JSON: u64 = 1 << 28;

/// Extensions that may be required: they do not touch the shape, or are understood.
const KNOWN: [&str; 6] =
    ["KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization", "KHR_xmp", "EXT_texture_"];

/// Reads a file of `length` bytes.
pub fn read(source: &mut dyn Read, length: u64, limits: &Limits) -> Result<MeshFile, ReadError> {
    let mut stream = Stream::new(source, length);
    let (json, binary) = match stream.peek(MAGIC.len())?.starts_with(MAGIC) {
        true => read_chunks(&mut stream)?,
        false => (take(&mut stream, length)?, None),
    };
    let document: Document = serde_json::from_slice(&json).map_err(|error| {
        let hint = "glTF is JSON, or begins with `glTF`; export the object again, as .glb";
        ReadError::new(Place::File, format!("it is no glTF document: {error}")).try_this(hint)
    })?;
    drop(json);
    check_version(&document)?;
    let buffers = buffer::read_all(&document, binary)?;
    scene::read(&document, &buffers, limits)
}

/// The two chunks of a GLB: the document, and the first buffer.
fn read_chunks(stream: &mut Stream) -> Result<(Vec<u8>, Option<Vec<u8>>), ReadError> {
    let header = [number(stream)?, number(stream)?, number(stream)?];
    if header[1] != 2 {
        let message = format!("it is version {} of GLB, not 2", header[1]);
        return Err(ReadError::new(Place::Byte(4), message).try_this("export it as glTF 2.0"));
    }
    let left = u64::from(header[2]).saturating_sub(12);
    if left > stream.remaining() {
        let message = format!("it should have {} bytes more", left - stream.remaining());
        return Err(ReadError::new(Place::Byte(8), message).try_this("the file is cut short; copy it again"));
    }
    let (mut json, mut binary) = (None, None);
    while stream.remaining() >= 8 {
        let (place, size, kind) = (Place::Byte(stream.offset()), number(stream)?, number(stream)?);
        let size = u64::from(size);
        if size > stream.remaining() {
            let message = format!("a chunk of {size} bytes does not fit the file");
            return Err(ReadError::new(place, message).try_this("the file is cut short; copy it again"));
        }
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(take(stream, size)?),
            BINARY_CHUNK if json.is_some() && binary.is_none() => binary = Some(take_any(stream, size)?),
            _ => pass_over(stream, size)?,
        }
    }
    let missing = || ReadError::new(Place::Byte(12), "the JSON chunk is missing");
    Ok((json.ok_or_else(missing)?, binary))
}

fn number(stream: &mut Stream) -> Result<u32, ReadError> {
    Ok(u32::from_le_bytes(stream.take(4)?.try_into().expect("four bytes were taken")))
}

/// A document into memory.
fn take(stream: &mut Stream, size: u64) -> Result<Vec<u8>, ReadError> {
    if size > LONGEST_JSON {
        let message = format!("a document of {} MB is more than {}", size >> 20, LONGEST_JSON >> 20);
        return Err(ReadError::new(Place::File, message).try_this("export it as .glb"));
    }
    take_any(stream, size)
}

/// Bytes into memory, as they come: a size that is not there allocates nothing.
fn take_any(stream: &mut Stream, size: u64) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    while (bytes.len() as u64) < size {
        let step = (size - bytes.len() as u64).min(1 << 16) as usize;
        bytes.extend_from_slice(stream.take(step)?);
    }
    Ok(bytes)
}

fn pass_over(stream: &mut Stream, size: u64) -> Result<(), ReadError> {
    let mut left = size;
    while left > 0 {
        let step = left.min(1 << 16);
        stream.take(step as usize)?;
        left -= step;
    }
    Ok(())
}

fn check_version(document: &Document) -> Result<(), ReadError> {
    let version = &document.asset.version;
    if !version.starts_with("2.") {
        let message = format!("it is glTF {}, not 2", crate::words::shown(version));
        return Err(ReadError::new(Place::File, message).try_this("export it as glTF 2.0"));
    }
    let unknown =
        document.extensions_required.0.iter().find(|name| !KNOWN.iter().any(|known| name.starts_with(known)));
    match unknown {
        Some(name) => {
            let message = format!("it requires the extension `{}`", crate::words::shown(name));
            Err(ReadError::new(Place::File, message).try_this("export it without compression of meshes"))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
