//! The whole stage as a process, over scripts and files that are wrong in one way each.
//!
//! Needs Python with build123d, set up once below `target/tmp`. Where that cannot be done the tests are skipped and say why;
//! with `CI=true` that is a failure.

#![allow(clippy::unwrap_used)]

mod environment;

use fibar_core::artefact::mesh::TriangleMesh;
use glam::DVec3;
use serde_json::{Value, json};
use std::process::{Command, Output};
use std::sync::OnceLock;

const STAGE: &str = env!("CARGO_BIN_EXE_source-build123d");

/// One run on a file with this content.
struct Run {
    folder: tempfile::TempDir,
    output: Output,
}

impl Run {
    fn of(name: &str, content: &[u8], params: Value) -> Run {
        let python = environment().expect("asked before");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(name), content).unwrap();
        let mut request = json!({"params": {"path": name}, "out_dir": "out", "threads": 2, "python": python});
        request["params"].as_object_mut().unwrap().extend(params.as_object().unwrap().clone());
        std::fs::write(folder.path().join("request.json"), request.to_string()).unwrap();
        let output =
            Command::new(STAGE).args(["--request", "request.json"]).current_dir(folder.path()).output();
        Run { output: output.unwrap(), folder }
    }

    fn messages(&self) -> Vec<Value> {
        let text = String::from_utf8_lossy(&self.output.stdout);
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// The last message, which must be an error, as `kind param: message (hint)`.
    fn error(&self) -> String {
        let last = self.messages().pop().expect("a run says how it ended");
        let field = |name: &str| last[name].as_str().unwrap_or("").to_string();
        format!("{} {}: {} ({})", field("kind"), field("param"), field("message"), field("hint"))
    }

    fn file(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.folder.path().join("out").join(name))
            .unwrap_or_else(|_| panic!("{}", self.error()))
    }
}

#[track_caller]
fn check(name: &str, content: impl AsRef<[u8]>, params: Value, expected: &[&str]) {
    let error = Run::of(name, content.as_ref(), params).error();
    let missing: Vec<&&str> = expected.iter().filter(|part| !error.contains(**part)).collect();
    assert!(missing.is_empty(), "{error:?} does not say {missing:?}");
}

/// The interpreter of the environment; says why if there is none.
fn environment() -> Option<String> {
    static ENVIRONMENT: OnceLock<Option<String>> = OnceLock::new();
    ENVIRONMENT.get_or_init(|| environment::ensure().map_err(skip).ok()).clone()
}

fn skip(why: String) {
    assert_ne!(std::env::var("CI").as_deref(), Ok("true"), "{why}");
    eprintln!("skipped: {why}");
}

#[test]
fn a_bad_script_shows_its_line_and_exception() {
    if environment().is_none() {
        return;
    }
    let script = |text: &str, expected: &[&str]| check("a.py", text, json!({}), expected);
    script("x = 1\ny = = 2\n", &["input /path: a.py:2: SyntaxError", "`y = = 2`"]);
    script(
        "def f():\n    return 1 / 0\n\nresult = f()\n",
        &["a.py:2: in f: ZeroDivisionError", "`return 1 / 0`"],
    );
    script("import json\njson.loads('{')\n", &["a.py:2: JSONDecodeError", "`json.loads('{')`"]);
    script("import ocp_vscode\n", &["a.py:1: ModuleNotFoundError", "guard viewers"]);
    script("open('bracket.step')\n", &["a.py:1: FileNotFoundError", "files = {"]);
    script("x = 1\n", &["a.py: the script sets no `result`"]);
    script("import sys\nsys.exit(3)\n", &["a.py:2: the script called exit(3)"]);
    script("raise KeyboardInterrupt\n", &["a.py:1: KeyboardInterrupt"]);
    check("a.py", b"x = '\xff'\n", json!({}), &["a.py is not UTF-8 text"]);
}

