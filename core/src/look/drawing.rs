//! How strands become pixels, and how pixels that several of them touch are made.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, choices, number};

choices! {
    /// How strands become pixels.
    Primitive {
        Compute = "compute", "Compute rasteriser", "Segments binned into tiles and composited front to back in a compute shader";
        Ribbons = "ribbons", "Ribbons", "Camera-facing strips through the graphics pipeline, tapered";
    }
}
choices! {
    /// How partly covered pixels combine.
    Transparency {
        FrontToBack = "front-to-back", "Front to back", "Fragments sorted by depth and composited until the pixel is opaque";
        Opaque = "opaque", "Opaque", "The nearest strand covers the whole pixel: shows what coverage is worth";
    }
}

pub(super) fn primitive<'a>(choice: &'a mut Primitive, lod: &'a mut f32) -> Slot<'a> {
    Slot {
        key: "primitive",
        label: "Drawing",
        help: "How strands become pixels",
        choice,
        params: vec![number(
            "primitive.lod",
            "Level of detail",
            "share of strands",
            (0.02, 1.0),
            lod,
            &[],
            "Fewer, wider strands of the same total area",
        )],
    }
}

pub(super) fn transparency(choice: &mut Transparency) -> Slot<'_> {
    Slot {
        key: "transparency",
        label: "Transparency",
        help: "How partly covered pixels combine",
        choice,
        params: vec![],
    }
}
