//! Every rendering question as one enum, its parameters beside it, and one list of all of them.
//!
//! [`Look::slots`] is the only list of keys, ranges and units: the look panel, `lorelei looks`, `--set` and the change
//! marks are all made from it. A derive macro was rejected: a readable function for each question is shorter than the macro
//! would be. Adding a technique: a variant in its room here, an arm in `render/src/slot/`, a WGSL module, a golden image.

mod drawing;
mod picture;
pub mod presets;
mod scattering;
mod shadowing;
mod slot;
pub mod view;

use serde::{Deserialize, Serialize};

pub use drawing::{Antialiasing, DrawingParams, Primitive, ShadingRate, Transparency};
pub use picture::{Background, HeadShading, Tonemapping, WhiteBalance};
pub use scattering::{
    Environment, EnvironmentParams, Fresnel, KajiyaKayParams, Marschner2003Params, MultipleScattering, Offsets,
    Scattering, Surroundings,
};
pub use shadowing::{BeyondLast, LayerSpacing, ShadowParams, Shadowing};
pub use slot::{AnyChoice, Choice, ChoiceInfo, Param, ParamValue, SetError, Slot, Switch, set};
pub(crate) use slot::{choices, integer, number};
pub use view::{FalseColour, ViewParams};

/// Every slot's choice, with the parameters of all its choices, so that switching back loses nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Look {
    pub primitive: Primitive,
    pub antialiasing: Antialiasing,
    pub transparency: Transparency,
    pub drawing: DrawingParams,
    pub shading_rate: ShadingRate,
    pub scattering: Scattering,
    /// Weights of the lobes where they are on.
    pub lobe_r: Switch,
    pub lobe_tt: Switch,
    pub lobe_trt: Switch,
    pub weight_r: f32,
    pub weight_tt: f32,
    pub weight_trt: f32,
    pub kajiya_kay: KajiyaKayParams,
    pub marschner_2003: Marschner2003Params,
    /// Weight of what crosses the fibre three times or more, where the model has it.
    pub rest_weight: f32,
    pub fresnel: Fresnel,
    pub offsets: Offsets,
    pub multiple_scattering: MultipleScattering,
    /// Scale of the multiple-scattering term.
    pub multiple_scattering_weight: f32,
    pub environment: Environment,
    /// Linear RGB radiance from every direction.
    pub environment_colour: [f32; 3],
    pub environment_intensity: f32,
    /// Of the choices that take their light from a picture.
    pub environment_picture: EnvironmentParams,
    pub shadowing: Shadowing,
    /// Older files call it by the one technique that there was then.
    #[serde(alias = "deep_opacity")]
    pub shadows: ShadowParams,
    pub head: HeadShading,
    /// Linear RGB diffuse albedo.
    pub skin_colour: [f32; 3],
    /// Weight of the skin's own reflection; 1 is skin's.
    pub skin_gloss: f32,
    /// Cosine by which red light creeps around the border of a light.
    pub skin_softness: f32,
    /// 0-1: share of the scalp's light that hair roots keep.
    pub root_shadow: f32,
    pub tonemapping: Tonemapping,
    /// Stops.
    pub exposure: f32,
    pub white_balance: WhiteBalance,
    pub background: Background,
    /// Display value 0-1 of the background's middle; not tonemapped.
    pub background_grey: f32,
    /// 0-1: share of the strands drawn, the rest's area given to them as width.
    pub lod: f32,
    pub view: FalseColour,
    pub view_params: ViewParams,
}

impl Default for Look {
    fn default() -> Self {
        Self {
            primitive: Primitive::Compute,
            antialiasing: Antialiasing::Analytic,
            transparency: Transparency::FrontToBack,
            drawing: DrawingParams::default(),
            shading_rate: ShadingRate::PerVertex,
            scattering: Scattering::Marschner,
            lobe_r: Switch::On,
            lobe_tt: Switch::On,
            lobe_trt: Switch::On,
            weight_r: 1.0,
            weight_tt: 1.0,
            weight_trt: 1.0,
            kajiya_kay: KajiyaKayParams::default(),
            marschner_2003: Marschner2003Params::default(),
            rest_weight: 1.0,
            fresnel: Fresnel::Exact,
            offsets: Offsets::Fitted,
            multiple_scattering: MultipleScattering::FakeNormal,
            multiple_scattering_weight: 1.0,
            environment: Environment::Constant,
            environment_colour: [0.9, 0.95, 1.0],
            environment_intensity: 0.3,
            environment_picture: EnvironmentParams::default(),
            shadowing: Shadowing::DeepOpacity,
            shadows: ShadowParams::default(),
            head: HeadShading::Skin,
            skin_colour: [0.40, 0.265, 0.20],
            skin_gloss: 0.5,
            skin_softness: 0.3,
            root_shadow: 0.7,
            tonemapping: Tonemapping::Agx,
            exposure: 0.0,
            white_balance: WhiteBalance::NEUTRAL,
            background: Background::Gradient,
            background_grey: 0.28,
            lod: 1.0,
            view: FalseColour::Final,
            view_params: ViewParams::default(),
        }
    }
}

