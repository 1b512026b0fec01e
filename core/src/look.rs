//! Every rendering question as one enum, its parameters beside it, and one list of all of them.
//!
//! [`Look::slots`] is the only place that names keys, ranges and units: the look panel, `lorelei looks`,
//! `--set` and the change marks are all made from it. A derive macro was rejected: one readable table is
//! shorter than the macro would be. Adding a technique: a variant here, an arm in `render/src/slot/`, a
//! WGSL module, a golden image.

use serde::{Deserialize, Serialize};

/// The name, label and help of one choice of a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChoiceInfo {
    /// What `--set` takes: lower case with hyphens.
    pub name: &'static str,
    pub label: &'static str,
    pub help: &'static str,
}

/// An enum of alternatives for one question.
pub trait Choice: Copy + PartialEq + 'static {
    const ALL: &'static [Self];
    fn info(self) -> ChoiceInfo;
}

/// A choice seen without its type, for panels and the command line.
pub trait AnyChoice {
    fn index(&self) -> usize;
    fn set_index(&mut self, index: usize);
    fn infos(&self) -> Vec<ChoiceInfo>;
}

impl<C: Choice> AnyChoice for C {
    fn index(&self) -> usize {
        C::ALL.iter().position(|choice| choice == self).unwrap_or(0)
    }
    fn set_index(&mut self, index: usize) {
        *self = C::ALL[index];
    }
    fn infos(&self) -> Vec<ChoiceInfo> {
        C::ALL.iter().map(|choice| choice.info()).collect()
    }
}

macro_rules! choices {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $key:literal, $label:literal, $help:literal;)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
        pub enum $name { $($(#[$variant_meta])* $variant),+ }
        impl Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$variant),+];
            fn info(self) -> ChoiceInfo {
                match self { $(Self::$variant => ChoiceInfo { name: $key, label: $label, help: $help }),+ }
            }
        }
    };
}

pub(crate) use choices;

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
choices! {
    /// How a single fibre scatters light.
    Scattering {
        KajiyaKay = "kajiya-kay", "Kajiya-Kay", "Diffuse and Phong-like specular from the tangent (Kajiya and Kay 1989)";
        Marschner = "marschner", "Marschner", "R, TT and TRT lobes in the real-time form of Karis and Tafuri";
    }
}
choices! {
    /// A switch with a shader of its own for each state.
    Switch {
        On = "on", "On", "Computed";
        Off = "off", "Off", "Left out";
    }
}
choices! {
    /// Light that has met several fibres.
    MultipleScattering {
        FakeNormal = "fake-normal", "Fake normal", "A wrapped diffuse term from a fake normal, tinted by shadow depth (Karis 2016)";
        Off = "off", "Off", "Single scattering only: blond hair looks dark";
    }
}
choices! {
    /// Light from all around.
    Environment {
        Constant = "constant", "Constant colour", "The same radiance from every direction, dimmed inside the hair";
        Off = "off", "Off", "Lamps only";
    }
}
choices! {
    /// How hair shadows hair and head.
    Shadowing {
        DeepOpacity = "deep-opacity", "Deep opacity maps", "Opacity layers that follow the hair's front as the light sees it (Yuksel and Keyser 2008)";
        Off = "off", "Off", "No light is lost in the hair";
    }
}
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
        Plain = "plain", "Plain", "One flat grey";
        Transparent = "transparent", "Transparent", "No background: alpha in the picture";
    }
}

/// Every slot's choice, with the parameters of all its choices, so that switching back loses nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Look {
    pub primitive: Primitive,
    pub transparency: Transparency,
    pub scattering: Scattering,
    /// Weights of the lobes where they are on.
    pub lobe_r: Switch,
    pub lobe_tt: Switch,
    pub lobe_trt: Switch,
    pub weight_r: f32,
    pub weight_tt: f32,
    pub weight_trt: f32,
    pub kajiya_kay: KajiyaKayParams,
    pub multiple_scattering: MultipleScattering,
    /// Scale of the multiple-scattering term.
    pub multiple_scattering_weight: f32,
    pub environment: Environment,
    /// Linear RGB radiance from every direction.
    pub environment_colour: [f32; 3],
    pub environment_intensity: f32,
    pub shadowing: Shadowing,
    pub deep_opacity: DeepOpacityParams,
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
    pub background: Background,
    /// Display value 0-1 of the background's middle; not tonemapped.
    pub background_grey: f32,
    /// 0-1: share of the strands drawn, the rest's area given to them as width.
    pub lod: f32,
}

