#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| overcoat_fuzz::targets::ktx2(data));