impl Look {
    /// Every slot with its choice and parameters: the table behind panels, `--set` and `lorelei looks`.
    pub fn slots(&mut self) -> Vec<Slot<'_>> {
        vec![
            drawing::primitive(&mut self.primitive, &mut self.lod),
            drawing::antialiasing(&mut self.antialiasing),
            drawing::transparency(&mut self.transparency, &mut self.drawing),
            drawing::shading_rate(&mut self.shading_rate),
            scattering::scattering(
                &mut self.scattering,
                &mut self.kajiya_kay,
                &mut self.marschner_2003,
                &mut self.rest_weight,
            ),
            scattering::fresnel(&mut self.fresnel),
            scattering::offsets(&mut self.offsets),
            scattering::lobe_r(&mut self.lobe_r, &mut self.weight_r),
            scattering::lobe_tt(&mut self.lobe_tt, &mut self.weight_tt),
            scattering::lobe_trt(&mut self.lobe_trt, &mut self.weight_trt),
            scattering::multiple(&mut self.multiple_scattering, &mut self.multiple_scattering_weight),
            scattering::environment(
                &mut self.environment,
                &mut self.environment_colour,
                &mut self.environment_intensity,
                &mut self.environment_picture,
            ),
            shadowing::shadowing(&mut self.shadowing, &mut self.shadows),
            picture::head(
                &mut self.head,
                &mut self.skin_colour,
                &mut self.skin_gloss,
                &mut self.skin_softness,
                &mut self.root_shadow,
            ),
            picture::tonemapping(&mut self.tonemapping, &mut self.exposure, &mut self.white_balance),
            picture::background(&mut self.background, &mut self.background_grey),
            view::view(&mut self.view, &mut self.view_params),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_is_unique_and_every_default_is_in_range() {
        let mut look = Look::default();
        let mut keys = std::collections::HashSet::new();
        for slot in look.slots() {
            assert!(keys.insert(slot.key.to_owned()));
            for param in slot.params {
                assert!(param.key.starts_with(&format!("{}.", slot.key)), "{}", param.key);
                assert!(keys.insert(param.key.clone()), "{}", param.key);
                if let ParamValue::Choice(choice) = &param.value {
                    assert!(choice.infos().iter().any(|info| info.name == param.value.to_text()), "{}", param.key);
                    continue;
                }
                let values: Vec<f32> = param.value.to_text().split(',').map(|v| v.parse().unwrap()).collect();
                assert!(values.iter().all(|v| (param.min..=param.max).contains(v)), "{}", param.key);
            }
        }
    }

    #[test]
    fn set_takes_choices_numbers_and_colours_and_refuses_the_rest() {
        let mut look = Look::default();
        set(&mut look.slots(), "shadowing", "off").unwrap();
        set(&mut look.slots(), "shadowing.layers", "5").unwrap();
        set(&mut look.slots(), "head.colour", "0.1, 0.2,0.3").unwrap();
        set(&mut look.slots(), "shadowing.spacing", "fibonacci").unwrap();
        assert_eq!(
            (look.shadowing, look.shadows.n_layers, look.skin_colour, look.shadows.layer_spacing),
            (Shadowing::Off, 5, [0.1, 0.2, 0.3], LayerSpacing::Fibonacci)
        );
        let before = look.clone();
        for (key, value) in [
            ("shadowing", "magic"),
            ("shadowing.layers", "99"),
            ("shadowing.spacing", "wide"),
            ("head.colour", "1,2"),
            ("nothing", "1"),
            ("r.weight", "NaN"),
        ] {
            set(&mut look.slots(), key, value).unwrap_err();
        }
        assert_eq!(look, before);
    }
}
