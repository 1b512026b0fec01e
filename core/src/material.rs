//! What the fibres of a layer are made of: pigment given in one of three ways, roughness, and how strands differ; and hair
//! colours by name.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::look::{AnyChoice, Choice, ChoiceInfo, Param, ParamValue, Slot, choices};

/// What the fibres are made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct HairMaterial {
    pub pigment: Pigment,
    /// Concentrations in the units of Chiang et al. 2016 / pbrt: absorption per fibre radius is
    /// eumelanin * (0.419, 0.697, 1.37) + pheomelanin * (0.187, 0.4, 1.05).
    pub eumelanin: f32,
    pub pheomelanin: f32,
    /// Linear RGB of the whole head of hair, for [`Pigment::Colour`].
    pub colour: [f32; 3],
    /// Absorption per fibre radius, RGB, for [`Pigment::Absorption`].
    pub absorption: [f32; 3],
    /// Longitudinal roughness: standard deviation of the R lobe in theta_h.
    pub beta_m_deg: f32,
    /// Azimuthal roughness, 0-1 as in Chiang et al. 2016.
    pub beta_n: f32,
    /// Tilt of the cuticle scales towards the root.
    pub tilt_deg: f32,
    pub index_of_refraction: f32,
    /// Spread of the colour from strand to strand, 0-1. The tilt of the scales follows it.
    pub colour_variation: f32,
    /// Spread of the longitudinal roughness from strand to strand: deviation of its logarithm.
    pub roughness_variation: f32,
    /// Further spread of the tilt from strand to strand: its deviation.
    pub tilt_variation_deg: f32,
    /// Lighter towards the tip: share of the absorption that is gone there, 0-1.
    pub tip_lightening: f32,
    /// 0-1: share of the own absorption that the dye's takes the place of.
    pub dye: f32,
    /// Linear RGB of a whole head of dyed hair.
    pub dye_colour: [f32; 3],
    /// Shares of a strand's length where the dye begins and where it is full.
    pub dye_from: f32,
    pub dye_to: f32,
}

choices! {
    /// How the absorption is given.
    Pigment {
        Melanin = "melanin", "Melanin", "Eumelanin (brown) and pheomelanin (red)";
        Colour = "colour", "Colour", "The absorption that gives a head of hair this colour (Chiang et al. 2016)";
        Absorption = "absorption", "Absorption", "Absorption coefficients per fibre radius, as other renderers take them";
    }
}

choices! {
    /// Hair colours by name. Concentrations after the ranges of d'Eon et al. 2011.
    HairPreset {
        Black = "black", "Black", "Eumelanin 8";
        Brown = "brown", "Brown", "Eumelanin 1.3, a little red";
        LightBrown = "light-brown", "Light brown", "Eumelanin 0.7, a little red";
        Red = "red", "Red", "Eumelanin 0.35, pheomelanin 1.5";
        Blond = "blond", "Blond", "Eumelanin 0.25, a little red";
        Platinum = "platinum", "Platinum", "Eumelanin 0.06: bleached";
        White = "white", "White", "Next to no pigment";
        Fantasy = "fantasy", "Fantasy", "Bleached, and dyed turquoise from a hand's breadth below the roots";
    }
}

impl Default for HairMaterial {
    fn default() -> Self {
        Self {
            pigment: Pigment::Melanin,
            eumelanin: 1.3,
            pheomelanin: 0.2,
            colour: [0.25, 0.12, 0.05],
            absorption: [0.25, 0.45, 0.95],
            beta_m_deg: 7.5,
            beta_n: 0.3,
            tilt_deg: 3.0,
            index_of_refraction: 1.55,
            colour_variation: 0.15,
            roughness_variation: 0.0,
            tilt_variation_deg: 0.0,
            tip_lightening: 0.15,
            dye: 0.0,
            dye_colour: [0.02, 0.32, 0.36],
            dye_from: 0.0,
            dye_to: 0.0,
        }
    }
}

impl HairMaterial {
    /// Absorption coefficient per fibre radius, RGB, without dye.
    pub fn sigma_a(&self) -> Vec3 {
        match self.pigment {
            // pbrt-v4, HairBxDF::SigmaAFromConcentration, after d'Eon et al. 2011.
            Pigment::Melanin => {
                Vec3::new(0.419, 0.697, 1.37) * self.eumelanin + Vec3::new(0.187, 0.4, 1.05) * self.pheomelanin
            }
            Pigment::Colour => self.absorption_for(self.colour),
            Pigment::Absorption => Vec3::from_array(self.absorption),
        }
    }

    /// Absorption coefficient per fibre radius of the dye.
    pub fn dye_sigma_a(&self) -> Vec3 {
        self.absorption_for(self.dye_colour)
    }

