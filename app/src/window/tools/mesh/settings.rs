//! What the modelling tool's operations are done with; kept while the studio runs.

use lorelei_core::brush::{Brush, Falloff};
use lorelei_core::hair_mesh::select::Reach;
use lorelei_core::hair_mesh::{Along, Scheme, Weld};

use super::cage::Display;
use super::grab::GrabKind;

/// How an area is selected by a drag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Area {
    #[default]
    Box,
    Lasso,
}

/// Which way faces are extruded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ExtrudeWay {
    #[default]
    Onward,
    Normal,
    Gravity,
    Curve,
}

impl ExtrudeWay {
    pub const ALL: [Self; 4] = [Self::Onward, Self::Normal, Self::Gravity, Self::Curve];

    pub fn label(self) -> &'static str {
        match self {
            Self::Onward => "The way the hair goes",
            Self::Normal => "Along the normal",
            Self::Gravity => "Towards the ground",
            Self::Curve => "Along an arch",
        }
    }
}

/// All of it. Lengths in centimetres.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    pub area: Area,
    pub handle: GrabKind,
    pub is_soft: bool,
    pub soft_radius: f32,
    pub soft_falloff: Falloff,
    pub soft_reach: Reach,
    pub is_symmetric: bool,
    /// Place the inside after every move.
    pub relaxes: bool,
    pub stays_out: bool,
    pub clearance: f32,
    pub way: ExtrudeWay,
    /// Of [`ExtrudeWay::Gravity`], 0-1.
    pub pull: f32,
    pub length: f32,
    pub n_layers: u32,
    pub weld: Weld,
    pub scheme: Scheme,
    /// Where a new layer or vertex is put, 0-1.
    pub at: f32,
    pub smoothing: f32,
    pub display: Display,
    pub push: Brush,
    pub is_pushing: bool,
    /// About the side of a root quad of a new hair mesh.
    pub new_spacing: f32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            area: Area::Box,
            handle: GrabKind::Move,
            is_soft: false,
            soft_radius: 4.0,
            soft_falloff: Falloff::Smooth,
            soft_reach: Reach::Straight,
            is_symmetric: false,
            relaxes: true,
            stays_out: true,
            clearance: 0.3,
            way: ExtrudeWay::Onward,
            pull: 0.4,
            length: 3.0,
            n_layers: 1,
            weld: Weld::Neighbours,
            scheme: Scheme::CatmullClark,
            at: 0.5,
            smoothing: 0.5,
            display: Display::default(),
            push: Brush { strength: 0.3, ..Brush::default() },
            is_pushing: false,
            new_spacing: 2.5,
        }
    }
}

impl Settings {
    pub fn along(&self) -> Along {
        match self.way {
            ExtrudeWay::Onward => Along::Onward,
            ExtrudeWay::Normal => Along::Normal,
            ExtrudeWay::Gravity => Along::Gravity { pull: self.pull },
            // A quarter of a circle, up and over: its shape counts, not its size.
            ExtrudeWay::Curve => Along::Curve(
                (0..=8)
                    .map(|i| {
                        let (sin, cos) = (i as f32 / 8.0 * std::f32::consts::FRAC_PI_2).sin_cos();
                        glam::Vec3::new(0.0, sin, 1.0 - cos)
                    })
                    .collect(),
            ),
        }
    }
}
