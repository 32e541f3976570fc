//! What lies in the build folder.

use crate::bench::{Bench, book};
use expect_test::{Expect, expect};
use fibar_engine::Class;
use fibar_engine::build::Waivers;
use std::time::{Duration, Instant};

#[track_caller]
fn check(bench: &Bench, file: &str, expected: Expect) {
    expected.assert_eq(&bench.read(&format!("build/book/{file}")));
}

#[test]
fn outputs_and_metrics_are_published() {
    let bench = Bench::new();
    bench.build(&book("times = 2", "", "word = 'zebra'")).unwrap();
    let expected = [
        "book",
        "fibar.lock",
        "metrics.json",
        "provenance.json",
        "text.txt",
        "timings.json",
        "trace.json",
        "upper.txt",
    ];
    assert_eq!(bench.list("build/book"), expected);
    check(&bench, "book/pages/0.txt", expect!["HELLOHELLO"]);
    check(
        &bench,
        "metrics.json",
        expect![[r#"
            {
              "text.bytes": {"unit":"1","value":10}
            }
        "#]],
    );
    let metrics = bench.read("build/book/metrics.json");
    bench.build(&book("times = 2", "", "word = 'zebra'")).unwrap();
    assert_eq!(bench.read("build/book/metrics.json"), metrics, "a hit reproduces metrics");
}

#[test]
fn a_broken_rule_marks_the_build_until_it_is_allowed() {
    let mut bench = Bench::new();
    let report = bench.build(&book("", "", "word = 'HELL'")).unwrap();
    assert!(!report.is_verified());
    check(
        &bench,
        "UNVERIFIED",
        expect![[r#"
            The files beside this one break these rules:

            text.word (verify-text): "HELL" is on the first page at (1.000, 2.000, 3.000) mm
        "#]],
    );
    assert!(
        !bench.build(&book("", "", "word = 'HELL'")).unwrap().is_verified(),
        "a hit reproduces violations"
    );

    let allowed = book("", "", "word = 'HELL'\nallow = ['text.word']");
    let report = bench.build(&allowed).unwrap();
    assert!(report.is_verified() && report.violations.len() == 1 && report.executed() == 0);
    assert!(!bench.path("build/book/UNVERIFIED").exists());

    bench.waivers = Waivers::Ignore;
    assert!(!bench.build(&allowed).unwrap().is_verified());
}

#[test]
fn outputs_that_are_no_longer_made_go_away_unless_edited() {
    let bench = Bench::new();
    bench.build(&book("", "name = 'a.txt'", "")).unwrap();
    bench.build(&book("", "name = 'b.txt'", "")).unwrap();
    assert!(!bench.path("build/book/a.txt").exists());
    bench.write("build/book/b.txt", "mine");
    bench.build(&book("", "name = 'c.txt'", "")).unwrap();
    assert_eq!(bench.read("build/book/b.txt"), "mine");
}

#[test]
fn an_edited_output_is_put_right() {
    let bench = Bench::new();
    bench.build(&book("", "", "")).unwrap();
    bench.write("build/book/upper.txt", "XXXXX");
    bench.write("build/book/book/title.txt", "XXXXX");
    bench.build(&book("", "", "")).unwrap();
    check(&bench, "upper.txt", expect!["HELLO"]);
    check(&bench, "book/title.txt", expect!["1 pages"]);
}

#[test]
fn values_can_be_set_from_outside() {
    let bench = Bench::new();
    bench.build_with(&book("", "", ""), &["make-text.text=\"one\"", "make-text.times=2"], &|| false).unwrap();
    check(&bench, "text.txt", expect!["oneone"]);
    bench.build_with(&book("", "", ""), &["make-text.text=two words"], &|| false).unwrap();
    check(&bench, "text.txt", expect!["two words"]);
    let error = bench.build_with(&book("", "", ""), &["mak-text.text=1"], &|| false).unwrap_err();
    assert!(error.render().contains("did you mean `make-text`?"), "{error}");
}

#[track_caller]
fn check_cancel(upper: &str) {
    let bench = Bench::new();
    let started = Instant::now();
    let stop = || started.elapsed() > Duration::from_millis(300);
    let error = bench.build_with(&book("", upper, ""), &[], &stop).unwrap_err();
    assert_eq!(error.class, Class::Cancelled, "{error}");
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
    assert_eq!(bench.list("store/work"), [""; 0]);
    bench.runs(&book("", "", ""), &["upper-text", "bind-text", "verify-text"]);
}

#[test]
fn a_build_can_be_stopped_and_goes_on_from_there() {
    check_cancel("seconds = 9");
    check_cancel("seconds = 9\ndeaf = true");
}

#[test]
fn independent_stages_run_side_by_side() {
    let bench = Bench::new();
    let upper = |id: u32| format!("[[stage]]\nuse = 'upper-text'\nname = '{id}.txt'\nseconds = 0.4\n");
    let recipe = "fibar = 1\n[object]\nname = 'book'\n[[stage]]\nuse = 'make-text'\n".to_owned();
    bench.build(&(recipe + &upper(1) + &upper(2))).unwrap();
    let timings: serde_json::Value = serde_json::from_str(&bench.read("build/book/timings.json")).unwrap();
    let span = |stage: usize| {
        let time = |key: &str| timings["stages"][stage][key].as_f64().unwrap();
        (time("start_s"), time("start_s") + time("seconds"))
    };
    let (first, second) = (span(1), span(2));
    assert!(first.0 < second.1 && second.0 < first.1, "{first:?} and {second:?} do not overlap");
}
