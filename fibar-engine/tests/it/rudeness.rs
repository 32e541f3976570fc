//! What misbehaving plugins cannot do.

use crate::bench::{Bench, list};
use fibar_engine::Class;
use fibar_engine::host::{Limits, Sandbox};
use std::time::Duration;

/// A recipe of one rude stage, after one that makes a text for it.
fn rude(how: &str) -> String {
    format!(
        "fibar = 1\n[object]\nname = \"rude\"\n[[stage]]\nuse = \"make-text\"\n\
         [[stage]]\nuse = \"rude-stage\"\nhow = \"{how}\"\n"
    )
}

/// Impatient, so that tests are quick.
const IMPATIENT: Limits = Limits {
    start: Duration::from_secs(5),
    silence: Duration::from_millis(200),
    cancel: Duration::from_millis(200),
    exit: Duration::from_millis(200),
};

fn bench(sandbox: Sandbox) -> Bench {
    Bench { limits: IMPATIENT, sandbox, ..Bench::new() }
}

/// The build fails by the plugin's fault, says so, publishes nothing and leaves nothing; the next one is fine.
#[track_caller]
fn check(how: &str, says: &str) {
    for sandbox in [Sandbox::Off, Sandbox::Auto] {
        let bench = bench(sandbox);
        let error = bench.build(&rude(how)).expect_err("it misbehaved");
        let text = error.render();
        assert_eq!(error.class, Class::Plugin, "{text}");
        for part in [says, "rude-stage", "recipe.toml:7:7"] {
            assert!(text.contains(part), "{part:?} is not in:\n{text}");
        }
        assert_eq!(bench.list("build"), [""; 0], "something was published");
        assert_eq!(bench.list("store/actions").len(), 1, "only the text is finished");
        bench.runs(&rude("well"), &["rude-stage"]);
    }
}

#[test]
fn outputs_must_be_as_promised() {
    check("lie", "output `out` is missing: it wrote no out.txt");
    check("lie about ports", "output `more` is not in its description");
    check("escape by name", "which is not a plain file name");
    check("write too much", "it wrote \"extra.txt\", which is no output");
    check("link", "a symbolic link");
}

#[test]
fn a_plugin_that_dies_is_reported() {
    check("die", "exit status: 3");
    check("crash", "signal: 6");
    check("half", "a line that is no message");
    check("garbage", "a line that is no message");
}

#[test]
fn a_plugin_that_floods_or_stalls_is_stopped() {
    check("flood", "more than 10000 metrics or violations");
    check("flood without newline", "a line that is no message");
    check("stall", "it stalled");
    check("stall after a child", "it stalled");
}

#[test]
fn a_changed_input_ruins_the_run() {
    let bench = bench(Sandbox::Off);
    let error = bench.build(&rude("change input")).expect_err("it changed its input").render();
    assert!(error.contains("it changed input `text`, which is read-only"), "{error}");
    assert_eq!(bench.list("build"), [""; 0]);
}

/// What a rude stage in a sandbox finds, if there is a sandbox.
#[track_caller]
fn check_confined(lines: &str, expected: &str) {
    let bench = bench(Sandbox::Auto);
    if let Err(reason) = bench.sandbox.granted() {
        println!("skipped: {reason}");
        return;
    }
    bench.build(&(rude("look").replace("how = \"look\"", lines))).unwrap();
    assert_eq!(bench.read("build/rude/out.txt"), expected, "{lines}");
}

#[test]
fn a_stage_in_a_sandbox_sees_nothing_of_the_user() {
    for (path, seen) in
        [("in/text", true), ("/stage/out", true), ("/etc/hostname", false), ("/home", false), ("/sys", false)]
    {
        check_confined(&format!("how = 'look'\ntarget = '{path}'"), &seen.to_string());
    }
    let own = env!("CARGO_MANIFEST_DIR");
    check_confined(&format!("how = 'look'\ntarget = '{own}'"), "false");
}

#[test]
fn a_stage_in_a_sandbox_writes_to_its_folder_only() {
    for (path, written) in
        [("out/../tmp/x", true), ("/tmp/x", true), ("/usr/x", false), ("/x", false), ("in/text", false)]
    {
        check_confined(&format!("how = 'write'\ntarget = '{path}'"), &written.to_string());
    }
}

#[test]
fn a_stage_in_a_sandbox_has_no_network() {
    let server = std::net::TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = server.local_addr().unwrap().port();
    check_confined(&format!("how = 'call'\nport = {port}"), "false");
}

#[test]
fn a_stage_gets_an_allow_listed_environment() {
    let everywhere =
        "HOME LANG OMP_NUM_THREADS PATH PYTHONDONTWRITEBYTECODE PYTHONHASHSEED RAYON_NUM_THREADS TMPDIR TZ";
    let of_glibc = if cfg!(all(target_os = "linux", target_env = "gnu")) { "GLIBC_TUNABLES " } else { "" };
    let names = format!("{of_glibc}{everywhere}");
    check_confined("how = 'environment'", &names);
    let open = bench(Sandbox::Off);
    open.build(&rude("environment")).unwrap();
    assert_eq!(open.read("build/rude/out.txt"), names);
}

#[test]
fn another_version_is_told_apart() {
    let bench = Bench::new();
    let script = "#!/bin/sh\necho '{\"type\":\"hello\",\"protocol\":99,\"name\":\"odd-stage 9\",\"since\":2031}'\nread x\nread x\n";
    bench.write_plugin("odd-stage", script);
    let recipe = rude("well").replace("rude-stage", "odd-stage");
    let error = bench.build(&recipe).unwrap_err();
    assert_eq!(error.class, Class::Plugin);
    let says = "odd-stage 9 speaks protocol 99, this fibar speaks 1";
    assert!(error.render().contains(says), "{error}");
}

/// Names of processes that still run something below a folder.
#[cfg(target_os = "linux")]
fn sleepers() -> Vec<String> {
    let is_sleep = |pid: &String| {
        std::fs::read(format!("/proc/{pid}/cmdline")).is_ok_and(|line| line.starts_with(b"sleep\x00600"))
    };
    list("/proc".as_ref()).into_iter().filter(is_sleep).collect()
}

#[test]
#[cfg(target_os = "linux")]
fn children_of_a_stage_end_with_it() {
    let bench = bench(Sandbox::Auto);
    bench.build(&rude("stall after a child")).unwrap_err();
    for _ in 0..50 {
        if sleepers().is_empty() {
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    panic!("{:?} still sleep", sleepers());
}
