//! The slots of drawing and of the last pass.

use lorelei_core::look::{Antialiasing, Background, Look, ShadingRate, Tonemapping};
use lorelei_shaders::Link;

/// `lorelei::cover`: how much of a pixel a strand covers.
pub fn antialiasing(choice: Antialiasing) -> Link<'static> {
    Link::Slot(
        "cover",
        match choice {
            // Supersampling draws smaller pixels, each as exactly.
            Antialiasing::Analytic | Antialiasing::Super2 | Antialiasing::Super3 => "cover_analytic",
            Antialiasing::None => "cover_none",
            Antialiasing::Msaa4 => "cover_msaa4",
            Antialiasing::AlphaToCoverage => "cover_alpha_to_coverage",
        },
    )
}

/// Pixels drawn for one of the picture, along a side.
pub fn supersampling(choice: Antialiasing) -> u32 {
    match choice {
        Antialiasing::None | Antialiasing::Analytic | Antialiasing::Msaa4 | Antialiasing::AlphaToCoverage => 1,
        Antialiasing::Super2 => 2,
        Antialiasing::Super3 => 3,
    }
}

/// `lorelei::radiance`: where strands are shaded; with what shades them, where that is asked for there.
pub fn shading_rate(look: &Look) -> Vec<Link<'static>> {
    match look.shading_rate {
        ShadingRate::PerVertex => vec![Link::Slot("radiance", "radiance_vertex")],
        ShadingRate::PerFragment => {
            let mut links = crate::shade::links(look);
            links.push(Link::Slot("radiance", "radiance_fragment"));
            links
        }
    }
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
            Background::Environment => "background_environment",
            Background::Plain => "background_plain",
            Background::Transparent => "background_transparent",
        },
    )
}
