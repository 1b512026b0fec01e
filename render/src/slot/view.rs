//! The slots of false colours: a vertex's, and the picture's.

use lorelei_core::look::FalseColour;
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
            | FalseColour::Transmittance => "view_picture_flat",
            FalseColour::Overdraw => "view_picture_overdraw",
            FalseColour::Depth => "view_picture_depth",
            FalseColour::Coverage => "view_picture_coverage",
            FalseColour::Normals => "view_picture_normals",
        },
    )
}
