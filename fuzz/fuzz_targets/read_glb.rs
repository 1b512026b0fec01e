//! Any bytes under the name of a .glb file: a mesh or an error.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(import) = lorelei_core::io::read_mesh_from_bytes("fuzz.glb", bytes) {
        import.place();
    }
});
