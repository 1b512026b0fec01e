//! The brushes: each a function that moves the points of one hair under one dab, a file each.
//!
//! A brush says where the hair wants to go. That segments keep their lengths, that no point enters the head, and
//! that frozen hair stays, is the same for all and holds afterwards, whatever a brush did (`super::solve`,
//! [`super::session`]).

mod add;
mod clump;
mod comb;
mod curl;
mod cut;
mod delete;
#[cfg(test)]
mod effects;
mod freeze;
mod length;
mod mask;
mod part;
mod pinch;
mod puff;
mod slide;
mod smooth;
#[cfg(test)]
mod tests;
mod twist;

use glam::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

use super::K;
use super::solve::Follow;
use super::view::View;
use crate::brush::{Brush, BrushSpace};
use crate::distance_field::DistanceField;
use crate::look::{Choice, ChoiceInfo, choices};

choices! {
    /// What a stroke does.
    #[derive(Default)]
    SculptBrush {
        #[default]
        Comb = "comb", "Comb", "Draw the hair along with the pointer";
        Smooth = "smooth", "Smooth", "Straighten the hair and even it out with its neighbours";
        Puff = "puff", "Puff", "Lift the hair off the scalp; inverted: press it down";
        Pinch = "pinch", "Pinch", "Gather the hair under the pointer; inverted: spread it";
        Clump = "clump", "Clump", "Draw the hair to the middle of its lock; inverted: apart";
        Twist = "twist", "Twist", "Turn the lock about its own middle; inverted: the other way";
        Curl = "curl", "Curl", "Roll the hair up; inverted: the other way";
        Part = "part", "Part", "Lay the hair to the two sides of the stroke";
        Length = "length", "Length", "Let the hair grow; inverted: shrink it";
        Cut = "cut", "Cut", "Cut the hair off where the pointer crosses it; inverted: let cut hair come back";
        Add = "add", "Add", "Plant hair: bring back what was deleted, then let more grow than the style has; inverted: delete";
        Delete = "delete", "Delete", "Take hair away; inverted: bring it back";
        Slide = "slide", "Slide roots", "Move the roots over the scalp";
        Freeze = "freeze", "Freeze", "Frozen hair is left alone by every brush; inverted: thaw it";
        Mask = "mask", "Mask", "Where this sculpt layer acts less, when it is masked; inverted: act again";
    }
}

/// A hair under a brush.
#[derive(Debug)]
pub struct Hair<'a> {
    /// Root first; head space, centimetres. Mirrored for the other side of a symmetric stroke.
    pub points: &'a mut [Vec3; K],
    /// How strongly the dab acts on each point, 0-1; less on frozen hair.
    pub weights: [f32; K],
    /// Out of the scalp at the root.
    pub normal: Vec3,
    /// Share of the path that is there to be seen, and of that without any cut.
    pub shown: f32,
    pub left: f32,
    pub numbers: &'a mut Numbers,
}

/// A hair's numbers in the sculpt layer, as in [`super::SculptGuide`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Numbers {
    pub length: f32,
    pub cut: f32,
    pub keep: f32,
    pub frozen: f32,
    pub masked: f32,
}

impl Hair<'_> {
    /// How strongly the dab acts on the hair as a whole.
    pub fn weight(&self) -> f32 {
        self.weights.iter().copied().fold(0.0, f32::max)
    }
}

/// One touch of the brush.
#[derive(Debug, Clone, Copy)]
pub struct Dab<'a> {
    pub view: &'a View,
    /// Where the pointer is and where it was one dab before, points of the window.
    pub at: Vec2,
    pub before: Vec2,
    /// The place under the pointer, head space.
    pub centre: Vec3,
    /// Of the brush at its centre.
    pub radius_cm: f32,
    /// Under the pen's pressure.
    pub brush: Brush,
    pub is_inverted: bool,
    pub field: Option<&'a DistanceField>,
    /// The mean of the hair under the brush, for brushes that gather it.
    pub lock: Option<&'a [Vec3; K]>,
    /// Everything is mirrored at X = 0, but not the distance field.
    pub is_mirrored: bool,
}

