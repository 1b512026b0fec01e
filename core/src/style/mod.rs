//! The style stack: what happens to a strand after it was traced or interpolated.
//!
//! Operators work along the strand's own path and in its own twist-free frame, so that moving the hair
//! mesh or the head carries the style along. Ironing, clumps and wisps move the path itself, the latter towards
//! the path of the strand in the middle; bends and partings turn it; every other operator displaces the strand
//! around its path. So a clump gathers strands without ironing their waves. Among operators of one sort the order
//! of the stack counts, and [`Blend`] says how each joins those before it: coarse locks first, fine clumps after
//! them; what stands before a wisp acts on whole wisps.
//!
//! Displacing points by a noise over space was rejected: a small move of the hair mesh would change the
//! shape of every strand (Yuksel, Schaefer and Keyser 2009, section 3.4).

use serde::{Deserialize, Serialize};

use crate::look::{Param, ParamValue};
use crate::maps::MapKind;

mod kind;
pub mod presets;
mod profile;

pub use kind::{Blend, StyleKind, direction};
pub use profile::{MOST_POINTS, N_TABLE, Profile, SHAPES, Shape, table_at};

/// One operator of the stack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct StyleOp {
    pub on: bool,
    /// Where any operator that is on is solo, only those act.
    pub solo: bool,
    /// Given by the artist; empty is the kind's.
    pub name: String,
    /// 0 leaves the strand as it was, 1 is the operator's full effect.
    pub strength: f32,
    /// Where along the strand the operator begins, 0 root to 1 tip.
    pub from: f32,
    /// How its effect grows from there to the tip: x^ramp with x from 0 to 1; 0 is a constant. Counts where no
    /// curve is drawn.
    pub ramp: f32,
    /// The effect from `from` to the tip, drawn by hand.
    pub curve: Profile,
    pub seed: u32,
    /// A painted map that says, strand by strand, what share of the strength there is.
    pub map: Option<MapKind>,
    /// How it joins the operators before it; [`StyleOp::blend`] says what counts.
    pub blend: Blend,
    pub kind: StyleKind,
}

impl Default for StyleOp {
    fn default() -> Self {
        Self::new(StyleKind::DEFAULTS[0])
    }
}

impl StyleOp {
    /// The operator along the whole strand at full strength.
    pub fn new(kind: StyleKind) -> Self {
        let ramp = match kind {
            StyleKind::Clump { .. } | StyleKind::Frizz { .. } | StyleKind::Wave { .. } | StyleKind::Bend { .. } => 1.0,
            StyleKind::Deviate { .. } => 2.0,
            StyleKind::Length { .. }
            | StyleKind::Curl { .. }
            | StyleKind::Smooth { .. }
            | StyleKind::Part { .. }
            | StyleKind::Wisp { .. } => 0.0,
        };
        let curve = match kind {
            StyleKind::Part { .. } => Profile::of(profile::ROOT),
            StyleKind::Wisp { .. } => Profile::of(profile::POINTED),
            StyleKind::Length { .. }
            | StyleKind::Clump { .. }
            | StyleKind::Wave { .. }
            | StyleKind::Curl { .. }
            | StyleKind::Frizz { .. }
            | StyleKind::Deviate { .. }
            | StyleKind::Bend { .. }
            | StyleKind::Smooth { .. } => Profile::default(),
        };
        let name = String::new();
        let (strength, from, seed, map, blend) = (1.0, 0.0, 0, None, Blend::Add);
        Self { on: true, solo: false, name, strength, from, ramp, curve, seed, map, blend, kind }
    }

    /// What the operator is called.
    pub fn label(&self) -> &str {
        if self.name.is_empty() { self.kind.label() } else { &self.name }
    }

    /// Whether it does anything.
    pub fn is_active(&self) -> bool {
        self.on && self.strength != 0.0
    }

