//! A brush: how far it reaches, how strongly it acts, and how that falls off, for sculpting and painting alike.
//!
//! What a brush does is the business of whoever uses it; this is only the part that an artist sets once and
//! keeps from brush to brush.

use serde::{Deserialize, Serialize};

/// How a brush's strength falls off from its middle to its rim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum Falloff {
    /// Flat in the middle and at the rim: 1 - 3x^2 + 2x^3.
    #[default]
    Smooth,
    /// A half circle: sqrt(1 - x^2).
    Sphere,
    /// 1 - x.
    Linear,
    /// (1 - x)^2.
    Sharp,
    /// Full up to the rim.
    Constant,
}

impl Falloff {
    pub const ALL: [Self; 5] = [Self::Smooth, Self::Sphere, Self::Linear, Self::Sharp, Self::Constant];

    pub fn label(self) -> &'static str {
        match self {
            Self::Smooth => "Smooth",
            Self::Sphere => "Sphere",
            Self::Linear => "Linear",
            Self::Sharp => "Sharp",
            Self::Constant => "Constant",
        }
    }

    /// Strength (0-1) at the distance `x` from the middle, in radii; 0 from 1 on.
    pub fn at(self, x: f32) -> f32 {
        if x >= 1.0 {
            return 0.0;
        }
        let x = x.max(0.0);
        match self {
            Self::Smooth => 1.0 - x * x * (3.0 - 2.0 * x),
            Self::Sphere => (1.0 - x * x).sqrt(),
            Self::Linear => 1.0 - x,
            Self::Sharp => (1.0 - x) * (1.0 - x),
            Self::Constant => 1.0,
        }
    }
}

/// What a brush's radius is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
pub enum BrushSpace {
    /// In points of the window: everything under the circle, at any depth.
    Screen,
    /// In centimetres around the place under the pointer.
    #[default]
    Surface,
}

/// The settings that brushes share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Brush {
    /// In [`BrushSpace::Surface`], centimetres.
    pub radius_cm: f32,
    /// In [`BrushSpace::Screen`], points of the window.
    pub radius_points: f32,
    /// 0-1.
    pub strength: f32,
    pub falloff: Falloff,
    pub space: BrushSpace,
    /// Do the same on the other side of the plane X = 0.
    pub is_symmetric: bool,
    /// Reach what faces away from the eye, too.
    pub has_back_faces: bool,
    /// A pen's pressure scales the radius.
    pub pressure_sets_radius: bool,
    /// A pen's pressure scales the strength.
    pub pressure_sets_strength: bool,
}

impl Default for Brush {
    fn default() -> Self {
        Self {
            radius_cm: 3.0,
            radius_points: 60.0,
            strength: 0.5,
            falloff: Falloff::Smooth,
            space: BrushSpace::Surface,
            is_symmetric: false,
            has_back_faces: false,
            pressure_sets_radius: false,
            pressure_sets_strength: true,
        }
    }
}

impl Brush {
    /// Smallest and largest radius in either space: centimetres, points.
    pub const RADIUS_CM: (f32, f32) = (0.1, 20.0);
    pub const RADIUS_POINTS: (f32, f32) = (4.0, 400.0);

    /// The brush under a pen's pressure, 0-1; a mouse presses with 1.
    pub fn under_pressure(mut self, pressure: f32) -> Self {
        let pressure = pressure.clamp(0.0, 1.0);
        if self.pressure_sets_radius {
            self.radius_cm *= pressure.max(0.05);
            self.radius_points *= pressure.max(0.05);
        }
        if self.pressure_sets_strength {
            self.strength *= pressure;
        }
        self
    }

    /// Make the brush larger or smaller, in whichever space it is measured.
    pub fn scale_radius(&mut self, factor: f32) {
        match self.space {
            BrushSpace::Surface => {
                self.radius_cm = (self.radius_cm * factor).clamp(Self::RADIUS_CM.0, Self::RADIUS_CM.1);
            }
            BrushSpace::Screen => {
                self.radius_points = (self.radius_points * factor).clamp(Self::RADIUS_POINTS.0, Self::RADIUS_POINTS.1);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_falloff_is_full_in_the_middle_falls_and_ends_at_the_rim() {
        for falloff in Falloff::ALL {
            assert_eq!((falloff.at(0.0), falloff.at(1.0), falloff.at(5.0)), (1.0, 0.0, 0.0), "{falloff:?}");
            let values: Vec<f32> = (0..100).map(|i| falloff.at(i as f32 / 100.0)).collect();
            assert!(values.windows(2).all(|pair| pair[1] <= pair[0] && pair[1] > 0.0), "{falloff:?}");
        }
    }

    #[test]
    fn pressure_acts_where_it_is_asked_to() {
        let brush = Brush::default();
        assert_eq!(brush.under_pressure(1.0), brush);
        let light = brush.under_pressure(0.5);
        assert_eq!((light.radius_cm, light.strength), (brush.radius_cm, 0.5 * brush.strength));
        let wide = Brush { pressure_sets_radius: true, pressure_sets_strength: false, ..brush }.under_pressure(0.5);
        assert_eq!((wide.radius_cm, wide.strength), (0.5 * brush.radius_cm, brush.strength));
    }
}
