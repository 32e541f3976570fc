//! From TOML to [`Recipe`], collecting every mistake.

use super::matrix::{Matrix, Variant};
use super::{
    Entry, From, Node, NodeValue, Override, RECIPE_FORMAT, Reading, Recipe, RecipeStage, Source, include,
    matrix, overrides,
};
use crate::error::{IoContext, distinct};
use fibar_core::diagnostic::{Diagnostic, SourceText, did_you_mean};
use fibar_core::protocol::MAX_SEED;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

const TOP_KEYS: [&str; 5] = ["fibar", "object", "include", "stage", "matrix"];
const OBJECT_KEYS: [&str; 2] = ["name", "description"];

/// Reads the file and what it includes, and applies the overrides to it or to each of its variants.
pub(super) fn read(path: &Path, changes: &[Override], matrix: Matrix) -> crate::Result<Reading> {
    let text = std::fs::read_to_string(path).context("read the recipe", path)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_owned();
    let source = Arc::new(Source { text: SourceText::new(path.display().to_string(), text), folder });
    let (root, mut findings) = Node::parse_file(&source);
    let profiles = include::profiles(&root, &mut findings);
    if !findings.is_empty() {
        // What follows from a broken line is noise.
        return Err(crate::Error { class: crate::Class::Recipe, findings });
    }
    let mut reader = Reader { findings };
    reader.check_keys(&root, &TOP_KEYS, "a recipe");
    reader.check_format(&root);
    for profile in &profiles {
        reader.check_keys(profile, &include::PROFILE_KEYS, "a profile");
        reader.check_format(profile);
    }
    let name = reader.object_name(&root);
    let tables = reader.tables(&root);
    let mut variants = matrix::variants(&root, &mut reader.findings);
    if matrix == Matrix::Ignore {
        variants = vec![Variant::default()];
    }
    let sources: Vec<_> = [&root].into_iter().chain(&profiles).map(|node| Arc::clone(&node.source)).collect();
    let recipes = variants.into_iter().map(|variant| {
        let variant_name =
            if variant.name.is_empty() { name.clone() } else { format!("{name}@{}", variant.name) };
        let changes = || variant.changes.iter().chain(changes);
        Recipe {
            path: path.to_owned(),
            name: variant_name,
            sources: sources.clone(),
            changes: changes().map(Override::to_string).collect(),
            stages: reader.stages(tables.clone(), changes(), &profiles),
        }
    });
    let recipes = recipes.collect();
    Ok(Reading { recipes, findings: distinct(reader.findings) })
}

struct Reader {
    findings: Vec<Diagnostic>,
}

impl Reader {
    fn check_keys(&mut self, table: &Node, known: &[&str], what: &str) {
        for entry in table.entries().iter().filter(|e| !known.contains(&e.key.as_str())) {
            let finding = entry.key_error(format!("unknown key `{}` in {what}", entry.key));
            self.findings.push(match did_you_mean(&entry.key, known.iter().copied()) {
                Some(key) => finding.hint(format!("did you mean `{key}`?")),
                None => finding.hint(format!("known keys: {}", known.join(", "))),
            });
        }
    }

    fn check_format(&mut self, root: &Node) {
        match root.get("fibar") {
            Some(Node { value: NodeValue::Integer(RECIPE_FORMAT), .. }) => {}
            Some(other) => {
                let message = format!("this fibar reads recipes of format {RECIPE_FORMAT}");
                self.findings.push(other.error(message).hint(format!("fibar = {RECIPE_FORMAT}")));
            }
            None => self.findings.push(
                at_top(root, "the recipe does not state its format")
                    .hint(format!("begin with `fibar = {RECIPE_FORMAT}`")),
            ),
        }
    }

    fn object_name(&mut self, root: &Node) -> String {
        let Some(object) = root.get("object") else {
            self.findings
                .push(at_top(root, "the recipe names no object").hint("add:\n[object]\nname = \"bunny\""));
            return String::new();
        };
        self.check_keys(object, &OBJECT_KEYS, "[object]");
        match object.get("name").map(|node| (node, node.as_str())) {
            Some((_, Some(name))) if is_plain_name(name) => return name.to_owned(),
            Some((node, _)) => self.findings.push(
                node.error("the name of an object is a text of letters, digits, `-`, `_` and `.`")
                    .hint("it names the build folder"),
            ),
            None => self.findings.push(object.error("the object has no name").hint("name = \"bunny\"")),
        }
        String::new()
    }

    /// The tables of the stages, each with its id.
    fn tables(&mut self, root: &Node) -> Vec<(String, Node)> {
        let tables = match root.get("stage").map(|node| (node, &node.value)) {
            Some((_, NodeValue::Array(tables))) if !tables.is_empty() => tables.clone(),
            Some((node, _)) => {
                self.findings.push(node.error("stages are written as [[stage]]"));
                return Vec::new();
            }
            None => {
                self.findings.push(at_top(root, "the recipe has no [[stage]]"));
                return Vec::new();
            }
        };
        self.named(tables)
    }

