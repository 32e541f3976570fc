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

#[test]
fn a_change_is_followed_to_the_line_that_made_it() {
    let bench = Bench::new();
    bench.build(&book("text = 'bye'", "", "")).unwrap();
    check(
        &bench,
        &[],
        "verify-text",
        expect![[r#"
        `verify-text` (verify-text) hit #: the store has this, nothing would run
    "#]],
    );
    check(
        &bench,
        &["verify-text.word=x"],
        "verify-text",
        expect![[r#"
        `verify-text` (verify-text) miss #: would run
          compared with the earlier run #:
          params/word: "" → "x"  (--set verify-text.word:1:1)
    "#]],
    );
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
    bench.build(&book("text = 'BYE'", "", "")).unwrap();
    bench.write("recipe.toml", &book("text = 'bye'\ntimes = 2", "", ""));
    bench.build_with(&book("text = 'bye'\ntimes = 2", "seconds = 0", ""), &[], &|| false).unwrap();
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
fn the_first_run_and_a_lost_artefact_are_told_apart() {
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
    bench.build(&book("", "", "")).unwrap();
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
