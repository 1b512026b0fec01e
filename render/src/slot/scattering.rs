//! The slots of the shading kernel: how fibres scatter.

use lorelei_core::look::{Environment, Look, MultipleScattering, Scattering, Switch};
use lorelei_shaders::Link;

/// `lorelei::scattering`: how one fibre scatters.
pub fn scattering(choice: Scattering) -> Link<'static> {
    Link::Slot(
        "scattering",
        match choice {
            Scattering::KajiyaKay => "scatter_kajiya_kay",
            Scattering::KajiyaKay1989 => "scatter_kajiya_kay_1989",
            Scattering::KajiyaKayHalf => "scatter_kajiya_kay_half",
            Scattering::Marschner => "scatter_marschner",
            Scattering::Marschner2003 => "scatter_marschner_2003",
            Scattering::Marschner2003Nalu => "scatter_marschner_2003_nalu",
            Scattering::Deon => "scatter_deon",
            Scattering::Chiang => "scatter_chiang",
        },
    )
}

/// `lorelei::lobe_r`, `lobe_tt` and `lobe_trt`: Marschner's lobes.
pub fn lobes(look: &Look) -> [Link<'static>; 3] {
    let file = |switch: Switch, lobe: &'static str| match switch {
        Switch::On => lobe,
        Switch::Off => "scatter_lobe_off",
    };
    [
        Link::Slot("lobe_r", file(look.lobe_r, "scatter_r")),
        Link::Slot("lobe_tt", file(look.lobe_tt, "scatter_tt")),
        Link::Slot("lobe_trt", file(look.lobe_trt, "scatter_trt")),
    ]
}

/// `lorelei::multiple`: light that has met several fibres.
pub fn multiple_scattering(choice: MultipleScattering) -> Link<'static> {
    Link::Slot(
        "multiple",
        match choice {
            MultipleScattering::FakeNormal => "scatter_multiple_fake_normal",
            MultipleScattering::Off => "scatter_multiple_off",
        },
    )
}

/// `lorelei::environment`: light from all around.
pub fn environment(choice: Environment) -> Link<'static> {
    Link::Slot(
        "environment",
        match choice {
            Environment::Constant => "shade_environment_constant",
            Environment::Karis => "shade_environment_karis",
            Environment::Harmonics => "shade_environment_harmonics",
            Environment::Off => "shade_environment_off",
        },
    )
}

/// `lorelei::ambient`: what skin gets of the environment.
pub fn ambient(choice: Environment) -> Link<'static> {
    Link::Slot(
        "ambient",
        match choice {
            // Off is a constant of no light.
            Environment::Constant | Environment::Off => "ambient_constant",
            Environment::Karis | Environment::Harmonics => "ambient_picture",
        },
    )
}
