//! Frames of a movement in a file: written as they are simulated, so that what was interrupted goes on.
//!
//! A header says what the frames were made from; records follow, each with its length and a checksum. A frame is the bits of
//! its numbers against those of the frame before, the like bytes of all numbers together, deflated: what rests costs nothing,
//! and what is read is what was simulated, bit for bit. Every few seconds of movement the solver's state is written too: from
//! the last one an interrupted simulation goes on. Until it is whole, the file is called NAME.part.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use glam::{Affine3A, Vec3};
use lorelei_sim::SolverState;

use super::Shot;

/// What names of such files end in.
pub const EXTENSION: &str = "frames";
const MAGIC: [u8; 8] = *b"LRLEFRMS";
const VERSION: u32 = 1;
/// Frames between two states of the solver.
const FRAMES_PER_STATE: u32 = 120;
/// More than the header of any groom.
const LONGEST_HEADER: u64 = 1 << 20;
/// A record that is longer than this is none.
const LONGEST_RECORD: u64 = 1 << 32;

/// What the frames were made from.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Of everything that decides how the frames are: [`super::key::key_of`].
    pub key: u128,
    pub fps: f32,
    /// First and last frame.
    pub start: u32,
    pub end: u32,
    /// Guide vertices of each layer.
    pub layers: Vec<u32>,
    /// The device that simulated them.
    pub device: String,
}

/// Why a file of frames cannot be read or written: what, where, and what next.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("{path}: {why}")]
    Io { path: PathBuf, why: std::io::Error },
    #[error(
        "{path} holds no frames of a movement: choose a file that `lorelei simulate --out NAME.frames` or the studio wrote"
    )]
    WrongKind { path: PathBuf },
    #[error(
        "{path} was written by a newer Lorelei (version {version} of the format): open it with that, or simulate again"
    )]
    TooNew { path: PathBuf, version: u32 },
    #[error("{path} is no file of frames and would be lost: choose another name, or remove it first")]
    WouldBeLost { path: PathBuf },
    #[error("{path} is damaged at byte {at}: simulate again")]
    Damaged { path: PathBuf, at: u64 },
}

/// A file as it was read: frames by their number, in order, and the last state.
#[derive(Debug)]
pub struct Contents {
    pub header: Header,
    pub shots: Vec<(u32, Shot)>,
    pub state: Option<(u32, SolverState)>,
    /// Where the record of the last state ends.
    resume_at: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Frame = 1,
    State = 2,
}

/// A file that is being written.
pub struct Writer {
    file: File,
    part: PathBuf,
    path: PathBuf,
    /// Words of the frame before.
    before: Vec<u32>,
    n_since_state: u32,
}

/// What a file of a name will take the place of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Replaced {
    Nothing,
    /// Frames of this movement.
    Same,
    /// Frames of another movement, whole or not.
    Other,
}

/// What [`Writer::open`] of the same path and header will take the place of. Fails where that is no file of frames, which
/// nobody means to lose.
pub fn replaced(path: &Path, header: &Header) -> Result<Replaced, FileError> {
    let of = |path: &Path| match File::open(path) {
        Ok(file) => {
            let mut first = Vec::new();
            file.take(LONGEST_HEADER)
                .read_to_end(&mut first)
                .map_err(|why| FileError::Io { path: path.to_owned(), why })?;
            // An interrupted run may have left less than a header.
            let is_same = read_header(&mut first.as_slice(), path).map(|known| known == *header);
            is_same.map(|is_same| if is_same { Replaced::Same } else { Replaced::Other })
        }
        Err(why) if why.kind() == std::io::ErrorKind::NotFound => Ok(Replaced::Nothing),
        Err(why) => Err(FileError::Io { path: path.to_owned(), why }),
    };
    let whole = match of(path) {
        Err(FileError::WrongKind { path }) => return Err(FileError::WouldBeLost { path }),
        Err(FileError::TooNew { .. } | FileError::Damaged { .. }) => Replaced::Other,
        other => other?,
    };
    let part = of(&part_of(path)).unwrap_or(Replaced::Nothing);
    Ok(if whole == Replaced::Other || part == Replaced::Other { Replaced::Other } else { whole })
}

/// What a file is called until it is whole.
fn part_of(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".part");
    path.with_file_name(name)
}

