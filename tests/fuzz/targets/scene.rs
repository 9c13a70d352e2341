#![no_main]

#[path = "../bodies/scene.rs"]
mod body;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| body::scene(bytes));
