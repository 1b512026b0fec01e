//! A glTF file whose nodes move: for the window and for the command line.

/// Times of the keys, seconds.
const SECS: [f32; 3] = [0.0, 0.25, 0.5];

/// Two nodes with three keys each: "Head" goes 6 cm to the model's left and stays, "Hips" 6 cm down.
pub fn animated_glb() -> Vec<u8> {
    let mut bytes: Vec<u8> = SECS.iter().flat_map(|secs| secs.to_le_bytes()).collect();
    for way in [[0.06_f32, 0.0, 0.0], [0.0, -0.06, 0.0]] {
        let places = [[0.0; 3], way, way];
        bytes.extend(places.iter().flatten().flat_map(|metres| metres.to_le_bytes()));
    }
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"name":"Head"}},{{"name":"Hips"}}],
        "buffers":[{{"byteLength":{}}}],
        "bufferViews":[{{"buffer":0,"byteLength":12}},{{"buffer":0,"byteOffset":12,"byteLength":36}},
        {{"buffer":0,"byteOffset":48,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR","min":[0],"max":[0.5]}},
        {{"bufferView":1,"componentType":5126,"count":3,"type":"VEC3"}},
        {{"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"}}],
        "animations":[{{"samplers":[{{"input":0,"output":1}},{{"input":0,"output":2}}],
        "channels":[{{"sampler":0,"target":{{"node":0,"path":"translation"}}}},
        {{"sampler":1,"target":{{"node":1,"path":"translation"}}}}]}}]}}"#,
        bytes.len()
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF".to_vec();
    glb.extend(2_u32.to_le_bytes());
    glb.extend(((12 + 8 + json.len() + 8 + bytes.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bytes)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    glb
}
