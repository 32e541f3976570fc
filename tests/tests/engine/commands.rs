//! Every command once, as a user types it.

use crate::demo::{Demo, STAGE_COUNT};
use fibar_tests::Outcome;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

impl Demo {
    /// The program with the demo's plugins.
    fn fibar(&self, words: &[&str]) -> Outcome {
        self.shop.run(&[words, &["--plugin-path", "plugins"]].concat())
    }

    fn read(&self, file: &str) -> String {
        std::fs::read_to_string(self.shop.path().join(file)).unwrap()
    }
}

/// Fails unless a command ends with this code and says every part, on standard output.
#[track_caller]
fn check(demo: &Demo, words: &[&str], code: i32, says: &[&str]) -> Outcome {
    let outcome = demo.fibar(words).expect(code);
    for part in says {
        assert!(outcome.stdout.contains(part), "{words:?} does not say {part:?}:\n{}", outcome.stdout);
    }
    outcome
}

#[test]
fn build() {
    let demo = Demo::new();
    check(&demo, &["build", "demo.toml"], 0, &["verified, 9 of 9 stages ran", "longest chain", "text.txt"]);
    check(&demo, &["build", "demo.toml"], 0, &["verified, nothing to do", "unchanged"]);
    check(&demo, &["build", "demo.toml", "-j", "1", "--out", "other"], 0, &["nothing to do", "other/demo"]);
    demo.fibar(&["build", "nowhere.toml"]).expect(3).says(&["nowhere.toml"]);
}

#[test]
fn build_with_values_set() {
    let demo = Demo::new();
    check(&demo, &["build", "demo.toml", "--set", "make-text.times=2"], 0, &["9 of 9"]);
    assert!(demo.read("build/demo/text.txt").starts_with("hellohello0123"));
    let misspelt = demo.fibar(&["build", "demo.toml", "--set", "make-text.tims=2"]).expect(2);
    misspelt.says(&["--set make-text.tims", "did you mean `times`?"]);
}

#[test]
fn build_locked() {
    let demo = Demo::new();
    demo.fibar(&["build", "demo.toml", "--locked"]).expect(3).says(&["build once without --locked"]);
    check(&demo, &["build", "demo.toml"], 0, &[]);
    check(&demo, &["build", "demo.toml", "--locked"], 0, &["nothing to do"]);
    let other = demo.fibar(&["build", "demo.toml", "--locked", "--set", "make-text.text=x"]).expect(1);
    other.says(&["differs from", "nothing was published", "- stage make-text", "+ stage make-text"]);
    assert!(demo.read("build/demo/text.txt").starts_with("hello"));
}

#[test]
fn build_variants() {
    let demo = Demo::new();
    let recipe = demo.read("demo.toml") + "[matrix]\n\"verify-text.word\" = [\"x\", \"y\", \"z\"]\n";
    demo.shop.write("demo.toml", recipe);
    check(&demo, &["plan", "demo.toml", "--matrix"], 0, &["3 variants, 27 stages, 0 hits"]);
    check(&demo, &["build", "demo.toml", "--matrix"], 0, &["demo@word=x", "demo@word=y", "demo@word=z"]);
    let executed = |word| Demo::executed_in(&demo.shop.path().join(format!("build/demo@word={word}")));
    let all: usize = ["x", "y", "z"].map(executed).iter().sum();
    assert_eq!(all, STAGE_COUNT + 2, "they share all but the last stage");
}

#[test]
fn build_with_a_profile() {
    let demo = Demo::new();
    demo.shop.write(
        "profiles/loud.toml",
        "fibar = 1\n[profile]\nname = \"loud\"\n[defaults.make-text]\ntext = \"LOUD\"\n",
    );
    let recipe = demo.read("demo.toml");
    demo.shop.write("demo.toml", format!("include = [\"loud\"]\n{recipe}"));
    check(&demo, &["build", "demo.toml"], 0, &["9 of 9"]);
    assert!(demo.read("build/demo/text.txt").starts_with("LOUD0123"));
}

