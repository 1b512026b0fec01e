//! The container of binary glTF 2.0: a header, the description as JSON, and one chunk of numbers.

/// A `.glb` file's bytes. `blob` is a multiple of four bytes long, as its views demand.
pub fn to_glb(mut json: String, blob: &[u8]) -> Vec<u8> {
    while !json.len().is_multiple_of(4) {
        json.push(' ');
    }
    let n_bytes = 28 + json.len() + blob.len();
    let mut file = Vec::with_capacity(n_bytes);
    file.extend_from_slice(b"glTF");
    for word in [2, n_bytes as u32, json.len() as u32] {
        file.extend_from_slice(&word.to_le_bytes());
    }
    file.extend_from_slice(b"JSON");
    file.extend_from_slice(json.as_bytes());
    file.extend_from_slice(&(blob.len() as u32).to_le_bytes());
    file.extend_from_slice(b"BIN\0");
    file.extend_from_slice(blob);
    file
}