impl Writer {
    /// Begin a file, or go on with what an interrupted run has left of the same movement; returns the frames and the state
    /// to go on from.
    pub fn open(path: &Path, header: &Header) -> Result<(Self, Option<Contents>), FileError> {
        let part = part_of(path);
        let io = |why| FileError::Io { path: part.clone(), why };
        // Another device's frames are not gone on with: the same frame would not follow.
        let left = read_records(&part).ok().filter(|left| left.header == *header && left.state.is_some());
        let mut file = File::options().create(true).truncate(false).read(true).write(true).open(&part).map_err(io)?;
        let mut before = Vec::new();
        let left = left.map(|mut left| {
            let last = left.state.as_ref().map_or(0, |(at, _)| *at);
            left.shots.retain(|(frame_idx, _)| *frame_idx <= last);
            left
        });
        if let Some(left) = &left {
            file.set_len(left.resume_at).map_err(io)?;
            file.seek(SeekFrom::End(0)).map_err(io)?;
            before = left.shots.last().map_or(Vec::new(), |(_, shot)| words_of(shot));
        } else {
            file.set_len(0).map_err(io)?;
            file.write_all(&header_bytes(header)).map_err(io)?;
        }
        Ok((Self { file, part, path: path.to_owned(), before, n_since_state: 0 }, left))
    }

    /// Write a frame; true where a state should follow.
    pub fn frame(&mut self, frame_idx: u32, shot: &Shot) -> Result<bool, FileError> {
        let words = words_of(shot);
        let mut planes = vec![0; 4 * words.len()];
        for (i, &word) in words.iter().enumerate() {
            let change = word ^ self.before.get(i).copied().unwrap_or(0);
            for (plane, byte) in change.to_le_bytes().into_iter().enumerate() {
                planes[plane * words.len() + i] = byte;
            }
        }
        self.record(Kind::Frame, frame_idx, &planes)?;
        self.before = words;
        self.n_since_state += 1;
        Ok(self.n_since_state >= FRAMES_PER_STATE)
    }

    /// Write what the solver goes on from at a frame that was written.
    pub fn state(&mut self, frame_idx: u32, state: &SolverState) -> Result<(), FileError> {
        self.n_since_state = 0;
        self.record(Kind::State, frame_idx, &state.to_bytes())
    }

    /// All frames are there: the file gets its name.
    pub fn finish(self) -> Result<(), FileError> {
        let io = |why| FileError::Io { path: self.part.clone(), why };
        self.file.sync_all().map_err(io)?;
        std::fs::rename(&self.part, &self.path).map_err(io)
    }

    fn record(&mut self, kind: Kind, frame_idx: u32, contents: &[u8]) -> Result<(), FileError> {
        let io = |why| FileError::Io { path: self.part.clone(), why };
        let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(contents).map_err(io)?;
        let packed = encoder.finish().map_err(io)?;
        let mut bytes = vec![kind as u8];
        bytes.extend(frame_idx.to_le_bytes());
        bytes.extend((packed.len() as u64).to_le_bytes());
        bytes.extend(checksum(&packed).to_le_bytes());
        bytes.extend(packed);
        self.file.write_all(&bytes).map_err(io)
    }
}

/// Read a file that is whole.
pub fn read(path: &Path) -> Result<Contents, FileError> {
    let read = read_records(path)?;
    let is_whole = read.shots.last().is_some_and(|(frame_idx, _)| *frame_idx == read.header.end);
    if is_whole { Ok(read) } else { Err(FileError::Damaged { path: path.to_owned(), at: read.resume_at }) }
}

/// Every record up to the first that is not whole.
fn read_records(path: &Path) -> Result<Contents, FileError> {
    let io = |why| FileError::Io { path: path.to_owned(), why };
    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.read_to_end(&mut bytes).map_err(io)?;
    let mut rest = bytes.as_slice();
    let header = read_header(&mut rest, path)?;
    let n_words = 12 + 3 * header.layers.iter().map(|n| *n as usize).sum::<usize>();
    let mut read = Contents { header, shots: Vec::new(), state: None, resume_at: (bytes.len() - rest.len()) as u64 };
    let mut before = vec![0_u32; n_words];
    while let Some((kind, frame_idx, contents)) = read_record(&mut rest, 4 * n_words) {
        match kind {
            Kind::Frame if contents.len() == 4 * n_words => {
                for (i, word) in before.iter_mut().enumerate() {
                    let byte = |plane: usize| contents[plane * n_words + i];
                    *word ^= u32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)]);
                }
                read.shots.push((frame_idx, shot_of(&before, &read.header.layers)));
            }
            Kind::State => {
                let Some(state) = SolverState::from_bytes(&contents) else { break };
                read.state = Some((frame_idx, state));
                read.resume_at = (bytes.len() - rest.len()) as u64;
            }
            Kind::Frame => break,
        }
    }
    Ok(read)
}