/// Kajiya and Kay 1989, with the second, coloured highlight that artists expect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct KajiyaKayParams {
    pub diffuse: f32,
    pub specular: f32,
    pub exponent: f32,
}

impl Default for KajiyaKayParams {
    fn default() -> Self {
        Self { diffuse: 0.35, specular: 0.25, exponent: 40.0 }
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

impl Default for Look {
    fn default() -> Self {
        Self {
            primitive: Primitive::Compute,
            transparency: Transparency::FrontToBack,
            scattering: Scattering::Marschner,
            lobe_r: Switch::On,
            lobe_tt: Switch::On,
            lobe_trt: Switch::On,
            weight_r: 1.0,
            weight_tt: 1.0,
            weight_trt: 1.0,
            kajiya_kay: KajiyaKayParams::default(),
            multiple_scattering: MultipleScattering::FakeNormal,
            multiple_scattering_weight: 1.0,
            environment: Environment::Constant,
            environment_colour: [0.9, 0.95, 1.0],
            environment_intensity: 0.3,
            shadowing: Shadowing::DeepOpacity,
            deep_opacity: DeepOpacityParams::default(),
            head: HeadShading::Skin,
            skin_colour: [0.40, 0.265, 0.20],
            skin_gloss: 0.5,
            skin_softness: 0.3,
            root_shadow: 0.7,
            tonemapping: Tonemapping::Agx,
            exposure: 0.0,
            background: Background::Gradient,
            background_grey: 0.28,
            lod: 1.0,
        }
    }
}

/// A number or colour of the look, as panels and `--set` reach it.
pub enum ParamValue<'a> {
    F32(&'a mut f32),
    U32(&'a mut u32),
    /// Linear RGB.
    Colour(&'a mut [f32; 3]),
}

impl ParamValue<'_> {
    /// As `--set` takes it and as `--json` prints it.
    pub fn to_text(&self) -> String {
        match self {
            Self::F32(value) => value.to_string(),
            Self::U32(value) => value.to_string(),
            Self::Colour([r, g, b]) => format!("{r},{g},{b}"),
        }
    }
}

/// One parameter of one choice (or of the whole slot).
pub struct Param<'a> {
    /// `slot.name`, what `--set` takes.
    pub key: String,
    pub label: &'static str,
    /// Empty for a bare number.
    pub unit: &'static str,
    pub min: f32,
    pub max: f32,
    pub help: &'static str,
    /// The choices (by name) that the parameter belongs to; empty: all of them.
    pub of: &'static [&'static str],
    pub value: ParamValue<'a>,
}

impl Param<'_> {
    /// Take a value as [`ParamValue::to_text`] writes it; out of range or not a number is refused.
    pub fn set_from_text(&mut self, value: &str) -> Result<(), SetError> {
        let (min, max) = (self.min, self.max);
        let bad = |takes: String| SetError::BadValue { key: self.key.clone(), value: value.to_owned(), takes };
        let in_range = |v: f32| v.is_finite() && v >= min && v <= max;
        match &mut self.value {
            ParamValue::F32(target) => {
                let number = value.parse::<f32>().ok().filter(|&v| in_range(v));
                **target = number.ok_or_else(|| bad(format!("a number from {min} to {max} {}", self.unit)))?;
            }
            ParamValue::U32(target) => {
                let number = value.parse::<u32>().ok().filter(|&v| in_range(v as f32));
                **target = number.ok_or_else(|| bad(format!("a whole number from {min} to {max}")))?;
            }
            ParamValue::Colour(target) => {
                let numbers: Option<Vec<f32>> =
                    value.split(',').map(|part| part.trim().parse().ok().filter(|&v| in_range(v))).collect();
                let rgb = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
                **target = rgb.ok_or_else(|| bad(format!("three numbers from {min} to {max}: R,G,B")))?;
            }
        }
        Ok(())
    }
}

/// One rendering question.
pub struct Slot<'a> {
    pub key: &'static str,
    pub label: &'static str,
    pub help: &'static str,
    pub choice: &'a mut dyn AnyChoice,
    pub params: Vec<Param<'a>>,
}

impl Slot<'_> {
    /// The info of the choice made.
    pub fn chosen(&self) -> ChoiceInfo {
        self.choice.infos()[self.choice.index()]
    }
}

