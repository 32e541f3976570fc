//! A recipe as text, to be cut down and changed by stages.

use std::path::Path;

/// The head of a recipe and its stages, each a block of lines.
#[derive(Clone)]
pub struct Recipe {
    head: String,
    stages: Vec<String>,
}

const STAGE: &str = "[[stage]]\n";

/// Stages that routing does not wait for.
const NOT_ROUTING: [&str; 5] = ["sweep-", "export-", "render-", "verify-solids", "verify-recognition"];

impl Recipe {
    /// Reads a recipe; files that it names by relative paths are named from the root.
    pub fn read(path: &Path) -> Result<Recipe, String> {
        let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let folder = path.parent().unwrap_or(Path::new("")).display().to_string();
        let lines = text.lines().map(|line| match line.strip_prefix("path = \"") {
            Some(rest) if !rest.starts_with('/') => format!("path = \"{folder}/{rest}\n"),
            _ => format!("{line}\n"),
        });
        let text: String = lines.collect();
        let mut blocks = text.split(STAGE).map(str::to_owned);
        let head = blocks.next().unwrap_or_default();
        Ok(Recipe { head, stages: blocks.collect() })
    }

    /// The same with another name of the object.
    pub fn named(mut self, name: &str) -> Recipe {
        let line = |line: &str| match line.starts_with("name = ") {
            true => format!("name = \"{name}\"\n"),
            false => format!("{line}\n"),
        };
        self.head = self.head.lines().map(line).collect();
        self
    }

    /// The same with one plugin in the place of another; parameters of the other go.
    pub fn replaced(mut self, old: &str, new: &str) -> Recipe {
        for stage in self.stages.iter_mut().filter(|stage| plugin(stage) == old) {
            *stage = format!("id = \"route\"\nuse = \"{new}\"\n");
        }
        self
    }

    /// The stages up to the route and what measures it, with bounds if there are none. At quick effort, as in our recipes,
    /// these are a per cent or two low, and shares of them as much too high.
    pub fn for_routing(mut self) -> Recipe {
        self.stages.retain(|stage| !NOT_ROUTING.iter().any(|prefix| plugin(stage).starts_with(prefix)));
        if !self.stages.iter().any(|stage| plugin(stage) == "bound-light") {
            let route = self.stages.iter().position(|stage| plugin(stage).starts_with("route-"));
            let bounds = "use = \"bound-light\"\neffort = \"quick\"\n".to_owned();
            self.stages.insert(route.unwrap_or(self.stages.len()), bounds);
        }
        self
    }

    /// The recipe as a file holds it.
    pub fn text(&self) -> String {
        let stages: Vec<String> = self.stages.iter().map(|stage| format!("{STAGE}{stage}")).collect();
        format!("{}{}", self.head, stages.join("\n"))
    }
}

/// What a stage uses.
fn plugin(stage: &str) -> &str {
    let line = stage.lines().find_map(|line| line.strip_prefix("use = \""));
    line.and_then(|rest| rest.split('"').next()).unwrap_or_default()
}
