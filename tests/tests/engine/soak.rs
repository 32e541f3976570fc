//! `kill -9` at random moments: what is visible is whole, nothing finished is lost, and the next build succeeds without
//! flags.
//!
//! The moments are the same in every run with the same seed (`FIBAR_SOAK_SEED`), apart from how fast the machine is.

use crate::demo::Demo;
use crate::store::{actions, check_published, check_store};
use fibar_tests::{Outcome, Workshop, checkout};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn soak_killed_builds_of_demo_stages_lose_nothing() {
    let demo = Demo::new();
    let build = |salt| demo.build(salt, "build");
    Soak { name: "demo", shop: &demo.shop, build: &build }.run(if is_long() { 200 } else { 6 });
}

#[test]
fn soak_killed_builds_of_the_pebble_lose_nothing() {
    let shop = Workshop::default();
    let recipe = checkout().join("recipes/pebble.toml");
    let build = |salt: usize| {
        let seed = format!("assign-covering.seed={salt}");
        shop.program(&["build", recipe.to_str().unwrap(), "--set", &seed])
    };
    Soak { name: "pebble", shop: &shop, build: &build }.run(if is_long() { 200 } else { 1 });
}

/// Whether this is `cargo xtask soak`.
pub fn is_long() -> bool {
    std::env::var_os("FIBAR_SOAK").is_some()
}

/// Moments that are the same in every run: a linear congruential generator (Knuth's MMIX).
pub struct Moments(u64);

impl Moments {
    /// From `FIBAR_SOAK_SEED`, else from 1.
    pub fn seeded() -> Moments {
        let given = std::env::var("FIBAR_SOAK_SEED").ok().map(|seed| seed.parse().unwrap());
        Moments(given.unwrap_or(1))
    }

    /// Somewhere before `longest`.
    pub fn next(&mut self, longest: Duration) -> Duration {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        longest.mul_f64((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

/// Builds that are killed, one after the other.
struct Soak<'a> {
    /// Name of the object.
    name: &'static str,
    shop: &'a Workshop,
    /// A build that gives other bytes for every salt.
    build: &'a dyn Fn(usize) -> Command,
}

/// What was seen so far.
#[derive(Default)]
struct Tally {
    rounds: usize,
    kills: usize,
    /// Artefacts that were hashed.
    checked: usize,
    /// Stages that killed builds had finished, which the next build did not run again.
    kept: usize,
}

impl Soak<'_> {
    fn run(&self, kills: usize) {
        let mut moments = Moments::seeded();
        println!("{}: {kills} kills, seed {}", self.name, moments.0);
        self.finish(0);
        let started = Instant::now();
        let stages = self.finish(1);
        let longest = started.elapsed();
        let mut tally = Tally::default();
        while tally.kills < kills {
            self.round(2 + tally.rounds, moments.next(longest), stages, &mut tally);
            if tally.rounds.is_multiple_of(10) {
                tally.print(self.name, started.elapsed());
            }
        }
        tally.print(self.name, started.elapsed());
        println!("{}: nothing was lost", self.name);
    }

    /// Kills a build, looks at what is visible, and lets the next build finish, which runs only what is missing of
    /// `stages`.
    fn round(&self, salt: usize, moment: Duration, stages: usize, tally: &mut Tally) {
        let before = actions(self.shop);
        let mut build = (self.build)(salt);
        let build = build.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        tally.kills += usize::from(kill_after(build, moment));
        tally.checked += check_store(self.shop);
        let kept = actions(self.shop) - before;
        let executed = self.finish(salt);
        assert!(
            executed + kept <= stages,
            "{kept} stages were finished, yet {executed} of {stages} ran again"
        );
        tally.checked += check_published(&self.shop.opened(self.name));
        self.shop.run(&["cache", "gc", "--max-size", "1"]).expect(0);
        tally.kept += kept;
        tally.rounds += 1;
    }

    /// Builds to the end, whatever verifiers say of the result; says how many stages ran.
    fn finish(&self, salt: usize) -> usize {
        let outcome = Outcome::of(&mut (self.build)(salt));
        assert!(matches!(outcome.code, 0 | 1), "{outcome:?}");
        self.shop.opened(self.name).executed()
    }
}

impl Tally {
    fn print(&self, name: &str, time: Duration) {
        println!(
            "{name}: {} rounds, {} kills, {} artefacts checked, {} stages kept over a kill, {:.0} s",
            self.rounds,
            self.kills,
            self.checked,
            self.kept,
            time.as_secs_f64()
        );
    }
}

/// Kills the program, unless it was quicker; says whether it was killed.
pub fn kill_after(mut build: Child, moment: Duration) -> bool {
    std::thread::sleep(moment);
    let runs = build.try_wait().unwrap().is_none();
    build.kill().unwrap();
    build.wait().unwrap();
    runs
}