fn read_record(rest: &mut &[u8], most: usize) -> Option<(Kind, u32, Vec<u8>)> {
    let mut ahead = *rest;
    let kind = match take::<1>(&mut ahead)? {
        [1] => Kind::Frame,
        [2] => Kind::State,
        _ => return None,
    };
    let frame_idx = u32::from_le_bytes(take(&mut ahead)?);
    let n_packed = u64::from_le_bytes(take(&mut ahead)?);
    let sum = u32::from_le_bytes(take(&mut ahead)?);
    if n_packed > LONGEST_RECORD {
        return None;
    }
    let (packed, behind) = ahead.split_at_checked(n_packed as usize)?;
    if checksum(packed) != sum {
        return None;
    }
    let mut contents = Vec::new();
    // A state holds a few arrays of every vertex; a small file must not unpack to more than that.
    DeflateDecoder::new(packed).take(16 * most as u64 + (1 << 20)).read_to_end(&mut contents).ok()?;
    *rest = behind;
    Some((kind, frame_idx, contents))
}

fn header_bytes(header: &Header) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(header.key.to_le_bytes());
    bytes.extend(header.fps.to_le_bytes());
    for number in [header.start, header.end, header.layers.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    header.layers.iter().for_each(|n| bytes.extend(n.to_le_bytes()));
    bytes.extend((header.device.len() as u32).to_le_bytes());
    bytes.extend(header.device.as_bytes());
    bytes
}

fn read_header(rest: &mut &[u8], path: &Path) -> Result<Header, FileError> {
    let wrong_kind = || FileError::WrongKind { path: path.to_owned() };
    if take(rest) != Some(MAGIC) {
        return Err(wrong_kind());
    }
    let version = u32::from_le_bytes(take(rest).ok_or_else(wrong_kind)?);
    if version > VERSION {
        return Err(FileError::TooNew { path: path.to_owned(), version });
    }
    let mut header = || -> Option<Header> {
        let key = u128::from_le_bytes(take(rest)?);
        let fps = f32::from_le_bytes(take(rest)?);
        let start = u32::from_le_bytes(take(rest)?);
        let end = u32::from_le_bytes(take(rest)?);
        let n_layers = u32::from_le_bytes(take(rest)?);
        let layers = (0..n_layers).map(|_| take(rest).map(u32::from_le_bytes)).collect::<Option<_>>()?;
        let n = u32::from_le_bytes(take(rest)?) as usize;
        let (device, behind) = rest.split_at_checked(n)?;
        *rest = behind;
        Some(Header { key, fps, start, end, layers, device: String::from_utf8_lossy(device).into_owned() })
    };
    header().ok_or_else(|| FileError::Damaged { path: path.to_owned(), at: MAGIC.len() as u64 })
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (bytes, behind) = rest.split_at_checked(N)?;
    *rest = behind;
    bytes.try_into().ok()
}

fn checksum(bytes: &[u8]) -> u32 {
    let mut sum = flate2::Crc::new();
    sum.update(bytes);
    sum.sum()
}

/// A frame's numbers as bits: the head's pose, then every vertex.
fn words_of(shot: &Shot) -> Vec<u32> {
    let pose = shot.world_from_head.to_cols_array();
    let positions = shot.positions.iter().flatten().flat_map(Vec3::to_array);
    pose.into_iter().chain(positions).map(f32::to_bits).collect()
}

fn shot_of(words: &[u32], layers: &[u32]) -> Shot {
    let (pose, mut rest) = words.split_at(12);
    let world_from_head = Affine3A::from_cols_slice(&pose.iter().map(|bits| f32::from_bits(*bits)).collect::<Vec<_>>());
    let positions = layers.iter().map(|&n| {
        let (layer, behind) = rest.split_at(3 * n as usize);
        rest = behind;
        layer.chunks_exact(3).map(|p| Vec3::from_array([p[0], p[1], p[2]].map(f32::from_bits))).collect()
    });
    Shot { world_from_head, positions: positions.collect() }
}
