#![no_main]

mod search;

libfuzzer_sys::fuzz_target!(|input: &[u8]| search::read("flight_log", input));
