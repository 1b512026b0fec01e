//! Looks with names: those of the studio, and those that an artist keeps in files.
//!
//! A file holds the look alone, as RON; what it leaves out is as in the default look, so that a short file says only
//! what it is about. Material, lights and camera are no part of it.

use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{AnyChoice, Look, ParamValue, set};

/// Look files are text of a few kilobytes; this is a thousand times what any needs.
const MAX_FILE_BYTES: u64 = 4 << 20;

/// A look with a name. In files the same, as RON.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct LookPreset {
    pub name: String,
    /// What it is for, in a sentence.
    pub help: String,
    pub look: Look,
}

/// Why a look file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum LookFileError {
    #[error("{path}: {why}. Check that the file exists and may be read.")]
    Read { path: String, why: std::io::Error },
    #[error(
        "{path} is {n_bytes} bytes long, and a look is no longer than {MAX_FILE_BYTES}: is it another sort of file?"
    )]
    TooLarge { path: String, n_bytes: u64 },
    #[error("{path} is no look: {why}. A look is RON, as `Save look` writes it.")]
    NotALook { path: String, why: String },
    #[error(transparent)]
    Write(#[from] crate::io::WriteError),
}

impl LookPreset {
    pub fn to_text(&self) -> String {
        let pretty = ron::ser::PrettyConfig::default();
        ron::ser::to_string_pretty(self, pretty).expect("a look is numbers and names, which RON can write")
    }

    /// Read a look; numbers beyond their range are taken to its end.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let mut preset: Self = ron::from_str(text).map_err(|why| why.to_string())?;
        preset.look.keep_in_range();
        Ok(preset)
    }

    pub fn save(&self, path: &Path) -> Result<(), LookFileError> {
        let text = self.to_text();
        crate::io::write_atomically(path, |out| out.write_all(text.as_bytes()))?;
        Ok(())
    }

    pub fn open(path: &Path) -> Result<Self, LookFileError> {
        let name = || path.display().to_string();
        let read = |why| LookFileError::Read { path: name(), why };
        let n_bytes = std::fs::metadata(path).map_err(read)?.len();
        if n_bytes > MAX_FILE_BYTES {
            return Err(LookFileError::TooLarge { path: name(), n_bytes });
        }
        let bytes = std::fs::read(path).map_err(read)?;
        let text = String::from_utf8(bytes)
            .map_err(|_| LookFileError::NotALook { path: name(), why: "it is not text".to_owned() })?;
        let mut preset = Self::from_text(&text).map_err(|why| LookFileError::NotALook { path: name(), why })?;
        if preset.name.is_empty() {
            preset.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        }
        Ok(preset)
    }
}

impl Look {
    /// Take every number to its range; what is no number becomes the default.
    pub fn keep_in_range(&mut self) {
        let mut default = Self::default();
        for (slot, default) in self.slots().into_iter().zip(default.slots()) {
            for (param, default) in slot.params.into_iter().zip(default.params) {
                let (min, max) = (param.min, param.max);
                match (param.value, default.value) {
                    (ParamValue::F32(value), ParamValue::F32(default)) => {
                        *value = if value.is_finite() { value.clamp(min, max) } else { *default };
                    }
                    (ParamValue::U32(value), ParamValue::U32(_)) => *value = (*value).clamp(min as u32, max as u32),
                    (ParamValue::Colour(value), ParamValue::Colour(default)) => {
                        for (channel, default) in value.iter_mut().zip(default) {
                            *channel = if channel.is_finite() { channel.clamp(min, max) } else { *default };
                        }
                    }
                    (ParamValue::F32(_) | ParamValue::U32(_) | ParamValue::Colour(_) | ParamValue::Choice(_), _) => {}
                }
            }
        }
    }

    /// Choose by name in a slot, where both are there.
    fn choose(&mut self, key: &str, name: &str) {
        for slot in self.slots().into_iter().filter(|slot| slot.key == key) {
            set_choice(slot.choice, name);
        }
    }

    /// The look with one of its light terms alone ([`TERMS`]); that term is on, whatever it was.
    pub fn solo(&self, term: &str) -> Self {
        let mut look = self.clone();
        for (key, _) in TERMS {
            if *key != term {
                look.choose(key, "off");
            }
        }
        for slot in look.slots().into_iter().filter(|slot| slot.key == term) {
            if slot.chosen().name == "off" {
                slot.choice.set_index(0);
            }
        }
        look
    }
}

fn set_choice(choice: &mut dyn AnyChoice, name: &str) {
    if let Some(index) = choice.infos().iter().position(|info| info.name == name) {
        choice.set_index(index);
    }
}

/// The slots that add light of their own, with what each is called when it is alone. All have a choice `off`.
pub const TERMS: &[(&str, &str)] = &[
    ("r", "R lobe"),
    ("tt", "TT lobe"),
    ("trt", "TRT lobe"),
    ("multiple", "Multiple scattering"),
    ("environment", "Environment"),
];

/// A look by its name, what it is for, and what differs from the default look.
type Named = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

