//! The style stack: what happens to a strand after it was traced or interpolated.
//!
//! Operators work along the strand's own path and in its own twist-free frame, so that moving the hair
//! mesh or the head carries the style along. Clumps move the path itself, towards the path of the strand
//! in the middle of the clump; every other operator displaces the strand around its path, and these
//! displacements add up. So a clump gathers strands without ironing their waves, and the order of the
//! stack matters only among clumps: coarse locks first, fine clumps after them.
//!
//! Displacing points by a noise over space was rejected: a small move of the hair mesh would change the
//! shape of every strand (Yuksel, Schaefer and Keyser 2009, section 3.4).

use serde::{Deserialize, Serialize};

use crate::look::{Param, ParamValue};

/// One operator of the stack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StyleOp {
    pub on: bool,
    /// 0 leaves the strand as it was, 1 is the operator's full effect.
    pub strength: f32,
    /// Where along the strand the operator begins, 0 root to 1 tip.
    pub from: f32,
    /// How its effect grows from there to the tip: x^ramp with x from 0 to 1; 0 is a constant.
    pub ramp: f32,
    pub seed: u32,
    pub kind: StyleKind,
}

impl Default for StyleOp {
    fn default() -> Self {
        Self::new(StyleKind::DEFAULTS[0])
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
    /// turns the bend from any side (0) to away from the head (1): fly-aways.
    Deviate { share: f32, amplitude: f32, lift: f32 },
}

impl StyleKind {
    /// One of each, with parameters that show what it does.
    pub const DEFAULTS: [Self; 6] = [
        Self::Clump { strands_per_clump: 40.0, flare: 0.2, stray: 0.3 },
        Self::Length { variation: 0.15, strands_per_clump: 1.0 },
        Self::Wave { amplitude: 0.5, wavelength: 6.0, strands_per_clump: 800.0 },
        Self::Curl { radius: 0.6, pitch: 2.0, strands_per_clump: 60.0, loosen: 0.3 },
        Self::Frizz { amplitude: 0.1, wavelength: 2.0, strands_per_clump: 1.0 },
        Self::Deviate { share: 0.02, amplitude: 2.0, lift: 0.5 },
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

    pub fn help(&self) -> &'static str {
        match self {
            Self::Length { .. } => "Shorten strands by a random share of their length",
            Self::Clump { .. } => "Gather strands around the middle one of their clump",
            Self::Wave { .. } => "Waves in one plane",
            Self::Curl { .. } => "Helix around the strand's path",
            Self::Frizz { .. } => "Smooth noise across the strand",
            Self::Deviate { .. } => "Bend some strands away: loose tips, fly-aways",
        }
    }

    /// As many clumps for a share of the strands.
    pub fn scale_clumps(&mut self, share: f32) {
        match self {
            Self::Length { strands_per_clump, .. }
            | Self::Clump { strands_per_clump, .. }
            | Self::Wave { strands_per_clump, .. }
            | Self::Curl { strands_per_clump, .. }
            | Self::Frizz { strands_per_clump, .. } => *strands_per_clump = (*strands_per_clump * share).max(1.0),
            Self::Deviate { .. } => {}
        }
    }

    /// How many strands share the operator's random numbers; at least 1.
    pub fn strands_per_clump(self) -> f32 {
        match self {
            Self::Length { strands_per_clump, .. }
            | Self::Clump { strands_per_clump, .. }
            | Self::Wave { strands_per_clump, .. }
            | Self::Curl { strands_per_clump, .. }
            | Self::Frizz { strands_per_clump, .. } => strands_per_clump.max(1.0),
            Self::Deviate { .. } => 1.0,
        }
    }
}

impl StyleOp {
    /// The operator along the whole strand at full strength.
    pub fn new(kind: StyleKind) -> Self {
        let ramp = match kind {
            StyleKind::Clump { .. } | StyleKind::Frizz { .. } | StyleKind::Wave { .. } => 1.0,
            StyleKind::Deviate { .. } => 2.0,
            StyleKind::Length { .. } | StyleKind::Curl { .. } => 0.0,
        };
        Self { on: true, strength: 1.0, from: 0.0, ramp, seed: 0, kind }
    }

