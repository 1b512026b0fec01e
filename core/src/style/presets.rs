//! Named stacks: those of the studio, and those that an artist keeps in files.
//!
//! A stack says how many strands share a lock, so it fits a number of strands: a preset is written for
//! [`STRANDS`] and scaled to the layer that it is put on, so that locks keep their width.

use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Profile, StyleKind, StyleOp};
use crate::look::ParamValue;

/// How many strands on a head the studio's presets are written for.
pub const STRANDS: u32 = 100_000;

/// Style files are text of a few kilobytes; this is a thousand times what any needs.
const MAX_FILE_BYTES: u64 = 4 << 20;
/// Most operators that a file may hold.
const MOST_OPS: usize = 200;

/// A stack with a name. In files the same, as RON.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Preset {
    pub name: String,
    /// What it is for, in a sentence.
    #[serde(default)]
    pub help: String,
    /// How many strands its clumps were made for.
    #[serde(default = "default_strands")]
    pub n_strands: u32,
    pub stack: Vec<StyleOp>,
}

fn default_strands() -> u32 {
    STRANDS
}

/// Why a style file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum PresetError {
    #[error("{path}: {why}. Check that the file exists and may be read.")]
    Read { path: String, why: std::io::Error },
    #[error(
        "{path} is {n_bytes} bytes long, and a style is no longer than {MAX_FILE_BYTES}: is it another sort of file?"
    )]
    TooLarge { path: String, n_bytes: u64 },
    #[error("{path} is no style: {why}. A style is RON, as `Save style` writes it.")]
    NotAStyle { path: String, why: String },
    #[error(transparent)]
    Write(#[from] crate::io::WriteError),
}

impl Preset {
    /// The stack for a layer of so many strands.
    pub fn for_strands(&self, n_strands: u32) -> Vec<StyleOp> {
        let share = n_strands.max(1) as f32 / self.n_strands.max(1) as f32;
        let mut stack = self.stack.clone();
        for op in &mut stack {
            op.kind.scale_clumps(share);
        }
        stack
    }

    /// The stack as text.
    pub fn to_text(&self) -> String {
        let pretty = ron::ser::PrettyConfig::default();
        ron::ser::to_string_pretty(self, pretty).expect("a style is numbers and names, which RON can write")
    }

    /// Read a stack; numbers beyond their range are taken to its end.
    pub fn from_text(text: &str) -> Result<Self, String> {
        let mut preset: Self = ron::from_str(text).map_err(|why| why.to_string())?;
        if preset.stack.len() > MOST_OPS {
            return Err(format!("{} operators, where {MOST_OPS} are the most", preset.stack.len()));
        }
        preset.stack.iter_mut().for_each(StyleOp::keep_in_range);
        Ok(preset)
    }

    /// Write a style file. What was at `path` stays until the new file is complete.
    pub fn save(&self, path: &Path) -> Result<(), PresetError> {
        let text = self.to_text();
        crate::io::write_atomically(path, |out| out.write_all(text.as_bytes()))?;
        Ok(())
    }

    /// Read a style file.
    pub fn open(path: &Path) -> Result<Self, PresetError> {
        let name = || path.display().to_string();
        let read = |why| PresetError::Read { path: name(), why };
        let n_bytes = std::fs::metadata(path).map_err(read)?.len();
        if n_bytes > MAX_FILE_BYTES {
            return Err(PresetError::TooLarge { path: name(), n_bytes });
        }
        let bytes = std::fs::read(path).map_err(read)?;
        let text = String::from_utf8(bytes).map_err(|why| why.to_string());
        text.and_then(|text| Self::from_text(&text)).map_err(|why| PresetError::NotAStyle { path: name(), why })
    }
}

impl StyleOp {
    /// Bring every number within its range; what is no number becomes the usual one.
    pub fn keep_in_range(&mut self) {
        let mut usual = Self::new(self.kind);
        let usual: Vec<String> = usual.params().iter().map(|param| param.value.to_text()).collect();
        for (param, usual) in self.params().into_iter().zip(usual) {
            if let ParamValue::F32(value) = param.value {
                *value = if value.is_finite() { *value } else { usual.parse().unwrap_or(param.min) };
                *value = if value.is_finite() { value.clamp(param.min, param.max) } else { param.min };
            }
        }
    }
}

