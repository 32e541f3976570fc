//! Every recipe that comes with fibar is sound: its keys, wires and files, held against the plugins' own schemas; and gives
//! the same bytes again.

use fibar_tests::{Workshop, checkout, is_full};
use std::path::PathBuf;

/// Recipes of the checkout, ours and the paper's.
fn recipes() -> Vec<PathBuf> {
    let of_folder = |folder: &str| {
        let entries = std::fs::read_dir(checkout().join(folder)).unwrap().flatten();
        let recipes: Vec<_> =
            entries.map(|e| e.path()).filter(|p| p.extension() == Some("toml".as_ref())).collect();
        assert!(recipes.len() >= 3, "{folder} holds {recipes:?}");
        recipes
    };
    ["recipes", "recipes/paper"].into_iter().flat_map(of_folder).collect()
}

#[test]
fn every_recipe_can_be_planned() {
    let workshop = Workshop::default();
    for recipe in recipes() {
        workshop.run(&["plan", recipe.to_str().unwrap()]).expect(0);
    }
}

/// All but the pebble take minutes.
#[test]
fn every_recipe_gives_the_same_bytes_again() {
    let workshop = Workshop::default();
    for recipe in recipes() {
        if is_full() || recipe.file_stem() == Some("pebble".as_ref()) {
            workshop.run(&["check-determinism", recipe.to_str().unwrap()]).expect(0);
        }
    }
}
