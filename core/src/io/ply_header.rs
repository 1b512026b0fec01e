//! The header of a PLY file: which elements come, how many of each, with which properties.

use super::error::{Place, ReadError};
use super::source::Source;

/// How the numbers after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub(crate) fn n_bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What means 1 where the number is a share: the largest whole number, or 1 for floats.
    pub(crate) fn full_scale(self) -> f64 {
        match self {
            Self::I8 => f64::from(i8::MAX),
            Self::U8 => f64::from(u8::MAX),
            Self::I16 => f64::from(i16::MAX),
            Self::U16 => f64::from(u16::MAX),
            Self::I32 => f64::from(i32::MAX),
            Self::U32 => f64::from(u32::MAX),
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// The number from its bytes, least significant first.
    pub(crate) fn value(self, b: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(b[0] as i8),
            Self::U8 => f64::from(b[0]),
            Self::I16 => f64::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([b[0], b[1]])),
            Self::I32 => f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::U32 => f64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
            Self::F64 => f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]),
        }
    }
}

pub(crate) struct Property {
    pub name: String,
    /// Type of the number, or of a list's items.
    pub scalar: Scalar,
    /// Type of the list's length, where it is a list.
    pub list: Option<Scalar>,
}

pub(crate) struct Element {
    pub name: String,
    pub n: u64,
    pub properties: Vec<Property>,
}

impl Element {
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }

    /// Bytes that a row takes at least.
    pub(crate) fn min_row_bytes(&self, encoding: Encoding) -> u64 {
        let of = |property: &Property| match encoding {
            // A digit; the spaces between are left out of the reckoning.
            Encoding::Ascii => 1,
            Encoding::LittleEndian | Encoding::BigEndian => property.list.unwrap_or(property.scalar).n_bytes() as u64,
        };
        self.properties.iter().map(of).sum()
    }
}

pub(crate) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Lines that the header took.
    pub n_lines: u64,
}

impl Header {
    /// Read up to and with `end_header`.
    pub(crate) fn read(source: &mut Source<'_>) -> Result<Self, ReadError> {
        // Real headers have some twenty lines.
        const MAX_LINES: u64 = 1000;
        const MAX_LINE: usize = 4096;
        const NEXT: &str = "The header is damaged: export the file again";
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut line = String::new();
        for n_lines in 1..=MAX_LINES {
            if !source.line(&mut line, MAX_LINE)? {
                return Err(source.corrupt(
                    Place::Line(n_lines),
                    "has a header that does not end: no `end_header`",
                    NEXT,
                ));
            }
            let bad = |problem: String| Err(source.corrupt(Place::Line(n_lines), problem, NEXT));
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["ply"] | ["comment" | "obj_info", ..] | [] => {}
                ["format", name, _version] => {
                    encoding = Some(match *name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::LittleEndian,
                        "binary_big_endian" => Encoding::BigEndian,
                        _ => return bad(format!("has the unknown encoding `{name}`")),
                    });
                }
                ["element", name, n] => {
                    let Ok(n) = n.parse() else { return bad(format!("has an element count `{n}` that is no number")) };
                    elements.push(Element { name: (*name).to_owned(), n, properties: Vec::new() });
                }
                ["property", rest @ ..] => {
                    let property = match rest {
                        ["list", length, item, name] => {
                            (name, Scalar::from_name(item), Some(Scalar::from_name(length)))
                        }
                        [scalar, name] => (name, Scalar::from_name(scalar), None),
                        _ => return bad(format!("has a property that is not understood: `{line}`")),
                    };
                    let ((name, Some(scalar), None | Some(Some(_))), Some(element)) = (property, elements.last_mut())
                    else {
                        return bad(format!("has a property that is not understood: `{line}`"));
                    };
                    let list = property.2.flatten();
                    element.properties.push(Property { name: (*name).to_owned(), scalar, list });
                }
                ["end_header"] => {
                    let Some(encoding) = encoding else {
                        return bad("has no `format` line before the end of the header".to_owned());
                    };
                    return Ok(Self { encoding, elements, n_lines });
                }
                _ => return bad(format!("has a line that is not understood: `{line}`")),
            }
        }
        Err(source.corrupt(Place::Line(MAX_LINES), "has a header of more than 1000 lines", NEXT))
    }
}
