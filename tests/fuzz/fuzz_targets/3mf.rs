//! The target `3mf` of `fibar_tests::fuzz`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fibar_tests::fuzz::run("3mf", bytes));
