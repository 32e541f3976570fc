//! Matrix, profiles, and plans of many variants.

use crate::bench::{Bench, book};
use fibar_engine::build::Outcome;
use fibar_engine::ledger::BuildReport;
use fibar_engine::recipe::Matrix;

/// The variants of a recipe: name, and ids of the stages that ran.
fn ran(reports: &[BuildReport]) -> Vec<(&str, Vec<&str>)> {
    reports
        .iter()
        .map(|report| {
            let stages = report.stages.iter().filter(|s| s.outcome == Outcome::Executed);
            (report.name.as_str(), stages.map(|s| s.id.as_str()).collect())
        })
        .collect()
}

#[test]
fn variants_share_every_stage_they_can() {
    let mut bench = Bench::new();
    let matrix = "[matrix]\n\"verify-text.word\" = ['x', 'y']\n\"upper-text.name\" = ['a.txt', 'b.txt']\n";
    let recipe = book("", "", "") + matrix;
    assert_eq!(bench.build(&recipe).unwrap().name, "book");
    assert_eq!(bench.list("build"), ["book"], "the matrix counts only when asked for");
    let fresh = Bench { matrix: Matrix::Expand, ..Bench::new() };
    let reports = fresh.build_all(&recipe, &[], &|| false).unwrap();
    let executed: usize = ran(&reports).iter().map(|(_, stages)| stages.len()).sum();
    // One text, two capitals with names of their own, whose bytes are the same: one book, two words looked for.
    assert_eq!(executed, 1 + 2 + 1 + 2, "{:?}", ran(&reports));
    let folders = [
        "book@word=x,name=a.txt",
        "book@word=x,name=b.txt",
        "book@word=y,name=a.txt",
        "book@word=y,name=b.txt",
    ];
    assert_eq!(fresh.list("build"), folders);
    assert!(fresh.path("build/book@word=y,name=b.txt/b.txt").exists());
    bench.matrix = Matrix::Expand;
    let error =
        bench.build(&(book("", "", "") + "[matrix]\n\"verify-text.wrd\" = ['x', 'y']\n")).unwrap_err();
    assert_eq!(error.findings.len(), 2, "{error}");
    assert!(error.render().contains("did you mean `word`?"), "{error}");
}

#[test]
fn a_variant_can_choose_another_plugin() {
    let bench = Bench { matrix: Matrix::Expand, ..Bench::new() };
    let recipe = "fibar = 1\n[object]\nname = 'book'\n[[stage]]\nuse = 'make-text'\n\
                  [[stage]]\nid = 'last'\nuse = 'upper-text'\n[matrix]\n'last.use' = ['upper-text', 'leak-text']\n";
    let reports = bench.build_all(recipe, &[], &|| false).unwrap();
    assert_eq!(
        ran(&reports),
        [("book@use=upper-text", vec!["make-text", "last"]), ("book@use=leak-text", vec!["last"])]
    );
}

#[test]
fn a_thousand_variants_can_be_planned() {
    let bench = Bench { matrix: Matrix::Expand, ..Bench::new() };
    let values = |n: usize| (0..n).map(|i| format!("'w{i}'")).collect::<Vec<_>>().join(", ");
    let matrix =
        format!("[matrix]\n'verify-text.word' = [{}]\n'make-text.text' = [{}]\n", values(100), values(10));
    bench.write("recipe.toml", &(book("", "", "") + &matrix));
    let store = bench.store();
    let plans = bench.plans(&store, &[]);
    assert_eq!(plans.len(), 1000);
    let names: std::collections::BTreeSet<&str> = plans.iter().map(|plan| plan.name.as_str()).collect();
    assert_eq!(names.len(), 1000);
}

#[test]
fn profiles_give_values_that_a_stage_does_not_give_itself() {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("profiles")).unwrap();
    let head = "fibar = 1\n[profile]\nname = 'p'\n[defaults.make-text]\n";
    bench.write(
        "profiles/loud.toml",
        &format!("{head}text = 'loud'\ntimes = 2\n[defaults.not-used]\nx = 1\n"),
    );
    bench.write("quiet.toml", &format!("{head}text = 'quiet'\n"));
    let recipe = |include: &str, make: &str| format!("include = {include}\n{}", book(make, "", ""));
    let check = |include: &str, make: &str, set: &[&str], expected: &str| {
        bench.build_with(&recipe(include, make), set, &|| false).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(bench.read("build/book/text.txt"), expected, "{include} {make} {set:?}");
    };
    check("'loud'", "", &[], "loudloud");
    check("['loud', './quiet.toml']", "", &[], "quietquiet");
    check("['loud']", "text = 'own'", &[], "ownown");
    check("['loud']", "text = 'own'", &["make-text.times=1"], "own");
    bench.write("profiles/loud.toml", &format!("{head}txt = 'loud'\n"));
    let error = bench.build(&recipe("'loud'", "")).unwrap_err().render();
    assert!(error.contains("profiles/loud.toml:5:1") && error.contains("did you mean `text`?"), "{error}");
    let error = bench.build(&recipe("'lout'", "")).unwrap_err().render();
    assert!(error.contains("recipe.toml:1:11") && error.contains("did you mean \"loud\"?"), "{error}");
}
