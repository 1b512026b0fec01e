//! The movement of nodes in a glTF 2.0 animation, as keyed poses against the node's first.
//!
//! Translations and rotations of a node and of all above it are sampled, whether they step, are linear or cubic splines (glTF
//! 2.0, appendix C), sixty times a second and at every key; keys that the others give are left out. Scales of ancestors count;
//! the node's own size does not change.

use std::path::Path;

use glam::{Mat4, Quat, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::animation::{Interpolation, Property};

use super::error::{Place, ReadError};
use super::gltf_mesh::{Buffers, parse};
use super::source::{Source, Watch};
use crate::motion::{PoseKey, PoseTrack};

/// Centimetres in glTF's metre.
const CM: f32 = 100.0;
/// Samples a second.
const RATE: f32 = 60.0;
/// Longer animations are cut off, seconds.
const LONGEST_SECS: f32 = 600.0;
/// Keys are left out where the others give them this well: centimetres and radians.
const CLOSE: (f32, f32) = (2e-3, 2e-4);
/// Nodes above each other.
const MAX_DEPTH: usize = 128;

/// The tracks of every node that an animation of the file moves, by the nodes' names; at least one.
pub fn read_motions(path: &Path, watch: Watch<'_>) -> Result<Vec<PoseTrack>, ReadError> {
    motions_from(&mut Source::open(path, watch)?)
}

/// As [`read_motions`], from memory; `name` stands for the path in errors.
pub fn read_motions_from_bytes(name: &str, bytes: &[u8]) -> Result<Vec<PoseTrack>, ReadError> {
    motions_from(&mut Source::from_bytes(name, bytes, Watch::default())?)
}

/// The track of a node by its name; without a name the one that is called a head, or the first. The error names what
/// there is.
pub fn track_of(tracks: &[PoseTrack], node: Option<&str>) -> Result<PoseTrack, String> {
    let named = |name: &str| tracks.iter().find(|track| track.name.eq_ignore_ascii_case(name));
    let head = || tracks.iter().find(|track| track.name.to_lowercase().contains("head")).or(tracks.first());
    let found = node.map_or_else(head, named).cloned();
    found.ok_or_else(|| {
        let names: Vec<&str> = tracks.iter().map(|track| track.name.as_str()).collect();
        format!("there is no moving node of that name; the file has: {}", names.join(", "))
    })
}

/// One channel's keys.
struct Curve {
    times: Vec<f32>,
    /// Three a key (in-tangent, value, out-tangent) for cubic splines, else one.
    values: Vec<[f32; 4]>,
    interpolation: Interpolation,
    is_rotation: bool,
}

/// What moves a node.
#[derive(Default)]
struct Moved {
    translation: Option<Curve>,
    rotation: Option<Curve>,
}

fn motions_from(source: &mut Source<'_>) -> Result<Vec<PoseTrack>, ReadError> {
    source.rewind()?;
    let bytes = source.rest()?;
    let (document, buffers) = parse(source, &bytes)?;
    let mut parents = vec![None; document.nodes().len()];
    for node in document.nodes() {
        node.children().for_each(|child| parents[child.index()] = Some(node.index()));
    }
    let nodes: Vec<gltf::Node<'_>> = document.nodes().collect();
    let mut tracks = Vec::new();
    let n_animations = document.animations().len();
    for animation in document.animations() {
        let mut moved: Vec<Moved> = nodes.iter().map(|_| Moved::default()).collect();
        for channel in animation.channels() {
            let target = channel.target();
            let part = name_of(&animation, &channel);
            let Some(moved) = moved.get_mut(target.node().index()) else { continue };
            match target.property() {
                Property::Translation => moved.translation = Some(curve(source, &buffers, &channel, 3, &part)?),
                Property::Rotation => moved.rotation = Some(curve(source, &buffers, &channel, 4, &part)?),
                Property::Scale | Property::MorphTargetWeights => {}
            }
        }
        let is_moved = |moved: &Moved| moved.translation.is_some() || moved.rotation.is_some();
        for (node_idx, _) in moved.iter().enumerate().filter(|(_, moved)| is_moved(moved)) {
            let mut chain = vec![node_idx];
            while let Some(parent) = parents[chain[chain.len() - 1]].filter(|_| chain.len() < MAX_DEPTH) {
                chain.push(parent);
            }
            let name = nodes[node_idx].name().map_or_else(|| format!("node {node_idx}"), str::to_owned);
            let name = match animation.name() {
                Some(of) if n_animations > 1 => format!("{name} ({of})"),
                _ => name,
            };
            tracks.push(track(name, &chain, &nodes, &moved));
        }
    }
    if tracks.is_empty() {
        return Err(source.nothing(
            "no animation that moves or turns a node",
            "Export the scene with its animation as GLB; animations of single vertices are not read",
        ));
    }
    Ok(tracks)
}

/// Sample the node at the chain's beginning through all above it.
fn track(name: String, chain: &[usize], nodes: &[gltf::Node<'_>], moved: &[Moved]) -> PoseTrack {
    let curves = || chain.iter().flat_map(|&idx| [&moved[idx].translation, &moved[idx].rotation]).flatten();
    let first = curves().filter_map(|curve| curve.times.first()).copied().fold(f32::INFINITY, f32::min).max(0.0);
    let last = curves().filter_map(|curve| curve.times.last()).copied().fold(0.0, f32::max).min(LONGEST_SECS);
    let mut times: Vec<f32> = (0..=((last - first).max(0.0) * RATE) as u32).map(|i| first + i as f32 / RATE).collect();
    for curve in curves() {
        let of_keys = curve.times.iter().copied().filter(|t| (first..=last).contains(t));
        times.extend(of_keys.clone());
        if curve.interpolation == Interpolation::Step {
            times.extend(of_keys.map(|t| t - 1e-4).filter(|t| *t > first));
        }
    }
    times.sort_by(f32::total_cmp);
    times.dedup();
    let pose_at = |secs: f32| {
        let world_from_node = chain.iter().rev().fold(Mat4::IDENTITY, |world_from_parent, &idx| {
            let (translation, rotation, scale) = nodes[idx].transform().decomposed();
            let translation = moved[idx].translation.as_ref().map_or(Vec3::from_array(translation), |curve| {
                let [x, y, z, _] = curve.at(secs);
                Vec3::new(x, y, z)
            });
            let rotation = moved[idx].rotation.as_ref().map_or(rotation, |curve| curve.at(secs));
            let rotation = Quat::from_array(rotation).normalize();
            let rotation = if rotation.is_finite() { rotation } else { Quat::IDENTITY };
            world_from_parent * Mat4::from_scale_rotation_translation(Vec3::from_array(scale), rotation, translation)
        });
        let (_, rotation, translation) = world_from_node.to_scale_rotation_translation();
        (rotation.normalize(), CM * translation)
    };
    let (rest_rotation, rest_place) = pose_at(first);
    let keys = times.iter().map(|&secs| {
        let (rotation, place) = pose_at(secs);
        PoseKey { secs: secs - first, rotation: rotation * rest_rotation.inverse(), shift: place - rest_place }
    });
    let is_finite = |key: &PoseKey| key.rotation.is_finite() && key.shift.is_finite();
    PoseTrack { name, keys: keys.filter(is_finite).collect() }.simplified(CLOSE.0, CLOSE.1)
}

impl Curve {
    /// The value at a time; before the first and behind the last key theirs.
    fn at(&self, secs: f32) -> [f32; 4] {
        let is_cubic = self.interpolation == Interpolation::CubicSpline;
        let value = |key: usize| if is_cubic { self.values[3 * key + 1] } else { self.values[key] };
        let behind = self.times.partition_point(|t| *t <= secs);
        if behind == 0 {
            return value(0);
        }
        let before = behind - 1;
        if behind == self.times.len() {
            return value(before);
        }
        let length = (self.times[behind] - self.times[before]).max(1e-9);
        let t = (secs - self.times[before]) / length;
        let (a, b) = (value(before), value(behind));
        match self.interpolation {
            Interpolation::Step => a,
            Interpolation::Linear if self.is_rotation => {
                let (from, to) = (Quat::from_array(a), Quat::from_array(b));
                // Opposite signs are the same rotation: along the shorter arc.
                let to = if from.dot(to) < 0.0 { -to } else { to };
                from.slerp(to, t).to_array()
            }
            Interpolation::Linear => std::array::from_fn(|i| a[i] + t * (b[i] - a[i])),
            Interpolation::CubicSpline => {
                let (out, into) = (self.values[3 * before + 2], self.values[3 * behind]);
                let (t2, t3) = (t * t, t * t * t);
                std::array::from_fn(|i| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a[i]
                        + length * (t3 - 2.0 * t2 + t) * out[i]
                        + (3.0 * t2 - 2.0 * t3) * b[i]
                        + length * (t3 - t2) * into[i]
                })
            }
        }
    }
}

const NEXT: &str = "Export the animation again, sampled at every frame, or delete this channel where it was made; other channels may be whole";

/// Names a channel by where it is in the file and by what it moves.
fn name_of(animation: &gltf::Animation<'_>, channel: &gltf::animation::Channel<'_>) -> String {
    let target = channel.target();
    let node = target.node();
    let what = match target.property() {
        Property::Translation => "translation",
        Property::Rotation => "rotation",
        Property::Scale => "scale",
        Property::MorphTargetWeights => "weights",
    };
    let quoted = |name: Option<&str>| name.map_or_else(String::new, |name| format!(" \"{name}\""));
    let (of_animation, of_node) = (quoted(animation.name()), quoted(node.name()));
    let (animation, channel) = (animation.index(), channel.index());
    format!("animation {animation}{of_animation}, channel {channel} ({what} of node {}{of_node})", node.index())
}

fn curve(
    source: &mut Source<'_>,
    buffers: &Buffers<'_>,
    channel: &gltf::animation::Channel<'_>,
    n_components: usize,
    part: &str,
) -> Result<Curve, ReadError> {
    let sampler = channel.sampler();
    let times: Vec<f32> = numbers(source, buffers, &sampler.input(), 1, part)?.into_iter().map(|[t, ..]| t).collect();
    let values = numbers(source, buffers, &sampler.output(), n_components, part)?;
    let interpolation = sampler.interpolation();
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let bad = |problem: String| source.corrupt(Place::Part(part.to_owned()), problem, NEXT);
    if let Some(key_idx) = times.iter().position(|t| !t.is_finite()) {
        return Err(bad(format!("the time of key {key_idx} is {}, no number of seconds,", times[key_idx])));
    }
    if let Some(key_idx) = times.windows(2).position(|pair| pair[0] > pair[1]) {
        let (before, after) = (times[key_idx], times[key_idx + 1]);
        return Err(bad(format!("key {} is at {after} s, before the key at {before} s that it follows,", key_idx + 1)));
    }
    if times.is_empty() || values.len() != per_key * times.len() {
        return Err(bad(format!("there are {} times for {} values,", times.len(), values.len())));
    }
    Ok(Curve { times, values, interpolation, is_rotation: n_components == 4 })
}

/// Elements of an accessor, filled up with zeros.
fn numbers(
    source: &mut Source<'_>,
    buffers: &Buffers<'_>,
    accessor: &gltf::Accessor<'_>,
    n_components: usize,
    part: &str,
) -> Result<Vec<[f32; 4]>, ReadError> {
    let has = match accessor.dimensions() {
        Dimensions::Scalar => 1,
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        Dimensions::Vec4 => 4,
        Dimensions::Mat2 | Dimensions::Mat3 | Dimensions::Mat4 => 0,
    };
    let size = accessor.data_type().size();
    let bad = |source: &Source<'_>, problem: &str| {
        source.corrupt(Place::Part(part.to_owned()), problem, "Export the animation again as GLB, without compression")
    };
    let is_read = accessor.data_type() == DataType::F32 || (accessor.normalized() && size <= 2);
    let Some(view) = accessor.view().filter(|_| has == n_components && is_read && accessor.sparse().is_none()) else {
        return Err(bad(source, "has numbers of another kind than glTF's animations have,"));
    };
    let n = accessor.count();
    let reaches = |idx: usize| buffers.element(&view, accessor.offset(), size * has, idx);
    if n > 0 && reaches(n - 1).is_none() {
        return Err(bad(source, "reaches past the end of its buffer,"));
    }
    let mut values = source.reserve(n as u64)?;
    for bytes in (0..n).filter_map(reaches) {
        let mut value = [0.0; 4];
        for (number, b) in value.iter_mut().zip(bytes.chunks_exact(size)) {
            *number = match accessor.data_type() {
                DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
                DataType::I8 => f32::from(b[0] as i8) / 127.0,
                DataType::U8 | DataType::U32 => f32::from(b[0]) / 255.0,
                DataType::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0,
                DataType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
            };
        }
        values.push(value);
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node "Head" under a node that is moved by (0, 1, 0) and scaled by 2; `channels` are on the head, with times 0, 1, 2.
    fn file(interpolation: &str, translations: &[[f32; 3]], rotations: &[[f32; 4]]) -> Vec<u8> {
        let mut bytes: Vec<u8> = [0.0_f32, 1.0, 2.0].iter().flat_map(|v| v.to_le_bytes()).collect();
        bytes.extend(translations.iter().flatten().flat_map(|v| v.to_le_bytes()));
        bytes.extend(rotations.iter().flatten().flat_map(|v| v.to_le_bytes()));
        let (n_t, n_r) = (12 * translations.len(), 16 * rotations.len());
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"nodes":[{{"children":[1],"translation":[0,1,0],"scale":[2,2,2]}},{{"name":"Head"}}],
            "buffers":[{{"byteLength":{}}}],
            "bufferViews":[{{"buffer":0,"byteLength":12}},{{"buffer":0,"byteOffset":12,"byteLength":{n_t}}},{{"buffer":0,"byteOffset":{},"byteLength":{n_r}}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR","min":[0],"max":[2]}},
            {{"bufferView":1,"componentType":5126,"count":{},"type":"VEC3"}},{{"bufferView":2,"componentType":5126,"count":{},"type":"VEC4"}}],
            "animations":[{{"samplers":[{{"input":0,"output":1,"interpolation":"{interpolation}"}},{{"input":0,"output":2,"interpolation":"{interpolation}"}}],
            "channels":[{{"sampler":0,"target":{{"node":1,"path":"translation"}}}},{{"sampler":1,"target":{{"node":1,"path":"rotation"}}}}]}}]}}"#,
            bytes.len(),
            12 + n_t,
            translations.len(),
            rotations.len()
        );
        let mut json = json.into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF".to_vec();
        glb.extend(2u32.to_le_bytes());
        glb.extend(((12 + 8 + json.len() + 8 + bytes.len()) as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &bytes)] {
            glb.extend((chunk.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(chunk);
        }
        glb
    }

    const PLACES: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.1, 0.2, 0.0]];

    fn turns() -> [[f32; 4]; 3] {
        // The last is the same rotation with the other sign.
        let half = Quat::from_rotation_y(1.0);
        [Quat::IDENTITY.to_array(), half.to_array(), (-half).to_array()]
    }

    fn head(bytes: &[u8]) -> PoseTrack {
        track_of(&read_motions_from_bytes("a.glb", bytes).unwrap(), Some("head")).unwrap()
    }

    #[test]
    fn linear_and_stepped_keys_are_passed_in_centimetres() {
        let linear = head(&file("LINEAR", &PLACES, &turns()));
        assert_eq!((linear.name.as_str(), linear.secs()), ("Head", 2.0));
        let near = |(rotation, shift): (Quat, Vec3), yaw: f32, place: Vec3| {
            rotation.angle_between(Quat::from_rotation_y(yaw)) < 2e-3 && shift.distance(place) < 0.02
        };
        // The parent's scale counts: 0.1 m are 20 cm.
        assert!(near(linear.at(0.5), 0.5, Vec3::X * 10.0), "{:?}", linear.at(0.5));
        assert!(near(linear.at(1.5), 1.0, Vec3::new(20.0, 20.0, 0.0)), "{:?}", linear.at(1.5));
        assert!(linear.keys.len() < 12, "{} keys", linear.keys.len());
        let stepped = head(&file("STEP", &PLACES, &turns()));
        assert!(near(stepped.at(0.99), 0.0, Vec3::ZERO) && near(stepped.at(1.01), 1.0, Vec3::X * 20.0));
    }

    #[test]
    fn cubic_splines_pass_their_keys_with_their_tangents() {
        // Flat tangents: an even swing, as slow at its ends as a smoothstep.
        let flat = |values: [[f32; 3]; 3]| values.iter().flat_map(|v| [[0.0; 3], *v, [0.0; 3]]).collect::<Vec<_>>();
        let still: Vec<[f32; 4]> = (0..3).flat_map(|_| [[0.0; 4], Quat::IDENTITY.to_array(), [0.0; 4]]).collect();
        let track = head(&file("CUBICSPLINE", &flat(PLACES), &still));
        assert!((track.at(0.5).1.x - 10.0).abs() < 0.02 && (track.at(0.25).1.x - 20.0 * 0.15625).abs() < 0.05);
        assert!(track.at(1.0).1.distance(Vec3::X * 20.0) < 0.02);
    }

    #[test]
    fn a_key_without_a_time_is_told_with_its_channel_and_what_to_do() {
        let good = file("LINEAR", &PLACES, &turns());
        // The times are what the binary chunk begins with.
        let at = good.windows(4).position(|four| four == b"BIN\0").unwrap() + 4;
        let why = |key_idx: usize, secs: f32| {
            let mut bytes = good.clone();
            bytes[at + 4 * key_idx..][..4].copy_from_slice(&secs.to_le_bytes());
            read_motions_from_bytes("a.glb", &bytes).unwrap_err().to_string()
        };
        for (why, said) in [
            (why(1, f32::NAN), "key 1 is NaN"),
            (why(2, f32::INFINITY), "key 2 is inf"),
            (why(2, 0.5), "key 2 is at 0.5 s, before the key at 1 s"),
        ] {
            for words in [said, "animation 0, channel 0 (translation of node 1 \"Head\")", "Export the animation again"]
            {
                assert!(why.contains(words), "{why}");
            }
        }
    }

    #[test]
    fn files_without_movement_or_with_broken_keys_say_so() {
        let still = br#"{"asset":{"version":"2.0"},"nodes":[{}]}"#;
        let why = read_motions_from_bytes("a.gltf", still).unwrap_err().to_string();
        assert!(why.contains("no animation") && why.contains("a.gltf"), "{why}");
        let why = read_motions_from_bytes("a.glb", &file("LINEAR", &PLACES[..2], &turns())).unwrap_err().to_string();
        assert!(why.contains("channel 0") && why.contains("3 times"), "{why}");
        let tracks = read_motions_from_bytes("a.glb", &file("LINEAR", &PLACES, &turns())).unwrap();
        assert!(track_of(&tracks, Some("Hips")).unwrap_err().contains("Head"));
        assert_eq!(track_of(&tracks, None).unwrap().name, "Head");
        let good = file("LINEAR", &PLACES, &turns());
        for n in (0..good.len()).step_by(13) {
            // Never a panic, whatever is cut off.
            let _ = read_motions_from_bytes("a.glb", &good[..n.max(1)]);
        }
    }
}
