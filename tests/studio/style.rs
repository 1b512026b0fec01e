//! A style stack with more operators than there is room for says so, once, on its way to the GPU.

use lorelei_core::style::{StyleKind, StyleOp};
use lorelei_render::Renderer;
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_tests::golden::groom::groom;

#[test]
fn operators_without_room_are_named_when_the_style_changes_and_not_again() {
    let mut groom = groom();
    let mut renderer = Renderer::new(&Gpu::headless().unwrap(), ShaderLibrary::embedded()).unwrap();
    assert_eq!(renderer.set_groom(&groom).unwrap(), Vec::<String>::new());
    let clump = StyleOp::new(StyleKind::DEFAULTS[0]);
    groom.layers[0].style.extend([clump.clone(), clump.clone(), clump]);
    let warnings = renderer.set_groom(&groom).unwrap();
    assert!(warnings.len() == 1 && warnings[0].starts_with("hair: no room for operator 6 (Clump)"), "{warnings:?}");
    groom.look.exposure = 1.0;
    assert_eq!(renderer.set_groom(&groom).unwrap(), Vec::<String>::new());
}
