//! Every recipe that comes with fibar is sound: its keys, wires and files, held against the plugins' own schemas.

use fibar_tests::{Workshop, checkout};

#[test]
fn every_recipe_can_be_planned() {
    let workshop = Workshop::default();
    for folder in ["recipes", "recipes/paper"] {
        let entries = std::fs::read_dir(checkout().join(folder)).unwrap().flatten();
        let recipes: Vec<_> =
            entries.map(|e| e.path()).filter(|p| p.extension() == Some("toml".as_ref())).collect();
        assert!(recipes.len() >= 3, "{folder} holds {recipes:?}");
        for recipe in recipes {
            workshop.run(&["plan", recipe.to_str().unwrap()]).expect(0);
        }
    }
}
