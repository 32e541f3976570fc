//! Every plugin that comes with fibar tells what a recipe can ask of it.

use fibar_tests::{Workshop, checkout};
use serde_json::Value;

#[test]
fn every_parameter_has_a_default_and_words() {
    let workshop = Workshop::default();
    let entries = std::fs::read_dir(checkout().join("plugins")).unwrap();
    for name in entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()) {
        let about = workshop.run(&["plugin", "describe", &name]).expect(0).stdout;
        let about: Value = serde_json::from_str(&about).unwrap();
        assert_eq!(about["name"], name.as_str());
        for (parameter, schema) in about["params"]["properties"].as_object().unwrap() {
            assert!(schema.get("default").is_some(), "{name} shows no default of {parameter}: {schema}");
            assert!(schema["description"].is_string(), "{name} does not say what {parameter} is: {schema}");
        }
    }
}
