//! A stage that misbehaves in the way its parameter says. It speaks the protocol by hand, so that it can break it.
//!
//! The first of `/stage/in` and friends it can name are the paths of a run; what it must not reach is given by parameters.

use serde_json::{Value, json};
use std::io::{BufRead, Write};
use std::time::Duration;

fn main() {
    let mut lines = std::io::stdin().lock().lines().map_while(Result::ok);
    let hello: Value = lines.next().and_then(|l| serde_json::from_str(&l).ok()).unwrap_or_default();
    say(json!({"type": "hello", "protocol": hello["protocol"], "name": "rude-stage 1"}));
    let order: Value = lines.next().and_then(|l| serde_json::from_str(&l).ok()).unwrap_or_default();
    match order["type"].as_str() {
        Some("describe") => say(description()),
        Some("run") => run(&order["params"]),
        _ => std::process::exit(5),
    }
}

fn description() -> Value {
    let text = |default: &str| json!({"type": "string", "default": default});
    json!({
        "type": "description", "name": "rude-stage", "summary": "Misbehaves.",
        "params": {"type": "object", "properties": {
            "how": text("well"), "target": text(""), "port": {"type": "integer", "default": 0},
            "file": {"type": ["string", "null"], "format": "fibar-file", "default": null},
        }},
        "inputs": [{"name": "text", "type": "text", "arity": "optional"}],
        "outputs": [{"name": "out", "type": "rude", "publish": "out.txt"}],
    })
}

fn say(message: Value) {
    println!("{message}");
}

fn done(file: &str) {
    say(json!({"type": "done", "outputs": {"out": file}}));
}

/// Writes the output and says so.
fn behave(text: impl AsRef<[u8]>) {
    std::fs::write("out/out.txt", text).expect("the out folder can be written");
    done("out.txt");
}

#[expect(clippy::zombie_processes, reason = "the host has to end it")]
fn leave_a_child() {
    std::process::Command::new("sleep").arg("600").spawn().expect("sleep is there");
    forever()
}

fn forever() -> ! {
    loop {
        std::thread::sleep(Duration::from_secs(1));
    }
}

fn run(params: &Value) {
    let target = params["target"].as_str().unwrap_or_default();
    match params["how"].as_str().unwrap_or_default() {
        "well" => behave("good"),
        "slowly" => {
            std::thread::sleep(Duration::from_millis(400));
            behave("good");
        }
        "lie" => done("out.txt"),
        "lie about ports" => say(json!({"type": "done", "outputs": {"out": "out.txt", "more": "x"}})),
        "escape by name" => done("../request.json"),
        "write too much" => {
            std::fs::write("out/extra.txt", "x").expect("it can be written");
            behave("good");
        }
        "link" => link("out/out.txt"),
        "change input" => change_input(),
        "flood" => flood(),
        "flood without newline" => flood_a_line(),
        "garbage" => println!("hello there"),
        "stall" => forever(),
        "stall after a child" => leave_a_child(),
        "die" => std::process::exit(3),
        "crash" => std::process::abort(),
        "half" => {
            print!("{{\"type\":\"do");
            std::io::stdout().flush().expect("it can be written");
            std::process::exit(0);
        }
        "blame a file" => blame(params["file"].as_str().unwrap_or_default()),
        "look" => behave(look(target)),
        "write" => behave(format!("{:?}", std::fs::write(target, "rude").is_ok())),
        "call" => behave(call(params["port"].as_u64().unwrap_or_default() as u16)),
        "environment" => behave(environment()),
        other => panic!("it does not know how to {other}"),
    }
}

fn link(path: &str) {
    #[cfg(unix)]
    std::os::unix::fs::symlink("/etc/hostname", path).expect("links can be made");
    done("out.txt");
}

fn change_input() {
    let path = "in/text";
    let _ = std::fs::remove_file(path);
    let _ = std::fs::write(path, "changed");
    behave("good");
}

fn flood() {
    for i in 0u64.. {
        say(json!({"type": "metric", "name": format!("m{i}"), "value": i, "unit": "1"}));
    }
}

fn flood_a_line() {
    let block = [b'x'; 65536];
    while std::io::stdout().write_all(&block).is_ok() {}
}

/// Says where the fault is, in the words of the stage's own world.
fn blame(file: &str) {
    let whole = std::path::absolute(file).expect("there is a working folder");
    let message = format!("{file}:3: odd, see {}", whole.display());
    say(json!({"type": "error", "kind": "input", "message": message, "param": "/file"}));
}

/// Whether a path can be seen.
fn look(target: &str) -> String {
    format!("{}", std::fs::symlink_metadata(target).is_ok())
}

/// Whether a port of this machine can be reached.
fn call(port: u16) -> String {
    format!("{}", std::net::TcpStream::connect(("127.0.0.1", port)).is_ok())
}

fn environment() -> String {
    let mut names: Vec<String> = std::env::vars().map(|(name, _)| name).collect();
    names.sort();
    names.join(" ")
}
