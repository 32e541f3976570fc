//! What a build tells while it runs: plain lines in a pipe, JSON for programs, bars on a terminal.

use crate::demo::{Demo, STAGE_COUNT};
use fibar_tests::Outcome;
use serde_json::Value;
use std::io::Read;
use std::process::{Command, Stdio};

/// The kinds of lines that `docs/engine.md` lists.
fn documented() -> Vec<String> {
    let page = std::fs::read_to_string(fibar_tests::checkout().join("docs/engine.md")).unwrap();
    let (_, rest) = page.split_once("| `event` |").expect("there is a table of events");
    let rows = rest.lines().skip(2).take_while(|line| line.starts_with("| `"));
    rows.flat_map(|row| row.split('|').nth(1).unwrap().split('`').skip(1).step_by(2).map(str::to_owned))
        .collect()
}

/// The lines of a build with `--log json`, each an object whose kind is documented.
#[track_caller]
fn json_lines(demo: &Demo, words: &[&str], code: i32) -> Vec<Value> {
    let words = [&["build", "demo.toml", "--plugin-path", "plugins", "--log", "json"], words].concat();
    let said = demo.shop.run(&words).expect(code).stderr;
    let documented = documented();
    let parse = |line: &str| {
        let value: Value = serde_json::from_str(line).unwrap_or_else(|e| panic!("{line:?}: {e}"));
        let kind = value["event"].as_str().unwrap_or_else(|| panic!("{line:?} has no event")).to_owned();
        assert!(documented.contains(&kind), "{kind:?} is not among {documented:?}");
        value
    };
    said.lines().map(parse).collect()
}

fn count(lines: &[Value], kind: &str) -> usize {
    lines.iter().filter(|line| line["event"] == kind).count()
}

#[test]
fn every_line_of_the_json_log_can_be_read() {
    let demo = Demo::new();
    let lines = json_lines(&demo, &[], 0);
    assert_eq!((count(&lines, "planned"), lines[0]["stages"].as_u64()), (1, Some(STAGE_COUNT as u64)));
    assert_eq!((count(&lines, "started"), count(&lines, "finished")), (STAGE_COUNT, STAGE_COUNT));
    assert!(lines.iter().all(|line| line["t"].is_number()), "{lines:?}");
    assert!(count(&lines, "progress") > 0 && count(&lines, "left") > 0, "{lines:?}");
    let again = json_lines(&demo, &[], 0);
    assert!(
        again[1..].iter().all(|line| line["event"] == "finished" && line["result"] == "hit"),
        "{again:?}"
    );
    let wrong = json_lines(&demo, &["--set", "make-text.times=99", "--set", "verify-text.wrd=x"], 2);
    assert_eq!(count(&wrong, "error"), 2, "{wrong:?}");
    assert!(
        wrong.iter().all(|line| line["place"]["line"].is_number() && line["message"].is_string()),
        "{wrong:?}"
    );
    let failed = json_lines(&demo, &["--set", "make-text.text=", "--set", "make-text.file=empty.txt"], 3);
    assert_eq!(count(&failed, "error"), 1, "{failed:?}");
}

#[test]
fn what_is_left_goes_by_earlier_builds() {
    let demo = Demo::new();
    let first = json_lines(&demo, &[], 0);
    let left = |lines: &[Value]| lines.iter().find(|line| line["event"] == "left").cloned().unwrap();
    assert_eq!(left(&first)["unknown"], STAGE_COUNT as u64, "nothing is known of a first build");
    let again = left(&json_lines(&demo, &["--set", "make-text.text=x"], 0));
    assert_eq!(again["unknown"], 0);
    let timings: Value =
        serde_json::from_slice(&std::fs::read(demo.shop.path().join("build/demo/timings.json")).unwrap())
            .unwrap();
    let made_in =
        timings["stages"].as_array().unwrap().iter().map(|stage| stage["made_in_s"].as_f64().unwrap());
    let (least, most) = (0.1, made_in.sum::<f64>() * 20.0);
    let seconds = again["seconds"].as_f64().unwrap();
    assert!((least..most).contains(&seconds), "{seconds} s");
}

