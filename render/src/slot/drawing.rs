//! The slots of drawing and of the last pass.

use lorelei_core::look::{Background, Tonemapping, Transparency};
use lorelei_shaders::Link;

/// `lorelei::blend`: how fragments of a pixel combine in the compute rasteriser.
pub fn transparency(choice: Transparency) -> Link<'static> {
    Link::Slot(
        "blend",
        match choice {
            Transparency::FrontToBack => "blend_front_to_back",
            Transparency::Opaque => "blend_opaque",
        },
    )
}

/// `lorelei::lane_blend`: the same where a thread owns pixels.
pub fn transparency_in_lanes(choice: Transparency) -> Link<'static> {
    Link::Slot(
        "lane_blend",
        match choice {
            Transparency::FrontToBack => "lane_blend_front_to_back",
            Transparency::Opaque => "lane_blend_opaque",
        },
    )
}

/// `lorelei::tonemap`: from scene light to the display.
pub fn tonemapping(choice: Tonemapping) -> Link<'static> {
    Link::Slot(
        "tonemap",
        match choice {
            Tonemapping::Agx => "tonemap_agx",
            Tonemapping::Linear => "tonemap_linear",
        },
    )
}

/// `lorelei::background`: what is behind head and hair.
pub fn background(choice: Background) -> Link<'static> {
    Link::Slot(
        "background",
        match choice {
            Background::Gradient => "background_gradient",
            Background::Plain => "background_plain",
            Background::Transparent => "background_transparent",
        },
    )
}
