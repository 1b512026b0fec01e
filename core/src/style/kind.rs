//! What an operator of the stack does, and the numbers that each kind has.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::look::{Choice, ChoiceInfo, Param, ParamValue, choices};

choices! {
    /// How an operator joins those before it in the stack.
    #[derive(Default)]
    Blend {
        #[default]
        Add = "add", "Add", "On top of what the operators before it did";
        Replace = "replace", "Replace", "What the operators before it did fades out as this one fades in";
        Modulate = "modulate", "Modulate", "Makes what the operators before it did larger and smaller along the strand, and adds nothing itself";
    }
}

/// What an operator does. Lengths in centimetres.
///
/// `strands_per_clump` is the size of the group that shares an operator's random numbers: at 1 every
/// strand has its own.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum StyleKind {
    /// Shorten by a random share of the length, up to `variation` (0-1): layered ends. The cut is made
    /// in the strand's parameter, the shape below it stays.
    Length { variation: f32, strands_per_clump: f32 },
    /// Pull strands to the strand in the middle of their clump. `flare` (0-1) is the share of the pull
    /// that is gone again at the tip; `stray` (0-1) how much less some strands and some clumps follow.
    Clump { strands_per_clump: f32, flare: f32, stray: f32 },
    /// Sine waves in one plane of the strand's frame, in phase within a clump.
    Wave { amplitude: f32, wavelength: f32, strands_per_clump: f32 },
    /// Helix around the strand, in phase within a clump. `loosen` (0-1): how much wider and longer a
    /// turn is at the tip than at the root.
    Curl { radius: f32, pitch: f32, strands_per_clump: f32, loosen: f32 },
    /// Smooth noise across the strand, `amplitude` from rest, one feature every `wavelength`. With many
    /// strands in a clump whole locks wander.
    Frizz { amplitude: f32, wavelength: f32, strands_per_clump: f32 },
    /// Bend a random `share` (0-1) of the strands away by up to `amplitude` at the tip. `lift` (-1 to 1)
    /// turns the bend from any side (0) to away from the head (1): fly-aways. `whole` (0-1): at 0 each leaves
    /// the others somewhere along the strand, at 1 all leave at the root. Two of these, 30 % of the tips and
    /// 10 % of whole strands, are the deviations of Tariq and Bavoil 2008 after Choe and Ko 2005.
    Deviate {
        share: f32,
        amplitude: f32,
        lift: f32,
        #[serde(default)]
        whole: f32,
    },
    /// Turn the strand's segments towards a direction and keep their lengths, a whole lock alike. The direction
    /// is given on the head: `heading_deg` 0 is the front, 90 the model's left; `elevation_deg` 90 is up.
    /// `gravity` (0-1) exchanges it for straight down in the world. `variation` (0-1): how much less some locks bend.
    Bend { heading_deg: f32, elevation_deg: f32, gravity: f32, variation: f32, strands_per_clump: f32 },
    /// Iron the strand: its path becomes a mean over `reach` (share of its length, 0-1) to both sides, and what the
    /// operators before it did goes flat.
    Smooth { reach: f32 },
    /// Turn strands away from a line over the scalp, to the side that they grow on. The line runs from front to
    /// back at `offset` towards the model's left, turned by `turn_deg` about the vertical; strands farther than
    /// `width` from it stay as they were.
    Part { offset: f32, turn_deg: f32, width: f32 },
    /// Wisps: strands leave their own path for the wisp's, over the first `gather` (share of the length), and lie
    /// around it within `radius` times the operator's strength from root to tip (Yuksel, Schaefer and Keyser 2009,
    /// fig. 9, after Choe and Ko 2005). `fuzz` (0-1): how far strands stand out and wander; `twist`: turns of the
    /// wisp about itself, root to tip; `length_variation` (0-1): share of their length that strands may lack. The
    /// operators before it in the stack act on the wisp's curve, so on the whole wisp alike.
    Wisp { strands_per_clump: f32, radius: f32, gather: f32, fuzz: f32, twist: f32, length_variation: f32 },
}

impl StyleKind {
    /// One of each, with parameters that show what it does.
    pub const DEFAULTS: [Self; 10] = [
        Self::Clump { strands_per_clump: 40.0, flare: 0.2, stray: 0.3 },
        Self::Length { variation: 0.15, strands_per_clump: 1.0 },
        Self::Wave { amplitude: 0.5, wavelength: 6.0, strands_per_clump: 800.0 },
        Self::Curl { radius: 0.6, pitch: 2.0, strands_per_clump: 60.0, loosen: 0.3 },
        Self::Frizz { amplitude: 0.1, wavelength: 2.0, strands_per_clump: 1.0 },
        Self::Deviate { share: 0.02, amplitude: 2.0, lift: 0.5, whole: 0.0 },
        Self::Bend { heading_deg: 0.0, elevation_deg: -90.0, gravity: 1.0, variation: 0.3, strands_per_clump: 200.0 },
        Self::Smooth { reach: 0.3 },
        Self::Part { offset: 0.0, turn_deg: 0.0, width: 4.0 },
        Self::Wisp {
            strands_per_clump: 100.0,
            radius: 0.6,
            gather: 0.25,
            fuzz: 0.2,
            twist: 0.3,
            length_variation: 0.1,
        },
    ];

