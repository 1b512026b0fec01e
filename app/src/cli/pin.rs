//! `--pin`: a ball on the head that holds what hair lies in it, without a window.

use glam::Vec3;
use lorelei_core::pin::{Pin, RADII};

use super::wind_source::{finite, within};

/// How it is written.
pub const SYNTAX: &str = "X,Y,Z[,KEY=VALUE...]";
const EXAMPLE: &str = "7,2,3,radius=1.5";

/// Read [`SYNTAX`], for clap.
pub fn parse(text: &str) -> Result<Pin, String> {
    let mut parts = text.split(',').map(str::trim);
    let mut place = [0.0; 3];
    for (axis, place) in ["x", "y", "z"].into_iter().zip(&mut place) {
        let number = parts.next().ok_or_else(|| format!("{axis} is missing: {SYNTAX}, such as {EXAMPLE}"))?;
        *place = finite(number, "a place, in centimetres")?;
    }
    let mut pin = Pin { centre: Vec3::from_array(place), ..Pin::default() };
    for part in parts {
        let (key, value) = part.split_once('=').ok_or_else(|| format!("{part:?}: write it as KEY=VALUE"))?;
        match (key.trim(), value.trim()) {
            ("name", name) => name.clone_into(&mut pin.name),
            ("radius", number) => pin.radius = within(number, "the radius in centimetres", RADII)?,
            (key, _) => return Err(format!("there is no {key:?}: radius, name")),
        }
    }
    Ok(pin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pin_is_read_and_what_is_wrong_is_said() {
        let read = parse("7, -2.5,3, radius=2, name=temple").unwrap();
        assert_eq!((read.centre, read.radius, read.name.as_str()), (Vec3::new(7.0, -2.5, 3.0), 2.0, "temple"));
        assert!(read.on && parse("1,2,3").unwrap().radius == Pin::default().radius);
        for (text, said) in [
            ("1,2", "z is missing"),
            ("1,b,2", "\"b\""),
            ("1,2,inf", "\"inf\""),
            ("1,2,3,4", "KEY=VALUE"),
            ("1,2,3,radius=0", "0.1 to 30"),
            ("1,2,3,size=2", "radius, name"),
        ] {
            let why = parse(text).unwrap_err();
            assert!(why.contains(said), "{text}: {why}");
        }
    }
}
