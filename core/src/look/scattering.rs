//! How fibres scatter light: one of them, several, and what comes from all around.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, Switch, alternatives, choices, colour, number};

choices! {
    /// How a single fibre scatters light. The names in a document are the variants'.
    Scattering {
        KajiyaKay = "kajiya-kay", "Kajiya-Kay", "Diffuse and two highlights along the tangent, their power kept (after Kajiya and Kay 1989)";
        KajiyaKay1989 = "kajiya-kay-1989", "Kajiya-Kay, as in 1989", "Diffuse by the angle to the tangent, one white highlight on the mirror cone";
        KajiyaKayHalf = "kajiya-kay-half", "Kajiya-Kay, half vector", "The same with the highlight from the half vector, as in games";
        Marschner = "marschner", "Marschner, closed form", "R, TT and TRT lobes in the real-time form of Karis and Tafuri";
        Marschner2003 = "marschner-2003", "Marschner 2003", "Smooth cylinder with caustics, from tables that leave the colour out";
        Marschner2003Nalu = "marschner-2003-nalu", "Marschner 2003, Nalu tables", "The same from two lookups with the colour inside, as in the Nalu demo of 2004";
        Deon = "deon", "d'Eon 2011", "Rough cylinder that keeps energy, averaged over its width";
        Chiang = "chiang", "Chiang 2016", "The film renderers' fibre: rough, keeps energy, and shows its width where it is shaded per pixel";
    }
}
choices! {
    /// Reflectance of a fibre's surface in the closed form of Marschner's lobes.
    Fresnel {
        Exact = "exact", "Exact", "Fresnel's equations, unpolarised";
        Schlick = "schlick", "Schlick", "Schlick's approximation: a fifth brighter across a fibre";
    }
}
choices! {
    /// Where across the fibre the closed form of Marschner's lobes takes reflectance and path length.
    Offsets {
        Fitted = "fitted", "Fitted", "Offsets that give the exact averages over the fibre's width";
        Tafuri = "tafuri", "Tafuri", "TT at the middle, TRT at sqrt(3)/2 (Tafuri 2019)";
        Karis = "karis", "Karis", "TT where the light that leaves there came in, approximately; TRT at sqrt(3)/2 (Karis 2016)";
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
        Karis = "karis", "One sample", "What a surface that faces the eye would get of the picture, as if from one light (Karis 2016)";
        Harmonics = "harmonics", "Spherical harmonics", "The picture's broad features from every direction, as the fibre scatters them";
        Off = "off", "Off", "Lamps only";
    }
}

choices! {
    /// The picture of what is all around.
    Surroundings {
        Studio = "studio", "Studio", "A dark room with two soft boxes in front and two strips behind";
        Overcast = "overcast", "Overcast sky", "Even light from above, a dim ground below";
        Sunset = "sunset", "Sunset", "A low sun from behind on one side, blue sky on the other";
        Ring = "ring", "Ring light", "A ring around the camera, a blue strip and a pink one behind";
        File = "file", "From a file", "The picture that was loaded with the groom, .hdr or .exr";
    }
}

/// Which picture lights the scene, and how it stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EnvironmentParams {
    pub picture: Surroundings,
    /// About the vertical axis, towards the model's left as azimuths of lights grow.
    pub rotation_deg: f32,
    /// Stops.
    pub exposure: f32,
}

impl Environment {
    /// Whether light comes from the picture.
    pub fn is_pictured(self) -> bool {
        match self {
            Self::Karis | Self::Harmonics => true,
            Self::Constant | Self::Off => false,
        }
    }
}

impl Default for EnvironmentParams {
    fn default() -> Self {
        Self { picture: Surroundings::Studio, rotation_deg: 0.0, exposure: 0.0 }
    }
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

/// What Marschner et al. 2003 do about the caustics of TRT, where a smooth cylinder would be infinitely bright (their
/// section 5.2.2 and table 1), and the flatness of the fibre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Marschner2003Params {
    /// k_G.
    pub glint: f32,
    /// w_c.
    pub glint_width_deg: f32,
    /// Delta eta'.
    pub glint_fade: f32,
    /// Delta h_M.
    pub glint_limit: f32,
    /// Ratio of the cross-section's axes, a.
    pub eccentricity: f32,
}

impl Default for Marschner2003Params {
    fn default() -> Self {
        Self { glint: 1.0, glint_width_deg: 15.0, glint_fade: 0.3, glint_limit: 0.5, eccentricity: 1.0 }
    }
}