impl Dab<'_> {
    /// -1 for the opposite of what the brush does, else 1.
    pub fn sign(&self) -> f32 {
        if self.is_inverted { -1.0 } else { 1.0 }
    }

    /// Falloff at a place, without the strength: 0 outside the brush.
    pub fn reach(&self, p: Vec3) -> f32 {
        let x = match self.brush.space {
            BrushSpace::Surface => p.distance(self.centre) / self.radius_cm.max(1e-4),
            BrushSpace::Screen => {
                let Some(at) = self.view.project(p) else { return 0.0 };
                at.distance(self.at) / self.brush.radius_points.max(1e-4)
            }
        };
        self.brush.falloff.at(x)
    }

    /// How strongly the dab acts on a place of a hair whose scalp faces along `normal`.
    pub fn weight(&self, p: Vec3, normal: Vec3) -> f32 {
        let reach = self.reach(p);
        if reach <= 0.0 {
            return 0.0;
        }
        self.brush.strength * reach * self.facing(p, normal)
    }

    /// 1 in front of the head, 0 behind it, where back faces are left out.
    fn facing(&self, p: Vec3, normal: Vec3) -> f32 {
        if self.brush.has_back_faces {
            return 1.0;
        }
        let towards_eye = (self.view.eye - p).normalize_or(-self.view.forward);
        let x = ((self.outwards(p, normal).dot(towards_eye) + 0.15) / 0.3).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    }

    /// Unit vector away from the head.
    pub fn outwards(&self, p: Vec3, normal: Vec3) -> Vec3 {
        let Some(field) = self.field else { return normal };
        let mirror = |v: Vec3| if self.is_mirrored { mirrored(v) } else { v };
        mirror(field.gradient(mirror(p))).normalize_or(normal)
    }

    /// What the pointer's movement since the last dab is at a place.
    pub fn movement_at(&self, p: Vec3) -> Vec3 {
        self.view.move_at(p, self.at - self.before)
    }
}

pub(super) fn mirrored(v: Vec3) -> Vec3 {
    Vec3::new(-v.x, v.y, v.z)
}

impl SculptBrush {
    /// Let a dab act on a hair.
    pub fn act(self, hair: &mut Hair<'_>, dab: &Dab<'_>) {
        match self {
            Self::Comb => comb::comb(hair, dab),
            Self::Smooth => smooth::smooth(hair, dab),
            Self::Puff => puff::puff(hair, dab),
            Self::Pinch => pinch::pinch(hair, dab),
            Self::Clump => clump::clump(hair, dab),
            Self::Twist => twist::twist(hair, dab),
            Self::Curl => curl::curl(hair, dab),
            Self::Part => part::part(hair, dab),
            Self::Length => length::length(hair, dab),
            Self::Cut => cut::cut(hair, dab),
            Self::Add => add::add(hair, dab),
            Self::Delete => delete::delete(hair, dab),
            Self::Slide => slide::slide(hair, dab),
            Self::Freeze => freeze::freeze(hair, dab),
            Self::Mask => mask::mask(hair, dab),
        }
    }

    /// Whether it gathers hair about the mean of all under the brush.
    pub fn needs_lock(self) -> bool {
        matches!(self, Self::Smooth | Self::Clump | Self::Twist)
    }

    /// What becomes of hair beyond the brush.
    pub fn follow(self) -> Follow {
        match self {
            Self::Comb | Self::Puff | Self::Pinch | Self::Clump | Self::Part => Follow::Pulled,
            Self::Smooth | Self::Twist | Self::Curl | Self::Length | Self::Slide
            // And those that move nothing.
            | Self::Cut | Self::Add | Self::Delete | Self::Freeze | Self::Mask => Follow::Turned,
        }
    }

    /// Whether it acts on frozen hair too.
    pub fn ignores_frozen(self) -> bool {
        matches!(self, Self::Freeze | Self::Mask)
    }
}
