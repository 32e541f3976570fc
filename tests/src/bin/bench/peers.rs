//! The same chain of stages in other people's tools, installed once below `target/peers`.

use fibar_tests::checkout;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A tool that runs a chain of stages.
pub struct Peer {
    pub name: &'static str,
    /// Writes its files into an empty folder.
    pub prepare: fn(&Path, usize),
    /// What runs the chain there.
    pub command: fn(&Path) -> Command,
    /// Where it comes from; an error is why it is skipped.
    pub install: fn() -> Result<(), String>,
}

pub const PEERS: [Peer; 3] = [
    Peer { name: "ninja", prepare: write_ninja, command: ninja, install: install_ninja },
    Peer { name: "Snakemake", prepare: write_snakemake, command: snakemake, install: install_python },
    Peer { name: "DVC", prepare: write_dvc, command: dvc, install: install_python },
];

fn python(program: &str) -> PathBuf {
    checkout().join("target/peers/engines/bin").join(program)
}

fn quietly(command: &mut Command) -> Result<(), String> {
    super::stopwatch::once(command).map(drop)
}

fn install_python() -> Result<(), String> {
    if python("dvc").exists() && python("snakemake").exists() {
        return Ok(());
    }
    let folder = checkout().join("target/peers/engines");
    eprintln!("installing DVC and Snakemake into {} (once)", folder.display());
    quietly(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder))?;
    quietly(Command::new(python("pip")).args(["install", "--quiet", "dvc==3.*", "snakemake==9.*"]))
}

fn install_ninja() -> Result<(), String> {
    if quietly(Command::new("ninja").arg("--version")).is_ok() {
        return Ok(());
    }
    let mut apt = Command::new("apt-get");
    quietly(apt.args(["install", "-y", "-qq", "--no-install-recommends", "ninja-build"]))
        .map_err(|_| "apt-get install ninja-build is not possible here".into())
}

fn ninja(folder: &Path) -> Command {
    let mut command = Command::new("ninja");
    command.args(["-j", "2"]).current_dir(folder);
    command
}

fn write_ninja(folder: &Path, stages: usize) {
    let mut text = "rule pass\n  command = sleep 0.1 && cat $in > $out && echo $out >> $out\n".to_owned();
    for i in 0..stages {
        let _ = writeln!(text, "build s{}: pass s{i}", i + 1);
    }
    write(folder, "build.ninja", &text);
}

fn snakemake(folder: &Path) -> Command {
    let mut command = Command::new(python("snakemake"));
    command.args(["--cores", "2", "--quiet", "all"]).current_dir(folder);
    command
}

fn write_snakemake(folder: &Path, stages: usize) {
    let mut text = format!("rule all:\n    input: 's{stages}'\n");
    for i in 0..stages {
        let (to, command) = (i + 1, "sleep 0.1 && cat {input} > {output} && echo {output} >> {output}");
        let _ = write!(text, "rule r{to}:\n    input: 's{i}'\n    output: 's{to}'\n    shell: '{command}'\n");
    }
    write(folder, "Snakefile", &text);
}

fn dvc(folder: &Path) -> Command {
    let mut command = Command::new(python("dvc"));
    command.args(["repro", "--quiet"]).current_dir(folder);
    command
}

fn write_dvc(folder: &Path, stages: usize) {
    let init = quietly(Command::new(python("dvc")).args(["init", "--no-scm", "--quiet"]).current_dir(folder));
    init.unwrap_or_else(|e| panic!("{e}"));
    let mut text = "stages:\n".to_owned();
    for i in 0..stages {
        let to = i + 1;
        let command = format!("sleep 0.1 && cat s{i} > s{to} && echo s{to} >> s{to}");
        let _ = write!(text, "  r{to}:\n    cmd: {command}\n    deps: [s{i}]\n    outs: [s{to}]\n");
    }
    write(folder, "dvc.yaml", &text);
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).expect("the folder can be written");
    std::fs::write(folder.join("s0"), "start\n").expect("the folder can be written");
}
