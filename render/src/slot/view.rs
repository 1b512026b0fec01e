//! The slots of false colours: a vertex's, and the picture's.

use lorelei_core::look::{FalseColour, Shadowing};
use lorelei_shaders::Link;

/// `lorelei::view_colour`: what a strand shows in place of its radiance. Of the final picture it is not asked.
pub fn view_colour(choice: FalseColour) -> Link<'static> {
    Link::Slot(
        "view_colour",
        match choice {
            FalseColour::Final
            | FalseColour::Overdraw
            | FalseColour::Depth
            | FalseColour::Coverage
            | FalseColour::Normals => "view_colour_grey",
            FalseColour::Tangent => "view_colour_tangent",
            FalseColour::RootUv
            | FalseColour::Strand
            | FalseColour::Group
            | FalseColour::Guides
            | FalseColour::Lod
            | FalseColour::Clump => "view_colour_strand",
            FalseColour::Transmittance => "view_colour_transmittance",
            FalseColour::ShadowLayer => "view_colour_shadow_layer",
        },
    )
}

/// `lorelei::shadow_part`: which layer, slice or cluster of the shadow technique hair lies in.
pub fn shadow_part(choice: Shadowing) -> Link<'static> {
    Link::Slot(
        "shadow_part",
        match choice {
            Shadowing::DeepOpacity => "shadow_part_deep_opacity",
            Shadowing::OpacityMaps => "shadow_part_opacity_maps",
            Shadowing::Clusters => "shadow_part_clusters",
            Shadowing::Occupancy => "shadow_part_occupancy",
            Shadowing::Off
            | Shadowing::ShadowMap
            | Shadowing::Exponential
            | Shadowing::DeepShadow
            | Shadowing::Voxels => "shadow_part_none",
        },
    )
}

/// `lorelei::view_picture`: how hair and body make the picture.
pub fn view_picture(choice: FalseColour) -> Link<'static> {
    Link::Slot(
        "view_picture",
        match choice {
            FalseColour::Final => "view_picture_light",
            FalseColour::Tangent
            | FalseColour::RootUv
            | FalseColour::Strand
            | FalseColour::Group
            | FalseColour::Guides
            | FalseColour::Lod
            | FalseColour::Clump
            | FalseColour::Transmittance
            | FalseColour::ShadowLayer => "view_picture_flat",
            FalseColour::Overdraw => "view_picture_overdraw",
            FalseColour::Depth => "view_picture_depth",
            FalseColour::Coverage => "view_picture_coverage",
            FalseColour::Normals => "view_picture_normals",
        },
    )
}