#[rustfmt::skip]
pub(super) fn scattering<'a>(
    choice: &'a mut Scattering,
    kajiya_kay: &'a mut KajiyaKayParams,
    marschner: &'a mut Marschner2003Params,
    rest_weight: &'a mut f32,
) -> Slot<'a> {
    const KAJIYA_KAY: &[&str] = &["kajiya-kay", "kajiya-kay-1989", "kajiya-kay-half"];
    const CYLINDER: &[&str] = &["marschner-2003", "marschner-2003-nalu"];
    Slot {
        key: "scattering",
        label: "Scattering",
        help: "How one fibre scatters light",
        choice,
        params: vec![
            number("scattering.kk_diffuse", "Diffuse", "", (0.0, 2.0), &mut kajiya_kay.diffuse, KAJIYA_KAY, "Weight of the diffuse term"),
            number("scattering.kk_specular", "Specular", "", (0.0, 2.0), &mut kajiya_kay.specular, KAJIYA_KAY, "Weight of the highlights"),
            number("scattering.kk_exponent", "Exponent", "", (1.0, 400.0), &mut kajiya_kay.exponent, KAJIYA_KAY, "Sharpness of the highlights"),
            number("scattering.glint", "Glint", "", (0.0, 5.0), &mut marschner.glint, CYLINDER, "Strength of TRT's caustics: Marschner's k_G, 0.5 to 5"),
            number("scattering.glint_width", "Glint width", "deg", (1.0, 40.0), &mut marschner.glint_width_deg, CYLINDER, "Width of TRT's caustics around the fibre: Marschner's w_c, 10 to 25"),
            number("scattering.glint_fade", "Glint fade", "", (0.01, 1.0), &mut marschner.glint_fade, CYLINDER, "Range of the index of refraction over which merged caustics fade: Marschner's Delta eta', 0.2 to 0.4"),
            number("scattering.glint_limit", "Glint limit", "radii", (0.01, 2.0), &mut marschner.glint_limit, CYLINDER, "Most of the width that a caustic gathers: Marschner's Delta h_M, 0.5"),
            number("scattering.eccentricity", "Flatness", "", (0.7, 1.4), &mut marschner.eccentricity, CYLINDER, "Ratio of the cross-section's axes: 1 is round, 0.85 is common; fibres are turned every way"),
            number("scattering.rest", "Beyond TRT", "", (0.0, 4.0), rest_weight, &["deon", "chiang"], "Weight of light that crosses the fibre three times or more: 0 leaves it out, 1 is physical"),
        ],
    }
}

pub(super) fn fresnel(choice: &mut Fresnel) -> Slot<'_> {
    Slot {
        key: "fresnel",
        label: "Reflectance",
        help: "Reflectance of the fibre's surface in the closed form of Marschner's lobes",
        choice,
        params: vec![],
    }
}

pub(super) fn offsets(choice: &mut Offsets) -> Slot<'_> {
    Slot {
        key: "offsets",
        label: "Offsets",
        help: "Where across the fibre the closed form of Marschner's lobes takes reflectance and path length",
        choice,
        params: vec![],
    }
}

pub(super) fn lobe_r<'a>(choice: &'a mut Switch, weight_r: &'a mut f32) -> Slot<'a> {
    Slot {
        key: "r",
        label: "R lobe",
        help: "Light reflected off the cuticle: the white highlight",
        choice,
        params: vec![number("r.weight", "Weight", "", (0.0, 4.0), weight_r, &["on"], "1 is physical")],
    }
}

pub(super) fn lobe_tt<'a>(choice: &'a mut Switch, weight_tt: &'a mut f32) -> Slot<'a> {
    Slot {
        key: "tt",
        label: "TT lobe",
        help: "Light through the fibre: the bright rim from behind",
        choice,
        params: vec![number("tt.weight", "Weight", "", (0.0, 4.0), weight_tt, &["on"], "1 is physical")],
    }
}

pub(super) fn lobe_trt<'a>(choice: &'a mut Switch, weight_trt: &'a mut f32) -> Slot<'a> {
    Slot {
        key: "trt",
        label: "TRT lobe",
        help: "Light reflected inside the fibre: the coloured highlight",
        choice,
        params: vec![number("trt.weight", "Weight", "", (0.0, 4.0), weight_trt, &["on"], "1 is physical")],
    }
}

pub(super) fn multiple<'a>(choice: &'a mut MultipleScattering, multiple_scattering_weight: &'a mut f32) -> Slot<'a> {
    Slot {
        key: "multiple",
        label: "Multiple scattering",
        help: "Light that has met several fibres",
        choice,
        params: vec![number(
            "multiple.weight",
            "Weight",
            "",
            (0.0, 4.0),
            multiple_scattering_weight,
            &["fake-normal"],
            "Scale of the term",
        )],
    }
}

/// The choices that take their light from a picture.
const PICTURED: &[&str] = &["karis", "harmonics"];

pub(super) fn environment<'a>(
    choice: &'a mut Environment,
    environment_colour: &'a mut [f32; 3],
    environment_intensity: &'a mut f32,
    pictured: &'a mut EnvironmentParams,
) -> Slot<'a> {
    Slot {
        key: "environment",
        label: "Environment",
        help: "Light from all around",
        choice,
        params: vec![
            colour("environment.colour", "Colour", environment_colour, &["constant"], "Radiance from every direction"),
            number(
                "environment.intensity",
                "Intensity",
                "",
                (0.0, 4.0),
                environment_intensity,
                &["constant"],
                "Scale of the colour",
            ),
            alternatives(
                "environment.picture",
                "Picture",
                &mut pictured.picture,
                PICTURED,
                "Where the light comes from; one from a file is loaded from the palette, the command line or by dropping it",
            ),
            number(
                "environment.rotation",
                "Rotation",
                "deg",
                (-180.0, 180.0),
                &mut pictured.rotation_deg,
                PICTURED,
                "Turns the picture about the vertical: its middle comes from in front, then from the model's left",
            ),
            number(
                "environment.exposure",
                "Exposure",
                "stops",
                (-8.0, 8.0),
                &mut pictured.exposure,
                PICTURED,
                "Doubles the picture's light with every stop",
            ),
        ],
    }
}
