//! What compiling OpenSubdiv takes beside a C++ compiler: cmake, ninja and libclang, fetched once per checkout.
//!
//! They come from PyPI through pip, pinned by digest; where pip cannot have them, those of the system serve. Where they are
//! is written to `target/opensubdiv/cargo.toml`, which `.cargo/config.toml` includes if it is there, so that every cargo in
//! the checkout compiles the same. The sources come with the crate `opensubdiv-petite-sys`.

use crate::checkout::run_quietly;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of the set below `target/opensubdiv`; another set of wheels is another folder.
const SET: &str = "cmake-4.4.5-libclang-18.1.1";

/// Wheels for Linux (x86-64, AArch64) and macOS.
const WHEELS: &str = "\
cmake==4.4.5 \
--hash=sha256:85625a9b6d5e88ff99c7eb79123d85570844e77ac076366cf75c609cc0b1b579 \
--hash=sha256:25fc8469e67857124ef10c002331c0ab416eb7b8d9e1d6e4c58e84e730013ece \
--hash=sha256:e07a5716b4233dc9c69d6ca6993f4405eefc7687e718d9f6eebbb6cc1be304ef
ninja==1.13.2 \
--hash=sha256:65a24341b5ac09fcadcc37082660be40a94174e51a937fabf6e2cae26225fa2c \
--hash=sha256:d775a5e43e9088f507a6250d57fcf5678eb31268c545feb5064ffeee33735622 \
--hash=sha256:fd82e26c0706ad4ab88e5fdd26f3fab0a987a90f810160f6c322e752c6af298b
libclang==18.1.1 \
--hash=sha256:c533091d8a3bbf7460a00cb6c1a71da93bffe148f172c7d03b1c31fbf8aa2a0b \
--hash=sha256:54dda940a4a0491a9d1532bf071ea3ef26e6dbaf03b5000ed94dd7174e8f9592 \
--hash=sha256:0b2e143f0fac830156feb56f9231ff8338c20aecfe72b4ffe96f19e5a1dbb69a
";

/// Folders where systems keep libclang, below them folders of its versions.
const LIBRARY_FOLDERS: [&str; 5] = [
    "/usr/lib",
    "/usr/lib64",
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/opt/homebrew/opt",
];

/// Sets everything up, on first use and whenever the checkout has moved.
pub fn ensure(root: &Path) -> Result<(), String> {
    let home = root.join("target").join("opensubdiv");
    let settings = home.join("cargo.toml");
    let tools = home.join(SET);
    if !is_whole(&tools) && given_by_user() {
        return Ok(());
    }
    let found = if is_whole(&tools) { Ok(()) } else { fetch(&home, &tools) };
    let wanted = match found {
        Ok(()) => settings_for(&fetched(&tools))?,
        Err(why) => settings_for(&of_system().ok_or_else(|| complain(&why))?)?,
    };
    if fs::read_to_string(&settings).is_ok_and(|is| is == wanted) {
        return Ok(());
    }
    forget_builds(&root.join("target").join("release").join("build"));
    write_whole(&settings, &wanted)
}

/// cmake refuses a folder that was configured elsewhere, as it lies in a target folder copied from another checkout.
fn forget_builds(builds: &Path) {
    for entry in fs::read_dir(builds).into_iter().flatten().flatten() {
        if entry.file_name().to_string_lossy().starts_with("opensubdiv-petite-sys-") {
            let _ = fs::remove_dir_all(entry.path().join("out").join("build"));
        }
    }
}

/// Where the programs and the library are.
struct Tools {
    cmake: PathBuf,
    /// The folder with ninja; none where cmake shall choose what it drives.
    ninja: Option<PathBuf>,
    /// The folder with libclang.
    libclang: PathBuf,
}

fn fetched(tools: &Path) -> Tools {
    Tools {
        cmake: tools.join("cmake/data/bin/cmake"),
        ninja: Some(tools.join("bin")),
        libclang: tools.join("clang/native"),
    }
}

fn is_whole(tools: &Path) -> bool {
    let parts = fetched(tools);
    parts.cmake.is_file() && has_libclang(&parts.libclang) && parts.ninja.is_some_and(|bin| bin.is_dir())
}

/// Whoever names both in the environment wants these and no others: cargo's settings give way to it.
fn given_by_user() -> bool {
    ["CMAKE", "LIBCLANG_PATH"].iter().all(|name| std::env::var_os(name).is_some())
}

