//! A file as bytes that are checked before they are believed: length first, then allocation.
//!
//! Every reader pulls from a [`Source`]. It knows how many bytes are left, where it is, and whom to
//! tell about progress; so no reader can allocate more than the file justifies, and every error knows
//! its place. Mapping the file into memory was rejected: a file that another program cuts short
//! meanwhile would kill the process.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use bytemuck::Pod;

use super::error::{Place, ReadError};

// All formats here are little-endian, and arrays are read straight into memory.
const _: () = assert!(cfg!(target_endian = "little"));

/// Bytes between two looks at the cancel flag.
const CHUNK: usize = 1 << 20;

/// Whom to tell about progress, and who may stop a long read or write.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Called now and then with the share that is done, 0-1.
    pub on_progress: Option<&'a dyn Fn(f32)>,
    /// Set it from any thread to stop.
    pub cancel: Option<&'a AtomicBool>,
}

impl<'a> Watch<'a> {
    pub fn new(on_progress: &'a dyn Fn(f32), cancel: &'a AtomicBool) -> Self {
        Self { on_progress: Some(on_progress), cancel: Some(cancel) }
    }

    /// Tell how much is done, 0-1.
    pub fn progress(&self, share: f32) {
        if let Some(on_progress) = self.on_progress {
            on_progress(share);
        }
    }

    pub fn cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }
}

/// What a source reads from.
trait Bytes: Read + Seek {}
impl<T: Read + Seek> Bytes for T {}

/// An open file, or bytes in memory under a name.
pub struct Source<'a> {
    path: PathBuf,
    reader: BufReader<Box<dyn Bytes + 'a>>,
    len: u64,
    offset: u64,
    told: u64,
    /// Bytes that this read may take in memory.
    allowance: u64,
    watch: Watch<'a>,
}

impl<'a> Source<'a> {
    /// Open a regular file that is not empty.
    pub fn open(path: &Path, watch: Watch<'a>) -> Result<Self, ReadError> {
        let open_error = |source| ReadError::Open { path: path.to_owned(), source };
        // Asked before opening: opening a pipe would wait for its other end.
        let metadata = std::fs::metadata(path).map_err(open_error)?;
        if !metadata.is_file() {
            let what = if metadata.is_dir() { "a folder" } else { "a device or pipe" };
            return Err(ReadError::NotAFile { path: path.to_owned(), what });
        }
        let file = File::open(path).map_err(open_error)?;
        let len = file.metadata().map_err(open_error)?.len();
        Self::new(path, Box::new(file), len, watch)
    }

    /// Read from memory; `name` stands for the path in errors and for its extension.
    pub fn from_bytes(name: &str, bytes: &'a [u8], watch: Watch<'a>) -> Result<Self, ReadError> {
        Self::new(Path::new(name), Box::new(Cursor::new(bytes)), bytes.len() as u64, watch)
    }

    fn new(path: &Path, reader: Box<dyn Bytes + 'a>, len: u64, watch: Watch<'a>) -> Result<Self, ReadError> {
        if len == 0 {
            return Err(ReadError::Empty { path: path.to_owned() });
        }
        let reader = BufReader::with_capacity(CHUNK.min(len as usize), reader);
        let allowance = usable_memory();
        Ok(Self { path: path.to_owned(), reader, len, offset: 0, told: 0, allowance, watch })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn watch(&self) -> Watch<'a> {
        self.watch
    }

    /// Bytes in the file.
    pub fn n_bytes(&self) -> u64 {
        self.len
    }

    pub fn offset(&self) -> u64 {
        self.offset
    }

    pub fn remaining(&self) -> u64 {
        self.len.saturating_sub(self.offset)
    }

    /// Go to an absolute offset.
    pub fn seek(&mut self, offset: u64) -> Result<(), ReadError> {
        // A relative seek keeps what is already buffered.
        let step = offset as i64 - self.offset as i64;
        self.reader.seek_relative(step).map_err(|source| self.io(source))?;
        self.offset = offset;
        Ok(())
    }

    /// Back to the first byte.
    pub fn rewind(&mut self) -> Result<(), ReadError> {
        self.reader.seek(SeekFrom::Start(0)).map_err(|source| self.io(source))?;
        self.offset = 0;
        Ok(())
    }

    /// The first bytes of the file, at most `n`, without moving on from byte 0.
    pub fn peek_start(&mut self, n: usize) -> Result<Vec<u8>, ReadError> {
        self.rewind()?;
        let mut bytes = vec![0; n.min(self.len as usize)];
        self.read_exact(&mut bytes, "the beginning")?;
        self.rewind()?;
        Ok(bytes)
    }

    pub fn read_exact(&mut self, bytes: &mut [u8], part: &str) -> Result<(), ReadError> {
        self.require(bytes.len() as u128, part)?;
        self.reader.read_exact(bytes).map_err(|source| self.io(source))?;
        self.advance(bytes.len() as u64)
    }

