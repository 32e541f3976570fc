//! A recipe as text, to be cut down and changed by stages.

use std::path::Path;

/// The head of a recipe and its stages, each a block of lines.
#[derive(Clone)]
pub struct Recipe {
    head: String,
    stages: Vec<String>,
}

const STAGE: &str = "[[stage]]\n";

/// How the stage begins that bounds the light of the markers, not of the candidate places.
const BEST: &str = "id = \"best\"";

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

    /// The same with another value of a parameter, as TOML, in the stages that use a plugin.
    pub fn set(mut self, wanted: &str, key: &str, value: &str) -> Recipe {
        for stage in self.stages.iter_mut().filter(|stage| plugin(stage) == wanted) {
            let others = stage.lines().filter(|line| !line.starts_with(&format!("{key} = ")));
            *stage = others.map(|line| format!("{line}\n")).collect();
            stage.push_str(&format!("{key} = {value}\n"));
        }
        self
    }

    /// The stages up to the route and what measures it, with bounds of normal effort for the markers.
    pub fn for_routing(mut self) -> Recipe {
        self.stages.retain(|stage| !NOT_ROUTING.iter().any(|prefix| plugin(stage).starts_with(prefix)));
        if !self.stages.iter().any(|stage| is_best(stage)) {
            let route = self.route();
            self.stages.insert(route, format!("{BEST}\nuse = \"bound-light\"\n"));
        }
        self
    }

    /// The stages that make what the router gets.
    pub fn before_route(mut self) -> Recipe {
        self.stages.truncate(self.route());
        self.stages.retain(|stage| !is_best(stage));
        self
    }

    /// The plugin that routes.
    pub fn router(&self) -> &str {
        self.stages.get(self.route()).map_or("", |stage| plugin(stage))
    }

    fn route(&self) -> usize {
        let route = self.stages.iter().position(|stage| plugin(stage).starts_with("route-"));
        route.unwrap_or(self.stages.len())
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

fn is_best(stage: &str) -> bool {
    stage.starts_with(BEST)
}
