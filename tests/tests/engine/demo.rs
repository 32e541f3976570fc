//! A workshop with the engine's demo stages as plugins.

use fibar_tests::{Build, Workshop, executables};
use std::path::Path;
use std::process::{Command, Stdio};

/// The stages of `fibar-engine/examples/demo-stages.rs`.
const STAGES: [&str; 6] = ["make-text", "pass-text", "upper-text", "bind-text", "verify-text", "leak-text"];

/// How many stages the recipe has.
pub const STAGE_COUNT: usize = 9;

pub struct Demo {
    pub shop: Workshop,
}

impl Demo {
    /// Plugins, a source file of 256 kB, and a recipe of stages that take a few hundredths of a second each.
    pub fn new() -> Demo {
        let shop = Workshop::default();
        std::fs::create_dir(shop.path().join("plugins")).unwrap();
        let stages = executables().join("examples/demo-stages");
        for name in STAGES {
            let copied = std::fs::copy(&stages, shop.path().join("plugins").join(name));
            copied.unwrap_or_else(|e| panic!("{}: {e}; run the tests by cargo xtask test", stages.display()));
        }
        shop.write("big.txt", "0123456789abcdef".repeat(16 << 10));
        shop.write("demo.toml", recipe());
        Demo { shop }
    }

    /// A build with other bytes for every `salt`, into `out`.
    pub fn build(&self, salt: usize, out: &str) -> Command {
        let salt = format!("make-text.text=\"salt {salt}\"");
        let mut command = self.shop.program(&[
            "build",
            "demo.toml",
            "--plugin-path",
            "plugins",
            "--out",
            out,
            "--set",
            &salt,
        ]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// How many stages the last build into `out` ran itself.
    pub fn executed(&self, out: &str) -> usize {
        Demo::executed_in(&self.shop.path().join(out).join("demo"))
    }

    /// The same of one build folder.
    pub fn executed_in(folder: &Path) -> usize {
        Build { folder: folder.to_owned() }.executed()
    }
}

fn recipe() -> String {
    let mut recipe =
        "fibar = 1\n[object]\nname = \"demo\"\n[[stage]]\nuse = \"make-text\"\nfile = \"big.txt\"\n"
            .to_owned();
    for word in ["a", "b", "c"] {
        recipe += &format!("[[stage]]\nuse = \"pass-text\"\nseconds = 0.03\nword = \"{word}\"\n");
    }
    for name in ["one", "two", "three"] {
        recipe += &format!("[[stage]]\nuse = \"upper-text\"\nseconds = 0.03\nname = \"{name}.txt\"\n");
    }
    recipe + "[[stage]]\nuse = \"bind-text\"\n[[stage]]\nuse = \"verify-text\"\nword = \"zebra\"\n"
}