    /// Whether it does anything.
    pub fn is_active(&self) -> bool {
        self.on && self.strength != 0.0
    }

    /// Every number of the operator with its range and unit, for panels.
    #[rustfmt::skip]
    pub fn params(&mut self) -> Vec<Param<'_>> {
        fn number<'a>(key: &str, label: &'static str, unit: &'static str, (min, max): (f32, f32), value: &'a mut f32, help: &'static str) -> Param<'a> {
            Param { key: format!("style.{key}"), label, unit, min, max, of: &[], help, value: ParamValue::F32(value) }
        }
        fn clump(value: &mut f32) -> Param<'_> {
            number("clump", "Strands a clump", "", (1.0, 20_000.0), value, "How many strands share the operator's random numbers")
        }
        let mut params = vec![number("strength", "Strength", "", (0.0, 1.0), &mut self.strength, "0 leaves the strands as they were")];
        params.extend(match &mut self.kind {
            StyleKind::Length { variation, strands_per_clump } => vec![
                number("variation", "Variation", "", (0.0, 1.0), variation, "Share of its length that a strand may lose"),
                clump(strands_per_clump),
            ],
            StyleKind::Clump { strands_per_clump, flare, stray } => vec![
                clump(strands_per_clump),
                number("flare", "Flare", "", (0.0, 1.0), flare, "Share of the pull that is gone again at the tip"),
                number("stray", "Stray", "", (0.0, 1.0), stray, "How much less some strands and some clumps follow"),
            ],
            StyleKind::Wave { amplitude, wavelength, strands_per_clump } => vec![
                number("amplitude", "Amplitude", "cm", (0.0, 5.0), amplitude, "From the strand's path to the crest"),
                number("wavelength", "Wavelength", "cm", (0.2, 40.0), wavelength, "From crest to crest"),
                clump(strands_per_clump),
            ],
            StyleKind::Curl { radius, pitch, strands_per_clump, loosen } => vec![
                number("radius", "Radius", "cm", (0.0, 5.0), radius, "Of the helix"),
                number("pitch", "Pitch", "cm", (0.2, 20.0), pitch, "Length of one turn"),
                clump(strands_per_clump),
                number("loosen", "Loosen", "", (0.0, 1.0), loosen, "How much wider and longer a turn is at the tip"),
            ],
            StyleKind::Frizz { amplitude, wavelength, strands_per_clump } => vec![
                number("amplitude", "Amplitude", "cm", (0.0, 5.0), amplitude, "From the strand's path"),
                number("wavelength", "Feature size", "cm", (0.1, 40.0), wavelength, "Small is fuzzy, large is unruly"),
                clump(strands_per_clump),
            ],
            StyleKind::Deviate { share, amplitude, lift } => vec![
                number("share", "Share", "of the strands", (0.0, 1.0), share, "How many strands leave the others"),
                number("amplitude", "Amplitude", "cm", (0.0, 10.0), amplitude, "How far at the tip"),
                number("lift", "Lift", "", (-1.0, 1.0), lift, "0 to any side, 1 away from the head"),
            ],
        });
        params.push(number("from", "From", "root to tip", (0.0, 1.0), &mut self.from, "Where along the strand it begins"));
        params.push(number("ramp", "Ramp", "", (0.0, 8.0), &mut self.ramp, "0 at once; 1 steadily; more: only at the tip"));
        params.push(Param { key: "style.seed".to_owned(), label: "Seed", unit: "", min: 0.0, max: 9999.0, of: &[], help: "Another throw of the dice", value: ParamValue::U32(&mut self.seed) });
        params
    }

    /// The operator's effect at parameter `t` of the strand, 0 root to 1 tip.
    pub fn envelope(&self, t: f32) -> f32 {
        envelope(self.strength, self.from, self.ramp, t)
    }
}