    fn stages<'a>(
        &mut self,
        mut tables: Vec<(String, Node)>,
        changes: impl Iterator<Item = &'a Override>,
        profiles: &[Node],
    ) -> Vec<RecipeStage> {
        for change in changes {
            self.findings.extend(overrides::apply(&mut tables, change));
        }
        for (_, table) in &mut tables {
            include::fill(table, profiles);
        }
        tables.into_iter().filter_map(|(id, table)| self.stage(id, table)).collect()
    }

    /// Gives every stage its id: its own, else its plugin's name, numbered from the second on.
    fn named(&mut self, tables: Vec<Node>) -> Vec<(String, Node)> {
        let mut taken = BTreeSet::new();
        for node in tables.iter().filter_map(|t| t.get("id")) {
            match node.as_str() {
                Some(id) if !is_plain_name(id) || id.contains('.') => {
                    self.findings.push(node.error("an id is a text of letters, digits, `-` and `_`"));
                }
                Some(id) if !taken.insert(id.to_owned()) => {
                    self.findings.push(node.error(format!("two stages have the id `{id}`")));
                }
                Some(_) => {}
                None => self.findings.push(node.error(format!("an id is a text, not {}", node.kind()))),
            }
        }
        let name = |table: Node| {
            let own = table.get("id").and_then(Node::as_str).map(str::to_owned);
            let id = own.unwrap_or_else(|| {
                let plugin = table.get("use").and_then(Node::as_str).unwrap_or("stage");
                let numbered = (2..).map(|n| format!("{plugin}-{n}"));
                let id = std::iter::once(plugin.to_owned()).chain(numbered).find(|id| !taken.contains(id));
                let id = id.expect("numbers do not end");
                taken.insert(id.clone());
                id
            });
            (id, table)
        };
        tables.into_iter().map(name).collect()
    }

    fn stage(&mut self, id: String, node: Node) -> Option<RecipeStage> {
        if !matches!(node.value, NodeValue::Table(_)) {
            self.findings.push(node.error("stages are written as [[stage]]"));
            return None;
        }
        let Some(use_node) = node.get("use").cloned() else {
            self.findings.push(node.error("the stage names no plugin").hint("use = \"source-mesh\""));
            return None;
        };
        let Some(plugin) = use_node.as_str().filter(|name| is_plain_name(name)).map(str::to_owned) else {
            self.findings.push(use_node.error("`use` is the name of a plugin, e.g. \"source-mesh\""));
            return None;
        };
        let params = node.entries().iter().filter(|e| !super::STAGE_KEYS.contains(&e.key.as_str()));
        Some(RecipeStage {
            id,
            plugin,
            from: self.from(&node),
            seed: self.seed(&node),
            allow: self.allow(&node),
            params: params.cloned().collect::<Vec<Entry>>(),
            use_node,
            node,
        })
    }

    fn from(&mut self, stage: &Node) -> From {
        match stage.get("from").map(|node| (node, &node.value)) {
            None => From::Nearest,
            Some((node, NodeValue::String(_))) => From::Stage(node.clone()),
            Some((_, NodeValue::Table(entries))) => From::Ports(entries.clone()),
            Some((node, _)) => {
                let finding = node.error("`from` names a stage, or a stage for each port");
                self.findings.push(finding.hint("from = \"route\"").hint("from = { routes = \"route\" }"));
                From::Nearest
            }
        }
    }

    fn seed(&mut self, stage: &Node) -> Option<(u64, Node)> {
        let node = stage.get("seed")?;
        match node.value {
            NodeValue::Integer(seed) if (0..=MAX_SEED as i64).contains(&seed) => {
                Some((seed as u64, node.clone()))
            }
            _ => {
                self.findings.push(node.error(format!("a seed is a whole number from 0 to {MAX_SEED}")));
                None
            }
        }
    }

    fn allow(&mut self, stage: &Node) -> Vec<String> {
        let Some(node) = stage.get("allow") else { return Vec::new() };
        let rules = match &node.value {
            NodeValue::Array(items) => items.iter().map(Node::as_str).collect::<Option<Vec<_>>>(),
            _ => None,
        };
        rules.map(|rules| rules.into_iter().map(str::to_owned).collect()).unwrap_or_else(|| {
            let finding = node.error("`allow` is a list of rules that may be broken");
            self.findings.push(finding.hint("allow = [\"clearance.gap\"]"));
            Vec::new()
        })
    }
}

fn at_top(root: &Node, message: &str) -> Diagnostic {
    Diagnostic::error(message).at(&root.source.text, 0..0)
}

/// Letters, digits, `-`, `_`, `.`, not starting with a dot: safe as the name of a file.
fn is_plain_name(name: &str) -> bool {
    !name.is_empty()
        && !name.starts_with('.')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.'))
}
