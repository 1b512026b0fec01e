//! How strands become pixels, and how pixels that several of them touch are made.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, choices, integer, number};

choices! {
    /// How strands become pixels.
    Primitive {
        Compute = "compute", "Compute rasteriser", "Segments onto pixels in a compute shader: the fastest";
        Polylines = "polylines", "Polylines", "Lines of one pixel through the graphics pipeline; a strand's width is their alpha";
        Ribbons = "ribbons", "Ribbons", "Camera-facing strips through the graphics pipeline, as wide as strands and tapered";
    }
}
choices! {
    /// How the edge of a strand meets a pixel.
    Antialiasing {
        None = "none", "None", "A strand covers a pixel whose centre it touches, and no other: thin strands break up";
        Analytic = "analytic", "Analytic coverage", "The exact share of the pixel that lies under the strand";
        Msaa4 = "msaa4", "MSAA x4", "Four samples a pixel decide what a strand covers; it is shaded once";
        Super2 = "ssaa2", "Supersampling 2 x 2", "Drawn at twice the size and averaged";
        Super3 = "ssaa3", "Supersampling 3 x 3", "Drawn at three times the size and averaged";
        AlphaToCoverage = "alpha-to-coverage", "Alpha to coverage", "As many of four samples as the strand's share of the pixel asks for";
    }
}
choices! {
    /// How partly covered pixels combine.
    Transparency {
        FrontToBack = "front-to-back", "Front to back", "Strands in buckets of depth, composited until the pixel is opaque";
        Opaque = "opaque", "Opaque", "The nearest strand covers the whole pixel: shows what coverage is worth";
        AlphaTest = "alpha-test", "Alpha test", "Strands that cover more than a threshold are opaque, others are not drawn";
        Hashed = "hashed", "Hashed alpha test", "A threshold for each place of each strand, hashed so that it moves with the hair (Wyman and McGuire 2017)";
        AlphaToCoverage = "alpha-to-coverage", "Alpha to coverage", "Opaque in as many of four samples as the alpha asks for: the same for alike strands";
        Stochastic = "stochastic", "Stochastic", "Opaque in samples chosen at random: right on average, and noisy (Enderton et al. 2010)";
        WeightedAverage = "weighted-average", "Weighted average", "Colours averaged whatever their order (Bavoil and Myers 2008)";
        ThreeSubsets = "three-subsets", "Three subsets", "The nearest opaque strand of each third of the strands, averaged: fake transparency";
        Sorted = "sorted", "Sorted segments", "Segments sorted from back to front on the GPU and blended by the graphics pipeline";
        HalfAngle = "half-angle", "Half-angle slices", "Slices across the vector half way between eye and light, each lit by what those before it let through: shadow and transparency at once (Ikits et al. 2004)";
        DepthPeeling = "depth-peeling", "Depth peeling", "Layer after layer from the front, exact as far as it goes (Everitt 2001)";
        Occupancy = "occupancy", "Occupancy maps", "The order of fragments from bits of occupied slices (Sintorn and Assarsson 2009)";
        KNearest = "k-nearest", "Nearest and tail", "The nearest few exactly, what is behind them by its transmittance in slabs";
    }
}
choices! {
    /// Where strands are shaded.
    ShadingRate {
        PerVertex = "per-vertex", "Per vertex", "Once a vertex, interpolated between: the fastest";
        PerFragment = "per-fragment", "Per fragment", "Wherever a strand touches a pixel, knowing how far from its axis: slower, sharper";
    }
}

/// Parameters of the choices of drawing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DrawingParams {
    /// 0-1: of the fibre itself; multiplies its coverage.
    pub opacity: f32,
    /// 0-1: alpha from which a strand is drawn.
    pub alpha_cutoff: f32,
    /// Samples a pixel of stochastic transparency.
    pub n_samples: u32,
    /// Which random numbers.
    pub seed: u32,
    pub n_layers: u32,
    pub n_nearest: u32,
    /// Half-angle slices: how many.
    pub n_slices: u32,
    /// Half-angle slices: the number of the light that shines through them, counted from 1 among the groom's.
    pub slices_light: u32,
    /// Half-angle slices: side of the light's buffer in texels.
    pub slices_resolution: u32,
}

impl Default for DrawingParams {
    fn default() -> Self {
        Self {
            opacity: 1.0,
            alpha_cutoff: 0.15,
            n_samples: 8,
            seed: 0,
            n_layers: 16,
            n_nearest: 4,
            n_slices: 64,
            slices_light: 1,
            slices_resolution: 1024,
        }
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

pub(super) fn antialiasing(choice: &mut Antialiasing) -> Slot<'_> {
    Slot {
        key: "antialiasing",
        label: "Antialiasing",
        help: "How the edge of a strand meets a pixel",
        choice,
        params: vec![],
    }
}

pub(super) fn transparency<'a>(choice: &'a mut Transparency, params: &'a mut DrawingParams) -> Slot<'a> {
    let DrawingParams {
        opacity,
        alpha_cutoff,
        n_samples,
        seed,
        n_layers,
        n_nearest,
        n_slices,
        slices_light,
        slices_resolution,
    } = params;
    Slot {
        key: "transparency",
        label: "Transparency",
        help: "How partly covered pixels combine",
        choice,
        params: vec![
            number(
                "transparency.opacity",
                "Opacity",
                "share",
                (0.0, 1.0),
                opacity,
                &[],
                "Of the fibre itself, times the share of the pixel that it covers",
            ),
            number(
                "transparency.cutoff",
                "Cutoff",
                "alpha",
                (0.0, 1.0),
                alpha_cutoff,
                &["alpha-test"],
                "Strands that cover less of a pixel are not drawn there",
            ),
            integer(
                "transparency.samples",
                "Samples",
                "a pixel",
                (1, 64),
                n_samples,
                &["stochastic"],
                "More are smoother and slower",
            ),
            integer(
                "transparency.seed",
                "Seed",
                "",
                (0, 65_535),
                seed,
                &["stochastic"],
                "Another pattern of noise; the mean of many is the exact picture",
            ),
            integer(
                "transparency.layers",
                "Layers",
                "",
                (1, 256),
                n_layers,
                &["depth-peeling"],
                "Layers that are peeled; it stops sooner where nothing is left",
            ),
            integer(
                "transparency.nearest",
                "Nearest",
                "fragments",
                (1, 8),
                n_nearest,
                &["k-nearest"],
                "Fragments of a pixel that are composited one by one",
            ),
            integer(
                "transparency.slices",
                "Slices",
                "",
                (16, 256),
                n_slices,
                &["half-angle"],
                "Slices of equally many segments: hair of one slice does not shadow itself",
            ),
            integer(
                "transparency.light",
                "Light",
                "",
                (1, 16),
                slices_light,
                &["half-angle"],
                "The light that shines through the slices, counted from 1; the next that is on and casts shadows, where \
                 this one does not. All others use the chosen shadowing",
            ),
            integer(
                "transparency.resolution",
                "Light buffer",
                "texels",
                (128, 4096),
                slices_resolution,
                &["half-angle"],
                "Side of the buffer that the slices' shadow is added up in",
            ),
        ],
    }
}

pub(super) fn shading_rate(choice: &mut ShadingRate) -> Slot<'_> {
    Slot { key: "rate", label: "Shading rate", help: "Where strands are shaded", choice, params: vec![] }
}
