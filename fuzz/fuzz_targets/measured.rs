#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| overcoat_fuzz::targets::measured(data));