/// Clump operators that take part in one stack.
pub const MOST_CLUMP_OPS: usize = 3;
/// Operators that displace strands and take part in one stack.
pub const MOST_DISPLACING_OPS: usize = 12;

/// Which operators of a stack take no part, because as many of their sort as there is room for come before them; in
/// words for the user, or `None`.
pub fn left_out(stack: &[StyleOp]) -> Option<String> {
    let (mut n_clumps, mut n_displacing) = (0, 0);
    let mut names = Vec::new();
    for (op_idx, op) in stack.iter().enumerate().filter(|(_, op)| op.is_active()) {
        let takes_part = match op.kind {
            StyleKind::Length { .. } => true,
            StyleKind::Clump { .. } => {
                n_clumps += 1;
                n_clumps <= MOST_CLUMP_OPS
            }
            StyleKind::Wave { .. } | StyleKind::Curl { .. } | StyleKind::Frizz { .. } | StyleKind::Deviate { .. } => {
                n_displacing += 1;
                n_displacing <= MOST_DISPLACING_OPS
            }
        };
        if !takes_part {
            names.push(format!("{} ({})", op_idx + 1, op.kind.label()));
        }
    }
    (!names.is_empty()).then(|| {
        format!(
            "no room for operator {} of its style: a stack has room for {MOST_CLUMP_OPS} clumps and {MOST_DISPLACING_OPS} operators that displace strands. Switch others off or remove them.",
            names.join(", ")
        )
    })
}

/// Strength * x^ramp, where x grows from 0 at `from` to 1 at the tip. Twin of `envelope` in generate.wgsl.
pub fn envelope(strength: f32, from: f32, ramp: f32, t: f32) -> f32 {
    if t < from {
        return 0.0;
    }
    if ramp <= 0.0 {
        return strength;
    }
    let x = ((t - from) / (1.0 - from).max(1e-4)).clamp(0.0, 1.0);
    strength * if x > 0.0 { x.powf(ramp) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn envelope_grows_from_its_start_to_its_strength() {
        let op = StyleOp { strength: 0.8, from: 0.25, ramp: 2.0, ..StyleOp::default() };
        assert_eq!(op.envelope(0.2), 0.0);
        assert!((op.envelope(0.625) - 0.2).abs() < 1e-6);
        assert!((op.envelope(1.0) - 0.8).abs() < 1e-6);
        assert_eq!(StyleOp { ramp: 0.0, ..op }.envelope(0.25), 0.8);
    }

    #[test]
    fn operators_without_room_are_named_and_idle_ones_take_none() {
        let clump = || StyleOp::new(StyleKind::DEFAULTS[0]);
        let wave = || StyleOp::new(StyleKind::DEFAULTS[2]);
        let length = || StyleOp::new(StyleKind::DEFAULTS[1]);
        let mut stack = vec![clump(), clump(), StyleOp { on: false, ..clump() }, length(), clump()];
        stack.extend((0..12).map(|_| wave()));
        stack.push(StyleOp { strength: 0.0, ..wave() });
        assert_eq!(left_out(&stack), None);
        stack.push(wave());
        stack.insert(0, clump());
        let words = left_out(&stack).unwrap();
        assert!(words.starts_with("no room for operator 6 (Clump), 20 (Wave) of its style"), "{words}");
    }

    #[test]
    fn every_kind_begins_within_its_ranges() {
        for kind in StyleKind::DEFAULTS {
            assert!(!kind.label().is_empty() && !kind.help().is_empty());
            for param in StyleOp::new(kind).params() {
                let value: f32 = param.value.to_text().parse().unwrap();
                assert!((param.min..=param.max).contains(&value), "{}", param.label);
            }
        }
    }
}
