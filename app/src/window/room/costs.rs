//! What each choice of the look costs here, to stand beside it: GPU time of the passes that answer its slot's question, and
//! the GPU memory that they hold, kept for every choice that was drawn of this groom at this size.

use std::collections::BTreeMap;

use lorelei_core::look::Look;

use crate::stage::report::FrameReport;
use crate::window::panels::widgets::{Note, Notes, mebibytes, milliseconds};

/// What one choice cost when it was drawn last.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    pub ms: f32,
    /// Where the memory is known apart from the rest.
    pub n_bytes: Option<u64>,
}

/// Memory that belongs to a slot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Memory {
    NotApart,
    OfDrawing,
    OfShadows,
}

/// How the cost of a slot is measured.
struct Measured {
    slot: &'static str,
    /// How its passes begin.
    passes: &'static [&'static str],
    memory: Memory,
    /// What that is, for the tooltip.
    what: &'static str,
}

/// Three slots decide about all of them together.
const DRAWING: &[&str] = lorelei_render::DRAWING_PASSES;

#[rustfmt::skip]
const MEASURED: &[Measured] = &[
    Measured { slot: "primitive", passes: DRAWING, memory: Memory::OfDrawing, what: "GPU time and memory of turning strands into pixels: drawing, antialiasing and transparency together" },
    Measured { slot: "antialiasing", passes: DRAWING, memory: Memory::OfDrawing, what: "GPU time and memory of turning strands into pixels: drawing, antialiasing and transparency together" },
    Measured { slot: "transparency", passes: DRAWING, memory: Memory::OfDrawing, what: "GPU time and memory of turning strands into pixels: drawing, antialiasing and transparency together" },
    Measured { slot: "rate", passes: &["shade"], memory: Memory::NotApart, what: "GPU time of shading vertices; what is shaded per fragment is a part of drawing" },
    Measured { slot: "scattering", passes: &["shade"], memory: Memory::NotApart, what: "GPU time of shading vertices; what is shaded per fragment is a part of drawing" },
    Measured { slot: "shadowing", passes: &["shadow"], memory: Memory::OfShadows, what: "GPU time of making the shadows of all lights, and their memory; looking them up is a part of shading" },
    Measured { slot: "head", passes: &["head"], memory: Memory::NotApart, what: "GPU time of drawing and lighting the head" },
    Measured { slot: "tonemapping", passes: &["resolve"], memory: Memory::NotApart, what: "GPU time of putting hair, head and background together and tonemapping them" },
    Measured { slot: "view", passes: &["view"], memory: Memory::NotApart, what: "GPU time of painting strands and counting them" },
];

/// Where passes take a smaller share than this of what they took before, they recorded nothing: what they make stood from
/// the frame before. Two timestamps with nothing between them are microseconds apart on a GPU, and up to a third of a
/// millisecond on a software driver.
const STOOD: f32 = 0.05;

/// What was drawn when costs were measured; of anything else they say nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Subject {
    n_strands: u64,
    n_vertices: u64,
    size: [u32; 2],
}

/// The costs that are known.
#[derive(Debug, Default)]
pub struct Costs {
    subject: Subject,
    of_choices: BTreeMap<(&'static str, &'static str), Cost>,
    /// The choice of each slot in the frame before.
    before: BTreeMap<&'static str, &'static str>,
}

impl Costs {
    /// Take in a frame of full detail that was drawn with a look.
    pub fn keep(&mut self, report: &FrameReport, look: &Look) {
        let subject = Subject { n_strands: report.n_strands, n_vertices: report.n_vertices, size: report.size };
        if subject != self.subject {
            *self = Self { subject, ..Self::default() };
        }
        let mut look = look.clone();
        for slot in look.slots() {
            let Some(measured) = MEASURED.iter().find(|measured| measured.slot == slot.key) else { continue };
            let is_its = |pass: &str| measured.passes.iter().any(|start| pass.starts_with(start));
            let mut its = report.pass_times.iter().filter(|(pass, _)| is_its(pass)).peekable();
            if its.peek().is_none() {
                continue;
            }
            let ms: f32 = its.map(|(_, ms)| ms).sum();
            let n_bytes = match measured.memory {
                Memory::NotApart => None,
                Memory::OfDrawing => Some(report.n_drawing_bytes),
                Memory::OfShadows => Some(report.n_shadow_bytes),
            };
            let name = slot.chosen().name;
            // The first frame of another choice makes all that it needs, be it nothing.
            let is_new = self.before.insert(slot.key, name) != Some(name);
            if is_new || self.of(slot.key, name).is_none_or(|known| ms > STOOD * known.ms) {
                self.of_choices.insert((slot.key, name), Cost { ms, n_bytes });
            }
        }
    }

