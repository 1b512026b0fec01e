//! How hair and head stand in the way of light.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Param, Slot, alternatives, choices, integer, number};

choices! {
    /// How hair shadows hair and head.
    Shadowing {
        DeepOpacity = "deep-opacity", "Deep opacity maps", "Opacity layers that follow the hair's front as the light sees it (Yuksel and Keyser 2008)";
        Off = "off", "Off", "No light is lost in the hair";
        ShadowMap = "shadow-map", "Shadow map", "Hair behind the nearest strand is dark (Williams 1978), edges averaged (Reeves et al. 1987)";
        Exponential = "exponential", "Exponential falloff", "Light dies by the distance behind the nearest strand (Karis 2016)";
        OpacityMaps = "opacity-maps", "Opacity shadow maps", "Opacity in slices across the light's way (Kim and Neumann 2001)";
        Clusters = "clusters", "Density clustering", "Four clusters of hair a texel, found by k-means (Mertens et al. 2004)";
        Occupancy = "occupancy", "Occupancy maps", "128 slices of one bit and four sums over a texel's own depths (Sintorn and Assarsson 2009)";
        DeepShadow = "deep-shadow", "Deep shadow maps", "Every fragment, sorted, as a polyline within a stated error (Lokovic and Veach 2000)";
        Voxels = "voxels", "Voxel transmittance", "One grid of density that every light's way is marched through";
    }
}
choices! {
    /// How thick the layers of a deep opacity map are; s is the first one's thickness.
    LayerSpacing {
        Linear = "linear", "Linear", "s, 2s, 3s, 4s, ..";
        Constant = "constant", "Constant", "s, s, s, s, ..";
        Fibonacci = "fibonacci", "Fibonacci", "s, s, 2s, 3s, 5s, ..";
        PowerOfTwo = "power-of-two", "Power of two", "s, 2s, 4s, 8s, ..";
    }
}
choices! {
    /// What becomes of hair behind the last layer of a deep opacity map.
    BeyondLast {
        LastLayer = "last-layer", "Last layer", "It is added to the last layer, and shadows itself";
        Ignore = "ignore", "Ignore", "It casts no shadow";
        Grow = "grow", "Grow", "The last layer ends behind the last strand, and is coarser";
    }
}

impl LayerSpacing {
    /// Thickness of each layer in units of the first one's.
    pub fn thicknesses(self) -> impl Iterator<Item = f32> {
        let (mut k, mut before, mut last) = (0, 0.0, 1.0);
        std::iter::from_fn(move || {
            k += 1;
            Some(match self {
                Self::Linear => k as f32,
                Self::Constant => 1.0,
                Self::PowerOfTwo => 2.0_f32.powi(k - 1),
                Self::Fibonacci => {
                    let now = last;
                    (before, last) = (now, before + now);
                    now
                }
            })
        })
    }
}

/// What the choices take. Several of them share a map's side, who casts, and the look-up's taps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct ShadowParams {
    /// Side of the square map in texels.
    pub resolution: u32,
    /// Strands that cast, wider by as much as they are fewer. They are spread over the scalp evenly.
    pub n_strands: u32,
    /// Multiplies the extinction: 1 is the strands' own area.
    pub density: f32,
    /// Taps on a side of the window that a look-up averages; each is between four texels.
    pub n_taps: u32,
    /// Texels between two taps.
    pub tap_spacing: f32,
    /// Deep opacity maps: layers behind the hair's front, as seen from the light.
    pub n_layers: u32,
    /// Deep opacity maps: thickness of the first layer in centimetres.
    pub layer_size: f32,
    pub layer_spacing: LayerSpacing,
    pub beyond_last: BeyondLast,
    /// Deep opacity maps: radius in texels of the filter over the map.
    pub filter_radius: f32,
    /// Shadow map: taps on a side of the window that is compared with.
    pub n_pcf_taps: u32,
    /// Shadow map and falloff: centimetres behind the front that are still lit.
    pub bias: f32,
    /// Exponential falloff: optical depth of a centimetre of hair.
    pub falloff: f32,
    /// Opacity shadow maps: slices across the light's way.
    pub n_slices: u32,
    /// Density clustering: rounds of k-means.
    pub n_rounds: u32,
    /// Occupancy maps: texels by which a look-up is thrown aside at most.
    pub jitter: f32,
    /// Deep shadow maps: by how much of the light the polyline may be off.
    pub tolerance: f32,
    /// Voxels along each side of the grid.
    pub n_voxels: u32,
    /// Voxels: steps from a strand out of the grid.
    pub n_steps: u32,
    /// Voxels: share of a step by which each one is thrown aside at most.
    pub step_jitter: f32,
}

