//! Any bytes under the name of a .ply file: strands, a mesh or an error.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(import) = lorelei_core::io::read_strands_from_bytes("fuzz.ply", bytes) {
        import.place();
    }
    if let Ok(import) = lorelei_core::io::read_mesh_from_bytes("fuzz.ply", bytes) {
        import.place();
    }
});