/// What Ctrl-C sends; the stage that runs would take minutes.
#[test]
#[cfg(target_os = "linux")]
fn build_stopped() {
    let demo = Demo::new();
    let quick = demo.read("demo.toml");
    demo.shop.write("demo.toml", quick.replacen("seconds = 0.03", "seconds = 300", 1));
    for sandbox in ["auto", "off"] {
        let words = ["build", "demo.toml", "--plugin-path", "plugins", "--sandbox", sandbox];
        let mut build = demo.shop.program(&words).stderr(Stdio::piped()).spawn().unwrap();
        let mut said = BufReader::new(build.stderr.take().unwrap()).lines().map(Result::unwrap);
        assert!(said.any(|line| line.contains("pass-text: started")), "it never came to the long stage");
        Outcome::of(Command::new("kill").args(["-INT", &build.id().to_string()])).expect(0);
        let rest: Vec<String> = said.collect();
        assert_eq!(build.wait().unwrap().code(), Some(130), "{rest:?}");
        assert!(rest.iter().any(|line| line.contains("the same command goes on from there")), "{rest:?}");
        assert_eq!(processes_of(&demo), Vec::<PathBuf>::new(), "a stage lives on");
    }
    demo.shop.write("demo.toml", quick);
    check(&demo, &["build", "demo.toml"], 0, &["8 of 9 stages ran"]);
}

/// Processes that run in a folder of the workshop: stages, or those that keep them in their sandbox.
#[cfg(target_os = "linux")]
fn processes_of(demo: &Demo) -> Vec<PathBuf> {
    let entries = std::fs::read_dir("/proc").unwrap().flatten();
    let folders = entries.filter_map(|entry| std::fs::read_link(entry.path().join("cwd")).ok());
    folders.filter(|folder| folder.starts_with(demo.shop.path())).collect()
}