impl Default for ShadowParams {
    fn default() -> Self {
        Self {
            resolution: 1024,
            n_strands: 25_000,
            density: 1.0,
            n_taps: 1,
            tap_spacing: 1.0,
            n_layers: 6,
            layer_size: 0.15,
            layer_spacing: LayerSpacing::Linear,
            beyond_last: BeyondLast::LastLayer,
            filter_radius: 1.5,
            n_pcf_taps: 3,
            bias: 0.1,
            falloff: 1.0,
            n_slices: 16,
            n_rounds: 1,
            jitter: 0.5,
            tolerance: 0.02,
            n_voxels: 96,
            n_steps: 32,
            step_jitter: 1.0,
        }
    }
}

const ALL: &[&str] =
    &["deep-opacity", "shadow-map", "exponential", "opacity-maps", "clusters", "occupancy", "deep-shadow", "voxels"];
const MAPS: &[&str] =
    &["deep-opacity", "shadow-map", "exponential", "opacity-maps", "clusters", "occupancy", "deep-shadow"];
const TAPPED: &[&str] = &["deep-opacity", "opacity-maps", "clusters", "occupancy", "deep-shadow"];
const DEEP_OPACITY: &[&str] = &["deep-opacity"];
const FRONT: &[&str] = &["shadow-map", "exponential"];

