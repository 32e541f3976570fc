//! One function per command.

use crate::arguments::{
    BuildOptions, CacheCommand, Common, ExplainOptions, ListOptions, LogForm, PlanOptions as PlanArguments,
    Recipes, TestOptions, VerifyOptions,
};
use crate::log::{self, JsonLog};
use crate::progress::Progress;
use crate::speak::{answer, tell};
use crate::table;
use fibar_core::diagnostic::Diagnostic;
use fibar_engine::build::{self, Budget, Locking, Observer, Silent, Waivers};
use fibar_engine::conformance::{self, Samples, Verdict};
use fibar_engine::ledger::BuildReport;
use fibar_engine::plan::{Plan, PlanOptions};
use fibar_engine::plugin::{Plugin, PluginPath};
use fibar_engine::recipe::{Matrix, Override, Recipe};
use fibar_engine::{Class, Error, Result, Store, determinism, explain, os};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;

/// `fibar build`
pub fn build(options: &BuildOptions, common: &Common) -> Result<ExitCode> {
    let reports = run_build(options, Waivers::Respect, common)?;
    for report in &reports {
        answer(table::build(report));
    }
    Ok(verdict(&reports))
}

/// `fibar verify`
pub fn verify(options: &VerifyOptions, common: &Common) -> Result<ExitCode> {
    let waivers = if options.strict { Waivers::Ignore } else { Waivers::Respect };
    let reports = run_build(&options.build, waivers, common)?;
    for report in &reports {
        answer(table::verification(report));
    }
    Ok(verdict(&reports))
}

fn verdict(reports: &[BuildReport]) -> ExitCode {
    let verified = reports.iter().all(BuildReport::is_verified);
    if verified { ExitCode::SUCCESS } else { ExitCode::from(Class::Verification as u8) }
}

fn run_build(options: &BuildOptions, waivers: Waivers, common: &Common) -> Result<Vec<BuildReport>> {
    with_build_options(options, waivers, common, |engine| build::build(&options.recipes.recipes, engine))
}

