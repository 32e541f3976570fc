//! The sources of upstream Manifold, the solid modeller, fetched once per checkout and pinned by digest.
//!
//! They come from the PyPI source archive of `manifold3d` through pip; fibar-solid's build script compiles them.
//! Why upstream rather than a binding from the Rust registry: `docs/decisions/manifold-through-own-bridge.md`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const VERSION: &str = "3.5.4";
const SHA256: &str = "5bd88c482c6fd7fc01aa7b715b3e31c2585ee98343d5559d286ba30db0d0b6f0";

/// Python programs to try, in this order.
const PYTHONS: [&str; 3] = ["python3.11", "python3", "python"];

/// pip asks the build backend for metadata before it hands over a source archive. This stub answers in its place,
/// so that nothing needs to be installed and no code of the archive runs.
const BACKEND: &str = r#"import os


def prepare_metadata_for_build_wheel(directory, config_settings=None):
    name = "manifold3d-VERSION.dist-info"
    os.makedirs(os.path.join(directory, name))
    with open(os.path.join(directory, name, "METADATA"), "w") as out:
        out.write("Metadata-Version: 2.1\nName: manifold3d\nVersion: VERSION\n")
    return name
"#;

/// Returns the folder with Manifold's `src` and `include`, fetching and unpacking it on first use.
///
/// `root` is the checkout. The folder is `target/manifold/VERSION`; it appears by rename, so it is whole or absent.
pub fn ensure(root: &Path) -> Result<PathBuf, String> {
    let home = root.join("target").join("manifold");
    let sources = home.join(VERSION);
    if sources.join("src").is_dir() && sources.join("include").is_dir() {
        return Ok(sources);
    }
    let work = home.join(format!("unpack-{}", std::process::id()));
    fs::create_dir_all(&work).map_err(|error| format!("{}: {error}", work.display()))?;
    let outcome = fetch(&work).and_then(|unpacked| publish(&unpacked, &sources));
    let _ = fs::remove_dir_all(&work);
    outcome.map(|()| sources)
}

/// Downloads and unpacks the archive in `work`; returns the unpacked folder.
fn fetch(work: &Path) -> Result<PathBuf, String> {
    let python = find_python()?;
    write_stub(work)?;
    run(Command::new(python)
        .current_dir(work)
        .env("PYTHONPATH", work.join("stub"))
        .args(["-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"])
        .args(["--no-binary", ":all:", "--no-build-isolation", "--require-hashes"])
        .args(["--dest", ".", "--requirement", "requirements.txt"]))?;
    let archive = format!("manifold3d-{VERSION}.tar.gz");
    run(Command::new(python).current_dir(work).args(["-m", "tarfile", "-e", &archive, "."]))?;
    Ok(work.join(format!("manifold3d-{VERSION}")))
}

/// A Python that has pip.
pub fn find_python() -> Result<&'static str, String> {
    let has_pip = |python: &&str| {
        Command::new(python).args(["-m", "pip", "--version"]).output().is_ok_and(|out| out.status.success())
    };
    let advice = "fetching what is compiled in needs Python 3.11 with pip; try: apt-get install python3-pip";
    PYTHONS.into_iter().find(has_pip).ok_or_else(|| advice.to_string())
}

fn write_stub(work: &Path) -> Result<(), String> {
    let package = work.join("stub").join("scikit_build_core");
    let requirement = format!("manifold3d=={VERSION} --hash=sha256:{SHA256}\n");
    fs::create_dir_all(&package)
        .and_then(|()| fs::write(package.join("__init__.py"), ""))
        .and_then(|()| fs::write(package.join("build.py"), BACKEND.replace("VERSION", VERSION)))
        .and_then(|()| fs::write(work.join("requirements.txt"), requirement))
        .map_err(|error| format!("{}: {error}", work.display()))
}

fn publish(unpacked: &Path, sources: &Path) -> Result<(), String> {
    match fs::rename(unpacked, sources) {
        Ok(()) => Ok(()),
        // Another process was faster; its copy has the same digest.
        Err(_) if sources.join("src").is_dir() => Ok(()),
        Err(error) => Err(format!("{}: {error}", sources.display())),
    }
}

fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().map_err(|error| format!("{}: {error}", command.get_program().display()))?;
    if output.status.success() {
        return Ok(());
    }
    let log = String::from_utf8_lossy(&output.stderr);
    Err(format!("fetching Manifold {VERSION} from PyPI failed:\n{}", log.trim_end()))
}
