//! Any bytes under the name of a .bin file: an import or an error.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(import) = lorelei_core::io::read_strands_from_bytes("fuzz.bin", bytes) {
        import.place();
    }
});