    /// How it joins the operators before it: a way that means nothing for its kind counts as the usual one.
    pub fn blend(&self) -> Blend {
        let blends = self.kind.blends();
        if blends.contains(&self.blend) { self.blend } else { blends[0] }
    }

    /// Every number of the operator with its range and unit, for panels.
    #[rustfmt::skip]
    pub fn params(&mut self) -> Vec<Param<'_>> {
        let mut params = vec![kind::number("strength", "Strength", "", (0.0, 1.0), &mut self.strength, "0 leaves the strands as they were")];
        params.extend(self.kind.params());
        params.push(kind::number("from", "From", "root to tip", (0.0, 1.0), &mut self.from, "Where along the strand it begins"));
        params.push(kind::number("ramp", "Ramp", "", (0.0, 8.0), &mut self.ramp, "0 at once; 1 steadily; more: only at the tip. Counts where no curve is drawn"));
        params.push(Param { key: "style.seed".to_owned(), label: "Seed", unit: "", min: 0.0, max: 9999.0, of: &[], help: "Another throw of the dice", value: ParamValue::U32(&mut self.seed) });
        params
    }

    /// The operator's effect at parameter `t` of the strand, 0 root to 1 tip.
    pub fn envelope(&self, t: f32) -> f32 {
        let table = self.curve.table();
        Envelope { strength: self.strength, from: self.from, ramp: self.ramp, table: table.as_ref() }.at(t)
    }
}

/// The operators of a stack that act, each with its place: those that are on, and where any of them is solo, only
/// the solo ones. An operator that is off is not solo, so that switching it off never leaves the hair without style.
pub fn acting(stack: &[StyleOp]) -> impl Iterator<Item = (usize, &StyleOp)> + Clone {
    let any_solo = stack.iter().any(|op| op.on && op.solo);
    stack.iter().enumerate().filter(move |(_, op)| op.is_active() && (op.solo || !any_solo))
}

/// Clumps and wisps that take part in one stack.
pub const MOST_CLUMP_OPS: usize = 3;
/// Operators that displace, turn or iron strands and take part in one stack; wisps count here too.
pub const MOST_DISPLACING_OPS: usize = 12;
/// Operators that iron the path and take part in one stack.
pub const MOST_SMOOTH_OPS: usize = 1;

/// What of a stack acts and has room, in order, each with its place.
pub fn taking_part(stack: &[StyleOp]) -> Vec<(usize, &StyleOp)> {
    acting(stack).zip(has_room(stack)).filter(|(_, has_room)| *has_room).map(|(op, _)| op).collect()
}

/// For each acting operator whether there is room for it.
fn has_room(stack: &[StyleOp]) -> Vec<bool> {
    let (mut n_clumps, mut n_displacing, mut n_smooth) = (0, 0, 0);
    let mut room = Vec::new();
    for (_, op) in acting(stack) {
        let (clumps, displacing, smooth) = match op.kind {
            StyleKind::Length { .. } => (0, 0, 0),
            StyleKind::Clump { .. } => (1, 0, 0),
            StyleKind::Wisp { .. } => (1, 1, 0),
            StyleKind::Smooth { .. } => (0, 1, 1),
            StyleKind::Wave { .. }
            | StyleKind::Curl { .. }
            | StyleKind::Frizz { .. }
            | StyleKind::Deviate { .. }
            | StyleKind::Bend { .. }
            | StyleKind::Part { .. } => (0, 1, 0),
        };
        let has_room = n_clumps + clumps <= MOST_CLUMP_OPS
            && n_displacing + displacing <= MOST_DISPLACING_OPS
            && n_smooth + smooth <= MOST_SMOOTH_OPS;
        if has_room {
            n_clumps += clumps;
            n_displacing += displacing;
            n_smooth += smooth;
        }
        room.push(has_room);
    }
    room
}

