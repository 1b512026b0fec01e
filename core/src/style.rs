//! The style stack: what happens to a strand after it was traced or interpolated.
//!
//! Operators work in the strand's own frame, so that moving the hair mesh carries the style along.

use serde::{Deserialize, Serialize};

use crate::look::{Param, ParamValue};

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

impl StyleKind {
    /// One of each, with parameters that show what it does.
    pub const DEFAULTS: [Self; 6] = [
        Self::Length { variation: 0.2 },
        Self::Clump { strands_per_clump: 60.0 },
        Self::Wave { amplitude: 0.4, wavelength: 4.0, strands_per_clump: 200.0 },
        Self::Curl { radius: 0.4, pitch: 2.0, strands_per_clump: 40.0 },
        Self::Frizz { amplitude: 0.1, wavelength: 1.5 },
        Self::Deviate { share: 0.1, amplitude: 1.0 },
    ];

    pub fn label(&self) -> &'static str {
        match self {
            Self::Length { .. } => "Length",
            Self::Clump { .. } => "Clump",
            Self::Wave { .. } => "Wave",
            Self::Curl { .. } => "Curl",
            Self::Frizz { .. } => "Frizz",
            Self::Deviate { .. } => "Deviate",
        }
    }
}

impl StyleOp {
    /// An operator over the whole strand that grows towards the tip.
    pub fn new(kind: StyleKind) -> Self {
        Self { on: true, strength: 1.0, from: 0.0, ramp: 1.0, seed: 0, kind }
    }

    /// Every number of the operator with its range and unit, for panels.
    #[rustfmt::skip]
    pub fn params(&mut self) -> Vec<Param<'_>> {
        fn number<'a>(key: &str, label: &'static str, unit: &'static str, (min, max): (f32, f32), value: &'a mut f32, help: &'static str) -> Param<'a> {
            Param { key: format!("style.{key}"), label, unit, min, max, of: &[], help, value: ParamValue::F32(value) }
        }
        let mut params = vec![number("strength", "Strength", "", (0.0, 1.0), &mut self.strength, "0 leaves the strands as they were")];
        match &mut self.kind {
            StyleKind::Length { variation } => {
                params.push(number("variation", "Variation", "", (0.0, 1.0), variation, "Share of its length that a strand may lose"));
            }
            StyleKind::Clump { strands_per_clump } => {
                params.push(number("clump", "Strands a clump", "", (2.0, 5000.0), strands_per_clump, "How many strands gather"));
            }
            StyleKind::Wave { amplitude, wavelength, strands_per_clump } => {
                params.push(number("amplitude", "Amplitude", "cm", (0.0, 5.0), amplitude, "From the strand to the crest"));
                params.push(number("wavelength", "Wavelength", "cm", (0.2, 30.0), wavelength, "From crest to crest"));
                params.push(number("clump", "Strands in phase", "", (1.0, 5000.0), strands_per_clump, "How many strands wave together"));
            }
            StyleKind::Curl { radius, pitch, strands_per_clump } => {
                params.push(number("radius", "Radius", "cm", (0.0, 5.0), radius, "Of the helix"));
                params.push(number("pitch", "Pitch", "cm", (0.1, 30.0), pitch, "Length of one turn"));
                params.push(number("clump", "Strands in phase", "", (1.0, 5000.0), strands_per_clump, "How many strands curl together"));
            }
            StyleKind::Frizz { amplitude, wavelength } => {
                params.push(number("amplitude", "Amplitude", "cm", (0.0, 3.0), amplitude, "From where the strand was"));
                params.push(number("wavelength", "Feature size", "cm", (0.1, 10.0), wavelength, "Small is fuzzy, large is unruly"));
            }
            StyleKind::Deviate { share, amplitude } => {
                params.push(number("share", "Share", "of the strands", (0.0, 1.0), share, "How many strands leave the others"));
                params.push(number("amplitude", "Amplitude", "cm", (0.0, 10.0), amplitude, "How far at the tip"));
            }
        }
        params.push(number("from", "From", "root to tip", (0.0, 1.0), &mut self.from, "Where along the strand it begins"));
        params.push(number("ramp", "Ramp", "", (0.0, 8.0), &mut self.ramp, "0 at once; 1 steadily; more: only at the tip"));
        params.push(Param { key: "style.seed".to_owned(), label: "Seed", unit: "", min: 0.0, max: 9999.0, of: &[], help: "Another throw of the dice", value: ParamValue::U32(&mut self.seed) });
        params
    }
}
