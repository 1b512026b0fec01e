//! How fibres scatter light: one of them, several, and what comes from all around.

use serde::{Deserialize, Serialize};

use super::slot::{Choice, ChoiceInfo, Slot, Switch, choices, colour, number};

choices! {
    /// How a single fibre scatters light.
    Scattering {
        KajiyaKay = "kajiya-kay", "Kajiya-Kay", "Diffuse and Phong-like specular from the tangent (Kajiya and Kay 1989)";
        Marschner = "marschner", "Marschner", "R, TT and TRT lobes in the real-time form of Karis and Tafuri";
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

pub(super) fn scattering<'a>(choice: &'a mut Scattering, kajiya_kay: &'a mut KajiyaKayParams) -> Slot<'a> {
    Slot {
        key: "scattering",
        label: "Scattering",
        help: "How one fibre scatters light",
        choice,
        params: vec![
            number(
                "scattering.kk_diffuse",
                "Diffuse",
                "",
                (0.0, 2.0),
                &mut kajiya_kay.diffuse,
                &["kajiya-kay"],
                "Weight of the diffuse term",
            ),
            number(
                "scattering.kk_specular",
                "Specular",
                "",
                (0.0, 2.0),
                &mut kajiya_kay.specular,
                &["kajiya-kay"],
                "Weight of the highlights",
            ),
            number(
                "scattering.kk_exponent",
                "Exponent",
                "",
                (1.0, 400.0),
                &mut kajiya_kay.exponent,
                &["kajiya-kay"],
                "Sharpness of the highlights",
            ),
        ],
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

pub(super) fn environment<'a>(
    choice: &'a mut Environment,
    environment_colour: &'a mut [f32; 3],
    environment_intensity: &'a mut f32,
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
        ],
    }
}
