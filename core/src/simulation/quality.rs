//! How finely time and air are cut, in one choice: steps a second, iterations a step, cells of the wind's grid. What the hair is
//! like stays as it is.

use serde::{Deserialize, Serialize};

use super::SimulationSettings;
use crate::look::{Choice, ChoiceInfo, choices};

choices! {
    /// Named settings of the solver's cost.
    Quality {
        Draft = "draft", "Draft", "120 steps a second: for trying things out and for slow devices";
        Normal = "normal", "Normal", "240 steps a second";
        High = "high", "High", "480 steps a second and a finer grid for the wind: for pictures that are kept";
    }
}

impl Quality {
    /// Steps a second, iterations a step, cells along each side of the wind's grid.
    fn numbers(self) -> (f32, u32, u32) {
        let normal = SimulationSettings::default();
        match self {
            Self::Draft => (120.0, 2, 24),
            Self::Normal => (normal.steps_per_second, normal.n_iterations, normal.air.resolution),
            Self::High => (480.0, 6, 64),
        }
    }

    /// Give settings this quality.
    pub fn put(self, settings: &mut SimulationSettings) {
        let (steps_per_second, n_iterations, resolution) = self.numbers();
        settings.steps_per_second = steps_per_second;
        settings.n_iterations = n_iterations;
        settings.air.resolution = resolution;
    }

    /// The quality that settings have; `None` where they have numbers of their own.
    pub fn of(settings: &SimulationSettings) -> Option<Self> {
        let has = (settings.steps_per_second, settings.n_iterations, settings.air.resolution);
        Self::ALL.iter().copied().find(|quality| quality.numbers() == has)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_have_the_quality_that_they_were_given_and_keep_everything_else() {
        let hair = SimulationSettings { gravity: 500.0, ..SimulationSettings::default() };
        assert_eq!(Quality::of(&hair), Some(Quality::Normal));
        for &quality in Quality::ALL {
            let mut settings = hair.clone();
            quality.put(&mut settings);
            assert_eq!(Quality::of(&settings), Some(quality));
            Quality::Normal.put(&mut settings);
            assert_eq!(settings, hair);
        }
        assert_eq!(Quality::of(&SimulationSettings { steps_per_second: 77.0, ..hair }), None);
    }
}
