//! `--wind-source`: a fan or a vortex that stands in the scene, without a window.

use glam::Vec3;
use lorelei_core::groom::Groom;
use lorelei_core::look::Choice;
use lorelei_core::simulation::Wind;
use lorelei_core::wind::{MAX_RADIUS, MAX_SPEED, SourceKind, WindSource};

use crate::stage::bounds_of;

/// A source as it was asked for; what was not said is as the panel's buttons make it.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceArgument {
    source: WindSource,
    /// Where it blows to; the groom's middle where nothing is said. What a vortex turns about points up then.
    to: Option<Vec3>,
}

/// How it is written.
pub const SYNTAX: &str = "KIND,X,Y,Z[,KEY=VALUE...]";
const EXAMPLE: &str = "fan,45,0,20,speed=800,to=0/2/0";

/// Read [`SYNTAX`], for clap.
pub fn parse(text: &str) -> Result<SourceArgument, String> {
    let mut parts = text.split(',').map(str::trim);
    let mut next = |what: &str| parts.next().ok_or_else(|| format!("{what} is missing: {SYNTAX}, such as {EXAMPLE}"));
    let name = next("the kind")?;
    let kind = SourceKind::ALL.iter().copied().find(|kind| kind.info().name == name).ok_or_else(|| {
        let kinds = SourceKind::ALL.iter().map(|kind| kind.info().name).collect::<Vec<_>>().join(", ");
        format!("the kind {name:?}: use one of {kinds}; {SYNTAX}, such as {EXAMPLE}")
    })?;
    let place = [next("x")?, next("y")?, next("z")?].map(|number| finite(number, "a place, in centimetres"));
    let [x, y, z] = place;
    let source =
        WindSource { name: kind.info().label.to_owned(), kind, place: Vec3::new(x?, y?, z?), ..WindSource::default() };
    let mut argument = SourceArgument { source, to: None };
    for part in parts {
        let (key, value) = part.split_once('=').ok_or_else(|| format!("{part:?}: write it as KEY=VALUE"))?;
        argument.set(key.trim(), value.trim())?;
    }
    Ok(argument)
}

/// A number of what is meant.
pub(super) fn finite(text: &str, what: &str) -> Result<f32, String> {
    text.parse::<f32>()
        .ok()
        .filter(|number| number.is_finite())
        .ok_or_else(|| format!("{text:?}: a number is wanted, {what}"))
}

/// The same in a range.
pub(super) fn within(text: &str, what: &str, (min, max): (f32, f32)) -> Result<f32, String> {
    let number = finite(text, what)?;
    let is_within = (min..=max).contains(&number);
    is_within.then_some(number).ok_or_else(|| format!("{text}: {what}, from {min} to {max}"))
}

impl SourceArgument {
    fn set(&mut self, key: &str, value: &str) -> Result<(), String> {
        let source = &mut self.source;
        match key {
            "name" => value.clone_into(&mut source.name),
            "speed" => source.speed = within(value, "the speed in cm/s", (0.0, MAX_SPEED))?,
            "radius" => source.radius = within(value, "the radius in centimetres", (0.5, MAX_RADIUS))?,
            "falloff" => source.falloff = within(value, "the falloff", (0.0, 20.0))?,
            "gusts" => source.gusts.strength = within(value, "gusts as a share of the speed", (0.0, 2.0))?,
            "gust-period" => source.gusts.period_secs = within(value, "seconds between gusts", (0.1, 60.0))?,
            "eddies" => source.eddies.amount = within(value, "eddies as a share of the speed", (0.0, 2.0))?,
            "eddy-size" => source.eddies.size_cm = within(value, "the size of eddies in centimetres", (0.5, 200.0))?,
            "seed" => {
                source.eddies.seed = value.parse().map_err(|_| format!("{value:?}: a seed is a whole number"))?;
            }
            "to" => {
                let numbers: Vec<f32> = value
                    .split('/')
                    .map(|number| finite(number, "a place X/Y/Z, in centimetres"))
                    .collect::<Result<_, _>>()?;
                let [x, y, z] = numbers[..] else { return Err(format!("{value:?}: a place is X/Y/Z, such as 0/2/0")) };
                self.to = Some(Vec3::new(x, y, z));
            }
            _ => {
                return Err(format!(
                    "there is no {key:?}: name, speed, radius, falloff, gusts, gust-period, eddies, eddy-size, seed, to"
                ));
            }
        }
        Ok(())
    }
}

/// Put sources beside those that the groom has. They blow on the grid, so the wind becomes one.
pub fn apply(groom: &mut Groom, arguments: &[SourceArgument]) {
    if arguments.is_empty() {
        return;
    }
    let (min, max) = bounds_of(groom);
    for SourceArgument { source, to } in arguments {
        let to_there = to.map(|to| to - source.place);
        let direction = match source.kind {
            SourceKind::Fan => to_there.unwrap_or(0.5 * (min + max) - source.place),
            SourceKind::Vortex => to_there.unwrap_or(Vec3::Y),
        };
        groom.simulation.sources.push(WindSource { direction, ..source.clone() }.tamed());
    }
    groom.simulation.wind = Wind::Grid;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_is_read_aimed_and_makes_the_wind_a_grid() {
        let mut groom = lorelei_assets::default_groom();
        let n_before = groom.simulation.sources.len();
        let fan = parse("fan,45,0,20,speed=800,radius=4,gusts=0.5,name=dryer").unwrap();
        let vortex = parse("vortex, 0, -10, -30, to=0/-10/0, eddies=0.2").unwrap();
        apply(&mut groom, &[fan, vortex]);
        let [fan, vortex] = &groom.simulation.sources[n_before..] else { panic!() };
        assert_eq!(
            (fan.kind, fan.place, fan.speed, fan.radius),
            (SourceKind::Fan, Vec3::new(45.0, 0.0, 20.0), 800.0, 4.0)
        );
        assert!(fan.name == "dryer" && fan.gusts.strength == 0.5 && fan.direction.x < -0.5, "{fan:?}");
        assert_eq!((vortex.kind, vortex.direction, vortex.eddies.amount), (SourceKind::Vortex, Vec3::Z, 0.2));
        assert_eq!(groom.simulation.wind, Wind::Grid);
        let calm = lorelei_assets::default_groom();
        let mut still = calm.clone();
        apply(&mut still, &[]);
        assert!(still == calm, "none asked for, nothing changed");
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, said) in [
            ("", "fan, vortex"),
            ("blower,0,0,0", "fan, vortex"),
            ("fan,0,0", "z is missing"),
            ("fan,0,a,0", "\"a\""),
            ("fan,0,0,inf", "\"inf\""),
            ("fan,0,0,0,800", "KEY=VALUE"),
            ("fan,0,0,0,speed=9e9", "from 0 to 5000"),
            ("fan,0,0,0,sped=9", "speed, radius"),
            ("fan,0,0,0,to=1/2", "X/Y/Z"),
        ] {
            let why = parse(text).unwrap_err();
            assert!(why.contains(said), "{text}: {why}");
        }
    }
}