    pub fn of(&self, slot: &'static str, choice: &'static str) -> Option<Cost> {
        self.of_choices.get(&(slot, choice)).copied()
    }

    /// For a slot's row and its list: the cost of each choice in words, and what was measured.
    pub fn notes(&self, slot: &'static str, choices: impl Iterator<Item = &'static str>) -> Notes {
        let in_words = |cost: Cost| {
            let time = milliseconds(cost.ms);
            let all = cost.n_bytes.map_or_else(|| time.clone(), |n_bytes| format!("{time}, {}", mebibytes(n_bytes)));
            Note { time, all }
        };
        let what = MEASURED.iter().find(|measured| measured.slot == slot).map_or("", |measured| measured.what);
        Notes { of_choices: choices.map(|choice| self.of(slot, choice).map(in_words)).collect(), what }
    }

    /// For the state report.
    pub fn report(&self) -> serde_json::Value {
        let costs = self.of_choices.iter().map(|((slot, choice), cost)| (format!("{slot}={choice}"), cost.ms.into()));
        serde_json::Value::Object(costs.collect())
    }
}

#[cfg(test)]
mod tests {
    use lorelei_core::look::{Choice, Shadowing};

    use super::*;

    fn report(passes: &[(&str, f32)]) -> FrameReport {
        FrameReport {
            pass_times: passes.iter().map(|(pass, ms)| ((*pass).to_owned(), *ms)).collect(),
            n_strands: 10,
            n_shadow_bytes: 3 << 20,
            ..FrameReport::default()
        }
    }

    #[test]
    fn every_choice_keeps_what_it_cost_until_something_else_is_drawn() {
        let mut look = Look::default();
        let mut costs = Costs::default();
        costs.keep(&report(&[("shadow", 2.0), ("raster.count", 1.0), ("raster.fine", 3.0)]), &look);
        assert_eq!(costs.of("shadowing", "deep-opacity"), Some(Cost { ms: 2.0, n_bytes: Some(3 << 20) }));
        assert_eq!(costs.of("primitive", "compute").unwrap().ms, 4.0);
        assert_eq!(costs.of("head", "skin"), None);
        // Shadows that stand cost nothing this time; the others are measured again.
        costs.keep(&report(&[("shadow", 0.001), ("raster.count", 1.0), ("raster.fine", 4.0)]), &look);
        assert_eq!(costs.of("shadowing", "deep-opacity").unwrap().ms, 2.0);
        assert_eq!(costs.of("primitive", "compute").unwrap().ms, 5.0);
        // Another choice costs nothing indeed, and the first is remembered.
        look.shadowing = Shadowing::Off;
        costs.keep(&report(&[("shadow", 0.001)]), &look);
        assert_eq!(costs.of("shadowing", "off").unwrap().ms, 0.001);
        let names = || Shadowing::ALL.iter().map(|choice| choice.info().name);
        let notes = costs.notes("shadowing", names());
        let all: Vec<&str> = notes.of_choices.iter().flatten().map(|note| note.all.as_str()).collect();
        assert_eq!(all, ["2.00 ms, 3.0 MiB", "0.00 ms, 3.0 MiB"]);
        assert!(notes.what.contains("shadows"));
        // Of another groom nothing is known.
        costs.keep(&FrameReport { n_strands: 11, ..report(&[]) }, &look);
        assert!(costs.notes("shadowing", names()).of_choices.iter().all(Option::is_none));
    }

    #[test]
    fn what_is_measured_is_a_slot() {
        let mut look = Look::default();
        let slots = look.slots();
        for measured in MEASURED {
            assert!(slots.iter().any(|slot| slot.key == measured.slot), "{}", measured.slot);
        }
    }
}
