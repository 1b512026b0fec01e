//! Kinds of hair by how they move: named sets of physical numbers, as starting points.
//!
//! The bending length of a single hair of 70 micrometres is about 4.6 cm: (E I / (rho A g))^(1/3) with Young's modulus
//! E = 4 GPa and density rho = 1.3 g/cm3 (Robbins 2012, "Chemical and Physical Behavior of Human Hair"). Hair that moves as
//! a lock is softer where its hairs slide on each other and stiffer where they lock, as curls do; wet hair is heavier,
//! softer and clings.

use super::SimulationSettings;
use crate::look::{Choice, ChoiceInfo, choices};
use serde::{Deserialize, Serialize};

choices! {
    /// A kind of hair by how it moves.
    HairKind {
        FineStraight = "fine-straight", "Fine, straight", "Soft and light: swings long and takes the wind";
        ThickWavy = "thick-wavy", "Thick, wavy", "Stiffer and heavier: swings as one and settles soon";
        TightCurls = "tight-curls", "Tight curls", "Locks into itself: bounces, hardly swings and keeps its volume";
        Wet = "wet", "Wet", "Heavy and soft: clings, and the wind does little";
        Tied = "tied", "Tied up", "Braids, buns and combed-back hair: stiff as a rope, held well above the roots";
    }
}

impl HairKind {
    /// Bend length (cm), bend damping (s), damping across and along (1/s), drag (1/s), hold (Hz) and how far (cm), distance to
    /// the head (cm), friction.
    fn numbers(self) -> [f32; 9] {
        match self {
            Self::FineStraight => [2.5, 0.003, 1.5, 1.5, 1.5, 3.0, 3.0, 0.15, 0.2],
            Self::ThickWavy => [4.5, 0.006, 2.2, 2.0, 0.9, 4.0, 3.5, 0.2, 0.25],
            Self::TightCurls => [7.0, 0.01, 2.0, 2.0, 2.5, 3.5, 2.5, 0.2, 0.3],
            Self::Wet => [1.5, 0.004, 2.5, 2.0, 0.2, 2.5, 2.0, 0.05, 0.7],
            Self::Tied => [9.0, 0.01, 3.0, 2.5, 0.6, 8.0, 6.0, 0.15, 0.3],
        }
    }

    /// The kind whose numbers settings have; `None` where they have numbers of their own.
    pub fn of(settings: &SimulationSettings) -> Option<Self> {
        let is_like = |kind: &Self| {
            let mut like = settings.clone();
            like.take(*kind);
            like == *settings
        };
        Self::ALL.iter().copied().find(is_like)
    }
}

impl SimulationSettings {
    /// Take the numbers of a kind of hair; solver, wind, colliders and steps stay.
    pub fn take(&mut self, kind: HairKind) {
        [
            self.bend_length,
            self.bend_damping,
            self.damping,
            self.damping_along,
            self.drag,
            self.hold,
            self.hold_length,
            self.collision_margin,
            self.friction,
        ] = kind.numbers();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_in_the_range_of_its_parameters_and_another_than_the_others() {
        let mut seen: Vec<SimulationSettings> = Vec::new();
        for &kind in HairKind::ALL {
            let mut settings = SimulationSettings::default();
            settings.take(kind);
            for mut param in settings.slots().into_iter().flat_map(|slot| slot.params) {
                let text = param.value.to_text();
                param.set_from_text(&text).unwrap();
            }
            assert!(!seen.contains(&settings), "{kind:?}");
            settings.wind_speed += 100.0;
            assert_eq!(HairKind::of(&settings), Some(kind));
            settings.wind_speed -= 100.0;
            let other = SimulationSettings { friction: 0.33, ..settings.clone() };
            assert_eq!(HairKind::of(&other), None);
            seen.push(settings);
        }
        assert_eq!(seen[0], SimulationSettings::default(), "the first kind is the default");
    }
}
