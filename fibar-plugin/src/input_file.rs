//! A parameter that names a file.

use fibar_core::protocol::FILE_FORMAT;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// A file named by a parameter. In the recipe it is a path relative to the recipe; the host reads the file, hashes it,
/// and the stage gets a read-only copy that keeps only the extension of the name.
///
/// `InputFile::default()` is empty and means "must be given" (use `Option<InputFile>` for a file that may be absent).
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct InputFile(PathBuf);

impl InputFile {
    /// Where the stage finds the file.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl JsonSchema for InputFile {
    fn schema_name() -> Cow<'static, str> {
        "InputFile".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "format": FILE_FORMAT })
    }
}