fn with_build_options<T>(
    options: &BuildOptions,
    waivers: Waivers,
    common: &Common,
    work: impl FnOnce(&build::BuildOptions<'_>) -> Result<T>,
) -> Result<T> {
    let store = open_store(common)?;
    let plugins = PluginPath::new(&common.plugin_path);
    let observer: Box<dyn Observer> = match options.log {
        LogForm::Text => Box::new(Progress::start(options.verbose)),
        LogForm::Json => Box::new(JsonLog::start()),
    };
    let result = work(&build::BuildOptions {
        store: &store,
        plugins: &plugins,
        overrides: &options.recipes.set,
        matrix: matrix(&options.recipes),
        locking: if options.locked { Locking::Require } else { Locking::Update },
        budget: options.jobs.map_or_else(Budget::whole_machine, Budget::cores),
        out: options.out.clone(),
        waivers,
        sandbox: options.sandbox.into(),
        threads: None,
        limits: Default::default(),
        observer: &*observer,
        is_cancelled: &|| os::interrupts() > 0,
    });
    if let (Err(error), LogForm::Json) = (&result, options.log) {
        log::findings(error);
    }
    result
}

fn matrix(recipes: &Recipes) -> Matrix {
    if recipes.matrix { Matrix::Expand } else { Matrix::Ignore }
}

/// `fibar check-determinism`
pub fn check_determinism(options: &BuildOptions, common: &Common) -> Result<ExitCode> {
    let comparisons = with_build_options(options, Waivers::Respect, common, |engine| {
        let plans = build::plan_all(&options.recipes.recipes, engine)?;
        let second = determinism::second_store(engine.store)?;
        let result = determinism::compare(&plans, engine, &second);
        let _ = std::fs::remove_dir_all(second.root());
        result
    })?;
    for comparison in &comparisons {
        answer(table::determinism(comparison));
    }
    let differs = comparisons.iter().any(|comparison| comparison.difference.is_some());
    Ok(if differs { ExitCode::from(Class::Verification as u8) } else { ExitCode::SUCCESS })
}

/// `fibar explain`
pub fn explain(options: &ExplainOptions, common: &Common) -> Result<ExitCode> {
    let store = open_store(common)?;
    let plugins = PluginPath::new(&common.plugin_path);
    let plan_options =
        PlanOptions { plugins: &plugins, store: &store, overrides: &options.set, matrix: Matrix::Ignore };
    let plan = Plan::make(&options.recipe, &plan_options)?.remove(0);
    let lock = options.out.join(&plan.name).join("fibar.lock");
    answer(explain::explain(&plan, &options.stage, &store, &lock)?);
    Ok(ExitCode::SUCCESS)
}

/// `fibar cache`
pub fn cache(command: &CacheCommand, common: &Common) -> Result<ExitCode> {
    let store = open_store(common)?;
    let mut code = ExitCode::SUCCESS;
    match command {
        CacheCommand::Gc { max_size } => {
            answer(table::collected(&store.collect_garbage(*max_size)?, *max_size))
        }
        CacheCommand::Stats => answer(table::stats(&store, &store.statistics()?)),
        CacheCommand::Verify => {
            let audit = store.audit()?;
            answer(table::audit(&audit));
            if !audit.damaged.is_empty() || audit.unreadable > 0 {
                code = ExitCode::from(Class::Verification as u8);
            }
        }
    }
    Ok(code)
}

/// `fibar plugin test`
pub fn plugin_test(options: &TestOptions, common: &Common) -> Result<ExitCode> {
    let given = std::path::absolute(&options.plugin).unwrap_or_default();
    let named = || PluginPath::new(&common.plugin_path).find(&options.plugin.to_string_lossy());
    let executable = if given.is_file() { Some(given) } else { named() };
    let executable = executable.ok_or_else(|| {
        let finding = Diagnostic::error(format!("there is no plugin {}", options.plugin.display()));
        Error::new(
            Class::Recipe,
            finding.hint("name an executable, or a plugin that `fibar plugin list` shows"),
        )
    })?;
    let mut samples = Samples::default();
    for (port, path) in &options.input {
        samples.inputs.entry(port.clone()).or_default().push(path.into());
    }
    for (key, value) in &options.set {
        let value = serde_json::from_str(value).unwrap_or_else(|_| value.as_str().into());
        samples.params.insert(key.clone(), value);
    }
    let checks = conformance::check(&executable, &samples, &open_store(common)?, &|note| tell(note))?;
    answer(table::conformance(&checks));
    let broken = checks.iter().any(|check| matches!(check.verdict, Verdict::Broken(_)));
    Ok(if broken { ExitCode::from(Class::Plugin as u8) } else { ExitCode::SUCCESS })
}

/// `fibar plan`
pub fn plan(options: &PlanArguments, common: &Common) -> Result<ExitCode> {
    let store = open_store(common)?;
    let plans = make_plans(&options.recipes, &store, common)?;
    let found = build::predict_all(&plans, &store);
    if plans.len() > 1 && !options.json {
        answer(table::plans(&plans, &found));
    }
    for (plan, found) in plans.iter().zip(&found) {
        if options.json {
            answer(format_args!("{}\n", table::plan_json(plan, found)));
        } else {
            answer(table::plan(plan, found));
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn make_plans(recipes: &Recipes, store: &Store, common: &Common) -> Result<Vec<Plan>> {
    let plugins = PluginPath::new(&common.plugin_path);
    build::plan_all(
        &recipes.recipes,
        &build::BuildOptions {
            store,
            plugins: &plugins,
            overrides: &recipes.set,
            matrix: matrix(recipes),
            locking: Locking::Update,
            budget: Budget::cores(1),
            out: PathBuf::new(),
            waivers: Waivers::Respect,
            sandbox: Default::default(),
            threads: None,
            limits: Default::default(),
            observer: &Silent,
            is_cancelled: &|| false,
        },
    )
}

/// `fibar plugin list`
pub fn plugin_list(options: &ListOptions, common: &Common) -> Result<ExitCode> {
    let found = PluginPath::new(&common.plugin_path).list();
    if options.names {
        for (name, path) in &found {
            answer(format_args!("{name}\t{}\n", path.display()));
        }
        return Ok(ExitCode::SUCCESS);
    }
    let store = open_store(common)?;
    for (name, path) in &found {
        match Plugin::load(name, path, &store) {
            Ok(plugin) => answer(table::plugin(&plugin)),
            Err(_) => answer(format_args!("{name}\n  is no plugin of this version: {}\n", path.display())),
        }
    }
    store.stats.save();
    Ok(ExitCode::SUCCESS)
}

/// `fibar plugin describe`
pub fn plugin_describe(name: &str, common: &Common) -> Result<ExitCode> {
    let path = PluginPath::new(&common.plugin_path).find(name).ok_or_else(|| {
        let finding = Diagnostic::error(format!("there is no plugin `{name}`"));
        Error::new(Class::Recipe, finding.hint("`fibar plugin list` shows those found"))
    })?;
    let plugin = Plugin::load(name, &path, &open_store(common)?)?;
    let text = serde_json::to_string_pretty(&plugin.description).expect("a description is plain data");
    answer(format_args!("{text}\n"));
    Ok(ExitCode::SUCCESS)
}

/// `fibar plugin required`
pub fn plugin_required(recipes: &[PathBuf]) -> Result<ExitCode> {
    let mut names = BTreeSet::new();
    for path in recipes {
        let none: &[Override] = &[];
        let reading = Recipe::read(path, none, Matrix::Expand)?;
        if !reading.findings.is_empty() {
            return Err(Error { class: Class::Recipe, findings: reading.findings });
        }
        let stages = reading.recipes.into_iter().flat_map(|recipe| recipe.stages);
        names.extend(stages.map(|stage| stage.plugin));
    }
    names.iter().for_each(|name| answer(format_args!("{name}\n")));
    Ok(ExitCode::SUCCESS)
}

fn open_store(common: &Common) -> Result<Store> {
    Store::open(&common.store.clone().unwrap_or_else(Store::default_root))
}
