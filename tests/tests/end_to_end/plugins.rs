//! Every plugin that comes with fibar tells what a recipe can ask of it, and keeps the promises of the protocol.

use fibar_tests::{Workshop, checkout, executables, is_full};
use serde_json::Value;

#[test]
fn every_parameter_has_a_default_and_words() {
    let workshop = Workshop::default();
    for name in names() {
        let about = workshop.run(&["plugin", "describe", &name]).expect(0).stdout;
        let about: Value = serde_json::from_str(&about).unwrap();
        assert_eq!(about["name"], name.as_str());
        for (parameter, schema) in about["params"]["properties"].as_object().unwrap() {
            assert!(schema.get("default").is_some(), "{name} shows no default of {parameter}: {schema}");
            assert!(schema["description"].is_string(), "{name} does not say what {parameter} is: {schema}");
        }
    }
}

/// What can be asked without inputs: descriptions, versions, unknown parameters, missing inputs. The Python environment of
/// `source-build123d` takes a minute to set up.
#[test]
fn every_plugin_keeps_the_promises_of_the_protocol() {
    let workshop = Workshop::default();
    for name in names().filter(|name| name != "source-build123d" || is_full()) {
        let said = workshop.run(&["plugin", "test", &name]).expect(0).stdout;
        assert!(said.lines().filter(|line| line.starts_with("  ok ")).count() >= 5, "{name}:\n{said}");
    }
}

/// What stands in a plugin enters its digest, and with it every key of a store that others may share.
#[test]
fn no_plugin_knows_where_it_was_compiled() {
    let here = checkout().to_str().unwrap().as_bytes();
    for name in names() {
        let bytes = std::fs::read(executables().join(&name)).unwrap();
        assert!(
            !bytes.windows(here.len()).any(|window| window == here),
            "{name} has the path of the checkout in it"
        );
    }
}

fn names() -> impl Iterator<Item = String> {
    let entries = std::fs::read_dir(checkout().join("plugins")).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap())
}
