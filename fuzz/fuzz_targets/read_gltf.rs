//! Any bytes under the name of a .gltf file: a mesh or an error.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(import) = lorelei_core::io::read_mesh_from_bytes("fuzz.gltf", bytes) {
        import.place();
    }
});
