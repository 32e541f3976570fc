//! Builds held against an earlier one: locks, provenance, determinism.

use crate::bench::{Bench, book};
use fibar_engine::Class;
use fibar_engine::build::{Locking, plan_all};
use fibar_engine::determinism::{Comparison, compare, second_store};
use fibar_engine::plugin::PluginPath;
use serde_json::Value;

#[test]
fn a_locked_build_refuses_to_differ() {
    let mut bench = Bench::new();
    bench.locking = Locking::Require;
    let error = bench.build(&book("", "", "")).unwrap_err();
    assert!(error.class == Class::Input && error.render().contains("build once without --locked"), "{error}");
    bench.locking = Locking::Update;
    bench.build(&book("", "", "")).unwrap();
    bench.locking = Locking::Require;
    bench.build(&book("", "", "")).unwrap();
    std::fs::remove_dir_all(bench.path("store")).unwrap();
    bench.build(&book("", "", "")).unwrap();

    let before = bench.read("build/book/text.txt");
    let error = bench.build(&book("text = 'other'", "", "")).unwrap_err();
    assert_eq!(error.class, Class::Verification);
    for part in ["differs from", "- stage make-text", "+ stage make-text", "+ output"] {
        assert!(error.render().contains(part), "{part:?} is not in {error}");
    }
    assert_eq!(bench.read("build/book/text.txt"), before, "nothing was published");

    bench.write_plugin("upper-text", "#!/bin/sh\nexit 1\n");
    let plugins = bench.path("plugins");
    std::fs::remove_file(plugins.join("upper-text")).unwrap();
    let mut other = std::fs::read(plugins.join("make-text")).unwrap();
    other.push(0);
    std::fs::write(plugins.join("upper-text"), other).unwrap();
    std::fs::set_permissions(
        plugins.join("upper-text"),
        std::fs::metadata(plugins.join("make-text")).unwrap().permissions(),
    )
    .unwrap();
    let error = bench.build(&book("", "", "")).unwrap_err();
    assert!(error.render().contains("stage `upper-text` is not as"), "{error}");
}

#[test]
fn lock_lines_are_sorted_and_equal_for_equal_builds() {
    let (one, two) = (Bench::new(), Bench::new());
    one.build(&book("", "", "")).unwrap();
    two.build(&book("", "", "")).unwrap();
    for file in ["fibar.lock", "provenance.json", "metrics.json"] {
        assert_eq!(
            one.read(&format!("build/book/{file}")),
            two.read(&format!("build/book/{file}")),
            "{file}"
        );
    }
    let lock = one.read("build/book/fibar.lock");
    assert!(lock.lines().skip(1).is_sorted(), "{lock}");
    assert_eq!(lock.lines().filter(|line| line.starts_with("stage ")).count(), 4);
}

#[test]
fn provenance_names_everything_by_digest() {
    let bench = Bench::new();
    bench.write("more.txt", " world");
    bench.build(&book("file = 'more.txt'", "", "")).unwrap();
    let statement: Value = serde_json::from_str(&bench.read("build/book/provenance.json")).unwrap();
    assert_eq!(statement["_type"], "https://in-toto.io/Statement/v1");
    assert_eq!(statement["predicateType"], "https://slsa.dev/provenance/v1");
    for subject in statement["subject"].as_array().unwrap() {
        let name = subject["name"].as_str().unwrap();
        let bytes = std::fs::read(bench.path("build/book").join(name)).unwrap();
        assert_eq!(subject["digest"]["sha256"], fibar_engine::Digest::of(&bytes).to_string(), "{name}");
    }
    let subjects: Vec<_> =
        statement["subject"].as_array().unwrap().iter().map(|s| s["name"].clone()).collect();
    assert_eq!(subjects, ["book/pages/0.txt", "book/title.txt", "text.txt", "upper.txt"]);
    let made_from = &statement["predicate"]["buildDefinition"]["resolvedDependencies"];
    let names: Vec<_> = made_from.as_array().unwrap().iter().map(|d| d["name"].as_str().unwrap()).collect();
    for name in
        ["recipe/recipe.toml", "file/make-text/file/more.txt", "plugin/make-text", "plugin/verify-text"]
    {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
}

#[test]
fn a_trace_can_be_read_by_a_browser() {
    let bench = Bench::new();
    bench.build(&book("", "", "")).unwrap();
    let trace: Value = serde_json::from_str(&bench.read("build/book/trace.json")).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    assert_eq!(events.len(), 4);
    assert!(events.iter().all(|e| e["ph"] == "X" && e["ts"].is_number() && e["dur"].is_number()), "{trace}");
}

/// Compares two builds of a recipe.
fn comparison(recipe: &str) -> (Bench, Comparison) {
    let bench = Bench::new();
    let path = bench.write("recipe.toml", recipe);
    let (store, plugins) = (bench.store(), PluginPath::only(vec![bench.path("plugins")]));
    let options = bench.options(&store, &plugins, &[], &|| false);
    let plans = plan_all(&[path], &options).unwrap();
    let found = compare(&plans, &options, &second_store(&store).unwrap()).unwrap().remove(0);
    (bench, found)
}

#[test]
fn a_stage_that_depends_on_its_threads_is_found() {
    let recipe = book("", "", "") + "[[stage]]\nuse = 'leak-text'\n";
    let (bench, found) = comparison(&recipe);
    let difference = found.difference.expect("it leaks");
    assert_eq!((difference.stage.as_str(), difference.artefact.as_str()), ("leak-text", "leak (leak.json)"));
    assert_eq!(difference.field.as_deref(), Some("/ran/threads"));
    assert_eq!(difference.byte, "{\"format\": \"leak/1\", \"ran\": {\"threads\": ".len());
    assert_eq!(difference.seen[1], "3");
    assert_eq!(bench.list("build"), [""; 0], "comparing publishes nothing");
    let (_, found) = comparison(&book("", "", ""));
    assert_eq!((found.same, found.difference), (4, None));
}
