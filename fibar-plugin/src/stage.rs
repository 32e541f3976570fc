//! The one trait of a stage.

use crate::{Job, StageError};
use fibar_core::protocol::Description;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// A stage of a build: what it is and what it does.
pub trait Stage {
    /// Its parameters. Put `#[serde(deny_unknown_fields, default)]` on the struct, the defaults in `Default`, one doc
    /// line on each field, and range and unit in `#[schemars(range(..), extend("unit" = "mm"))]`.
    type Params: serde::de::DeserializeOwned + schemars::JsonSchema;

    /// Name, ports and needs; `serve` adds the schema of the parameters.
    fn describe() -> Description;

    /// Does the work. Same request, same bytes, whatever `job.threads()` says.
    fn run(params: Self::Params, job: &mut Job) -> Result<(), StageError>;
}

/// The description of a stage with the schema of its parameters.
pub(crate) fn full_description<S: Stage>() -> Description {
    let mut description = S::describe();
    description.params = schema_of::<S::Params>();
    description
}

fn schema_of<P: schemars::JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| {
        s.inline_subschemas = true;
        s.meta_schema = None;
    });
    let mut schema = settings.into_generator().into_root_schema_for::<P>().to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("additionalProperties".into(), Value::Bool(false));
    }
    schema
}
