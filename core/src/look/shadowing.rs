//! How hair and head stand in the way of light.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, choices, integer, number};

choices! {
    /// How hair shadows hair and head.
    Shadowing {
        DeepOpacity = "deep-opacity", "Deep opacity maps", "Opacity layers that follow the hair's front as the light sees it (Yuksel and Keyser 2008)";
        Off = "off", "Off", "No light is lost in the hair";
    }
}

/// Yuksel and Keyser 2008.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DeepOpacityParams {
    /// Layers behind the hair's front, as seen from the light.
    pub n_layers: u32,
    /// Thickness of the first layer in centimetres; each next one is thicker by the same amount.
    pub layer_size: f32,
    /// Side of the square map in texels.
    pub resolution: u32,
    /// Radius in texels of the filter over the map.
    pub filter_radius: f32,
    /// Multiplies the extinction: 1 is the strands' own area.
    pub density: f32,
    /// Strands that cast, wider by as much as they are fewer. They are spread over the scalp evenly.
    pub n_strands: u32,
}

impl Default for DeepOpacityParams {
    fn default() -> Self {
        Self { n_layers: 6, layer_size: 0.15, resolution: 1024, filter_radius: 1.5, density: 1.0, n_strands: 25_000 }
    }
}

pub(super) fn shadowing<'a>(choice: &'a mut Shadowing, deep_opacity: &'a mut DeepOpacityParams) -> Slot<'a> {
    Slot {
        key: "shadowing",
        label: "Shadowing",
        help: "How hair shadows hair and head",
        choice,
        params: vec![
            integer(
                "shadowing.layers",
                "Layers",
                "",
                (1, 7),
                &mut deep_opacity.n_layers,
                &["deep-opacity"],
                "Opacity layers behind the hair's front",
            ),
            number(
                "shadowing.layer_size",
                "Layer size",
                "cm",
                (0.02, 4.0),
                &mut deep_opacity.layer_size,
                &["deep-opacity"],
                "Thickness of the first layer; each next one grows by as much",
            ),
            integer(
                "shadowing.resolution",
                "Resolution",
                "texels",
                (128, 4096),
                &mut deep_opacity.resolution,
                &["deep-opacity"],
                "Side of the map",
            ),
            number(
                "shadowing.filter",
                "Filter radius",
                "texels",
                (0.0, 4.0),
                &mut deep_opacity.filter_radius,
                &["deep-opacity"],
                "Softens the map's grain",
            ),
            integer(
                "shadowing.strands",
                "Casting strands",
                "",
                (1_000, 4_000_000),
                &mut deep_opacity.n_strands,
                &["deep-opacity"],
                "Strands that cast, wider by as much as they are fewer: fewer are faster and grainier",
            ),
            number(
                "shadowing.density",
                "Density",
                "",
                (0.0, 4.0),
                &mut deep_opacity.density,
                &["deep-opacity"],
                "1 is the strands' own area",
            ),
        ],
    }
}
