//! The style stack: what happens to a strand after it was traced or interpolated.
//!
//! Operators work in the strand's own frame, so that moving the hair mesh carries the style along.

use serde::{Deserialize, Serialize};

/// One operator of the stack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StyleOp {
    pub on: bool,
    /// 0 leaves the strand as it was, 1 is the operator's full effect.
    pub strength: f32,
    /// Where along the strand the operator begins, 0 root to 1 tip.
    pub from: f32,
    /// How its effect grows from there to the tip: (t - from)^ramp, 0 a constant.
    pub ramp: f32,
    pub seed: u32,
    pub kind: StyleKind,
}

/// What an operator does. Lengths in centimetres.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum StyleKind {
    /// Shorten each strand by a random share of its length, up to `variation` (0-1).
    Length { variation: f32 },
    /// Pull strands to the strand in the middle of their clump.
    Clump { strands_per_clump: f32 },
    /// Sine waves in one plane of the strand's frame, in phase within a clump of `strands_per_clump`.
    Wave { amplitude: f32, wavelength: f32, strands_per_clump: f32 },
    /// Helix around the strand, in phase within a clump of `strands_per_clump`.
    Curl { radius: f32, pitch: f32, strands_per_clump: f32 },
    /// Smooth noise, `amplitude` from rest, one feature every `wavelength`.
    Frizz { amplitude: f32, wavelength: f32 },
    /// Bend a random `share` (0-1) of the strands away, by up to `amplitude` at the tip: tips and fly-aways.
    Deviate { share: f32, amplitude: f32 },
}
