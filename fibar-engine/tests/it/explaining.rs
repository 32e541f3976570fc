//! Why something would run.

use crate::bench::{Bench, book};
use expect_test::{Expect, expect};
use fibar_engine::explain::explain;

/// The explanation of a stage after the recipe has been built and changed, digests blotted out.
#[track_caller]
fn check(bench: &Bench, set: &[&str], stage: &str, expected: Expect) {
    let store = bench.store();
    let plan = bench.plans(&store, set).remove(0);
    let text = explain(&plan, stage, &store, &bench.path("build/book/fibar.lock")).unwrap().to_string();
    let text = text.replace(&format!("{}/", bench.folder.path().display()), "");
    expected.assert_eq(&blotted(&text));
}

fn blotted(text: &str) -> String {
    let words = text.split_inclusive([' ', ':', ',', '\n']).map(|word| {
        let bare = word.trim_end_matches([' ', ':', ',', '\n']);
        let is_digest = bare.len() == 12 && bare.bytes().all(|b| b.is_ascii_hexdigit());
        if is_digest { word.replace(bare, "#") } else { word.to_owned() }
    });
    words.collect()
}

/// A bench where the book with this first stage has been built.
fn built(make: &str) -> Bench {
    let bench = Bench::new();
    bench.build(&book(make, "", "")).unwrap();
    bench
}

#[test]
fn what_the_store_has_would_not_run() {
    check(
        &built(""),
        &[],
        "verify-text",
        expect![[r#"
        `verify-text` (verify-text) hit #: the store has this, nothing would run
    "#]],
    );
}

#[test]
fn a_value_set_from_outside_is_the_reason() {
    check(
        &built(""),
        &["verify-text.word=x"],
        "verify-text",
        expect![[r#"
        `verify-text` (verify-text) miss #: would run
          compared with the earlier run #:
          params/word: "" → "x"  (--set verify-text.word:1:1)
    "#]],
    );
}

#[test]
fn a_change_is_followed_to_the_line_that_made_it() {
    let bench = built("text = 'bye'");
    bench.write("recipe.toml", &book("text = 'byes'", "", ""));
    check(
        &bench,
        &[],
        "make-text",
        expect![[r#"
        `make-text` (make-text) miss #: would run
          compared with the earlier run #:
          params/text: "bye" → "byes"  (recipe.toml:6:8)
    "#]],
    );
    check(
        &bench,
        &[],
        "verify-text",
        expect![[r#"
        `verify-text` (verify-text) waits for its inputs
          compared with the earlier run #:
          inputs/book: # → whatever `bind-text` gives
            `bind-text` (bind-text) waits for its inputs
              compared with the earlier run #:
              inputs/pages: # → whatever `upper-text` gives
                `upper-text` (upper-text) waits for its inputs
                  compared with the earlier run #:
                  inputs/text: # → whatever `make-text` gives
                    `make-text` (make-text) miss #: would run
                      compared with the earlier run #:
                      params/text: "bye" → "byes"  (recipe.toml:6:8)
    "#]],
    );
}

/// The store knows two earlier runs; the last build counts, not the one before.
#[test]
fn the_last_build_is_what_a_stage_is_compared_with() {
    let bench = built("text = 'BYE'");
    bench.build(&book("text = 'bye'\ntimes = 2", "", "")).unwrap();
    bench.write("recipe.toml", &book("text = 'BYE'\ntimes = 2", "", "word = 'q'"));
    check(
        &bench,
        &[],
        "bind-text",
        expect![[r#"
        `bind-text` (bind-text) waits for its inputs
          compared with the earlier run #:
          inputs/pages: # → whatever `upper-text` gives
            `upper-text` (upper-text) waits for its inputs
              compared with the earlier run #:
              inputs/text: # → whatever `make-text` gives
                `make-text` (make-text) miss #: would run
                  compared with the earlier run #:
                  params/text: "bye" → "BYE"  (recipe.toml:6:8)
    "#]],
    );
}

#[test]
fn a_first_run_has_nothing_to_be_compared_with() {
    let bench = Bench::new();
    bench.write("recipe.toml", &book("", "", ""));
    check(
        &bench,
        &[],
        "make-text",
        expect![[r#"
        `make-text` (make-text) miss #: would run
          the store knows no earlier run of it
    "#]],
    );
}

#[test]
fn a_lost_artefact_is_the_reason() {
    let bench = built("");
    let blob = bench.path("store/cas").join(fibar_engine::Digest::of(b"hello").to_string());
    std::fs::remove_file(blob).unwrap();
    check(
        &bench,
        &[],
        "make-text",
        expect![[r#"
        `make-text` (make-text) miss #: the store had this, but an output is gone
    "#]],
    );
}