fn op(kind: StyleKind) -> StyleOp {
    StyleOp::new(kind)
}

fn length(variation: f32, strands_per_clump: f32) -> StyleOp {
    op(StyleKind::Length { variation, strands_per_clump })
}

fn clump(strands_per_clump: f32, flare: f32, stray: f32, strength: f32) -> StyleOp {
    StyleOp { strength, ..op(StyleKind::Clump { strands_per_clump, flare, stray }) }
}

fn wave(amplitude: f32, wavelength: f32, strands_per_clump: f32) -> StyleOp {
    op(StyleKind::Wave { amplitude, wavelength, strands_per_clump })
}

fn frizz(amplitude: f32, wavelength: f32, strands_per_clump: f32) -> StyleOp {
    StyleOp { ramp: 0.5, ..op(StyleKind::Frizz { amplitude, wavelength, strands_per_clump }) }
}

fn named(name: &str, op: StyleOp) -> StyleOp {
    StyleOp { name: name.to_owned(), ..op }
}

/// Loose tips: 30 % of the strands leave the others towards their ends. Tariq and Bavoil 2008, "Real-time hair
/// rendering on the GPU", deviations.
fn loose_tips(amplitude: f32) -> StyleOp {
    named("Loose tips", op(StyleKind::Deviate { share: 0.3, amplitude, lift: 0.1, whole: 0.0 }))
}

/// Strays: 10 % of the strands leave the others all along; ibid.
fn strays(amplitude: f32) -> StyleOp {
    let kind = StyleKind::Deviate { share: 0.1, amplitude, lift: 0.15, whole: 1.0 };
    named("Strays", StyleOp { ramp: 1.0, ..op(kind) })
}

fn fly_aways(share: f32, amplitude: f32) -> StyleOp {
    named("Fly-aways", StyleOp { ramp: 1.3, ..op(StyleKind::Deviate { share, amplitude, lift: 0.5, whole: 0.3 }) })
}

/// Operators with numbers for a purpose, for the menu beside the plain kinds: (what it is for, operator).
pub fn named_ops() -> Vec<(&'static str, StyleOp)> {
    let gravity = StyleKind::Bend {
        heading_deg: 0.0,
        elevation_deg: -90.0,
        gravity: 1.0,
        variation: 0.2,
        strands_per_clump: 200.0,
    };
    let swept = StyleKind::Bend {
        heading_deg: 180.0,
        elevation_deg: 0.0,
        gravity: 0.0,
        variation: 0.3,
        strands_per_clump: 200.0,
    };
    vec![
        ("30 % of the strands leave the others towards their tips", loose_tips(0.8)),
        ("10 % of the strands leave the others all along", strays(0.6)),
        ("A few strands stand away from the head", fly_aways(0.02, 2.0)),
        ("Hair hangs more steeply", named("Hang", StyleOp { strength: 0.5, ..op(gravity) })),
        ("Hair is swept to the back", named("Sweep back", StyleOp { strength: 0.4, ..op(swept) })),
        (
            "A parting to the model's left",
            named("Side part", op(StyleKind::Part { offset: 3.0, turn_deg: 0.0, width: 4.0 })),
        ),
        ("Large locks, to put before finer clumps", named("Locks", clump(600.0, 0.25, 0.5, 0.7))),
        ("Whole locks wander", named("Unruly", frizz(0.4, 7.0, 200.0))),
    ]
}

