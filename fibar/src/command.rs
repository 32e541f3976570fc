//! One function per command.

use crate::arguments::{BuildOptions, Common, ListOptions, PlanOptions, Recipes, VerifyOptions};
use crate::progress::Progress;
use crate::table;
use fibar_core::diagnostic::Diagnostic;
use fibar_engine::build::{self, Budget, Silent, Waivers};
use fibar_engine::ledger::BuildReport;
use fibar_engine::plan::Plan;
use fibar_engine::plugin::{Plugin, PluginPath};
use fibar_engine::recipe::{Override, Recipe};
use fibar_engine::{Class, Error, Result, Store, os};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::ExitCode;

/// `fibar build`
pub fn build(options: &BuildOptions, common: &Common) -> Result<ExitCode> {
    let reports = run_build(options, Waivers::Respect, common)?;
    for report in &reports {
        print!("{}", table::build(report));
    }
    Ok(verdict(&reports))
}

/// `fibar verify`
pub fn verify(options: &VerifyOptions, common: &Common) -> Result<ExitCode> {
    let waivers = if options.strict { Waivers::Ignore } else { Waivers::Respect };
    let reports = run_build(&options.build, waivers, common)?;
    for report in &reports {
        print!("{}", table::verification(report));
    }
    Ok(verdict(&reports))
}

fn verdict(reports: &[BuildReport]) -> ExitCode {
    let verified = reports.iter().all(BuildReport::is_verified);
    if verified { ExitCode::SUCCESS } else { ExitCode::from(Class::Verification as u8) }
}

fn run_build(options: &BuildOptions, waivers: Waivers, common: &Common) -> Result<Vec<BuildReport>> {
    let store = open_store(common)?;
    let plugins = PluginPath::new(&common.plugin_path);
    let progress = Progress::start(options.verbose);
    build::build(
        &options.recipes.recipes,
        &build::BuildOptions {
            store: &store,
            plugins: &plugins,
            overrides: &options.recipes.set,
            budget: options.jobs.map_or_else(Budget::whole_machine, Budget::cores),
            out: options.out.clone(),
            waivers,
            sandbox: options.sandbox.into(),
            threads: None,
            limits: Default::default(),
            observer: &progress,
            is_cancelled: &|| os::interrupts() > 0,
        },
    )
}

/// `fibar plan`
pub fn plan(options: &PlanOptions, common: &Common) -> Result<ExitCode> {
    let store = open_store(common)?;
    let plans = make_plans(&options.recipes, &store, common)?;
    for plan in &plans {
        let found = build::predict(plan, &store);
        if options.json {
            println!("{}", table::plan_json(plan, &found));
        } else {
            print!("{}", table::plan(plan, &found));
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
            println!("{name}\t{}", path.display());
        }
        return Ok(ExitCode::SUCCESS);
    }
    let store = open_store(common)?;
    for (name, path) in &found {
        match Plugin::load(name, path, &store) {
            Ok(plugin) => print!("{}", table::plugin(&plugin)),
            Err(_) => println!("{name}\n  is no plugin of this version: {}", path.display()),
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
    println!("{text}");
    Ok(ExitCode::SUCCESS)
}

/// `fibar plugin required`
pub fn plugin_required(recipes: &[PathBuf]) -> Result<ExitCode> {
    let mut names = BTreeSet::new();
    for path in recipes {
        let none: &[Override] = &[];
        let reading = Recipe::read(path, none)?;
        if !reading.findings.is_empty() {
            return Err(Error { class: Class::Recipe, findings: reading.findings });
        }
        names.extend(reading.recipe.stages.into_iter().map(|stage| stage.plugin));
    }
    names.iter().for_each(|name| println!("{name}"));
    Ok(ExitCode::SUCCESS)
}

fn open_store(common: &Common) -> Result<Store> {
    Store::open(&common.store.clone().unwrap_or_else(Store::default_root))
}
