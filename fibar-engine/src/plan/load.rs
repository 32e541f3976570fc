//! Reading and checking a whole recipe before anything runs.

use super::wire::{Wire, WireSource, Wiring, order};
use super::{FileInput, Plan, PlanOptions, PlanSource, PlannedStage, schema};
use crate::error::distinct;
use crate::plugin::{Plugin, PluginPath};
use crate::recipe::{Node, Recipe, RecipeStage, Source};
use crate::{Class, Digest, Error, Result, Store};
use fibar_core::diagnostic::{Diagnostic, did_you_mean};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Plans a recipe or all its variants, or reports everything that is wrong with it.
pub(super) fn load(path: &Path, options: &PlanOptions<'_>) -> Result<Vec<Plan>> {
    let reading = Recipe::read(path, options.overrides, options.matrix)?;
    let mut checks = Checks { store: options.store, findings: reading.findings, other: 0, class: None };
    let all_stages = reading.recipes.iter().flat_map(|recipe| &recipe.stages);
    let found = checks.plugins(all_stages, options.plugins);
    let plans = reading.recipes.into_iter().map(|recipe| checks.plan(recipe, &found));
    let plans: Vec<Option<Plan>> = plans.collect();
    checks.finish()?;
    Ok(plans.into_iter().map(|plan| plan.expect("nothing was found wrong")).collect())
}

fn plan_source(source: &Arc<Source>) -> PlanSource {
    let name = Path::new(&source.text.name).file_name().unwrap_or_default().to_string_lossy().into_owned();
    PlanSource { name, digest: Digest::of(source.text.text.as_bytes()) }
}

/// A seeded stage without a seed in the recipe gets 0.
fn with_default_seed(mut stage: PlannedStage) -> PlannedStage {
    if stage.plugin.description.seeded {
        stage.seed.get_or_insert(0);
    }
    stage
}

fn planned(
    stage: RecipeStage,
    plugin: Arc<Plugin>,
    params: serde_json::Value,
    files: Vec<FileInput>,
    wires: Vec<Wire>,
) -> PlannedStage {
    PlannedStage {
        id: stage.id,
        plugin,
        params,
        files,
        seed: stage.seed.map(|(seed, _)| seed),
        allow: stage.allow,
        wires,
        node: stage.node,
        use_node: stage.use_node,
    }
}

/// Wires in terms of positions in the plan.
fn renumber(wires: Vec<Wire>, order: &[usize]) -> Vec<Wire> {
    let position = |at: usize| order.iter().position(|&other| other == at).expect("every stage is ordered");
    let source = |source: WireSource| WireSource { stage: position(source.stage), port: source.port };
    let wire = |wire: Wire| Wire { port: wire.port, sources: wire.sources.into_iter().map(source).collect() };
    wires.into_iter().map(wire).collect()
}

struct Checks<'a> {
    store: &'a Store,
    findings: Vec<Diagnostic>,
    /// How many of them are not simply mistakes in the recipe.
    other: usize,
    /// The gravest kind of those.
    class: Option<Class>,
}

/// Plugins by name; `None` for those that are wrong.
type Found = BTreeMap<String, Option<Arc<Plugin>>>;

