//! The conformance kit, and a stage in Python.

use crate::bench::Bench;
use fibar_engine::conformance::{Samples, Verdict, check};
use std::path::{Path, PathBuf};

/// Every check of a plugin as `kept`, `broken` or `skipped`, by name.
fn verdicts(bench: &Bench, executable: &Path, inputs: &[(&str, PathBuf)]) -> Vec<(&'static str, String)> {
    let mut samples = Samples::default();
    for (port, path) in inputs {
        samples.inputs.insert((*port).to_owned(), vec![path.clone()]);
    }
    let word = |verdict: Verdict| match verdict {
        Verdict::Kept => "kept".to_owned(),
        Verdict::Broken(reason) => format!("broken: {reason}"),
        Verdict::Skipped(reason) => format!("skipped: {reason}"),
    };
    let checks = check(executable, &samples, &bench.store(), &|_| {}).unwrap();
    checks.into_iter().map(|check| (check.name, word(check.verdict))).collect()
}

#[track_caller]
fn check_broken(bench: &Bench, plugin: &str, wanted: &[&str]) {
    let text = bench.write("text", "hello");
    let found = verdicts(bench, &bench.path("plugins").join(plugin), &[("text", text)]);
    let broken: Vec<&str> =
        found.iter().filter(|(_, v)| v.starts_with("broken")).map(|(name, _)| *name).collect();
    assert_eq!(broken, wanted, "{found:#?}");
}

#[test]
fn the_kit_tells_good_plugins_from_bad_ones() {
    let bench = Bench::new();
    check_broken(&bench, "make-text", &[]);
    check_broken(&bench, "upper-text", &[]);
    check_broken(&bench, "leak-text", &["gives the same bytes again"]);
    check_broken(&bench, "rude-stage", &["refuses another protocol version", "refuses unknown parameters"]);
    bench.write_plugin("odd-stage", "#!/bin/sh\necho hello\n");
    check_broken(&bench, "odd-stage", &["describes itself"]);
    let found = verdicts(&bench, &bench.path("plugins/upper-text"), &[]);
    assert!(found.iter().any(|(_, v)| v.contains("--input text=FILE")), "{found:?}");
}

/// The example in the documentation, as a plugin; `None` where there is no Python.
fn python_stage(bench: &Bench) -> Option<PathBuf> {
    let python = std::process::Command::new("/usr/bin/env").args(["python3", "--version"]).output();
    if !python.is_ok_and(|output| output.status.success()) {
        println!("skipped: there is no python3");
        return None;
    }
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/examples/count-words");
    bench.write_plugin("count-words", &std::fs::read_to_string(source).unwrap());
    Some(bench.path("plugins/count-words"))
}

#[test]
fn a_stage_in_python_keeps_the_protocol() {
    let bench = Bench::new();
    let Some(stage) = python_stage(&bench) else { return };
    let text = bench.write("text", "hello");
    let found = verdicts(&bench, &stage, &[("text", text)]);
    assert!(found.iter().all(|(name, v)| v == "kept" || *name == "stops when asked"), "{found:#?}");
}

#[test]
fn a_stage_in_python_runs_in_a_recipe() {
    let bench = Bench::new();
    let Some(_) = python_stage(&bench) else { return };
    let recipe = |word: &str| {
        format!(
            "fibar = 1\n[object]\nname = 'book'\n[[stage]]\nuse = 'make-text'\ntext = 'a b a'\n\
             [[stage]]\nuse = 'count-words'\nword = '{word}'\n"
        )
    };
    bench.runs(&recipe("a"), &["make-text", "count-words"]);
    assert_eq!(
        bench.read("build/book/words.json"),
        "{\"format\": \"words/1\", \"words\": {\"a\": 2, \"b\": 1}}\n"
    );
    assert!(bench.read("build/book/metrics.json").contains("\"words.found\": {\"unit\":\"1\",\"value\":2}"));
    bench.runs(&recipe("a"), &[]);
    let report = bench.build(&recipe("c")).unwrap();
    assert_eq!(report.violations[0].violation.rule, "words.missing");
    let error = bench.build(&recipe("")).unwrap_err();
    assert!(error.render().contains("recipe.toml:9:8"), "{error}");
}