pub(super) fn shadowing<'a>(choice: &'a mut Shadowing, params: &'a mut ShadowParams) -> Slot<'a> {
    let ShadowParams {
        resolution,
        n_strands,
        density,
        n_taps,
        tap_spacing,
        n_layers,
        layer_size,
        layer_spacing,
        beyond_last,
        filter_radius,
        n_pcf_taps,
        bias,
        falloff,
        n_slices,
        n_rounds,
        jitter,
        tolerance,
        n_voxels,
        n_steps,
        step_jitter,
    } = params;
    let strands = "Strands that cast, wider by as much as they are fewer: fewer are faster and grainier";
    let of_choices: Vec<Param<'a>> = vec![
        integer(
            "shadowing.layers",
            "Layers",
            "",
            (1, 15),
            n_layers,
            DEEP_OPACITY,
            "Opacity layers behind the hair's front",
        ),
        number(
            "shadowing.layer_size",
            "Layer size",
            "cm",
            (0.02, 4.0),
            layer_size,
            DEEP_OPACITY,
            "Thickness of the first layer",
        ),
        alternatives(
            "shadowing.spacing",
            "Layer spacing",
            layer_spacing,
            DEEP_OPACITY,
            "Thickness of the layers behind the first one",
        ),
        alternatives(
            "shadowing.beyond",
            "Behind the last",
            beyond_last,
            DEEP_OPACITY,
            "What becomes of hair behind the last layer",
        ),
        number(
            "shadowing.filter",
            "Filter radius",
            "texels",
            (0.0, 4.0),
            filter_radius,
            DEEP_OPACITY,
            "Softens the map's grain",
        ),
        integer(
            "shadowing.pcf",
            "Window",
            "taps",
            (1, 9),
            n_pcf_taps,
            FRONT,
            "Taps on a side of the window that each look-up averages",
        ),
        number(
            "shadowing.bias",
            "Bias",
            "cm",
            (0.0, 2.0),
            bias,
            FRONT,
            "Hair this little behind the nearest strand is lit in full",
        ),
        number(
            "shadowing.falloff",
            "Falloff",
            "per cm",
            (0.05, 20.0),
            falloff,
            &["exponential"],
            "How fast light dies behind the nearest strand: by e in 1 / falloff centimetres",
        ),
        integer(
            "shadowing.slices",
            "Slices",
            "",
            (4, 256),
            n_slices,
            &["opacity-maps"],
            "Slices across the light's way: few of them show as bands",
        ),
        integer(
            "shadowing.rounds",
            "Rounds",
            "",
            (1, 8),
            n_rounds,
            &["clusters"],
            "Rounds of k-means: each draws all strands once",
        ),
        number(
            "shadowing.jitter",
            "Jitter",
            "texels",
            (0.0, 2.0),
            jitter,
            &["occupancy"],
            "Throws each look-up aside: grain instead of edges",
        ),
        number(
            "shadowing.tolerance",
            "Tolerance",
            "of the light",
            (0.001, 0.2),
            tolerance,
            &["deep-shadow"],
            "By how much of the light the stored polyline may be off",
        ),
        integer(
            "shadowing.voxels",
            "Voxels a side",
            "",
            (16, 192),
            n_voxels,
            &["voxels"],
            "Cells of the grid along each of its sides",
        ),
        integer("shadowing.steps", "Steps", "", (4, 256), n_steps, &["voxels"], "Steps from a strand out of the grid"),
        number(
            "shadowing.step_jitter",
            "Step jitter",
            "of a step",
            (0.0, 1.0),
            step_jitter,
            &["voxels"],
            "Throws each step aside: grain instead of bands",
        ),
    ];
    let of_maps: Vec<Param<'a>> = vec![
        integer(
            "shadowing.taps",
            "Taps",
            "a side",
            (1, 7),
            n_taps,
            TAPPED,
            "Taps on a side of the window that a look-up averages: more are softer and slower",
        ),
        number("shadowing.tap_spacing", "Tap spacing", "texels", (0.25, 4.0), tap_spacing, MAPS, "Between two taps"),
        integer("shadowing.resolution", "Resolution", "texels", (128, 4096), resolution, MAPS, "Side of the map"),
        integer("shadowing.strands", "Casting strands", "", (1_000, 4_000_000), n_strands, ALL, strands),
        number("shadowing.density", "Density", "", (0.0, 4.0), density, ALL, "1 is the strands' own area"),
    ];
    Slot {
        key: "shadowing",
        label: "Shadowing",
        help: "How hair shadows hair and head",
        choice,
        params: of_choices.into_iter().chain(of_maps).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::Look;

    #[test]
    fn layers_grow_as_the_paper_has_it() {
        let first = |spacing: LayerSpacing| spacing.thicknesses().take(6).collect::<Vec<_>>();
        assert_eq!(first(LayerSpacing::Linear), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(first(LayerSpacing::Constant), [1.0; 6]);
        assert_eq!(first(LayerSpacing::PowerOfTwo), [1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
        assert_eq!(first(LayerSpacing::Fibonacci), [1.0, 1.0, 2.0, 3.0, 5.0, 8.0]);
    }

    #[test]
    fn every_parameter_belongs_to_choices_that_there_are() {
        let mut look = Look::default();
        let names: Vec<&str> = Shadowing::ALL.iter().map(|choice| choice.info().name).collect();
        for param in shadowing(&mut look.shadowing, &mut look.shadows).params {
            assert!(!param.of.is_empty() && param.of.iter().all(|name| names.contains(name)), "{}", param.key);
        }
    }

    #[test]
    fn a_look_saved_before_there_were_other_techniques_keeps_its_numbers() {
        let text = "(shadowing: Off, deep_opacity: (n_layers: 3, layer_size: 0.4, resolution: 512, filter_radius: 0.5, density: 0.7, n_strands: 9000))";
        let look: Look = ron::from_str(text).unwrap();
        let expected = ShadowParams {
            n_layers: 3,
            layer_size: 0.4,
            resolution: 512,
            filter_radius: 0.5,
            density: 0.7,
            n_strands: 9000,
            ..ShadowParams::default()
        };
        assert_eq!((look.shadowing, look.shadows), (Shadowing::Off, expected));
    }
}
