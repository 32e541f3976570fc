//! Compiles upstream Manifold and the bridge to it, or links a Manifold that the system has.
//!
//! Sources are looked for in `$FIBAR_MANIFOLD_DIR` (a folder with `src` and `include`), then in `target/manifold/3.5.4`
//! of the checkout, where `cargo xtask` puts them; then pkg-config is asked. The choice of flags:
//! `docs/decisions/manifold-through-own-bridge.md`.

use std::env;
use std::path::{Path, PathBuf};

const VERSION: &str = "3.5.4";

/// All of Manifold but cross sections (which need Clipper2).
const SOURCES: [&str; 18] = [
    "boolean3",
    "boolean_result",
    "constructors",
    "csg_tree",
    "edge_op",
    "execution_impl",
    "face_op",
    "impl",
    "manifold",
    "minkowski",
    "polygon",
    "properties",
    "quickhull",
    "sdf",
    "smoothing",
    "sort",
    "subdivision",
    "tree2d",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=cpp");
    println!("cargo::rerun-if-changed=src/bridge.rs");
    println!("cargo::rerun-if-env-changed=FIBAR_MANIFOLD_DIR");
    match find_sources() {
        Some(sources) => compile(&sources),
        None => link_system_library(),
    }
}

/// Manifold from its sources, serial: the parallel work is over LEDs and fibres, in Rust.
fn compile(manifold: &Path) {
    println!("cargo::rerun-if-changed={}", manifold.display());
    let sources = SOURCES.map(|name| manifold.join("src").join(name).with_extension("cpp"));
    let mut build = bridge(&[manifold.join("include"), manifold.join("src")]);
    build.define("MANIFOLD_PAR", "-1").define("MANIFOLD_NO_IOSTREAM", None).files(sources);
    map_prefix(&mut build, manifold, "manifold");
    build.compile("fibar_solid");
}

fn link_system_library() {
    let Ok(library) =
        pkg_config::Config::new().range_version(VERSION.."4").cargo_metadata(false).probe("manifold")
    else {
        println!(
            "cargo::error=Manifold {VERSION} is missing. Run `cargo xtask setup` (or any `cargo xtask build …`), which \
             fetches it, or set FIBAR_MANIFOLD_DIR to a folder with its src and include."
        );
        std::process::exit(1);
    };
    bridge(&library.include_paths).compile("fibar_solid");
    library.link_paths.iter().for_each(|path| println!("cargo::rustc-link-search=native={}", path.display()));
    library.libs.iter().for_each(|name| println!("cargo::rustc-link-lib={name}"));
}

/// The bridge's own code, with flags that give the same results and the same bytes in every checkout.
fn bridge(includes: &[PathBuf]) -> cc::Build {
    let crate_dir = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let out_dir = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    let mut build = cxx_build::bridge("src/bridge.rs");
    build.file("cpp/bridge.cpp").includes(includes).std("c++17").opt_level(2).debug(false).warnings(false);
    build.flag_if_supported("-ffp-contract=off");
    map_prefix(&mut build, &out_dir, "out");
    map_prefix(&mut build, &crate_dir, "fibar-solid");
    build
}

fn map_prefix(build: &mut cc::Build, from: &Path, to: &str) {
    build.flag_if_supported(format!("-ffile-prefix-map={}={to}", from.display()));
}

/// `None` when no folder holds them.
fn find_sources() -> Option<PathBuf> {
    let checkout = Path::new("..").canonicalize().ok().map(|root| root.join("target/manifold").join(VERSION));
    if let Some(place) = &checkout {
        println!("cargo::rerun-if-changed={}", place.display());
    }
    let given = env::var_os("FIBAR_MANIFOLD_DIR").map(PathBuf::from);
    given
        .into_iter()
        .chain(checkout)
        .find(|place| place.join("src").is_dir() && place.join("include").is_dir())
}
