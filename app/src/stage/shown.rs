//! What of a groom is shown, beside what the groom itself says: one term of its light alone, another look beside its
//! own. No part of the document and never undone.

use lorelei_core::light::Light;
use lorelei_core::look::{Environment, Look};
use lorelei_render::inspect::is_lobe;
use lorelei_render::versus::Comparison;

/// The only light that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solo {
    /// One of [`lorelei_core::look::presets::TERMS`], by its key.
    Term(&'static str),
    /// A lamp, by its place in the groom; it is on, whatever it was, and there is no environment.
    Light(usize),
}

/// What is shown.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shown {
    pub solo: Option<Solo>,
    /// Another look, and how it is seen beside the groom's own.
    pub versus: Option<(Look, Comparison)>,
}

impl Shown {
    /// A look with what is alone in it.
    pub fn look(&self, look: &Look) -> Look {
        match self.solo {
            Some(Solo::Term(term)) if is_lobe(term) => Look {
                // What the way through the hair does to single scattering belongs to this slot: only its light is left out.
                multiple_scattering: look.multiple_scattering,
                multiple_scattering_weight: 0.0,
                ..look.solo(term)
            },
            Some(Solo::Term(term)) => look.solo(term),
            Some(Solo::Light(_)) => Look { environment: Environment::Off, ..look.clone() },
            None => look.clone(),
        }
    }

    /// The lamps that shine.
    pub fn lights(&self, lights: &[Light]) -> Vec<Light> {
        let mut lights = lights.to_vec();
        if self.solo == Some(Solo::Term("environment")) {
            // Dark lamps still say what of the environment gets into the hair.
            for light in &mut lights {
                light.intensity = 0.0;
            }
        }
        if let Some(Solo::Light(alone)) = self.solo
            && alone < lights.len()
        {
            for (light_idx, light) in lights.iter_mut().enumerate() {
                light.on = light_idx == alone;
            }
        }
        lights
    }
}

#[cfg(test)]
mod tests {
    use lorelei_core::light::three_point_rig;
    use lorelei_core::look::Switch;

    use super::*;

    #[test]
    fn what_is_alone_is_alone_and_nothing_else_changes() {
        let (look, lights) = (Look::default(), three_point_rig());
        let shown = |solo| Shown { solo, versus: None };
        assert_eq!(shown(None).look(&look), look);
        assert_eq!(shown(None).lights(&lights), lights);
        let r = shown(Some(Solo::Term("r"))).look(&look);
        assert_eq!((r.lobe_r, r.lobe_tt, r.environment), (Switch::On, Switch::Off, Environment::Off));
        assert_eq!((r.multiple_scattering, r.multiple_scattering_weight), (look.multiple_scattering, 0.0));
        let one = shown(Some(Solo::Light(1)));
        assert_eq!(one.look(&look), Look { environment: Environment::Off, ..look.clone() });
        let on: Vec<bool> = one.lights(&lights).iter().map(|light| light.on).collect();
        assert_eq!(on, [false, true, false]);
        let environment = shown(Some(Solo::Term("environment")));
        assert!(environment.lights(&lights).iter().all(|light| light.on && light.intensity == 0.0));
        // A lamp that was removed meanwhile leaves the others as they are.
        assert_eq!(shown(Some(Solo::Light(9))).lights(&lights), lights);
    }
}
