//! A workbench: a folder with plugins, a store, recipes and a build folder.

use fibar_engine::build::{self, Budget, BuildOptions, Locking, Silent, Waivers};
use fibar_engine::host::{Limits, Sandbox};
use fibar_engine::ledger::BuildReport;
use fibar_engine::plan::{Plan, PlanOptions};
use fibar_engine::plugin::PluginPath;
use fibar_engine::recipe::{Matrix, Override};
use fibar_engine::{Result, Store};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The stages of `examples/demo-stages.rs`.
const STAGES: [&str; 5] = ["make-text", "upper-text", "bind-text", "verify-text", "leak-text"];

pub struct Bench {
    pub folder: TempDir,
    pub waivers: Waivers,
    pub cores: u32,
    pub sandbox: Sandbox,
    pub matrix: Matrix,
    pub locking: Locking,
    pub limits: Limits,
}

/// A recipe of all demo stages, with `extra` lines for each: make, upper, bind, verify.
pub fn book(make: &str, upper: &str, verify: &str) -> String {
    format!(
        "fibar = 1\n[object]\nname = \"book\"\n\
         [[stage]]\nuse = \"make-text\"\n{make}\n\
         [[stage]]\nuse = \"upper-text\"\n{upper}\n\
         [[stage]]\nuse = \"bind-text\"\n\
         [[stage]]\nuse = \"verify-text\"\n{verify}\n"
    )
}

impl Bench {
    pub fn new() -> Bench {
        let folder = TempDir::new().unwrap();
        std::fs::create_dir(folder.path().join("plugins")).unwrap();
        let executable = std::env::current_exe().unwrap();
        let examples = executable.parent().unwrap().join("../examples");
        for name in STAGES {
            std::fs::copy(examples.join("demo-stages"), folder.path().join("plugins").join(name)).unwrap();
        }
        let rude = folder.path().join("plugins/rude-stage");
        std::fs::copy(examples.join("rude-stage"), rude).unwrap();
        Bench {
            folder,
            waivers: Waivers::Respect,
            cores: 2,
            sandbox: Sandbox::Auto,
            matrix: Matrix::Ignore,
            locking: Locking::Update,
            limits: Limits::default(),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Builds `recipe.toml`, which is this recipe, into a build folder nobody else uses.
    pub fn build_in_own_folder(&self, recipe: &str) -> Result<BuildReport> {
        assert_eq!(self.read("recipe.toml"), recipe);
        let (store, plugins) = (self.store(), PluginPath::only(vec![self.path("plugins")]));
        let mut options = self.options(&store, &plugins, &[], &|| false);
        options.out = TempDir::new_in(self.folder.path()).unwrap().keep();
        build::build(&[self.path("recipe.toml")], &options).map(|mut reports| reports.remove(0))
    }

    /// Plans what is in `recipe.toml`, with values set from outside.
    pub fn plans(&self, store: &Store, set: &[&str]) -> Vec<Plan> {
        let overrides: Vec<_> = set.iter().map(|text| text.parse().unwrap()).collect();
        let plugins = PluginPath::only(vec![self.path("plugins")]);
        let options = PlanOptions { plugins: &plugins, store, overrides: &overrides, matrix: self.matrix };
        Plan::make(&self.path("recipe.toml"), &options).unwrap_or_else(|e| panic!("{e}"))
    }

    /// A plugin that is a script.
    #[cfg(unix)]
    pub fn write_plugin(&self, name: &str, script: &str) {
        use std::os::unix::fs::PermissionsExt;
        let path = self.write(&format!("plugins/{name}"), script);
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn store(&self) -> Store {
        Store::open(&self.path("store")).unwrap()
    }

    /// Builds a recipe text.
    pub fn build(&self, recipe: &str) -> Result<BuildReport> {
        self.build_with(recipe, &[], &|| false)
    }

    pub fn build_with(
        &self,
        recipe: &str,
        set: &[&str],
        is_cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<BuildReport> {
        self.build_all(recipe, set, is_cancelled).map(|mut reports| reports.remove(0))
    }

    /// Every variant of a recipe text, as far as the bench looks at its matrix.
    pub fn build_all(
        &self,
        recipe: &str,
        set: &[&str],
        is_cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<BuildReport>> {
        let path = self.write("recipe.toml", recipe);
        let overrides: Vec<_> = set.iter().map(|text| text.parse().unwrap()).collect();
        let store = self.store();
        let plugins = PluginPath::only(vec![self.path("plugins")]);
        build::build(&[path], &self.options(&store, &plugins, &overrides, is_cancelled))
    }

    pub fn options<'a>(
        &self,
        store: &'a Store,
        plugins: &'a PluginPath,
        overrides: &'a [Override],
        is_cancelled: &'a (dyn Fn() -> bool + Sync),
    ) -> BuildOptions<'a> {
        BuildOptions {
            store,
            plugins,
            overrides,
            matrix: self.matrix,
            locking: self.locking,
            budget: Budget { cores: self.cores, memory_mb: 4096 },
            out: self.path("build"),
            waivers: self.waivers,
            sandbox: self.sandbox,
            threads: None,
            limits: self.limits,
            observer: &Silent,
            is_cancelled,
        }
    }

    /// The ids of the stages that a build of the recipe runs.
    #[track_caller]
    pub fn runs(&self, recipe: &str, expected: &[&str]) {
        let report = self.build(recipe).unwrap_or_else(|e| panic!("{e}"));
        let ran = report.stages.iter().filter(|s| s.outcome == build::Outcome::Executed);
        assert_eq!(ran.map(|s| s.id.as_str()).collect::<Vec<_>>(), expected);
    }

    /// Sorted names of a folder.
    pub fn list(&self, folder: &str) -> Vec<String> {
        list(&self.path(folder))
    }
}

pub fn list(folder: &Path) -> Vec<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}