#[test]
fn a_build_leaves_its_trace() {
    let demo = Demo::new();
    check(&demo, &["build", "demo.toml"], 0, &[]);
    let trace: Value = serde_json::from_str(&demo.read("build/demo/trace.json")).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    assert_eq!(events.len(), STAGE_COUNT);
    for event in events {
        assert!(event["ph"] == "X" && event["dur"].as_f64().unwrap() > 0.0, "{event}");
    }
    let timings: Value = serde_json::from_str(&demo.read("build/demo/timings.json")).unwrap();
    let path: Vec<&str> =
        timings["critical_path"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    assert_eq!((path[0], path[path.len() - 1]), ("make-text", "verify-text"));
}

#[test]
fn verify() {
    let demo = Demo::new();
    check(&demo, &["verify", "demo.toml"], 0, &["verified", "no rule is broken"]);
    let word = ["--set", "verify-text.word=HELLO"];
    let broken = ["BROKEN text.word (verify-text): \"HELLO\" is on the first page at (1.00, 2.00, 3.00) mm"];
    check(&demo, &[&["verify", "demo.toml"][..], &word].concat(), 1, &broken);
    assert!(demo.read("build/demo/UNVERIFIED").contains("text.word"));
    let allowed =
        [&["verify", "demo.toml"][..], &word, &["--set", "verify-text.allow=[\"text.word\"]"]].concat();
    check(&demo, &allowed, 0, &["allowed text.word"]);
    check(&demo, &[&allowed[..], &["--strict"]].concat(), 1, &["BROKEN text.word"]);
}

#[test]
fn plan() {
    let demo = Demo::new();
    check(&demo, &["plan", "demo.toml"], 0, &["demo: 9 stages, 9 to run", "make-text", "miss"]);
    assert!(!demo.shop.path().join("build").exists(), "a plan builds nothing");
    check(&demo, &["build", "demo.toml"], 0, &[]);
    check(&demo, &["plan", "demo.toml"], 0, &["demo: 9 stages, 0 to run", "hit"]);
    let word = ["plan", "demo.toml", "--set", "verify-text.word=q", "--json"];
    let json: Value = serde_json::from_str(&check(&demo, &word, 0, &[]).stdout).unwrap();
    let misses = json["stages"].as_array().unwrap().iter().filter(|stage| stage["hit"] == false);
    assert_eq!(misses.map(|stage| stage["id"].as_str().unwrap()).collect::<Vec<_>>(), ["verify-text"]);
}

#[test]
fn explain() {
    let demo = Demo::new();
    let [first, last] = [["explain", "demo.toml", "make-text"], ["explain", "demo.toml", "verify-text"]];
    check(&demo, &first, 0, &["would run", "the store knows no earlier run of it"]);
    check(&demo, &["build", "demo.toml"], 0, &[]);
    check(&demo, &last, 0, &["hit", "nothing would run"]);
    demo.shop.write("big.txt", "another file");
    let reasons = ["waits for its inputs", "inputs/book", "`make-text`", "params/file", "demo.toml:6:8"];
    check(&demo, &last, 0, &reasons);
    demo.fibar(&["explain", "demo.toml", "mak-text"]).expect(2).says(&["did you mean `make-text`?"]);
}

#[test]
fn check_determinism() {
    let demo = Demo::new();
    check(&demo, &["check-determinism", "demo.toml"], 0, &["demo: 9 outputs are the same, byte by byte"]);
    let leak = "[[stage]]\nuse = \"leak-text\"\nfrom = \"make-text\"\n";
    demo.shop.write("demo.toml", demo.read("demo.toml") + leak);
    let found =
        ["demo: `leak-text` gives another leak (leak.json): byte 40, /ran/threads", "first:", "second:"];
    check(&demo, &["check-determinism", "demo.toml"], 1, &found);
}

#[test]
fn cache() {
    let demo = Demo::new();
    check(&demo, &["build", "demo.toml"], 0, &[]);
    check(&demo, &["cache", "stats"], 0, &["9 actions", "0 quarantined"]);
    check(&demo, &["cache", "verify"], 0, &["0 damaged", "9 actions: 0 unreadable, 0 incomplete"]);
    check(&demo, &["cache", "gc", "--max-size", "1k"], 0, &["freed 0 B", "build folders refer to"]);
    let blob = std::fs::read_dir(demo.shop.path().join("store/cas")).unwrap().next().unwrap().unwrap().path();
    std::fs::remove_file(&blob).unwrap();
    std::fs::write(&blob, "rot").unwrap();
    check(&demo, &["cache", "verify"], 1, &["1 damaged", "quarantined"]);
    check(&demo, &["cache", "stats"], 0, &["1 quarantined"]);
    check(&demo, &["build", "demo.toml"], 0, &["verified"]);
    check(&demo, &["cache", "verify"], 0, &["0 damaged", "0 incomplete"]);
    demo.fibar(&["cache", "gc", "--max-size", "much"]).expect(2).says(&["use k, M, G or T"]);
}

#[test]
fn plugins() {
    let demo = Demo::new();
    check(&demo, &["plugin", "list"], 0, &["make-text", "[text -> upper]", "Says it in capitals."]);
    check(&demo, &["plugin", "list", "--names"], 0, &["make-text\t"]);
    let about: Value =
        serde_json::from_str(&check(&demo, &["plugin", "describe", "make-text"], 0, &[]).stdout).unwrap();
    assert_eq!(about["params"]["properties"]["times"]["maximum"], 9);
    demo.fibar(&["plugin", "describe", "mak-text"]).expect(2).says(&["there is no plugin `mak-text`"]);
    check(&demo, &["plugin", "required", "demo.toml"], 0, &["bind-text\nmake-text\npass-text\n"]);
    demo.shop.write("hello.txt", "hello");
    let good = check(
        &demo,
        &["plugin", "test", "upper-text", "--input", "text=hello.txt"],
        0,
        &["ok       describes"],
    );
    assert!(!good.stdout.contains("BROKEN"), "{}", good.stdout);
    let bad = ["BROKEN   gives the same bytes again: output `leak` differs on 3 threads"];
    check(&demo, &["plugin", "test", "plugins/leak-text", "--input", "text=hello.txt"], 5, &bad);
}
