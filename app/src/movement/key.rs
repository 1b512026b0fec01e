//! A number of everything that decides how the frames of a movement are: guides, the head, the solver's settings, the
//! movement. Whatever only changes the picture (look, lights, style, camera) is not in it.

use lorelei_core::motion::Movement;
use lorelei_core::simulation::Wind;

use super::{Course, Subject};

/// The same number, the same frames.
pub fn key_of(subject: &Subject, course: &Course, movement: &Movement) -> u128 {
    let mut key = Key::new();
    key.bytes(env!("CARGO_PKG_VERSION").as_bytes());
    for hair in &subject.hair {
        key.word(hair.curves.n_vertices);
        key.floats(hair.curves.positions.iter().flat_map(glam::Vec3::to_array));
        key.floats(hair.ties.iter().flat_map(|tie| [tie.tied, tie.hold]));
        if course.settings.wind == Wind::Grid {
            key.floats([hair.g_per_cm]);
        }
        key.word(hair.n_shown() as u32);
    }
    if let Some(field) = &subject.field {
        key.floats(field.min.to_array().into_iter().chain([field.cell]));
        field.n.iter().for_each(|n| key.word(*n));
        key.floats(field.values.iter().copied());
    }
    // Whatever settings there will be are in their text.
    let settings = ron::to_string(&course.settings).unwrap_or_default();
    key.bytes(settings.as_bytes());
    key.bytes(format!("{:?}", course.motion).as_bytes());
    for track_key in course.track.iter().flat_map(|track| &track.keys) {
        key.floats(track_key.rotation.to_array().into_iter().chain(track_key.shift.to_array()).chain([track_key.secs]));
    }
    key.floats(course.neck.to_array());
    key.floats([movement.fps, movement.warm_up_secs]);
    key.word(movement.start);
    key.0
}

/// The hash FNV-1a of 128 bits (Fowler, Noll, Vo), a word of four bytes at a time.
struct Key(u128);

impl Key {
    fn new() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    fn word(&mut self, word: u32) {
        const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
        self.0 = (self.0 ^ u128::from(word)).wrapping_mul(PRIME);
    }

    fn floats(&mut self, values: impl IntoIterator<Item = f32>) {
        values.into_iter().for_each(|value| self.word(value.to_bits()));
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u32);
        for byte in bytes {
            self.word(u32::from(*byte));
        }
    }
}