    /// The absorption of fibres of which a whole head has a colour, at this azimuthal roughness: Chiang et al. 2016, eq. 9.
    fn absorption_for(&self, colour: [f32; 3]) -> Vec3 {
        let b = self.beta_n;
        let d = 5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5);
        Vec3::from_array(colour.map(|c| (c.clamp(1e-4, 0.999).ln() / d).powi(2)))
    }

    /// Take a hair colour by name; everything but pigment and dye stays.
    pub fn take(&mut self, preset: HairPreset) {
        self.pigment = Pigment::Melanin;
        (self.dye, self.dye_from, self.dye_to) = (0.0, 0.0, 0.0);
        (self.eumelanin, self.pheomelanin) = match preset {
            HairPreset::Black => (8.0, 0.2),
            HairPreset::Brown => (1.3, 0.2),
            HairPreset::LightBrown => (0.7, 0.2),
            HairPreset::Red => (0.35, 1.5),
            HairPreset::Blond => (0.25, 0.2),
            HairPreset::Platinum => (0.06, 0.02),
            HairPreset::White => (0.01, 0.01),
            HairPreset::Fantasy => {
                self.dye_colour = Self::default().dye_colour;
                (self.dye, self.dye_from, self.dye_to) = (1.0, 0.15, 0.5);
                (0.06, 0.02)
            }
        };
    }

    /// The material's settings as a slot, for panels and `--set`.
    #[rustfmt::skip]
    pub fn slot(&mut self) -> Slot<'_> {
        let number = |key: &str, label, unit, (min, max), value, of, help| Param {
            key: format!("hair.{key}"), label, unit, min, max, of, help, value: ParamValue::F32(value),
        };
        let colour = |key: &str, label, value, of, help| Param {
            key: format!("hair.{key}"), label, unit: "linear RGB", min: 0.0, max: 1.0, of, help, value: ParamValue::Colour(value),
        };
        const MELANIN: &[&str] = &["melanin"];
        const ABSORPTION: &[&str] = &["absorption"];
        let [red, green, blue] = &mut self.absorption;
        Slot { key: "hair", label: "Hair fibre", help: "What the fibres of a layer are made of", choice: &mut self.pigment as &mut dyn AnyChoice, params: vec![
            number("eumelanin", "Eumelanin", "", (0.0, 10.0), &mut self.eumelanin, MELANIN, "Brown pigment: 8 black, 1.3 brown, 0.3 blond"),
            number("pheomelanin", "Pheomelanin", "", (0.0, 10.0), &mut self.pheomelanin, MELANIN, "Red pigment: 1.5-2 in red hair"),
            colour("colour", "Colour", &mut self.colour, &["colour"], "Colour of the whole head of hair"),
            number("absorption_red", "Absorption of red", "per radius", (0.0, 20.0), red, ABSORPTION, "0 is clear, 3.5 is black hair's"),
            number("absorption_green", "Absorption of green", "per radius", (0.0, 20.0), green, ABSORPTION, "0 is clear, 5.7 is black hair's"),
            number("absorption_blue", "Absorption of blue", "per radius", (0.0, 20.0), blue, ABSORPTION, "0 is clear, 11 is black hair's"),
            number("beta_m_deg", "Roughness along", "deg", (1.0, 40.0), &mut self.beta_m_deg, &[], "Width of the highlight along the strand"),
            number("beta_n", "Roughness around", "", (0.05, 1.0), &mut self.beta_n, &[], "Width of the scattering around the strand"),
            number("tilt_deg", "Scale tilt", "deg", (-10.0, 10.0), &mut self.tilt_deg, &[], "Shifts the highlights: white to the root, coloured to the tip"),
            number("ior", "Index of refraction", "", (1.1, 2.2), &mut self.index_of_refraction, &[], "1.55 for hair"),
            number("variation", "Colour variation", "", (0.0, 1.0), &mut self.colour_variation, &[], "From strand to strand"),
            number("roughness_variation", "Roughness variation", "", (0.0, 0.5), &mut self.roughness_variation, &[], "From strand to strand: 0.2 makes some a fifth rougher, some a fifth smoother"),
            number("tilt_variation", "Tilt variation", "deg", (0.0, 10.0), &mut self.tilt_variation_deg, &[], "From strand to strand: breaks highlights up"),
            number("tip_lightening", "Tip lightening", "", (0.0, 1.0), &mut self.tip_lightening, &[], "Share of the pigment that is gone at the tip"),
            number("dye", "Dye", "", (0.0, 1.0), &mut self.dye, &[], "Share of the own colour that the dye takes the place of"),
            colour("dye_colour", "Dye colour", &mut self.dye_colour, &[], "Colour of a whole head of dyed hair"),
            number("dye_from", "Dye from", "share of length", (0.0, 1.0), &mut self.dye_from, &[], "Where the dye begins, from the root: above 0 the roots have grown out"),
            number("dye_to", "Dye full at", "share of length", (0.0, 1.0), &mut self.dye_to, &[], "Where the dye is full, from the root"),
        ] }
    }
}

impl HairPreset {
    /// The preset of a name that `--set hair.preset=` takes.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|preset| preset.info().name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_go_from_dark_to_light_and_leave_no_dye_behind() {
        let sigma = |preset: HairPreset| {
            let mut material = HairMaterial { dye: 1.0, beta_n: 0.4, ..HairMaterial::default() };
            material.take(preset);
            assert_eq!((material.dye > 0.0, material.beta_n), (preset == HairPreset::Fantasy, 0.4));
            material.sigma_a()
        };
        let by_darkness =
            [HairPreset::Black, HairPreset::Brown, HairPreset::LightBrown, HairPreset::Blond, HairPreset::Platinum];
        assert!(by_darkness.windows(2).all(|pair| sigma(pair[0]).y > 1.5 * sigma(pair[1]).y));
        let red = sigma(HairPreset::Red);
        assert!(red.z / red.x > 1.2 * sigma(HairPreset::Brown).z / sigma(HairPreset::Brown).x);
        assert_eq!(HairPreset::by_name("platinum"), Some(HairPreset::Platinum));
    }

    #[test]
    fn a_lighter_colour_has_less_absorption_and_documents_without_the_new_fields_open() {
        let of =
            |c: f32| HairMaterial { pigment: Pigment::Colour, colour: [c; 3], ..HairMaterial::default() }.sigma_a().x;
        assert!(of(0.1) > of(0.3) && of(0.3) > of(0.9));
        let old: HairMaterial = ron::from_str("(pigment: Melanin, eumelanin: 0.4)").unwrap();
        assert_eq!(old, HairMaterial { eumelanin: 0.4, ..HairMaterial::default() });
    }
}
