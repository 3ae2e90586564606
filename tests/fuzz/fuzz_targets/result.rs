//! `RUSTC_BOOTSTRAP=1 cargo fuzz run --fuzz-dir tests/fuzz --features libfuzzer --sanitizer none result`
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| massline_fuzz::fuzz_result(bytes));
