//! What a recipe can say.

use fibar_plugin::{Direction, InputFile, StageError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Parameters of the stage.
#[derive(Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {
    /// The file: a build123d script (.py) that sets `result`, or STEP (.step, .stp) or BREP (.brep, .brp).
    pub path: InputFile,
    /// Values for names that the script assigns at top level: numbers, texts, true or false, lists.
    pub parameters: BTreeMap<String, Value>,
    /// Files for names that the script assigns at top level: such a name becomes the path of the file.
    pub files: BTreeMap<String, InputFile>,
    /// Greatest distance between a curved surface and its triangles.
    #[schemars(range(min = 1e-4, max = 10.0), extend("unit" = "mm"))]
    pub chord_error_mm: f64,
    /// Greatest turn of a curved surface across one triangle.
    #[schemars(range(min = 0.5, max = 90.0), extend("unit" = "deg"))]
    pub angle_deg: f64,
    /// Factor applied to the shape, before tessellating.
    #[schemars(range(min = 1e-6, max = 1e6))]
    pub scale: f64,
    /// Axis of the shape that points up; it becomes +Z.
    pub up: Direction,
    /// Longest side that is plausible, least and greatest; beyond it, units were probably mixed up.
    #[schemars(extend("unit" = "mm"))]
    pub size_mm: [f64; 2],
    /// Time for the script or reader, from the start of its process.
    #[schemars(range(min = 1.0, max = 86_400.0), extend("unit" = "s"))]
    pub timeout_s: f64,
}

impl Default for Params {
    fn default() -> Params {
        Params {
            path: InputFile::default(),
            parameters: BTreeMap::new(),
            files: BTreeMap::new(),
            chord_error_mm: 0.1,
            angle_deg: 15.0,
            scale: 1.0,
            up: Direction::PlusZ,
            size_mm: [20.0, 1000.0],
            timeout_s: 120.0,
        }
    }
}

/// A value for a script.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged)]
pub enum Value {
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Numbers in a list.
    Numbers(Vec<f64>),
    /// Texts in a list.
    Texts(Vec<String>),
}

/// Extensions of the files that can be read.
const EXTENSIONS: [&str; 5] = ["py", "step", "stp", "brep", "brp"];

impl Params {
    /// Refuses what makes no sense before anything is started.
    pub fn check(&self) -> Result<(), StageError> {
        let path = self.path.path();
        if path.as_os_str().is_empty() {
            let hint = "path = \"objects/NAME.py\", or .step, .brep";
            return Err(StageError::user("no file is named").param("/path").hint(hint));
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if !EXTENSIONS.contains(&extension.as_str()) {
            let message = format!("cannot tell from \".{extension}\" what the file is");
            let hint = "build123d scripts end in .py, STEP in .step or .stp, BREP in .brep; meshes go to source-mesh";
            return Err(StageError::user(message).param("/path").hint(hint));
        }
        self.check_script_only(&extension)?;
        self.check_numbers()
    }

    fn check_script_only(&self, extension: &str) -> Result<(), StageError> {
        if extension == "py" {
            return Ok(());
        }
        let blame =
            |pointer: &str| Err(StageError::user("only a script takes parameters or files").param(pointer));
        match (self.parameters.keys().next(), self.files.keys().next()) {
            (Some(name), _) => blame(&format!("/parameters/{name}")),
            (None, Some(name)) => blame(&format!("/files/{name}")),
            (None, None) => Ok(()),
        }
    }

    fn check_numbers(&self) -> Result<(), StageError> {
        let [smallest, largest] = self.size_mm;
        if !(smallest >= 0.0 && largest.is_finite() && smallest < largest) {
            let message = format!("size_mm must be least and greatest, is [{smallest}, {largest}]");
            return Err(StageError::user(message).param("/size_mm"));
        }
        let named = [
            ("chord_error_mm", self.chord_error_mm),
            ("angle_deg", self.angle_deg),
            ("scale", self.scale),
            ("timeout_s", self.timeout_s),
        ];
        match named.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
            Some((name, value)) => {
                let message = format!("{name} must be above 0, is {value}");
                Err(StageError::user(message).param(format!("/{name}")))
            }
            None => Ok(()),
        }
    }
}
