//! The head under the hair, what is behind both, and how light becomes a picture.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, choices, colour, number};

choices! {
    /// The head under the hair.
    HeadShading {
        Skin = "skin", "Skin", "Lit by the same lights, casting on and receiving from hair";
        Hidden = "hidden", "Hidden", "Hair alone; the head neither covers nor shadows it";
    }
}
choices! {
    /// From scene light to display.
    Tonemapping {
        Agx = "agx", "AgX", "Filmic curve that keeps highlights from skewing in hue (Sobotka's AgX, polynomial fit)";
        Linear = "linear", "None", "Exposure and clipping only";
    }
}
choices! {
    /// What is behind head and hair.
    Background {
        Gradient = "gradient", "Gradient", "Neutral grey, lighter in the middle";
        Environment = "environment", "Environment", "The picture that the environment light is taken from, exposed as the hair is";
        Plain = "plain", "Plain", "One flat grey";
        Transparent = "transparent", "Transparent", "No background: alpha in the picture";
    }
}

/// Which light is to look white.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct WhiteBalance {
    /// Of a black body, kelvin; 6500 is what scene colours are white in.
    pub temperature_k: f32,
    /// Off the black bodies, -1 to 1: light that is greener above 0, and that makes the picture more magenta.
    pub tint: f32,
}

impl WhiteBalance {
    /// The picture as it is.
    pub const NEUTRAL: Self = Self { temperature_k: 6500.0, tint: 0.0 };
}

impl Default for WhiteBalance {
    fn default() -> Self {
        Self::NEUTRAL
    }
}

pub(super) fn head<'a>(
    choice: &'a mut HeadShading,
    skin_colour: &'a mut [f32; 3],
    skin_gloss: &'a mut f32,
    skin_softness: &'a mut f32,
    root_shadow: &'a mut f32,
) -> Slot<'a> {
    Slot {
        key: "head",
        label: "Head",
        help: "The head under the hair",
        choice,
        params: vec![
            colour("head.colour", "Skin colour", skin_colour, &["skin"], "Diffuse albedo"),
            number(
                "head.gloss",
                "Gloss",
                "",
                (0.0, 4.0),
                skin_gloss,
                &["skin"],
                "Reflection off the surface: 0 is matte, 1 is skin",
            ),
            number(
                "head.softness",
                "Softness",
                "cosine",
                (0.0, 1.0),
                skin_softness,
                &["skin"],
                "How far red light creeps around the border of a light",
            ),
            number(
                "head.root_shadow",
                "Root shadow",
                "share",
                (0.0, 1.0),
                root_shadow,
                &["skin"],
                "Darkens the scalp between the roots of hair",
            ),
        ],
    }
}

pub(super) fn tonemapping<'a>(
    choice: &'a mut Tonemapping,
    exposure: &'a mut f32,
    white: &'a mut WhiteBalance,
) -> Slot<'a> {
    Slot {
        key: "tonemapping",
        label: "Tonemapping",
        help: "From scene light to display",
        choice,
        params: vec![
            number(
                "tonemapping.exposure",
                "Exposure",
                "stops",
                (-8.0, 8.0),
                exposure,
                &[],
                "Doubles the light with every stop",
            ),
            number(
                "tonemapping.temperature",
                "Temperature",
                "K",
                (2000.0, 15_000.0),
                &mut white.temperature_k,
                &[],
                "Of the light that is to look white: higher makes the picture warmer, 6500 leaves it as it is",
            ),
            number(
                "tonemapping.tint",
                "Tint",
                "",
                (-1.0, 1.0),
                &mut white.tint,
                &[],
                "Takes green out of the picture, or magenta below 0",
            ),
        ],
    }
}

pub(super) fn background<'a>(choice: &'a mut Background, background_grey: &'a mut f32) -> Slot<'a> {
    Slot {
        key: "background",
        label: "Background",
        help: "What is behind head and hair",
        choice,
        params: vec![number(
            "background.grey",
            "Grey",
            "display value",
            (0.0, 1.0),
            background_grey,
            &["gradient", "plain"],
            "Brightness of its middle",
        )],
    }
}