/// Three links take 0.4 s each when they are built again.
#[test]
fn a_pipe_is_told_once_how_long_it_takes() {
    let demo = Demo::new();
    let recipe = std::fs::read_to_string(demo.shop.path().join("demo.toml")).unwrap();
    demo.shop.write("demo.toml", recipe.replace("seconds = 0.03\nword", "seconds = 0.4\nword"));
    let build = |text: &str| {
        let set = format!("make-text.text={text}");
        demo.shop.run(&["build", "demo.toml", "--plugin-path", "plugins", "--set", &set]).expect(0).stderr
    };
    assert!(!build("one").contains("to go"));
    let said = build("two");
    assert_eq!(said.matches("s to go by what earlier builds took").count(), 1, "{said}");
    assert!(!said.contains('\r') && !said.contains('\u{1b}'), "{said:?}");
}

/// `script` gives the program a terminal.
#[test]
#[cfg(target_os = "linux")]
fn a_terminal_sees_bars() {
    let demo = Demo::new();
    let recipe = std::fs::read_to_string(demo.shop.path().join("demo.toml")).unwrap();
    demo.shop.write("demo.toml", recipe.replace("seconds = 0.03\nword", "seconds = 0.5\nword"));
    let build = |set: &str| {
        let program = fibar_tests::executables().join("fibar");
        let line =
            format!("{} build demo.toml --plugin-path plugins --set make-text.text={set}", program.display());
        let mut script = Command::new("script");
        script.args(["-qec", &line, "/dev/null"]).current_dir(demo.shop.path()).stdin(Stdio::null());
        script.env("FIBAR_STORE", demo.shop.path().join("store")).env("TERM", "xterm").output()
    };
    let Ok(first) = build("one") else {
        println!("skipped: there is no `script` to make a terminal with");
        return;
    };
    assert!(first.status.success(), "{}", String::from_utf8_lossy(&first.stdout));
    let again = String::from_utf8(build("two").unwrap().stdout).unwrap();
    for part in ["━", "of 9", "s left", "demo/pass-text"] {
        assert!(again.contains(part), "{part:?} is not in {again:?}");
    }
}

#[test]
fn a_listener_that_leaves_stops_nothing() {
    let demo = Demo::new();
    let mut build = demo.build(0, "build").spawn().unwrap();
    drop(build.stdout.take());
    let mut first = [0; 1];
    build.stderr.take().unwrap().read_exact(&mut first).unwrap();
    assert!(build.wait().unwrap().success());
    assert_eq!(demo.executed("build"), STAGE_COUNT);
    for plugin in ["make-text", "upper-text"] {
        let mut help = Command::new(demo.shop.path().join("plugins").join(plugin));
        let mut help = help.arg("--help").stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(help.stdout.take());
        let ended = help.wait_with_output().unwrap();
        assert!(ended.status.success() && ended.stderr.is_empty(), "{ended:?}");
    }
}

/// Where user namespaces are used up the build says so, and works; unless a sandbox is required.
#[test]
#[cfg(target_os = "linux")]
fn a_system_without_namespaces_is_named() {
    let demo = Demo::new();
    let build = |words: &[&str]| {
        let refuse = "echo 0 > /proc/sys/user/max_user_namespaces && exec \"$@\"";
        let mut unshare = Command::new("unshare");
        unshare.args(["--user", "--map-root-user", "sh", "-c", refuse, "sh"]);
        unshare.arg(fibar_tests::executables().join("fibar")).args([
            "build",
            "demo.toml",
            "--plugin-path",
            "plugins",
        ]);
        unshare.args(words).current_dir(demo.shop.path()).env("FIBAR_STORE", demo.shop.path().join("store"));
        unshare
    };
    let granted = Command::new("unshare").args(["--user", "--map-root-user", "true"]).output();
    if !granted.is_ok_and(|output| output.status.success()) {
        println!("skipped: there are no user namespaces here to take away");
        return;
    }
    let why = ["the system grants no user namespaces", "/proc/sys/user/max_user_namespaces"];
    Outcome::of(&mut build(&["--sandbox", "require"])).expect(5).says(&why);
    let open = Outcome::of(&mut build(&[])).expect(0);
    let note = "note: stages run without a sandbox, with network and all files";
    assert_eq!(open.stderr.matches(note).count(), 1, "{}", open.stderr);
    open.says(&why);
    assert_eq!(demo.executed("build"), STAGE_COUNT);
    let off = Outcome::of(&mut build(&["--sandbox", "off", "--set", "make-text.text=x"])).expect(0);
    off.says(&[note, "the sandbox is switched off"]);
}