#[rustfmt::skip]
const NAMED: &[Named] = &[
    ("neutral", "Every choice and number as a new groom has them", &[]),
    // The cheapest of docs/looks/shadowing-table.md at a stated error: three layers from 0.5 cm are a third nearer to exact
    // than from 0.15 cm in loose hair, and cost the same.
    ("fast", "For slow machines: half the strands, coarse shadows of few strands", &[
        ("primitive.lod", "0.5"), ("shadowing.layers", "3"), ("shadowing.layer_size", "0.5"),
        ("shadowing.resolution", "512"), ("shadowing.strands", "6000"),
    ]),
    // Occupancy maps with 3 x 3 taps are the nearest to exact there but for deep shadow maps, whose memory grows with strands
    // and lamps: a small device would answer with a coarser map.
    ("reference", "For stills: shaded at every fragment, 2 x 2 samples a pixel, every strand casts into occupancy maps", &[
        ("antialiasing", "ssaa2"), ("rate", "per-fragment"), ("shadowing", "occupancy"), ("shadowing.taps", "3"),
        ("shadowing.strands", "400000"),
    ]),
    ("rim", "Dark, with what shines through the hair from behind: best with the lights Rim", &[
        ("tt.weight", "1.6"), ("r.weight", "1.2"), ("environment.intensity", "0.06"), ("tonemapping.exposure", "0.3"),
        ("background.grey", "0.07"),
    ]),
    ("clay", "Shape alone: matte, without highlights, evenly lit", &[
        ("scattering", "kajiya-kay"), ("scattering.kk_diffuse", "0.8"), ("scattering.kk_specular", "0"),
        ("environment.colour", "1,1,1"), ("environment.intensity", "0.45"), ("head.gloss", "0"),
        ("head.colour", "0.35,0.35,0.35"),
    ]),
    ("single scattering", "What one fibre does and nothing else: no environment, no multiple scattering, no shadows", &[
        ("multiple", "off"), ("environment", "off"), ("shadowing", "off"),
    ]),
];

/// The studio's looks.
pub fn look_presets() -> Vec<LookPreset> {
    let preset = |&(name, help, changes): &Named| {
        let mut look = Look::default();
        for (key, value) in changes {
            let taken = set(&mut look.slots(), key, value);
            debug_assert!(taken.is_ok(), "{name}: {taken:?}");
        }
        LookPreset { name: name.to_owned(), help: help.to_owned(), look }
    };
    NAMED.iter().map(preset).collect()
}

/// A look of the studio by its name.
pub fn look_preset(name: &str) -> Option<LookPreset> {
    look_presets().into_iter().find(|preset| preset.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::look::Shadowing;

    #[test]
    fn every_setting_of_a_preset_is_taken() {
        for (name, _, changes) in NAMED {
            for (key, value) in *changes {
                let mut look = Look::default();
                set(&mut look.slots(), key, value).unwrap_or_else(|why| panic!("{name}: {why}"));
                assert_ne!(look, Look::default(), "{name}: {key}={value} is the default");
            }
        }
    }

    #[test]
    fn presets_differ_are_in_range_and_read_back() {
        let presets = look_presets();
        for (i, preset) in presets.iter().enumerate() {
            assert!(!preset.help.is_empty());
            assert_eq!(&LookPreset::from_text(&preset.to_text()).unwrap(), preset, "{}", preset.name);
            assert!(presets[..i].iter().all(|other| other.look != preset.look && other.name != preset.name));
            let mut ranged = preset.look.clone();
            ranged.keep_in_range();
            assert_eq!(ranged, preset.look, "{}", preset.name);
        }
        assert_eq!(look_preset("neutral").unwrap().look, Look::default());
        assert_eq!(look_preset("nothing"), None);
    }

    #[test]
    fn a_file_says_only_what_it_is_about_and_nonsense_is_refused_or_ranged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("short.ron");
        std::fs::write(&path, "(look: (shadowing: Off, exposure: 99.0, weight_r: NaN))").unwrap();
        let read = LookPreset::open(&path).unwrap();
        let expected = Look { shadowing: Shadowing::Off, exposure: 8.0, ..Look::default() };
        assert_eq!((read.name.as_str(), read.look), ("short", expected));
        for text in ["(look: (shadowing: Magic))", "[1]", "(look: (exposure: \"a\"))"] {
            std::fs::write(&path, text).unwrap();
            assert!(matches!(LookPreset::open(&path), Err(LookFileError::NotALook { .. })), "{text}");
        }
        assert!(matches!(LookPreset::open(&folder.path().join("none.ron")), Err(LookFileError::Read { .. })));
        let preset = look_preset("clay").unwrap();
        preset.save(&path).unwrap();
        assert_eq!(LookPreset::open(&path).unwrap(), preset);
    }

    #[test]
    fn every_term_can_be_alone() {
        let mut look = Look::default();
        let slots: Vec<(String, bool)> = look
            .slots()
            .iter()
            .map(|slot| (slot.key.to_owned(), slot.choice.infos().iter().any(|info| info.name == "off")))
            .collect();
        for (term, _) in TERMS {
            assert!(slots.contains(&((*term).to_owned(), true)), "{term} is a slot that can be off");
            // Alone even where it was off.
            look.choose(term, "off");
            let mut alone = look.solo(term);
            for slot in alone.slots() {
                if TERMS.iter().any(|(key, _)| *key == slot.key) {
                    assert_eq!(slot.chosen().name == "off", slot.key != *term, "{} beside {term}", slot.key);
                }
            }
        }
    }
}
