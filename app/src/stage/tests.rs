//! Shaders that are edited while the stage draws.

use std::path::Path;

use lorelei_core::look::Background;

use super::*;

#[test]
fn an_edited_shader_is_seen_in_the_next_frame_and_a_faulty_one_is_told_once_and_not_used() {
    let folder = tempfile::tempdir().unwrap();
    let sources = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shaders/wgsl"));
    for entry in std::fs::read_dir(sources).unwrap().flatten() {
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    let file = folder.path().join("background_plain.wgsl");
    let good = std::fs::read_to_string(&file).unwrap();
    let library = ShaderLibrary::watching(folder.path()).unwrap();
    let mut stage = Stage::with_library(Gpu::headless().unwrap(), None, library).unwrap();
    let mut groom = Groom::default();
    groom.look.background = Background::Plain;
    stage.set_groom(&groom).unwrap();
    let mut frame = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let result = stage.frame(&Playback::default(), 0.0, &Camera::default(), [16, 16], Detail::FULL);
        (result.map_err(|why| why.to_string()), stage.read_pixels().unwrap().get_pixel(8, 8).0)
    };
    let (result, grey) = frame(&good);
    assert_eq!(result, Ok(()));
    assert_eq!(grey[0], grey[1]);
    let red = good.replace("vec3<f32>(behind.grey)", "vec3<f32>(1.0, 0.0, 0.0)");
    assert_eq!(frame(&red), (Ok(()), [255, 0, 0, 255]));
    let faulty = good.replace("vec3<f32>(behind.grey)", "vec3<f32>(behind.gray)");
    let (result, pixel) = frame(&faulty);
    let line = 1 + good.lines().position(|line| line.contains("vec3<f32>(behind.grey)")).unwrap();
    let why = result.unwrap_err();
    assert!(why.starts_with(&format!("background_plain.wgsl:{line}:")), "{why}");
    assert_eq!(pixel, [255, 0, 0, 255], "the last good one stays");
    assert_eq!(frame(&faulty), (Ok(()), [255, 0, 0, 255]), "it is told once");
    assert_eq!(frame(&good), (Ok(()), grey));
}