    pub fn u32(&mut self, part: &str) -> Result<u32, ReadError> {
        let mut bytes = [0; 4];
        self.read_exact(&mut bytes, part)?;
        Ok(u32::from_le_bytes(bytes))
    }

    pub fn f32(&mut self, part: &str) -> Result<f32, ReadError> {
        self.u32(part).map(f32::from_bits)
    }

    /// An array of `n` values as they lie in the file.
    pub fn array<T: Pod>(&mut self, n: u64, part: &str) -> Result<Vec<T>, ReadError> {
        self.require(u128::from(n) * size_of::<T>() as u128, part)?;
        let mut values = self.reserve(n)?;
        values.resize(n as usize, T::zeroed());
        self.fill(&mut values, part)?;
        Ok(values)
    }

    /// Read values into a slice, in chunks, telling about progress.
    pub fn fill<T: Pod>(&mut self, values: &mut [T], part: &str) -> Result<(), ReadError> {
        for chunk in bytemuck::cast_slice_mut::<T, u8>(values).chunks_mut(CHUNK) {
            self.read_exact(chunk, part)?;
        }
        Ok(())
    }

    /// An empty vector with room for `n` values, or an error where that does not fit into memory. Call it
    /// only after [`Source::require`] or another check against the file's length.
    pub fn reserve<T>(&mut self, n: u64) -> Result<Vec<T>, ReadError> {
        let needed = n.saturating_mul(size_of::<T>() as u64);
        let mut values = Vec::new();
        if needed > self.allowance || values.try_reserve_exact(n as usize).is_err() {
            return Err(ReadError::TooLarge { path: self.path.clone(), needed, allowed: self.allowance });
        }
        self.allowance -= needed;
        Ok(values)
    }

    /// Check that `n` more bytes are there.
    pub fn require(&self, n: u128, part: &str) -> Result<(), ReadError> {
        if n <= u128::from(self.remaining()) {
            return Ok(());
        }
        Err(ReadError::Truncated {
            path: self.path.clone(),
            place: Place::Byte(self.offset),
            part: part.to_owned(),
            needed: u64::try_from(n).unwrap_or(u64::MAX),
            has: self.remaining(),
        })
    }

    /// One line without its end, as text; bytes that are not UTF-8 are replaced. `None` at the end of the file.
    pub fn line(&mut self, line: &mut String, max_len: usize) -> Result<bool, ReadError> {
        line.clear();
        let mut bytes = std::mem::take(line).into_bytes();
        let n = (&mut self.reader)
            .take(max_len as u64 + 1)
            .read_until(b'\n', &mut bytes)
            .map_err(|source| self.io(source))?;
        if n > max_len {
            return Err(self.corrupt(
                Place::Byte(self.offset),
                format!("has a line of more than {max_len} bytes"),
                "This is not a text file of this kind: check which file it is",
            ));
        }
        self.advance(n as u64)?;
        while matches!(bytes.last(), Some(b'\n' | b'\r')) {
            bytes.pop();
        }
        *line = String::from_utf8(bytes).unwrap_or_else(|e| String::from_utf8_lossy(e.as_bytes()).into_owned());
        Ok(n > 0)
    }

    /// Everything that is left, as bytes.
    pub fn rest(&mut self) -> Result<Vec<u8>, ReadError> {
        self.array(self.remaining(), "the rest of the file")
    }

    pub fn corrupt(&self, place: Place, problem: impl Into<String>, next: impl Into<String>) -> ReadError {
        ReadError::Corrupt { path: self.path.clone(), place, problem: problem.into(), next: next.into() }
    }

    pub fn wrong_kind(&self, what: impl Into<String>, next: impl Into<String>) -> ReadError {
        ReadError::WrongKind { path: self.path.clone(), what: what.into(), next: next.into() }
    }

    pub fn nothing(&self, what: impl Into<String>, next: impl Into<String>) -> ReadError {
        ReadError::Nothing { path: self.path.clone(), what: what.into(), next: next.into() }
    }

    fn io(&self, source: io::Error) -> ReadError {
        ReadError::Io { path: self.path.clone(), place: Place::Byte(self.offset), source }
    }

    fn advance(&mut self, n: u64) -> Result<(), ReadError> {
        self.offset += n;
        if self.offset >= self.told + CHUNK as u64 || self.offset < self.told {
            self.told = self.offset;
            if self.watch.cancelled() {
                return Err(ReadError::Cancelled { path: self.path.clone() });
            }
            self.watch.progress(self.offset as f32 / self.len as f32);
        }
        Ok(())
    }
}

/// Bytes that reading a file may take: 80 % of what the system says is free, where it says so, else
/// 16 GiB. Refusing early is better than being killed with unsaved work.
pub(crate) fn usable_memory() -> u64 {
    let free = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
        line.split_whitespace().nth(1)?.parse::<u64>().ok()
    });
    free.map_or(16 << 30, |kib| kib * 1024 / 5 * 4)
}
