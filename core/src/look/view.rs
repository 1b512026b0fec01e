//! What the picture shows in place of light: false colours that make one quantity of the hair visible.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, choices, integer, number};
use crate::hash::random;

choices! {
    /// What the picture shows.
    FalseColour {
        Final = "final", "Final picture", "Light, as everything else here makes it";
        Tangent = "tangent", "Tangent", "Which way each strand runs, root to tip, in the world: X red, Y green, Z blue";
        RootUv = "root-uv", "Root UV", "Where each strand's root lies in the scalp's texture: U red, V green";
        Strand = "strand", "Strand", "Each strand its own colour, by its stable id";
        Group = "group", "Group", "Each layer its own colour";
        Guides = "guides", "Guide influence", "Each guide its own colour; a strand mixes those that it hangs on by their weights";
        Lod = "lod", "Level of detail", "The order in which strands go when there is less detail: bright ones go first";
        Clump = "clump", "Clumps", "Each lock its own colour, each clump in it a shade of that; grey without clumps";
        Overdraw = "overdraw", "Overdraw", "Strands that touch a pixel: what a rasteriser has to work through";
        Depth = "depth", "Depth complexity", "Strands that a ray through the pixel meets, on average: the sum of their coverage";
        Coverage = "coverage", "Coverage", "Share of a pixel that hair hides: the picture's alpha before the head and the background";
        Transmittance = "transmittance", "Light transmittance", "What of the lamps' light gets through hair and past the head to each strand";
        ShadowLayer = "shadow-layer", "Shadow layers", "Which layer, slice or cluster of a lamp's shadow each strand lies in; grey where the technique has none";
        Normals = "normals", "Normals of the body", "Which way the head's surface faces, in the world; hair is left out";
    }
}

impl FalseColour {
    /// Whether the colours are light, to be exposed and tonemapped.
    pub fn is_light(self) -> bool {
        self == Self::Final
    }

    /// What a picture's colours mean.
    pub fn legend(self, params: &ViewParams) -> Legend {
        let ramp = |unit, low: f32, high: f32| Legend::Ramp { unit, low, high };
        match self {
            Self::Final => Legend::None,
            Self::Tangent | Self::Normals => {
                Legend::Names([("X", [1.0, 0.5, 0.5]), ("Y", [0.5, 1.0, 0.5]), ("Z", [0.5, 0.5, 1.0])])
            }
            Self::RootUv => {
                Legend::Names([("U", [1.0, 0.0, ROOT_BLUE]), ("V", [0.0, 1.0, ROOT_BLUE]), ("no head", NO_COLOUR)])
            }
            Self::Strand => Legend::Own("a strand"),
            Self::Group => Legend::Layers,
            Self::Guides => Legend::Own("a guide, mixed by weight"),
            Self::Clump => Legend::Own("a lock, in shades a clump"),
            Self::Lod => ramp("share of the strands", 0.0, 1.0),
            Self::Overdraw => ramp("strands", 0.0, params.most),
            Self::Depth => ramp("strands a ray", 0.0, params.most),
            Self::Coverage => ramp("share", 0.0, 1.0),
            Self::Transmittance => ramp("share of the light", 0.0, 1.0),
            Self::ShadowLayer if params.layer == 0 => Legend::Parts,
            Self::ShadowLayer => ramp("of the light, taken by it", 0.0, 1.0),
        }
    }
}

/// Blue of every colour of [`FalseColour::RootUv`].
pub const ROOT_BLUE: f32 = 0.25;
/// Where there is nothing to tell apart.
pub const NO_COLOUR: [f32; 3] = [0.5; 3];