/// Installs the wheels into a folder that appears by rename, so that it is whole or absent.
fn fetch(home: &Path, tools: &Path) -> Result<(), String> {
    let work = home.join(format!("unpack-{}", std::process::id()));
    let io = |error: std::io::Error| format!("{}: {error}", work.display());
    fs::create_dir_all(&work).map_err(io)?;
    fs::write(work.join("requirements.txt"), WHEELS).map_err(io)?;
    eprintln!("xtask: fetching cmake and libclang for OpenSubdiv (once)");
    let outcome = install(&work).and_then(|()| match fs::rename(work.join("tools"), tools) {
        // Another process was faster; its wheels have the same digests.
        Err(_) if is_whole(tools) => Ok(()),
        other => other.map_err(io),
    });
    let _ = fs::remove_dir_all(&work);
    outcome
}

fn install(work: &Path) -> Result<(), String> {
    let python = crate::manifold::find_python()?;
    let mut pip = Command::new(python);
    pip.current_dir(work)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps"])
        .args(["--only-binary", ":all:", "--require-hashes", "--target", "tools"])
        .args(["--requirement", "requirements.txt"]);
    run_quietly(&mut pip).map(drop)
}

/// cmake from the path and libclang from where systems have it.
fn of_system() -> Option<Tools> {
    run_quietly(Command::new("cmake").arg("--version")).ok()?;
    let mut folders: Vec<PathBuf> = LIBRARY_FOLDERS.iter().map(PathBuf::from).collect();
    let below = |folder: &PathBuf| {
        let mut names: Vec<_> =
            fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
        names.retain(|path| path.to_string_lossy().contains("llvm"));
        names.sort();
        names.into_iter().map(|path| path.join("lib")).collect::<Vec<_>>()
    };
    folders.extend(folders.iter().flat_map(below).collect::<Vec<_>>());
    let libclang = folders.into_iter().rev().find(|folder| has_libclang(folder))?;
    Some(Tools { cmake: "cmake".into(), ninja: None, libclang })
}

fn has_libclang(folder: &Path) -> bool {
    let names = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.file_name());
    names.map(|name| name.to_string_lossy().into_owned()).any(|name| {
        let is_library = name.starts_with("libclang.") || name.starts_with("libclang-");
        is_library && !name.contains("cpp") && [".so", ".dylib"].iter().any(|end| name.contains(end))
    })
}

/// Settings for cargo. libclang alone lacks the compiler's own headers (`stddef.h`): those of the C++ compiler serve.
fn settings_for(tools: &Tools) -> Result<String, String> {
    let compiler = std::env::var("CXX").unwrap_or("c++".into());
    let headers = run_quietly(Command::new(&compiler).arg("-print-file-name=include"))
        .map_err(|why| format!("OpenSubdiv needs a C++ compiler; try: apt-get install g++\n{why}"))?;
    let resources = Path::new(headers.trim()).parent().unwrap_or(Path::new("/")).display().to_string();
    let mut lines = vec![
        ("CMAKE", tools.cmake.display().to_string()),
        ("LIBCLANG_PATH", tools.libclang.display().to_string()),
        ("BINDGEN_EXTRA_CLANG_ARGS", format!("-resource-dir={resources}")),
    ];
    if let Some(ninja) = &tools.ninja {
        lines.push(("CMAKE_GENERATOR", "Ninja".into()));
        lines.push(("CMAKE_PROGRAM_PATH", ninja.display().to_string()));
    }
    let lines: Vec<String> = lines.iter().map(|(name, value)| format!("{name} = {value:?}\n")).collect();
    Ok(format!("# Written by cargo xtask: what compiles OpenSubdiv.\n[env]\n{}", lines.concat()))
}

fn write_whole(path: &Path, text: &str) -> Result<(), String> {
    let io = |error: std::io::Error| format!("{}: {error}", path.display());
    let draft = path.with_extension(format!("{}.draft", std::process::id()));
    fs::create_dir_all(path.parent().unwrap_or(Path::new("."))).map_err(io)?;
    fs::write(&draft, text).and_then(|()| fs::rename(&draft, path)).map_err(io)
}

fn complain(why: &str) -> String {
    format!(
        "subdivide-opensubdiv needs cmake and libclang, which can neither be had from PyPI nor found on this system; try: \
         apt-get install cmake libclang-dev (or set CMAKE and LIBCLANG_PATH)\n{why}"
    )
}