#[test]
fn a_script_that_dies_or_never_ends_is_told_by_line() {
    if environment().is_none() {
        return;
    }
    let script = |text: &str, expected: &[&str]| check("a.py", text, json!({"timeout_s": 3}), expected);
    script("import os\nos.abort()\n", &["input /path: a.py:2: the process ended by an abort"]);
    script(
        "import ctypes\ndef f():\n    ctypes.string_at(0)\nf()\n",
        &["a.py:3: the process ended by a segm"],
    );
    script("import os\nos._exit(0)\n", &["a.py: the process ended before it was finished"]);
    script("x = 0\nwhile True:\n    x += 1\n", &["a.py:", "not finished after 3 s", "timeout_s"]);
    script("import subprocess\nsubprocess.run(['sleep', '1000'])\n", &["a.py:2: not finished"]);
}

#[test]
fn parameters_must_be_names_of_the_script() {
    if environment().is_none() {
        return;
    }
    let text = "height = 87.0\nname = 'cone'\n";
    let with = |params: Value, expected: &[&str]| check("a.py", text, params, expected);
    with(json!({"parameters": {"heigth": 3}}), &["user /parameters/heigth", "did you mean `height`?"]);
    with(json!({"parameters": {"width": 3}}), &["assigns no `width`", "it assigns: height, name"]);
    with(
        json!({"parameters": {"height": "tall"}}),
        &["user /parameters/height", "a number in the script, not 'tall'"],
    );
    with(json!({"files": {"nam": "a.py"}}), &["user /files/nam", "did you mean `name`?"]);
    check("a.step", "", json!({"parameters": {"height": 3}}), &["user /parameters/height: only a script"]);
    check("a.stl", "", json!({}), &["user /path", "meshes go to source-mesh"]);
    check("a.py", "", json!({"size_mm": [9, 3]}), &["user /size_mm"]);
}

#[test]
fn damaged_files_are_refused_before_the_kernel_starts() {
    if environment().is_none() {
        return;
    }
    check("a.step", "hello", json!({}), &["input /path: a.step is no STEP file"]);
    check("a.step", "", json!({}), &["a.step is no STEP file"]);
    check("a.stp", "ISO-10303-21;\nHEADER;\n", json!({}), &["a.stp is cut short", "after 3 lines"]);
    check("a.brep", "hello", json!({}), &["a.brep is no BREP file"]);
}

#[test]
fn shapes_without_solids_and_mixed_up_units_are_refused() {
    if environment().is_none() {
        return;
    }
    let script = |text: &str, expected: &[&str]| {
        check("a.py", format!("from build123d import *\n{text}"), json!({}), expected);
    };
    script("result = Rectangle(30, 40)\n", &["input /path: there is no solid, only 1 face", "thickness"]);
    script(
        "result = Box(0.1, 0.1, 0.08)\n",
        &["0.1 × 0.1 × 0.08 mm, implausibly small", "scale = 1000 (gives 100"],
    );
    script("result = Box(111e3, 100, 100)\n", &["implausibly large", "scale = 0.001 (gives 111 ×"]);
    check(
        "a.brep",
        "CASCADE Topology V3, (c) Open Cascade\n12\n",
        json!({}),
        &["a.brep is damaged or cut short"],
    );
}

/// Two solids of an assembly, one of them with a hole, coloured, written as STEP and BREP too.
const ASSEMBLY: &str = "\
from build123d import *
height = 10.0
block = Box(30, 30, height) - Cylinder(4, 2 * height)
block.label, block.color = 'my block.1', '#ff8000'
ball = Sphere(5).moved(Location((40, 0, 0)))
ball.label = 'ball'
result = Compound(label='toy', children=[block, ball]).moved(Location((0, 0, 100)))
export_step(result, '/OUT/toy.step')
export_brep(result, '/OUT/toy.brep')
";