impl Checks<'_> {
    /// The plan of one recipe, unless something is wrong with it.
    fn plan(&mut self, recipe: Recipe, found: &Found) -> Option<Plan> {
        let with_plugin = |stage: RecipeStage| {
            let plugin = found.get(&stage.plugin).cloned().flatten();
            (stage, plugin)
        };
        let stages: Vec<_> = recipe.stages.into_iter().map(with_plugin).collect();
        let wiring = Wiring { stages: &stages };
        let mut wires: Vec<_> = (0..stages.len()).map(|at| wiring.wires(at, &mut self.findings)).collect();
        let order = order(&wires).unwrap_or_else(|cycle| {
            self.report_cycle(&stages, &cycle);
            Vec::new()
        });
        let mut checked: Vec<_> =
            stages.iter().map(|(stage, plugin)| self.stage(stage, plugin.as_deref())).collect();
        if !self.findings.is_empty() {
            return None;
        }
        let mut stages: Vec<_> = stages.into_iter().map(Some).collect();
        let planned = order.iter().map(|&at| {
            let (stage, plugin) = stages[at].take().expect("every stage is ordered once");
            let (params, files) = std::mem::take(&mut checked[at]);
            let wires = renumber(std::mem::take(&mut wires[at]), &order);
            planned(stage, plugin.expect("checked"), params, files, wires)
        });
        Some(Plan {
            recipe: recipe.path,
            name: recipe.name,
            sources: recipe.sources.iter().map(plan_source).collect(),
            changes: recipe.changes,
            stages: planned.map(with_default_seed).collect(),
        })
    }

    /// Finds and describes each plugin once; those that have to be asked, which costs a process each, at the same time.
    fn plugins<'a>(&mut self, stages: impl Iterator<Item = &'a RecipeStage>, plugins: &PluginPath) -> Found {
        let mut wanted: BTreeMap<&str, &Node> = BTreeMap::new();
        for stage in stages {
            wanted.entry(&stage.plugin).or_insert(&stage.use_node);
        }
        let store = self.store;
        let paths: BTreeMap<&str, _> = wanted.keys().map(|&name| (name, plugins.find(name))).collect();
        let load = &|name: &str| paths[name].as_ref().map(|path| Plugin::load(name, path, store));
        let is_known =
            |name: &str| paths[name].as_ref().is_none_or(|path| Plugin::is_described(name, path, store));
        let results: Vec<_> = std::thread::scope(|scope| {
            let unknown = wanted.keys().copied().filter(|name| !is_known(name));
            let mut asked: BTreeMap<&str, _> =
                unknown.map(|name| (name, scope.spawn(move || load(name)))).collect();
            let load = |&name: &&str| match asked.remove(name) {
                Some(thread) => thread.join().expect("loading does not panic"),
                None => load(name),
            };
            wanted.keys().map(load).collect()
        });
        let mut found = BTreeMap::new();
        for ((name, node), result) in wanted.into_iter().zip(results) {
            found.insert(name.to_owned(), self.plugin(name, node, result, plugins));
        }
        found
    }

    fn plugin(
        &mut self,
        name: &str,
        node: &Node,
        result: Option<Result<Plugin>>,
        plugins: &PluginPath,
    ) -> Option<Arc<Plugin>> {
        match result {
            Some(Ok(plugin)) => Some(Arc::new(plugin)),
            Some(Err(error)) => {
                self.note_other(error.class, error.findings.len());
                let place = node.place();
                self.findings.extend(error.findings.into_iter().map(|mut finding| {
                    finding.place.get_or_insert(place.clone());
                    finding
                }));
                None
            }
            None => {
                self.findings.push(missing(name, node, plugins));
                None
            }
        }
    }

    fn stage(&mut self, stage: &RecipeStage, plugin: Option<&Plugin>) -> (serde_json::Value, Vec<FileInput>) {
        let Some(plugin) = plugin else { return Default::default() };
        if let Some((_, node)) = stage.seed.as_ref().filter(|_| !plugin.description.seeded) {
            self.findings.push(node.error(format!("`{}` uses no seed", plugin.name)).hint("remove the line"));
        }
        let mut checked = schema::check(&plugin.description.params, &stage.params, &stage.use_node.place());
        self.findings.append(&mut checked.findings);
        let files = checked.files.iter().filter_map(|file| self.file(file)).collect();
        (checked.params, files)
    }

    fn file(&mut self, param: &schema::FileParam) -> Option<FileInput> {
        let text = param.node.as_str().unwrap_or("");
        let path = param.node.source.folder.join(text);
        match self.store.stats.digest_of(&path) {
            Ok((digest, _)) => {
                let extension =
                    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_lowercase());
                Some(FileInput { pointer: param.pointer.clone(), path, digest, extension })
            }
            Err(e) => {
                self.note_other(Class::Input, 1);
                let reason = match e.kind() {
                    std::io::ErrorKind::NotFound => "there is no such file".to_owned(),
                    _ => e.to_string(),
                };
                let finding = param.node.error(format!("cannot read {}: {reason}", path.display()));
                let beside = nearest_file(&path);
                self.findings.push(match beside {
                    Some(name) => finding.hint(format!("did you mean {name:?}?")),
                    None => finding.note("paths are relative to the file they are written in"),
                });
                None
            }
        }
    }

    fn note_other(&mut self, class: Class, count: usize) {
        self.class = self.class.max(Some(class));
        self.other += count;
    }

    fn report_cycle(&mut self, stages: &[(RecipeStage, Option<Arc<Plugin>>)], cycle: &[usize]) {
        let ids: Vec<_> = cycle.iter().map(|&at| format!("`{}`", stages[at].0.id)).collect();
        let first = &stages[cycle[0]].0;
        let node = first.node.get("from").unwrap_or(&first.use_node);
        self.findings.push(node.error(format!("these stages wait for each other: {}", ids.join(", "))));
    }

    fn finish(&mut self) -> Result<()> {
        self.findings.retain(|finding| !finding.message.is_empty());
        if self.findings.is_empty() {
            return Ok(());
        }
        self.findings = distinct(std::mem::take(&mut self.findings));
        let start = |f: &Diagnostic| {
            f.place.as_ref().map_or((String::new(), 0), |p| (p.source.name.clone(), p.range.start))
        };
        self.findings.sort_by_key(start);
        let class = self.class.filter(|_| self.other == self.findings.len()).unwrap_or(Class::Recipe);
        Err(Error { class, findings: std::mem::take(&mut self.findings) })
    }
}

/// The name of a file beside the missing one that was probably meant.
fn nearest_file(missing: &Path) -> Option<String> {
    let entries = std::fs::read_dir(missing.parent()?).ok()?;
    let mut names: Vec<_> = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    did_you_mean(missing.file_name()?.to_str()?, names.iter().map(String::as_str)).map(str::to_owned)
}

/// Why there is no such plugin, as far as that can be told.
fn missing(name: &str, node: &Node, plugins: &PluginPath) -> Diagnostic {
    let finding = node.error(format!("there is no plugin `{name}`"));
    if let Some(source) = plugins.source(name) {
        let finding = finding.note(format!("it is not compiled; its source is at {}", source.display()));
        return finding.hint("`cargo xtask build RECIPE` compiles what a recipe names, and builds it");
    }
    if let Some(guess) = did_you_mean(name, plugins.list().keys().map(String::as_str)) {
        return finding.hint(format!("did you mean `{guess}`?"));
    }
    let folders = plugins.folders().iter().map(|folder| folder.display().to_string());
    let folders = folders.collect::<Vec<_>>().join(", ");
    finding.note(format!("looked in {folders}")).hint("`fibar plugin list` shows those found")
}
