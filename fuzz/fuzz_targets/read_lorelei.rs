//! Any bytes under the name of a document: a groom that can be saved again, or an error.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = lorelei_core::document::open_bytes("fuzz.lorelei", bytes);
});
