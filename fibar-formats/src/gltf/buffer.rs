//! The buffers of a document: inside a GLB, or as data URIs. Nothing outside the file is ever opened.

use super::document::{Buffer, Document};
use crate::error::{Place, ReadError};
use crate::words::shown;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// All buffers; each holds at least the bytes that it declares.
pub fn read_all(document: &Document, mut binary: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, ReadError> {
    let mut buffers = Vec::new();
    for (k, buffer) in document.buffers.0.iter().enumerate() {
        let bytes = read(buffer, if k == 0 { binary.take() } else { None })
            .map_err(|error| error.inside(format!("buffers[{k}]")))?;
        if (bytes.len() as u64) < buffer.byte_length {
            let message = format!("it has {} bytes, not {}", bytes.len(), buffer.byte_length);
            return Err(ReadError::new(Place::File, message).inside(format!("buffers[{k}]")));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

fn read(buffer: &Buffer, binary: Option<Vec<u8>>) -> Result<Vec<u8>, ReadError> {
    let error = |message: String| ReadError::new(Place::File, message);
    let Some(uri) = &buffer.uri else {
        return binary.ok_or_else(|| error("its bytes are not in the file".into()));
    };
    let Some(data) = uri.strip_prefix("data:") else {
        let message = format!("its bytes are in another file, `{}`", shown(uri));
        return Err(error(message).try_this(
            "a stage sees only the file that its recipe names: export the object as one .glb, or with embedded buffers",
        ));
    };
    let text = data.split_once(";base64,").map(|(_, text)| text);
    let text = text.ok_or_else(|| error("its data URI is not in base64".into()))?;
    STANDARD.decode(text).map_err(|why| error(format!("its base64 is broken: {why}")))
}