    pub fn label(&self) -> &'static str {
        match self {
            Self::Length { .. } => "Length",
            Self::Clump { .. } => "Clump",
            Self::Wave { .. } => "Wave",
            Self::Curl { .. } => "Curl",
            Self::Frizz { .. } => "Frizz",
            Self::Deviate { .. } => "Deviate",
            Self::Bend { .. } => "Bend",
            Self::Smooth { .. } => "Smooth",
            Self::Part { .. } => "Part",
            Self::Wisp { .. } => "Wisp",
        }
    }

    pub fn help(&self) -> &'static str {
        match self {
            Self::Length { .. } => "Shorten strands by a random share of their length",
            Self::Clump { .. } => "Gather strands around the middle one of their clump",
            Self::Wave { .. } => "Waves in one plane",
            Self::Curl { .. } => "Helix around the strand's path",
            Self::Frizz { .. } => "Smooth noise across the strand",
            Self::Deviate { .. } => "Bend some strands away: loose tips, strays, fly-aways",
            Self::Bend { .. } => "Turn whole locks towards a direction or the ground, keeping their length",
            Self::Smooth { .. } => "Iron the path, and flatten what the operators above did",
            Self::Part { .. } => "Turn strands away from a line over the scalp, to their own side",
            Self::Wisp { .. } => "Gather strands into wisps; the operators above act on whole wisps",
        }
    }

    /// Ways to join the operators before it that mean something for the kind; the first is the usual one.
    pub fn blends(&self) -> &'static [Blend] {
        match self {
            // A periodic or noisy shape can also swell and calm what is there.
            Self::Wave { .. } | Self::Curl { .. } | Self::Frizz { .. } => {
                &[Blend::Add, Blend::Replace, Blend::Modulate]
            }
            // Replace: the cuts, clumps or displacements before are forgotten.
            Self::Length { .. } | Self::Clump { .. } | Self::Deviate { .. } => &[Blend::Add, Blend::Replace],
            // Each works on the path that is there.
            Self::Bend { .. } | Self::Smooth { .. } | Self::Part { .. } | Self::Wisp { .. } => &[Blend::Add],
        }
    }

    /// How many strands share the operator's random numbers, where the kind has such groups.
    fn clump_mut(&mut self) -> Option<&mut f32> {
        match self {
            Self::Length { strands_per_clump, .. }
            | Self::Clump { strands_per_clump, .. }
            | Self::Wave { strands_per_clump, .. }
            | Self::Curl { strands_per_clump, .. }
            | Self::Frizz { strands_per_clump, .. }
            | Self::Bend { strands_per_clump, .. }
            | Self::Wisp { strands_per_clump, .. } => Some(strands_per_clump),
            Self::Deviate { .. } | Self::Smooth { .. } | Self::Part { .. } => None,
        }
    }

    /// As many clumps for a share of the strands.
    pub fn scale_clumps(&mut self, share: f32) {
        if let Some(strands_per_clump) = self.clump_mut() {
            *strands_per_clump = (*strands_per_clump * share).max(1.0);
        }
    }

    /// How many strands share the operator's random numbers; at least 1.
    pub fn strands_per_clump(mut self) -> f32 {
        self.clump_mut().map_or(1.0, |strands_per_clump| strands_per_clump.max(1.0))
    }

    /// The kind's own numbers with their ranges and units.
    #[rustfmt::skip]
    pub(super) fn params(&mut self) -> Vec<Param<'_>> {
        match self {
            Self::Length { variation, strands_per_clump } => vec![
                number("variation", "Variation", "", (0.0, 1.0), variation, "Share of its length that a strand may lose"),
                clump(strands_per_clump),
            ],
            Self::Clump { strands_per_clump, flare, stray } => vec![
                clump(strands_per_clump),
                number("flare", "Flare", "", (0.0, 1.0), flare, "Share of the pull that is gone again at the tip"),
                number("stray", "Stray", "", (0.0, 1.0), stray, "How much less some strands and some clumps follow"),
            ],
            Self::Wave { amplitude, wavelength, strands_per_clump } => vec![
                number("amplitude", "Amplitude", "cm", (0.0, 5.0), amplitude, "From the strand's path to the crest"),
                number("wavelength", "Wavelength", "cm", (0.2, 40.0), wavelength, "From crest to crest"),
                clump(strands_per_clump),
            ],
            Self::Curl { radius, pitch, strands_per_clump, loosen } => vec![
                number("radius", "Radius", "cm", (0.0, 5.0), radius, "Of the helix"),
                number("pitch", "Pitch", "cm", (0.2, 20.0), pitch, "Length of one turn"),
                clump(strands_per_clump),
                number("loosen", "Loosen", "", (0.0, 1.0), loosen, "How much wider and longer a turn is at the tip"),
            ],
            Self::Frizz { amplitude, wavelength, strands_per_clump } => vec![
                number("amplitude", "Amplitude", "cm", (0.0, 5.0), amplitude, "From the strand's path"),
                number("wavelength", "Feature size", "cm", (0.1, 40.0), wavelength, "Small is fuzzy, large is unruly"),
                clump(strands_per_clump),
            ],
            Self::Deviate { share, amplitude, lift, whole } => vec![
                number("share", "Share", "of the strands", (0.0, 1.0), share, "How many strands leave the others"),
                number("amplitude", "Amplitude", "cm", (0.0, 10.0), amplitude, "How far at the tip"),
                number("lift", "Lift", "", (-1.0, 1.0), lift, "0 to any side, 1 away from the head"),
                number("whole", "Whole strand", "", (0.0, 1.0), whole, "0: each leaves the others somewhere on its way; 1: all leave at the root"),
            ],
            Self::Bend { heading_deg, elevation_deg, gravity, variation, strands_per_clump } => vec![
                number("heading", "Heading", "deg", (-180.0, 180.0), heading_deg, "Where to, around the head: 0 the front, 90 the model's left"),
                number("elevation", "Elevation", "deg", (-90.0, 90.0), elevation_deg, "-90 down, 0 level, 90 up"),
                number("gravity", "Gravity", "", (0.0, 1.0), gravity, "1: straight down, however the head is turned; 0: the direction given"),
                number("variation", "Variation", "", (0.0, 1.0), variation, "How much less some locks bend"),
                clump(strands_per_clump),
            ],
            Self::Smooth { reach } => vec![
                number("reach", "Reach", "of the strand", (0.0, 1.0), reach, "How long the bends are that are ironed out"),
            ],
            Self::Part { offset, turn_deg, width } => vec![
                number("offset", "Offset", "cm", (-12.0, 12.0), offset, "Of the line from the middle of the head, towards the model's left"),
                number("turn", "Turn", "deg", (-90.0, 90.0), turn_deg, "0: the line runs from front to back; 90: from ear to ear"),
                number("width", "Width", "cm", (0.2, 20.0), width, "Strands farther from the line stay as they were"),
            ],
            Self::Wisp { strands_per_clump, radius, gather, fuzz, twist, length_variation } => vec![
                Param { label: "Strands a wisp", help: "How many strands lie around one wisp curve", ..clump(strands_per_clump) },
                number("radius", "Radius", "cm", (0.0, 5.0), radius, "Of a wisp, times the curve from root to tip"),
                number("gather", "Gather", "of the strand", (0.01, 1.0), gather, "How much of the strand it takes from its root to the wisp"),
                number("fuzz", "Fuzz", "", (0.0, 1.0), fuzz, "How far strands stand out of the wisp and wander"),
                number("twist", "Twist", "turns", (-5.0, 5.0), twist, "Of the wisp about itself, root to tip"),
                number("shorten", "Shorten", "", (0.0, 1.0), length_variation, "Share of their length that strands may lack"),
            ],
        }
    }
}

pub(super) fn number<'a>(
    key: &str,
    label: &'static str,
    unit: &'static str,
    (min, max): (f32, f32),
    value: &'a mut f32,
    help: &'static str,
) -> Param<'a> {
    Param { key: format!("style.{key}"), label, unit, min, max, of: &[], help, value: ParamValue::F32(value) }
}

fn clump(value: &mut f32) -> Param<'_> {
    let help = "How many strands share the operator's random numbers";
    number("clump", "Strands a clump", "", (1.0, 20_000.0), value, help)
}

/// Unit vector on the head: `heading_deg` 0 is +Z (front), 90 is +X (the model's left); `elevation_deg` 90 is +Y.
pub fn direction(heading_deg: f32, elevation_deg: f32) -> Vec3 {
    let (sin, cos) = heading_deg.to_radians().sin_cos();
    let (up, level) = elevation_deg.to_radians().sin_cos();
    Vec3::new(sin * level, up, cos * level)
}