/// The studio's stacks.
pub fn presets() -> Vec<Preset> {
    let preset = |name: &str, help: &str, stack: Vec<StyleOp>| Preset {
        name: name.to_owned(),
        help: help.to_owned(),
        n_strands: STRANDS,
        stack,
    };
    let curl = |radius: f32, pitch: f32, strands_per_clump: f32, loosen: f32| {
        op(StyleKind::Curl { radius, pitch, strands_per_clump, loosen })
    };
    let wisp = |strands_per_clump: f32, radius: f32, fuzz: f32, twist: f32| {
        op(StyleKind::Wisp { strands_per_clump, radius, gather: 0.2, fuzz, twist, length_variation: 0.15 })
    };
    vec![
        preset(
            "Straight",
            "Falls as the hair mesh says, in soft locks",
            vec![
                length(0.1, 400.0),
                length(0.1, 1.0),
                clump(500.0, 0.3, 0.5, 0.45),
                clump(40.0, 0.5, 0.6, 0.45),
                frizz(0.06, 2.4, 1.0),
                loose_tips(0.5),
            ],
        ),
        preset(
            "Sleek",
            "Ironed flat: no lock leaves the others",
            vec![
                length(0.05, 1.0),
                named("Iron", StyleOp { strength: 0.9, ..op(StyleKind::Smooth { reach: 0.4 }) }),
                clump(60.0, 0.2, 0.3, 0.35),
                frizz(0.02, 3.0, 1.0),
            ],
        ),
        preset(
            "Soft waves",
            "Long waves, in phase within a lock",
            vec![
                length(0.14, 800.0),
                length(0.1, 1.0),
                clump(800.0, 0.3, 0.5, 0.6),
                clump(40.0, 0.4, 0.6, 0.6),
                wave(0.75, 10.0, 800.0),
                frizz(0.2, 4.0, 40.0),
                frizz(0.06, 2.4, 1.0),
                loose_tips(0.7),
            ],
        ),
        preset(
            "Beach waves",
            "Shorter waves that swell and calm, tousled by salt water",
            vec![
                length(0.2, 300.0),
                length(0.1, 1.0),
                clump(300.0, 0.4, 0.6, 0.7),
                clump(30.0, 0.3, 0.5, 0.7),
                wave(0.6, 5.5, 300.0),
                named(
                    "Swell",
                    StyleOp {
                        blend: super::Blend::Modulate,
                        ramp: 0.0,
                        seed: 3,
                        ..op(StyleKind::Frizz { amplitude: 1.0, wavelength: 9.0, strands_per_clump: 300.0 })
                    },
                ),
                frizz(0.25, 3.5, 30.0),
                frizz(0.08, 1.8, 1.0),
                loose_tips(1.0),
                strays(0.8),
            ],
        ),
        preset(
            "Curls",
            "Springy curls of finger width",
            vec![
                length(0.3, 60.0),
                length(0.1, 1.0),
                clump(500.0, 0.6, 0.5, 0.5),
                clump(60.0, 0.1, 0.3, 0.85),
                curl(0.7, 2.4, 60.0, 0.35),
                frizz(0.4, 5.0, 60.0),
                frizz(0.05, 1.3, 1.0),
                strays(0.6),
            ],
        ),
        preset(
            "Tight curls",
            "Coils of pencil width, close to each other",
            vec![
                length(0.3, 24.0),
                clump(24.0, 0.1, 0.3, 0.9),
                curl(0.3, 0.8, 24.0, 0.25),
                frizz(0.35, 3.0, 24.0),
                frizz(0.05, 0.9, 1.0),
                strays(0.5),
            ],
        ),
        preset(
            "Frizzy",
            "Every strand goes its own way, more towards the tips",
            vec![
                length(0.25, 1.0),
                clump(200.0, 0.6, 0.8, 0.4),
                frizz(0.6, 5.0, 100.0),
                frizz(0.35, 1.6, 1.0),
                curl(0.12, 0.7, 4.0, 0.5),
                loose_tips(1.4),
                strays(1.2),
            ],
        ),
        preset(
            "Wet",
            "Heavy, pointed strings of hair",
            vec![
                length(0.2, 120.0),
                named(
                    "Weight",
                    StyleOp {
                        strength: 0.35,
                        ..op(StyleKind::Bend {
                            heading_deg: 0.0,
                            elevation_deg: -90.0,
                            gravity: 1.0,
                            variation: 0.3,
                            strands_per_clump: 500.0,
                        })
                    },
                ),
                clump(500.0, 0.0, 0.2, 0.5),
                StyleOp { ramp: 0.5, ..clump(120.0, 0.0, 0.1, 0.97) },
                frizz(0.25, 6.0, 120.0),
                frizz(0.02, 2.0, 1.0),
            ],
        ),
        preset(
            "Wisps",
            "Separate wisps that end in points; the waves move whole wisps",
            vec![
                length(0.25, 150.0),
                wave(0.5, 7.0, 1.0),
                named("Wisps", wisp(150.0, 0.45, 0.25, 0.4)),
                frizz(0.04, 1.8, 1.0),
                loose_tips(0.6),
            ],
        ),
        preset(
            "Ringlets",
            "Wisps rolled into hanging curls",
            vec![
                length(0.25, 250.0),
                StyleOp {
                    curve: Profile::of(&[[0.0, 0.0], [0.25, 0.2], [0.5, 1.0], [1.0, 1.0]]),
                    ..curl(0.9, 3.0, 1.0, 0.2)
                },
                named("Wisps", wisp(250.0, 0.35, 0.15, 1.0)),
                frizz(0.04, 1.5, 1.0),
                strays(0.4),
            ],
        ),
        preset(
            "Fly-aways",
            "For a thin layer over the main one: loose strands that stand away",
            vec![length(0.45, 1.0), frizz(0.3, 5.0, 1.0), fly_aways(1.0, 1.5)],
        ),
        preset(
            "Frizz layer",
            "For a thin layer over the main one: short crinkled hair that breaks the outline",
            vec![length(0.6, 1.0), frizz(0.3, 1.4, 1.0), curl(0.1, 0.8, 1.0, 0.5), fly_aways(0.6, 0.7)],
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::style::left_out;

    #[test]
    fn every_preset_fits_a_stack_and_its_ranges_and_comes_back_from_its_text() {
        let mut names = std::collections::HashSet::new();
        for preset in presets() {
            assert!(names.insert(preset.name.clone()) && !preset.help.is_empty());
            assert_eq!(left_out(&preset.stack), None, "{}", preset.name);
            let mut kept = preset.clone();
            kept.stack.iter_mut().for_each(StyleOp::keep_in_range);
            assert_eq!(kept, preset, "{} is beyond a range", preset.name);
            assert_eq!(Preset::from_text(&preset.to_text()).unwrap(), preset);
        }
        for (help, op) in named_ops() {
            let mut kept = op.clone();
            kept.keep_in_range();
            assert!(kept == op && !op.name.is_empty() && !help.is_empty(), "{}", op.name);
        }
    }

    #[test]
    fn a_preset_keeps_the_width_of_its_locks_on_fewer_strands() {
        let preset = presets().into_iter().find(|preset| preset.name == "Curls").unwrap();
        let sizes = |stack: &[StyleOp]| stack.iter().map(|op| op.kind.strands_per_clump()).collect::<Vec<_>>();
        let (all, tenth) = (sizes(&preset.stack), sizes(&preset.for_strands(10_000)));
        assert!(all.iter().zip(&tenth).all(|(a, b)| (0.1 * a - b).abs() < 1e-3 || *b == 1.0));
    }

    #[test]
    fn a_style_file_is_written_read_and_a_broken_one_is_refused_with_the_reason() {
        let folder = std::env::temp_dir().join(format!("lorelei-style-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("mine.ron");
        let preset = &presets()[2];
        preset.save(&path).unwrap();
        assert_eq!(&Preset::open(&path).unwrap(), preset);
        std::fs::write(&path, "(name:\"x\",stack:[(strength:NaN,kind:Smooth(reach:7.0))])").unwrap();
        let kept = Preset::open(&path).unwrap();
        assert_eq!(kept.stack[0].strength, 1.0);
        assert_eq!(kept.stack[0].kind, StyleKind::Smooth { reach: 1.0 });
        std::fs::write(&path, "hair").unwrap();
        assert!(Preset::open(&path).unwrap_err().to_string().contains("is no style"));
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(matches!(Preset::open(&path), Err(PresetError::Read { .. })));
    }
}