fn number<'a>(
    key: &str,
    label: &'static str,
    unit: &'static str,
    (min, max): (f32, f32),
    value: &'a mut f32,
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    Param { key: key.to_owned(), label, unit, min, max, help, of, value: ParamValue::F32(value) }
}

fn integer<'a>(
    key: &str,
    label: &'static str,
    unit: &'static str,
    (min, max): (u32, u32),
    value: &'a mut u32,
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    Param {
        key: key.to_owned(),
        label,
        unit,
        min: min as f32,
        max: max as f32,
        help,
        of,
        value: ParamValue::U32(value),
    }
}

fn colour<'a>(
    key: &str,
    label: &'static str,
    value: &'a mut [f32; 3],
    of: &'static [&'static str],
    help: &'static str,
) -> Param<'a> {
    Param {
        key: key.to_owned(),
        label,
        unit: "linear RGB",
        min: 0.0,
        max: 1.0,
        help,
        of,
        value: ParamValue::Colour(value),
    }
}

impl Look {
    /// Every slot with its choice and parameters: the table behind panels, `--set` and `lorelei looks`.
    #[rustfmt::skip]
    pub fn slots(&mut self) -> Vec<Slot<'_>> {
        vec![
            Slot { key: "primitive", label: "Drawing", help: "How strands become pixels", choice: &mut self.primitive, params: vec![
                number("primitive.lod", "Level of detail", "share of strands", (0.02, 1.0), &mut self.lod, &[], "Fewer, wider strands of the same total area"),
            ] },
            Slot { key: "transparency", label: "Transparency", help: "How partly covered pixels combine", choice: &mut self.transparency, params: vec![] },
            Slot { key: "scattering", label: "Scattering", help: "How one fibre scatters light", choice: &mut self.scattering, params: vec![
                number("scattering.kk_diffuse", "Diffuse", "", (0.0, 2.0), &mut self.kajiya_kay.diffuse, &["kajiya-kay"], "Weight of the diffuse term"),
                number("scattering.kk_specular", "Specular", "", (0.0, 2.0), &mut self.kajiya_kay.specular, &["kajiya-kay"], "Weight of the highlights"),
                number("scattering.kk_exponent", "Exponent", "", (1.0, 400.0), &mut self.kajiya_kay.exponent, &["kajiya-kay"], "Sharpness of the highlights"),
            ] },
            Slot { key: "r", label: "R lobe", help: "Light reflected off the cuticle: the white highlight", choice: &mut self.lobe_r, params: vec![
                number("r.weight", "Weight", "", (0.0, 4.0), &mut self.weight_r, &["on"], "1 is physical"),
            ] },
            Slot { key: "tt", label: "TT lobe", help: "Light through the fibre: the bright rim from behind", choice: &mut self.lobe_tt, params: vec![
                number("tt.weight", "Weight", "", (0.0, 4.0), &mut self.weight_tt, &["on"], "1 is physical"),
            ] },
            Slot { key: "trt", label: "TRT lobe", help: "Light reflected inside the fibre: the coloured highlight", choice: &mut self.lobe_trt, params: vec![
                number("trt.weight", "Weight", "", (0.0, 4.0), &mut self.weight_trt, &["on"], "1 is physical"),
            ] },
            Slot { key: "multiple", label: "Multiple scattering", help: "Light that has met several fibres", choice: &mut self.multiple_scattering, params: vec![
                number("multiple.weight", "Weight", "", (0.0, 4.0), &mut self.multiple_scattering_weight, &["fake-normal"], "Scale of the term"),
            ] },
            Slot { key: "environment", label: "Environment", help: "Light from all around", choice: &mut self.environment, params: vec![
                colour("environment.colour", "Colour", &mut self.environment_colour, &["constant"], "Radiance from every direction"),
                number("environment.intensity", "Intensity", "", (0.0, 4.0), &mut self.environment_intensity, &["constant"], "Scale of the colour"),
            ] },
            Slot { key: "shadowing", label: "Shadowing", help: "How hair shadows hair and head", choice: &mut self.shadowing, params: vec![
                integer("shadowing.layers", "Layers", "", (1, 7), &mut self.deep_opacity.n_layers, &["deep-opacity"], "Opacity layers behind the hair's front"),
                number("shadowing.layer_size", "Layer size", "cm", (0.02, 4.0), &mut self.deep_opacity.layer_size, &["deep-opacity"], "Thickness of the first layer; each next one grows by as much"),
                integer("shadowing.resolution", "Resolution", "texels", (128, 4096), &mut self.deep_opacity.resolution, &["deep-opacity"], "Side of the map"),
                number("shadowing.filter", "Filter radius", "texels", (0.0, 4.0), &mut self.deep_opacity.filter_radius, &["deep-opacity"], "Softens the map's grain"),
                integer("shadowing.strands", "Casting strands", "", (1_000, 4_000_000), &mut self.deep_opacity.n_strands, &["deep-opacity"], "Strands that cast, wider by as much as they are fewer: fewer are faster and grainier"),
                number("shadowing.density", "Density", "", (0.0, 4.0), &mut self.deep_opacity.density, &["deep-opacity"], "1 is the strands' own area"),
            ] },
            Slot { key: "head", label: "Head", help: "The head under the hair", choice: &mut self.head, params: vec![
                colour("head.colour", "Skin colour", &mut self.skin_colour, &["skin"], "Diffuse albedo"),
                number("head.gloss", "Gloss", "", (0.0, 4.0), &mut self.skin_gloss, &["skin"], "Reflection off the surface: 0 is matte, 1 is skin"),
                number("head.softness", "Softness", "cosine", (0.0, 1.0), &mut self.skin_softness, &["skin"], "How far red light creeps around the border of a light"),
                number("head.root_shadow", "Root shadow", "share", (0.0, 1.0), &mut self.root_shadow, &["skin"], "Darkens the scalp between the roots of hair"),
            ] },
            Slot { key: "tonemapping", label: "Tonemapping", help: "From scene light to display", choice: &mut self.tonemapping, params: vec![
                number("tonemapping.exposure", "Exposure", "stops", (-8.0, 8.0), &mut self.exposure, &[], "Doubles the light with every stop"),
            ] },
            Slot { key: "background", label: "Background", help: "What is behind head and hair", choice: &mut self.background, params: vec![
                number("background.grey", "Grey", "display value", (0.0, 1.0), &mut self.background_grey, &["gradient", "plain"], "Brightness of its middle"),
            ] },
        ]
    }
}

