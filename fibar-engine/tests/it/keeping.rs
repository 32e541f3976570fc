//! What the store keeps, loses and survives.

use crate::bench::{Bench, book, list};
use fibar_engine::{Class, Digest, Store};
use std::time::{Duration, SystemTime};

/// Makes everything in a folder look old.
fn age(bench: &Bench, folder: &str, by: Duration) {
    for name in bench.list(folder) {
        let path = bench.path(folder).join(name);
        let file = std::fs::File::open(path).unwrap();
        file.set_modified(SystemTime::now() - by).unwrap();
    }
}

fn text(n: u32) -> String {
    book(&format!("text = 'text number {n}'"), "", "")
}

#[test]
fn garbage_is_what_was_used_least_recently() {
    let bench = Bench::new();
    for n in 0..4 {
        bench.build(&text(n)).unwrap();
        age(&bench, "store/actions", Duration::from_secs(100));
        age(&bench, "store/cas", Duration::from_secs(100));
    }
    bench.runs(&text(0), &[]);
    age(&bench, "store/actions", Duration::from_secs(50));
    age(&bench, "store/cas", Duration::from_secs(50));
    bench.write("store/tmp/leftover", "x");
    age(&bench, "store/tmp", Duration::from_secs(50));
    std::fs::remove_dir_all(bench.path("build")).unwrap();
    bench.build(&text(3)).unwrap();
    let (before, store) = (bench.list("store/cas").len(), bench.store());
    let done = store.collect_garbage(0).unwrap();
    assert!(done.blobs > 0 && done.actions > 0 && done.swept >= 1, "{done:?}");
    assert_eq!(bench.list("store/cas").len(), before - done.blobs);
    assert_eq!(bench.list("store/tmp"), [""; 0]);
    bench.runs(&text(3), &[]);
    bench.runs(&text(1), &["make-text", "upper-text", "bind-text", "verify-text"]);
    assert_eq!(store.audit().unwrap().damaged, []);
}

#[test]
fn what_a_build_folder_refers_to_is_pinned() {
    let bench = Bench::new();
    bench.build(&text(1)).unwrap();
    for folder in ["store/actions", "store/cas"] {
        age(&bench, folder, Duration::from_secs(100));
    }
    let done = bench.store().collect_garbage(0).unwrap();
    assert_eq!((done.actions, done.blobs, done.left), (0, 0, done.pinned), "{done:?}");
    std::fs::remove_dir_all(bench.path("build")).unwrap();
    assert_eq!(bench.store().collect_garbage(0).unwrap().left, 0);
}

#[test]
fn a_running_build_loses_nothing_to_the_collector() {
    let bench = Bench::new();
    std::thread::scope(|scope| {
        let build = scope.spawn(|| bench.build(&book("", "seconds = 0.5", "")).unwrap());
        while !build.is_finished() {
            bench.store().collect_garbage(0).unwrap();
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(build.join().unwrap().executed(), 4);
    });
    bench.runs(&book("", "seconds = 0.5", ""), &[]);
}

#[test]
fn an_audit_finds_what_is_damaged() {
    let bench = Bench::new();
    bench.build(&book("text = 'bye'", "", "")).unwrap();
    let name = Digest::of(b"bye").to_string();
    let blob = bench.path("store/cas").join(&name);
    std::fs::remove_file(&blob).unwrap();
    std::fs::write(&blob, "bYe").unwrap();
    let action = bench.path("store/actions").join(&bench.list("store/actions")[0]);
    let mut bytes = std::fs::read(&action).unwrap();
    let last = bytes.len() - 2;
    bytes[last] ^= 1;
    std::fs::write(&action, bytes).unwrap();
    let audit = bench.store().audit().unwrap();
    assert_eq!((audit.damaged, audit.unreadable, audit.actions), (vec![name.parse().unwrap()], 1, 3));
    bench.build(&book("text = 'bye'", "", "")).unwrap();
    let audit = bench.store().audit().unwrap();
    assert_eq!((audit.damaged.len(), audit.unreadable, audit.incomplete), (0, 0, 0));
}

#[test]
fn eight_builds_at_once_run_each_action_once() {
    let bench = Bench::new();
    let recipe = book("", "seconds = 0.1", "");
    bench.write("recipe.toml", &recipe);
    let executed: usize = std::thread::scope(|scope| {
        let build = |_| scope.spawn(|| bench.build_in_own_folder(&recipe).unwrap().executed());
        let builds: Vec<_> = (0..8).map(build).collect();
        builds.into_iter().map(|build| build.join().unwrap()).sum()
    });
    assert_eq!(executed, 4);
    let audit = bench.store().audit().unwrap();
    assert_eq!((audit.damaged.len(), audit.unreadable, audit.incomplete, audit.actions), (0, 0, 0, 4));
    assert_eq!(bench.list("store/work"), [""; 0]);
}

/// A file system of a megabyte, in a mount namespace of its own; only root can have one here.
#[cfg(target_os = "linux")]
struct SmallDisk(std::path::PathBuf);

#[cfg(target_os = "linux")]
impl SmallDisk {
    fn mount(path: std::path::PathBuf, size: &str) -> Option<SmallDisk> {
        std::fs::create_dir_all(&path).unwrap();
        let options = format!("size={size}");
        let mut mount = std::process::Command::new("mount");
        let mounted = mount.args(["-t", "tmpfs", "-o", &options, "none"]).arg(&path).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(SmallDisk(path))
    }

    fn grow(&self) {
        let mut mount = std::process::Command::new("mount");
        assert!(mount.args(["-o", "remount,size=64m"]).arg(&self.0).status().unwrap().success());
    }
}

#[cfg(target_os = "linux")]
impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = std::process::Command::new("umount").arg("-l").arg(&self.0).status();
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_loses_nothing_finished() {
    let bench = Bench::new();
    let Some(disk) = SmallDisk::mount(bench.path("store"), "400k") else {
        println!("skipped: a small file system cannot be mounted here");
        return;
    };
    bench.write("big.txt", &"0123456789".repeat(15_000));
    let recipe = book("file = 'big.txt'", "", "");
    let error = bench.build(&recipe).expect_err("150 kB do not fit three times");
    assert_eq!(error.class, Class::Resource, "{error}");
    assert!(error.render().contains("finished stages are kept"), "{error}");
    assert_eq!(list(&bench.path("store/work")), [""; 0]);
    let audit = Store::open(&bench.path("store")).unwrap().audit().unwrap();
    assert_eq!((audit.damaged.len(), audit.unreadable, audit.incomplete), (0, 0, 0));
    disk.grow();
    let ran = bench.build(&recipe).unwrap().executed();
    assert_eq!(ran, 4 - audit.actions, "finished stages are hits");
}
