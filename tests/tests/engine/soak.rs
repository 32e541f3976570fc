//! `kill -9` at random moments: what is visible is whole, and the next build succeeds without flags.

use crate::demo::{Demo, check_names};
use fibar_tests::{Workshop, checkout};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn is_soak() -> bool {
    std::env::var_os("FIBAR_SOAK").is_some()
}

/// Moments that are the same in every run: a linear congruential generator (Knuth's MMIX).
struct Moments(u64);

impl Moments {
    /// Somewhere before `longest`.
    fn next(&mut self, longest: Duration) -> Duration {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        longest.mul_f64((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}

/// Kills the program, unless it was quicker; says whether it was killed.
fn kill_after(mut build: Child, moment: Duration) -> bool {
    std::thread::sleep(moment);
    let runs = build.try_wait().unwrap().is_none();
    build.kill().unwrap();
    build.wait().unwrap();
    runs
}

#[test]
fn soak_killed_builds_lose_nothing() {
    let kills = if is_soak() { 200 } else { 6 };
    let demo = Demo::new();
    let started = Instant::now();
    assert!(demo.build(0, "build").output().unwrap().status.success());
    let longest = started.elapsed();
    let mut moments = Moments(1);
    let (mut killed, mut salt) = (0, 0);
    while killed < kills {
        salt += 1;
        let build = demo.build(salt, "build").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        killed += usize::from(kill_after(build, moments.next(longest)));
        demo.check_store();
        let next = demo.build(salt, "build").output().unwrap();
        assert!(next.status.success(), "{}", String::from_utf8_lossy(&next.stderr));
    }
    demo.check_store();
    println!(
        "{killed} builds of demo stages killed in {:.0} s: nothing lost",
        started.elapsed().as_secs_f64()
    );
}

#[test]
fn soak_killed_builds_of_the_pebble_lose_nothing() {
    let kills = if is_soak() { 20 } else { 1 };
    let shop = Workshop::default();
    let build = |salt: usize| -> Command {
        let recipe = checkout().join("recipes/pebble.toml");
        let mut command = shop.program(&[
            "build",
            recipe.to_str().unwrap(),
            "--set",
            &format!("assign-genetic.seed={salt}"),
        ]);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    let started = Instant::now();
    let code = build(0).status().unwrap().code();
    assert!(matches!(code, Some(0 | 1)), "{code:?}");
    let longest = started.elapsed();
    let mut moments = Moments(2);
    for salt in 1..=kills {
        kill_after(build(salt).spawn().unwrap(), moments.next(longest));
        check_names(&shop.path().join("store/cas"));
        shop.run(&["cache", "verify"]).expect(0);
        assert_eq!(build(salt).status().unwrap().code(), code);
    }
    println!("{kills} builds of the pebble killed in {:.0} s: nothing lost", started.elapsed().as_secs_f64());
}
