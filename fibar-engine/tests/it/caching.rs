//! What runs again, and what does not.

use crate::bench::{Bench, book};

const ALL: [&str; 4] = ["make-text", "upper-text", "bind-text", "verify-text"];

#[test]
fn a_second_build_runs_nothing() {
    let bench = Bench::new();
    bench.runs(&book("", "", "word = 'zebra'"), &ALL);
    bench.runs(&book("", "", "word = 'zebra'"), &[]);
}

#[test]
fn a_changed_parameter_reruns_its_stage_and_what_follows() {
    let bench = Bench::new();
    bench.runs(&book("", "", "word = 'a'"), &ALL);
    bench.runs(&book("text = 'bye'", "", "word = 'a'"), &ALL);
    bench.runs(&book("text = 'bye'", "", "word = 'b'"), &["verify-text"]);
    bench.runs(&book("text = 'bye'\ntimes = 1\nseed = 0", "", "word = 'b'"), &[]);
    bench.runs(&book("text = 'bye'\nseed = 3", "", "word = 'b'"), &["make-text"]);
}

#[test]
fn a_change_that_gives_the_same_bytes_stops_there() {
    let bench = Bench::new();
    bench.runs(&book("text = 'bye'", "", ""), &ALL);
    bench.runs(&book("text = 'BYE'", "", ""), &["make-text", "upper-text"]);
}

#[test]
fn a_changed_file_reruns_and_a_touched_one_does_not() {
    let bench = Bench::new();
    let recipe = book("file = 'more.txt'", "", "");
    bench.write("more.txt", " world");
    bench.runs(&recipe, &ALL);
    bench.write("more.txt", " world");
    bench.runs(&recipe, &[]);
    bench.write("more.txt", " moon");
    bench.runs(&recipe, &ALL);
}

#[test]
fn a_blob_that_is_gone_is_built_again() {
    let bench = Bench::new();
    let recipe = book("", "", "");
    bench.runs(&recipe, &ALL);
    let lock = bench.read("build/book/fibar.lock");
    for blob in bench.list("store/cas") {
        std::fs::remove_file(bench.path("store/cas").join(blob)).unwrap();
    }
    bench.runs(&recipe, &ALL);
    assert_eq!(bench.read("build/book/fibar.lock"), lock);
}

#[test]
fn a_folder_of_the_store_that_is_gone_is_made_again() {
    let bench = Bench::new();
    let recipe = book("", "", "");
    bench.runs(&recipe, &ALL);
    for (folder, again) in [("descriptions", &[][..]), ("locks", &[]), ("tmp", &[]), ("actions", &ALL)] {
        std::fs::remove_dir_all(bench.path("store").join(folder)).unwrap();
        bench.runs(&recipe, again);
    }
}

#[test]
fn a_flipped_byte_is_found_and_mended() {
    let bench = Bench::new();
    let recipe = book("text = 'bye'", "", "");
    bench.runs(&recipe, &ALL);
    let blob = bench.path("store/cas").join(fibar_engine::Digest::of(b"BYE").to_string());
    std::fs::remove_file(&blob).unwrap();
    std::fs::write(&blob, "BYX").unwrap();
    std::fs::remove_file(bench.path("build/book/upper.txt")).unwrap();
    bench.build(&recipe).unwrap();
    assert_eq!(std::fs::read(&blob).unwrap(), b"BYE");
    assert_eq!(bench.read("build/book/upper.txt"), "BYE");
    assert_eq!(bench.list("store/quarantine").len(), 1);
}
