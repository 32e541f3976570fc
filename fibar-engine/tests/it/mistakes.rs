//! What users are told when something is wrong.

use crate::bench::{Bench, book};
use fibar_engine::Class;
use fibar_engine::host::Sandbox;

/// A recipe that cannot be built: its class, and what the message must say.
#[track_caller]
fn check(recipe: &str, class: Class, says: &[&str]) {
    let bench = Bench::new();
    let error = bench.build(recipe).expect_err("this recipe is wrong");
    let text = error.render();
    for part in says {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
    assert_eq!(error.class, class, "{text}");
    assert_eq!(bench.list("build"), [""; 0], "something was published");
    assert_eq!(bench.list("store/tmp"), [""; 0], "something was left half-written");
}

#[test]
fn recipe_mistakes_are_reported_at_once() {
    let recipe = book("txt = 'a'\ntimes = 10", "sed = 1", "word = 3") + "[[stage]]\nuse = 'mak-text'\n";
    let says =
        ["`txt`", "`text`?", "10 is out of range", "from 1 to 9", "`sed`", "expected a text", "`make-text`?"];
    check(&recipe, Class::Recipe, &says);
}

#[test]
fn missing_parts_are_named() {
    check("", Class::Recipe, &["does not state its format", "names no object", "no [[stage]]"]);
    check("fibar = 2\n", Class::Recipe, &["format 1"]);
    check("fibar = 1\n[object]\nname = 'a/b'\n", Class::Recipe, &["recipe.toml:3:8"]);
    check("fibar = 1\n[[stage]\n", Class::Recipe, &["recipe.toml:2:9", "expected `]`"]);
    check("fibar = 1\n[object]\nname='a'\n[[stage]]\nid='x'\n", Class::Recipe, &["names no plugin"]);
}

#[test]
fn wires_are_typed() {
    let head = "fibar = 1\n[object]\nname = 'a'\n[[stage]]\nuse = 'make-text'\n";
    let with = |rest: &str| format!("{head}{rest}");
    check(&with("[[stage]]\nuse = 'verify-text'\n"), Class::Recipe, &["gives the `book` it needs"]);
    let upper = |from: &str| with(&format!("[[stage]]\nuse = 'upper-text'\nfrom = {from}\n"));
    check(&upper("'mak-text'"), Class::Recipe, &["no stage `mak-text`", "`make-text`?"]);
    check(&upper("{ txt = 'make-text' }"), Class::Recipe, &["no input `txt`", "`text`?"]);
    check(&upper("{ text = 'make-text.tex' }"), Class::Recipe, &["called `tex`"]);
    check(&upper("{ text = 'upper-text' }"), Class::Recipe, &["gives no `text`"]);
}

#[test]
fn missing_files_are_input_errors() {
    check(&book("file = 'nope.txt'", "", ""), Class::Input, &["recipe.toml:6:8", "nope.txt", "no such file"]);
}

#[test]
fn a_stage_can_blame_a_line() {
    let says = ["stage `make-text`: there is nothing to say", "recipe.toml:6:8", "say something"];
    check(&book("text = ''", "", ""), Class::Recipe, &says);
}

#[test]
fn two_outputs_of_one_name_are_refused() {
    let recipe = book("", "", "") + "[[stage]]\nuse = 'upper-text'\n";
    let bench = Bench::new();
    let error = bench.build(&recipe).expect_err("both publish upper.txt");
    assert!(error.render().contains("both publish upper.txt"), "{error}");
}

/// The stage knows a copy of the file; people know what they wrote.
#[test]
fn a_stage_names_a_file_as_the_recipe_does() {
    for sandbox in [Sandbox::Off, Sandbox::Auto] {
        let bench = Bench { sandbox, ..Bench::new() };
        bench.write("notes.txt", "one\ntwo\n");
        let recipe = "fibar = 1\n[object]\nname = 'a'\n[[stage]]\nuse = 'rude-stage'\n\
                      how = 'blame a file'\nfile = './notes.txt'\n";
        let error = bench.build(recipe).expect_err("it blames the file").render();
        assert!(error.contains("stage `rude-stage`: ./notes.txt:3: odd, see ./notes.txt\n"), "{error}");
        assert!(error.contains("recipe.toml:7:8"), "{error}");
    }
}
