//! The rows of a PLY file, one at a time, whichever way they are written.

use super::error::{Place, ReadError};
use super::ply_header::{Element, Encoding, Header, Scalar};
use super::source::Source;

/// One row. A list's length is its value.
#[derive(Default)]
pub(crate) struct Row {
    pub values: Vec<f64>,
    pub lists: Vec<Vec<f64>>,
}

/// Problem of a row: where, and what.
pub(crate) type RowProblem = (Place, String);

const NEXT: &str = "The file is damaged: export it again";

/// Longest line of an ascii file; a row of numbers is shorter by far.
const MAX_LINE: usize = 1 << 20;

pub(crate) struct Body<'s, 'a> {
    pub source: &'s mut Source<'a>,
    encoding: Encoding,
    words: Words,
}

/// What is left of the current line of an ascii file.
#[derive(Default)]
struct Words {
    line: String,
    at: usize,
    line_idx: u64,
}

impl<'s, 'a> Body<'s, 'a> {
    /// Check the counts of all elements against the file's length; the source stands after the header.
    pub(crate) fn new(source: &'s mut Source<'a>, header: &Header) -> Result<Self, ReadError> {
        let mut needed = 0u128;
        for element in &header.elements {
            needed += u128::from(element.n) * u128::from(element.min_row_bytes(header.encoding));
            source.require(needed, &format!("the {} rows of element {}", element.n, element.name))?;
        }
        let words = Words { line_idx: header.n_lines, ..Words::default() };
        Ok(Self { source, encoding: header.encoding, words })
    }

    /// Hand every row of the next element to `take`.
    pub(crate) fn rows(
        &mut self,
        element: &Element,
        mut take: impl FnMut(&Row) -> Result<(), RowProblem>,
    ) -> Result<(), ReadError> {
        // Rows without properties take no bytes: their count cannot be checked and says nothing.
        if element.properties.is_empty() {
            return Ok(());
        }
        let n_columns = element.properties.len();
        let mut row = Row { values: vec![0.0; n_columns], lists: vec![Vec::new(); n_columns] };
        let is_flat = element.properties.iter().all(|property| property.list.is_none());
        let mut bytes = vec![0; element.min_row_bytes(self.encoding) as usize];
        for _ in 0..element.n {
            match self.encoding {
                Encoding::LittleEndian if is_flat => {
                    self.source.read_exact(&mut bytes, &element.name)?;
                    let mut at = 0;
                    for (property, value) in element.properties.iter().zip(&mut row.values) {
                        *value = property.scalar.value(&bytes[at..]);
                        at += property.scalar.n_bytes();
                    }
                }
                Encoding::Ascii | Encoding::LittleEndian | Encoding::BigEndian => self.row(element, &mut row)?,
            }
            take(&row).map_err(|(place, problem)| self.source.corrupt(place, problem, NEXT))?;
        }
        Ok(())
    }

    pub(crate) fn skip(&mut self, element: &Element) -> Result<(), ReadError> {
        self.rows(element, |_| Ok(()))
    }

    fn row(&mut self, element: &Element, row: &mut Row) -> Result<(), ReadError> {
        for (column, property) in element.properties.iter().enumerate() {
            let Some(length) = property.list else {
                row.values[column] = self.value(property.scalar, &element.name)?;
                continue;
            };
            let n = self.value(length, &element.name)?;
            if !(n >= 0.0 && n.fract() == 0.0 && n <= f64::from(u32::MAX)) {
                return Err(self.source.corrupt(
                    self.place(),
                    format!("has a list of the impossible length {n}"),
                    NEXT,
                ));
            }
            row.values[column] = n;
            let item_bytes = if self.encoding == Encoding::Ascii { 1 } else { property.scalar.n_bytes() as u128 };
            let n = n as usize;
            let left_in_line = (self.words.line.len() - self.words.at) as u128;
            if self.encoding != Encoding::Ascii || n as u128 > left_in_line {
                self.source.require(n as u128 * item_bytes, "a list")?;
            }
            row.lists[column].clear();
            for _ in 0..n {
                let value = self.value(property.scalar, &element.name)?;
                row.lists[column].push(value);
            }
        }
        Ok(())
    }

    fn value(&mut self, scalar: Scalar, part: &str) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            return self.word(part);
        }
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..scalar.n_bytes()];
        self.source.read_exact(bytes, part)?;
        if self.encoding == Encoding::BigEndian {
            bytes.reverse();
        }
        Ok(scalar.value(bytes))
    }

    fn word(&mut self, part: &str) -> Result<f64, ReadError> {
        loop {
            let words = &mut self.words;
            let left = &words.line[words.at..];
            let left = left.trim_start();
            if !left.is_empty() {
                let n = left.find(char::is_whitespace).unwrap_or(left.len());
                let word = &left[..n];
                let start = words.line.len() - left.len();
                let value = word.parse::<f64>();
                words.at = start + n;
                return value.map_err(|_| {
                    let word = &self.words.line[start..start + n];
                    let word: String = word.chars().take(40).collect();
                    self.source.corrupt(self.place(), format!("has `{word}` where a number of {part} is due,"), NEXT)
                });
            }
            words.line_idx += 1;
            words.at = 0;
            if !self.source.line(&mut words.line, MAX_LINE)? {
                return Err(self.source.corrupt(
                    self.place(),
                    format!("ends before all of element {part} was there,"),
                    NEXT,
                ));
            }
        }
    }

    fn place(&self) -> Place {
        match self.encoding {
            Encoding::Ascii => Place::Line(self.words.line_idx),
            Encoding::LittleEndian | Encoding::BigEndian => Place::Byte(self.source.offset()),
        }
    }
}