/// Which operators of a stack take no part, because as many of their sort as there is room for come before them; in
/// words for the user, or `None`.
pub fn left_out(stack: &[StyleOp]) -> Option<String> {
    let names: Vec<String> = acting(stack)
        .zip(has_room(stack))
        .filter(|(_, has_room)| !has_room)
        .map(|((op_idx, op), _)| format!("{} ({})", op_idx + 1, op.label()))
        .collect();
    (!names.is_empty()).then(|| {
        format!(
            "no room for operator {} of its style: a stack has room for {MOST_CLUMP_OPS} clumps and wisps, {MOST_DISPLACING_OPS} operators that displace, turn or iron strands, and {MOST_SMOOTH_OPS} of these that irons. Switch others off or remove them.",
            names.join(", ")
        )
    })
}

/// How an effect runs along a strand.
#[derive(Debug, Clone, Copy, Default)]
pub struct Envelope<'a> {
    pub strength: f32,
    pub from: f32,
    pub ramp: f32,
    /// Counts in place of the ramp.
    pub table: Option<&'a [f32; N_TABLE]>,
}

impl Envelope<'_> {
    /// Strength times the table or x^ramp, where x grows from 0 at `from` to 1 at the tip. Twin of `envelope` in
    /// generate.wgsl.
    pub fn at(&self, t: f32) -> f32 {
        if t < self.from {
            return 0.0;
        }
        let x = ((t - self.from) / (1.0 - self.from).max(1e-4)).clamp(0.0, 1.0);
        if let Some(table) = self.table {
            return self.strength * table_at(table, x);
        }
        if self.ramp <= 0.0 {
            return self.strength;
        }
        self.strength * if x > 0.0 { x.powf(self.ramp) } else { 0.0 }
    }
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
        assert_eq!(StyleOp { ramp: 0.0, ..op.clone() }.envelope(0.25), 0.8);
        // A drawn curve counts in place of the ramp, from where the operator begins.
        let drawn = StyleOp { curve: Profile::of(&[[0.0, 1.0], [1.0, 0.5]]), ..op };
        assert_eq!(drawn.envelope(0.2), 0.0);
        assert!((drawn.envelope(0.625) - 0.6).abs() < 1e-6);
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
    fn solo_silences_the_others_and_an_operator_that_is_off_is_not_solo() {
        let mut stack: Vec<StyleOp> = StyleKind::DEFAULTS[..4].iter().map(|kind| StyleOp::new(*kind)).collect();
        let places = |stack: &[StyleOp]| acting(stack).map(|(place, _)| place).collect::<Vec<_>>();
        assert_eq!(places(&stack), [0, 1, 2, 3]);
        (stack[1].solo, stack[3].solo) = (true, true);
        assert_eq!(places(&stack), [1, 3]);
        stack[3].on = false;
        assert_eq!(places(&stack), [1]);
        stack[1].on = false;
        assert_eq!(places(&stack), [0, 2]);
    }

    #[test]
    fn an_operator_of_an_older_file_opens_as_it_was() {
        let text = "(on:true,strength:0.5,from:0.1,ramp:2.0,seed:7,kind:Deviate(share:0.1,amplitude:2.0,lift:0.5))";
        let op: StyleOp = ron::from_str(text).unwrap();
        let kind = StyleKind::Deviate { share: 0.1, amplitude: 2.0, lift: 0.5, whole: 0.0 };
        let expected = StyleOp { strength: 0.5, from: 0.1, ramp: 2.0, seed: 7, ..StyleOp::new(kind) };
        assert_eq!(op, expected);
        let drawn = StyleOp { curve: Profile::of(&[[0.0, 0.0], [0.3, 1.0], [1.0, 0.5]]), solo: true, ..expected };
        assert_eq!(ron::from_str::<StyleOp>(&ron::to_string(&drawn).unwrap()).unwrap(), drawn);
        // `Part` and `Wisp` have a curve of their own; a file without one means none.
        let text = "(kind:Part(offset:0.0,turn_deg:0.0,width:4.0))";
        assert!(ron::from_str::<StyleOp>(text).unwrap().curve.is_empty());
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
