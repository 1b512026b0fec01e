//! Texels as text, for edits that are written to files: a PNG in base 64.
//!
//! Numbers as digits were rejected: a stroke of twenty tiles would be 300 kB of text; painted texels as PNG
//! are about a fiftieth of that.

use std::io::Cursor;

use image::{ImageEncoder, ImageFormat, ImageReader};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::tiles::{ScalpMap, TILE_SIDE, Tile};

/// A map as edits and manifests hold it; `png` is empty where the texels are elsewhere.
#[derive(Serialize, Deserialize)]
pub(super) struct PackedMap {
    width: u32,
    height: u32,
    #[serde(default)]
    png: String,
}

impl From<ScalpMap> for PackedMap {
    fn from(map: ScalpMap) -> Self {
        let png = if map.has_texels() { pack(map.width(), map.height(), &map.texels()) } else { String::new() };
        Self { width: map.width(), height: map.height(), png }
    }
}

impl TryFrom<PackedMap> for ScalpMap {
    type Error = String;

    fn try_from(PackedMap { width, height, png }: PackedMap) -> Result<Self, String> {
        if width == 0 || height == 0 || width.max(height) > Self::MOST_SIDE {
            return Err(format!("a map of {width} x {height} texels"));
        }
        if png.is_empty() {
            return Ok(Self::without_texels(width, height));
        }
        let texels = unpack(width, height, &png)?;
        Self::from_texels(width, height, &texels).map_err(|error| error.to_string())
    }
}

impl Serialize for Tile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&pack(TILE_SIDE, TILE_SIDE, &self.0))
    }
}

impl<'de> Deserialize<'de> for Tile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        let texels = unpack(TILE_SIDE, TILE_SIDE, &text).map_err(D::Error::custom)?;
        Ok(Self(texels.try_into().map_err(|_| D::Error::custom("not the texels of a tile"))?))
    }
}

fn pack(width: u32, height: u32, texels: &[u8]) -> String {
    let mut png = Vec::new();
    image::codecs::png::PngEncoder::new(&mut png)
        .write_image(texels, width, height, image::ExtendedColorType::L8)
        .expect("texels of the stated size fit a PNG in memory");
    to_base64(&png)
}

fn unpack(width: u32, height: u32, text: &str) -> Result<Vec<u8>, String> {
    let png = from_base64(text).ok_or("the texels are no base 64")?;
    let size = ImageReader::with_format(Cursor::new(&png), ImageFormat::Png).into_dimensions();
    if size.map_err(|error| error.to_string())? != (width, height) {
        return Err(format!("the texels are not {width} x {height}"));
    }
    let picture = image::load_from_memory_with_format(&png, ImageFormat::Png).map_err(|error| error.to_string())?;
    Ok(picture.into_luma8().into_raw())
}

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// RFC 4648, section 4.
fn to_base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = three.iter().chain([0, 0].iter()).take(3).fold(0_u32, |bits, &byte| bits << 8 | u32::from(byte));
        for k in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= three.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

fn value_of(digit: u8) -> Option<u32> {
    Some(u32::from(match digit {
        b'A'..=b'Z' => digit - b'A',
        b'a'..=b'z' => digit - b'a' + 26,
        b'0'..=b'9' => digit - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    }))
}

fn from_base64(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    for four in text.trim().as_bytes().chunks(4) {
        let n = four.iter().position(|&digit| digit == b'=').unwrap_or(four.len());
        if four.len() != 4 || n < 2 || four[n..].iter().any(|&digit| digit != b'=') {
            return None;
        }
        let mut bits = 0_u32;
        for &digit in &four[..n] {
            bits = bits << 6 | value_of(digit)?;
        }
        bits <<= 6 * (4 - n);
        bytes.extend_from_slice(&bits.to_be_bytes()[1..n]);
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(to_base64(bytes.as_bytes()), text);
            assert_eq!(from_base64(text).unwrap(), bytes.as_bytes());
        }
        for bad in ["Z", "Zg", "Z===", "Zg=!", "Zm9"] {
            assert!(from_base64(bad).is_none(), "{bad}");
        }
    }

    #[test]
    fn a_tile_comes_back_from_text() {
        let mut tile = Tile::filled(3);
        (0..Tile::N_BYTES).for_each(|at| tile.0[at] = (at / 7) as u8);
        let text = ron::to_string(&tile).unwrap();
        assert_eq!(ron::from_str::<Tile>(&text).unwrap(), tile);
        assert!(ron::from_str::<Tile>("\"AAAA\"").is_err());
    }
}