/// What false colours are, for whoever looks at them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Legend {
    None,
    /// Along [`ramp`], from one value to another.
    Ramp {
        unit: &'static str,
        low: f32,
        high: f32,
    },
    /// Names, and the colour of each.
    Names([(&'static str, [f32; 3]); 3]),
    /// Every one of these has a colour of its own.
    Own(&'static str),
    /// Every layer has [`layer_colour`].
    Layers,
    /// Layers, slices or clusters of a shadow have [`part_colour`], from the lamp on; grey: none.
    Parts,
}

/// Numbers of the views.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ViewParams {
    /// Strands a pixel at the end of the ramp.
    pub most: f32,
    /// 0: the mean over all lamps; else the lamp's number, counted from 1.
    pub light: u32,
    /// 0: every layer of the shadow in its colour; else what the layer of this number, from 1, takes of the light.
    pub layer: u32,
}

impl Default for ViewParams {
    fn default() -> Self {
        Self { most: 32.0, light: 0, layer: 0 }
    }
}

pub(super) fn view<'a>(choice: &'a mut FalseColour, params: &'a mut ViewParams) -> Slot<'a> {
    Slot {
        key: "view",
        label: "View",
        help: "What the picture shows: light, or one quantity in false colours",
        choice,
        params: vec![
            number(
                "view.most",
                "Most",
                "strands",
                (1.0, 1000.0),
                &mut params.most,
                &["overdraw", "depth"],
                "Where the colours end",
            ),
            integer(
                "view.light",
                "Light",
                "",
                (0, 64),
                &mut params.light,
                &["transmittance", "shadow-layer"],
                "The lamp's number among those that are on; a square lamp counts as four. 0: the mean of all, or for \
                 shadow layers the first",
            ),
            integer(
                "view.layer",
                "Only layer",
                "",
                (0, 256),
                &mut params.layer,
                &["shadow-layer"],
                "Show what of the light this layer, slice or cluster takes, counted from 1 at the lamp. 0: all, each in \
                 its colour",
            ),
        ],
    }
}

/// A colour, encoded for a display, for a share of 0 to 1: dark blue over green to yellow, evenly in brightness and
/// told apart by everybody.
///
/// Polynomial of the sixth degree (M. Zucker 2019, public domain) through matplotlib's viridis (S. van der Walt and
/// N. Smith 2015). Twin of `ramp` in `view_ramp.wgsl`.
pub fn ramp(share: f32) -> [f32; 3] {
    const C: [[f32; 3]; 7] = [
        [0.277_727_33, 0.005_407_344_6, 0.334_099_8],
        [0.105_093_04, 1.404_613_5, 1.384_590_1],
        [-0.330_861_84, 0.214_847_56, 0.095_095_16],
        [-4.634_230_6, -5.799_101, -19.332_441],
        [6.228_27, 14.179_933, 56.690_55],
        [4.776_385, -13.745_145, -65.353_035],
        [-5.435_456, 4.645_852_6, 26.312_435],
    ];
    let x = share.clamp(0.0, 1.0);
    [0, 1, 2].map(|channel| C.iter().rev().fold(0.0, |sum, c| sum * x + c[channel]).clamp(0.0, 1.0))
}

/// A colour of a number's own, encoded for a display: any hue, never dark or grey.
pub fn own_colour(seed: u32) -> [f32; 3] {
    hue_colour(random(seed, FOR_HUE), 0.55 + 0.35 * random(seed, FOR_SATURATION), 0.7 + 0.3 * random(seed, FOR_VALUE))
}

const FOR_HUE: u32 = 0xC010;
const FOR_SATURATION: u32 = 0xC011;
const FOR_VALUE: u32 = 0xC012;

/// Hue, saturation and value, 0-1, as a colour (A. R. Smith 1978).
pub fn hue_colour(hue: f32, saturation: f32, value: f32) -> [f32; 3] {
    [0.0, 1.0 / 3.0, 2.0 / 3.0].map(|phase| {
        let wave = ((hue + 1.0 - phase).fract() * 6.0 - 3.0).abs() - 1.0;
        // Red is at the hue's two ends, where the wave is 2.
        value * (1.0 - saturation * (1.0 - wave.clamp(0.0, 1.0)))
    })
}

/// The colour of a layer, slice or cluster of a shadow, encoded for a display: from red over green to violet away from the
/// lamp, every second one darker. Twin of `part_colour` in `view_parts.wgsl`.
pub fn part_colour(part: u32, n: u32) -> [f32; 3] {
    hue_colour(0.8 * (part as f32 + 0.5) / n.max(1) as f32, 0.85, if part % 2 == 1 { 0.75 } else { 1.0 })
}

/// The colour of a layer, encoded for a display: eight that are told apart, then again.
pub fn layer_colour(layer_idx: usize) -> [f32; 3] {
    // Okabe and Ito 2008, told apart by everybody; black is replaced by a light grey.
    const COLOURS: [[u8; 3]; 8] = [
        [230, 159, 0],
        [86, 180, 233],
        [0, 158, 115],
        [204, 121, 167],
        [240, 228, 66],
        [0, 114, 178],
        [213, 94, 0],
        [200, 200, 200],
    ];
    COLOURS[layer_idx % COLOURS.len()].map(|channel| f32::from(channel) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_grows_brighter_all_the_way_and_ends_as_viridis_does() {
        let luminance = |[r, g, b]: [f32; 3]| 0.2126 * r.powf(2.2) + 0.7152 * g.powf(2.2) + 0.0722 * b.powf(2.2);
        let mut before = -1.0;
        for step in 0..=100 {
            let now = luminance(ramp(step as f32 / 100.0));
            assert!(now > before - 1e-4, "{step}: {now} after {before}");
            before = now;
        }
        // matplotlib's viridis at 0, 0.5 and 1.
        for (share, expected) in
            [(0.0, [0.267, 0.005, 0.329]), (0.5, [0.128, 0.567, 0.551]), (1.0, [0.993, 0.906, 0.144])]
        {
            for (a, b) in ramp(share).iter().zip(expected) {
                assert!((a - b).abs() < 0.03, "{share}: {:?}", ramp(share));
            }
        }
    }

    #[test]
    fn hues_are_where_they_belong_and_own_colours_differ() {
        for (hue, expected) in [(0.0, [1.0, 0.0, 0.0]), (1.0 / 3.0, [0.0, 1.0, 0.0]), (2.0 / 3.0, [0.0, 0.0, 1.0])] {
            let colour = hue_colour(hue, 1.0, 1.0);
            assert!(colour.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5), "{hue}: {colour:?}");
        }
        let colours: Vec<[f32; 3]> = (0..40).map(own_colour).collect();
        let apart = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>();
        let n_alike = (1..40).filter(|&i| apart(&colours[i - 1], &colours[i]) < 0.1).count();
        assert!(n_alike < 4, "{n_alike} of 39 neighbours look alike");
        assert!(colours.iter().all(|c| c.iter().copied().fold(0.0, f32::max) >= 0.69));
    }
}
