//! Many processes, one store.

use crate::demo::{Demo, STAGE_COUNT};
use crate::soak::{Moments, is_long, kill_after};
use crate::store::{actions, check_store};
use std::process::Child;
use std::time::{Duration, Instant};

#[test]
fn soak_eight_builds_share_one_store() {
    let demo = Demo::new();
    let rounds = if is_long() { 20 } else { 1 };
    for salt in 0..rounds {
        let executed: usize = finish(start(&demo, salt), &demo);
        assert_eq!(executed, STAGE_COUNT, "each action is executed once");
        check_store(&demo.shop);
    }
    println!("{rounds} times eight builds at once: each action executed once");
}

#[test]
fn soak_a_killed_build_does_not_hold_up_the_others() {
    let demo = Demo::new();
    let started = Instant::now();
    finish(start(&demo, 0), &demo);
    let longest = started.elapsed();
    let mut moments = Moments::seeded();
    let rounds = if is_long() { 20 } else { 2 };
    let mut kills = 0;
    for salt in 1..=rounds {
        let before = actions(&demo.shop);
        let mut builds = start(&demo, salt);
        kills += usize::from(kill_after(builds.remove(0).1, moments.next(longest)));
        let executed = finish(builds, &demo);
        assert!(executed <= STAGE_COUNT, "{executed} of {STAGE_COUNT} stages ran");
        assert_eq!(actions(&demo.shop) - before, STAGE_COUNT);
        check_store(&demo.shop);
    }
    println!(
        "{rounds} times eight builds at once, one of them killed ({kills} before their end): the others succeeded"
    );
}

/// Eight builds of the same, each with its folder.
fn start(demo: &Demo, salt: usize) -> Vec<(String, Child)> {
    let build = |i| (format!("out{i}"), demo.build(salt, &format!("out{i}")).spawn().unwrap());
    (0..8).map(build).collect()
}

/// Waits for all to succeed; how many stages they executed, together.
fn finish(builds: Vec<(String, Child)>, demo: &Demo) -> usize {
    let finish_one = |(out, build): (String, Child)| {
        let output = build.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        demo.executed(&out)
    };
    builds.into_iter().map(finish_one).sum()
}

/// A stale lock would stop the next build for ever.
#[test]
fn a_killed_build_leaves_no_lock() {
    let demo = Demo::new();
    kill_after(demo.build(0, "out").spawn().unwrap(), Duration::from_millis(80));
    assert!(demo.build(0, "out").output().unwrap().status.success());
}
