//! Many processes, one store.

use crate::demo::{Demo, STAGE_COUNT};

#[test]
fn eight_builds_share_one_store() {
    let demo = Demo::new();
    let builds: Vec<_> = (0..8).map(|i| demo.build(0, &format!("out{i}")).spawn().unwrap()).collect();
    for build in builds {
        let output = build.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let executed: usize = (0..8).map(|i| demo.executed(&format!("out{i}"))).sum();
    assert_eq!(executed, STAGE_COUNT, "each action is executed once");
    demo.check_store();
}

#[test]
fn a_killed_build_leaves_no_lock() {
    let demo = Demo::new();
    let mut first = demo.build(0, "out").spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(80));
    first.kill().unwrap();
    first.wait().unwrap();
    let output = demo.build(0, "out").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