#[test]
fn labels_colours_and_bytes_are_the_same_on_every_way_in() {
    if environment().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let script = ASSEMBLY.replace("/OUT", &folder.path().to_string_lossy());
    let coarse = json!({"chord_error_mm": 0.5, "parameters": {"height": 20}});
    let first = Run::of("toy.py", script.as_bytes(), coarse.clone());
    let parts: Value = serde_json::from_slice(&first.file("parts.json")).unwrap();
    let summary = |part: &Value| (part["label"].clone(), part["colour"].clone(), part["open_edges"].clone());
    assert_eq!(
        summary(&parts["parts"][0]),
        (json!("my block.1"), json!([1.0, 0.501961, 0.0, 1.0]), json!(0))
    );
    assert_eq!(summary(&parts["parts"][1]), (json!("ball"), Value::Null, json!(0)));
    check_ball(&first.file("mesh.ply"), &parts["parts"][1]);
    check_volume(&parts["parts"][0], 900.0 * 20.0 - std::f64::consts::PI * 16.0 * 20.0);
    let second = Run::of("toy.py", script.as_bytes(), coarse);
    assert_eq!(first.output.stdout, second.output.stdout);
    assert!(first.file("mesh.ply") == second.file("mesh.ply"), "bytes differ from run to run");
    let step = std::fs::read_to_string(folder.path().join("toy.step")).unwrap();
    let from_step: Value =
        serde_json::from_slice(&Run::of("b.step", step.as_bytes(), json!({})).file("parts.json")).unwrap();
    assert_eq!(summary(&from_step["parts"][0]), summary(&parts["parts"][0]));
    assert_eq!(summary(&from_step["parts"][1]), summary(&parts["parts"][1]));
    check("c.step", without_a_solid(&step), json!({}), &["c.step is damaged: 1 records are missing, #"]);
    check("d.step", cut_in_the_middle(&step), json!({}), &["d.step is damaged"]);
    let brep = std::fs::read(folder.path().join("toy.brep")).unwrap();
    let from_brep: Value =
        serde_json::from_slice(&Run::of("e.brep", &brep, json!({})).file("parts.json")).unwrap();
    assert_eq!(from_brep["parts"].as_array().unwrap().len(), 2);
    check_volume(&from_brep["parts"][1], parts["parts"][1]["volume_mm3"].as_f64().unwrap());
}

fn without_a_solid(step: &str) -> String {
    let at = step.rfind("MANIFOLD_SOLID_BREP").unwrap();
    let (before, after) = step.split_at(at);
    let record = before.rfind('#').unwrap();
    format!("{}{}", &before[..record], after.split_once(";\n").unwrap().1)
}

/// As if the end had been pasted on.
fn cut_in_the_middle(step: &str) -> String {
    let at = step[step.len() / 2..].find('(').unwrap() + step.len() / 2;
    format!("{}\nENDSEC;\nEND-ISO-10303-21;\n", &step[..=at])
}

/// Every triangle of the ball stays within the chord error of the true sphere, in its middle and along its edges.
fn check_ball(ply: &[u8], part: &Value) {
    let mesh = TriangleMesh::from_ply(ply).unwrap();
    let number = |name: &str| part[name].as_u64().unwrap() as usize;
    for k in number("first_triangle")..number("first_triangle") + number("triangles") {
        let [a, b, c] = mesh.corners(k);
        for point in [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0] {
            let depth = 5.0 - point.distance(DVec3::new(40.0, 0.0, 100.0));
            assert!((-1e-9..0.5).contains(&depth), "triangle {k} lies {depth} mm under the sphere");
        }
    }
}

#[track_caller]
fn check_volume(part: &Value, expected_mm3: f64) {
    let volume = part["volume_mm3"].as_f64().unwrap();
    assert!((volume / expected_mm3 - 1.0).abs() < 0.05, "{volume} for {expected_mm3} mm³");
}

#[test]
fn a_request_without_python_or_with_one_that_is_gone_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let request = |extra: &str| {
        let text = format!(r#"{{"params": {{"path": "a.py"}}, "out_dir": "out"{extra}}}"#);
        std::fs::write(folder.path().join("request.json"), text).unwrap();
        let output =
            Command::new(STAGE).args(["--request", "request.json"]).current_dir(folder.path()).output();
        String::from_utf8(output.unwrap().stdout).unwrap()
    };
    assert!(request("").contains("the request names no Python"));
    assert!(request(r#", "python": "/gone/bin/python""#).contains("is broken: its Python is gone"));
}