/// Why `KEY=VALUE` was not taken.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SetError {
    #[error("there is no setting `{key}`; `lorelei looks --json` lists them all (close: {close})")]
    UnknownKey { key: String, close: String },
    #[error("`{key}` cannot be `{value}`; it takes {takes}")]
    BadValue { key: String, value: String, takes: String },
}

/// Set a slot's choice (`shadowing=off`) or a parameter (`shadowing.layers=5`) from text.
pub fn set(slots: &mut [Slot<'_>], key: &str, value: &str) -> Result<(), SetError> {
    for slot in slots.iter_mut() {
        if slot.key == key {
            let infos = slot.choice.infos();
            let index = infos.iter().position(|info| info.name == value);
            let index = index.ok_or_else(|| SetError::BadValue {
                key: key.to_owned(),
                value: value.to_owned(),
                takes: infos.iter().map(|info| info.name).collect::<Vec<_>>().join(", "),
            })?;
            slot.choice.set_index(index);
            return Ok(());
        }
        let Some(param) = slot.params.iter_mut().find(|param| param.key == key) else { continue };
        param.set_from_text(value)?;
        return Ok(());
    }
    let mut keys: Vec<String> = Vec::new();
    for slot in slots.iter() {
        keys.push(slot.key.to_owned());
        keys.extend(slot.params.iter().map(|param| param.key.clone()));
    }
    let head = key.split('.').next().unwrap_or_default();
    let close = keys.iter().filter(|k| k.starts_with(head) || k.contains(key)).cloned().collect::<Vec<_>>();
    let close = if close.is_empty() { "none".to_owned() } else { close.join(", ") };
    Err(SetError::UnknownKey { key: key.to_owned(), close })
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
        assert_eq!(
            (look.shadowing, look.deep_opacity.n_layers, look.skin_colour),
            (Shadowing::Off, 5, [0.1, 0.2, 0.3])
        );
        let before = look.clone();
        for (key, value) in [
            ("shadowing", "magic"),
            ("shadowing.layers", "99"),
            ("head.colour", "1,2"),
            ("nothing", "1"),
            ("r.weight", "NaN"),
        ] {
            set(&mut look.slots(), key, value).unwrap_err();
        }
        assert_eq!(look, before);
    }
}
