//! `--set KEY=VALUE`: the look, movement, and of every layer its fibre, its counts and widths, and its style
//! operators, all through the tables behind the panels.

use std::sync::Arc;

use lorelei_core::groom::{Groom, HairMaterial, HairPreset, Layer, Source};
use lorelei_core::look::{Choice, Param, SetError, Slot, set};
use lorelei_core::maps::MapKind;
use lorelei_core::simulation::HairKind;
use lorelei_core::strands::Strands;
use lorelei_core::style::{Profile, SHAPES, StyleKind, StyleOp};

use super::CliError;

/// Takes a hair colour by name.
pub const PRESET_KEY: &str = "hair.preset";

/// Takes a kind of hair, by how it moves.
pub const KIND_KEY: &str = "sim.kind";

/// Split `KEY=VALUE`, for clap.
pub fn parse_assignment(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("write it as KEY=VALUE, such as shadowing=off")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Apply assignments in order.
pub fn apply(groom: &mut Groom, assignments: &[(String, String)]) -> Result<(), CliError> {
    for (key, value) in assignments {
        apply_one(groom, key, value).map_err(|why| CliError::Usage(format!("--set {key}={value}: {why}")))?;
    }
    Ok(())
}

fn apply_one(groom: &mut Groom, key: &str, value: &str) -> Result<(), SetError> {
    let head = key.split('.').next().unwrap_or_default();
    if key == PRESET_KEY {
        let preset = HairPreset::by_name(value).ok_or_else(|| {
            let takes = HairPreset::ALL.iter().map(|preset| preset.info().name).collect::<Vec<_>>().join(", ");
            SetError::BadValue { key: key.to_owned(), value: value.to_owned(), takes }
        })?;
        groom.layers.iter_mut().for_each(|layer| layer.material.take(preset));
        return Ok(());
    }
    if key == KIND_KEY {
        let kind = HairKind::ALL.iter().copied().find(|kind| kind.info().name == value).ok_or_else(|| {
            let takes = HairKind::ALL.iter().map(|kind| kind.info().name).collect::<Vec<_>>().join(", ");
            SetError::BadValue { key: key.to_owned(), value: value.to_owned(), takes }
        })?;
        groom.simulation.take(kind);
        return Ok(());
    }
    if head == "hair" {
        // Checked even where there is no layer.
        set(&mut [HairMaterial::default().slot()], key, value)?;
        return groom.layers.iter_mut().try_for_each(|layer| set(&mut [layer.material.slot()], key, value));
    }
    match head {
        "layer" => return set_layers(groom, key, value),
        "style" => return set_style(groom, key, value),
        _ => {}
    }
    let Groom { look, simulation, .. } = groom;
    let mut slots: Vec<Slot<'_>> = look.slots();
    slots.extend(simulation.slots());
    set(&mut slots, key, value)
}

/// A layer whose every number can be set, to ask what there is.
pub fn sample_layer() -> Layer {
    Layer::new("", Source::Guides(Arc::new(Strands::default())))
}

/// `layer.KEY`: a number of every layer. Imported strands are as many as they are, so they pass over a count.
fn set_layers(groom: &mut Groom, key: &str, value: &str) -> Result<(), SetError> {
    set_param(sample_layer().params(), key, value)?;
    for layer in &mut groom.layers {
        if let Some(mut param) = layer.params().into_iter().find(|param| param.key == key) {
            param.set_from_text(value)?;
        }
    }
    Ok(())
}

/// How operators of a kind are called in keys: `style.curl.radius`.
pub fn style_key(kind: StyleKind) -> String {
    format!("style.{}", kind.label().to_lowercase())
}

/// The numbers of an operator under the keys that `--set` takes.
pub fn style_params(op: &mut StyleOp) -> Vec<Param<'_>> {
    let prefix = style_key(op.kind);
    let mut params = op.params();
    for param in &mut params {
        param.key = format!("{prefix}{}", param.key.trim_start_matches("style"));
    }
    params
}

/// What of an operator is no number: the word after `style.KIND`, the values that it takes by name, what else it
/// takes, and what it is for.
pub struct StyleWord {
    pub word: &'static str,
    /// (name, label, help).
    pub names: Vec<(String, String, String)>,
    pub also: &'static str,
    pub help: &'static str,
}

/// The words of operators of a kind.
pub fn style_words(kind: StyleKind) -> [StyleWord; 4] {
    let name = |name: &str, label: &str, help: &str| (name.to_owned(), label.to_owned(), help.to_owned());
    let blends = kind.blends().iter().map(|blend| blend.info());
    let kinds = [MapKind::Density, MapKind::Length, MapKind::Clump, MapKind::Curl];
    let maps = kinds.iter().map(|map| (map.to_string(), map.label(), map.help().to_owned()));
    [
        StyleWord {
            word: "solo",
            names: vec![name("off", "Off", "Acts while none is solo"), name("on", "On", "Only solo operators act")],
            also: "",
            help: "While any operator is solo, only those act",
        },
        StyleWord {
            word: "blend",
            names: blends.map(|info| name(info.name, info.label, info.help)).collect(),
            also: "",
            help: "How it joins the operators before it",
        },
        StyleWord {
            word: "map",
            names: std::iter::once(name("none", "Everywhere", "No map")).chain(maps).collect(),
            also: "mask:NAME",
            help: "A painted map that says what share of its strength there is",
        },
        StyleWord {
            word: "curve",
            names: SHAPES.iter().map(|shape| name(shape.name, shape.label, shape.help)).collect(),
            also: "2-8 points from root to tip as PLACE/STRENGTH: 0/0.5,0.4/1,1/0",
            help: "Its strength from root to tip, in place of the ramp",
        },
    ]
}

/// What an operator has for a word.
pub fn style_word_of(op: &StyleOp, word: &str) -> String {
    match word {
        "solo" => if op.solo { "on" } else { "off" }.to_owned(),
        "blend" => op.blend().info().name.to_owned(),
        "map" => op.map.as_ref().map_or("none".to_owned(), ToString::to_string),
        _ => match op.curve.shape() {
            Some(shape) => shape.name.to_owned(),
            None => op.curve.points().iter().map(|[x, y]| format!("{x}/{y}")).collect::<Vec<_>>().join(","),
        },
    }
}

/// Set a word of an operator; `None` where there is no such word, false where it does not take the value.
fn set_style_word(op: &mut StyleOp, word: &str, value: &str) -> Option<bool> {
    let taken = match word {
        "solo" => ["on", "off"].contains(&value).then(|| op.solo = value == "on"),
        "blend" => {
            let blend = op.kind.blends().iter().find(|blend| blend.info().name == value);
            blend.map(|blend| op.blend = *blend)
        }
        "map" if value == "none" => {
            op.map = None;
            Some(())
        }
        "map" => value.parse().ok().map(|kind| op.map = Some(kind)),
        "curve" => parse_curve(value).map(|curve| op.curve = curve),
        _ => return None,
    };
    Some(taken.is_some())
}

fn parse_curve(text: &str) -> Option<Profile> {
    if let Some(shape) = SHAPES.iter().find(|shape| shape.name == text) {
        return Some(Profile::of(shape.points));
    }
    let point = |text: &str| {
        let (x, y) = text.split_once('/')?;
        Some([x.trim().parse().ok()?, y.trim().parse().ok()?])
    };
    let points: Vec<[f32; 2]> = text.split(',').map(point).collect::<Option<_>>()?;
    let is_within = points.iter().flatten().all(|v| (0.0..=1.0).contains(v));
    let n_points = points.len();
    let curve = Profile::from(points);
    (is_within && curve.points().len() == n_points).then_some(curve)
}

/// `style.KIND.KEY`: a number, or one of [`style_words`], of every operator of that kind in every layer;
/// `style.KIND=on` or `=off`.
fn set_style(groom: &mut Groom, key: &str, value: &str) -> Result<(), SetError> {
    let kind = StyleKind::DEFAULTS.into_iter().find(|kind| {
        let name = style_key(*kind);
        key == name || key.strip_prefix(&name).is_some_and(|rest| rest.starts_with('.'))
    });
    let Some(kind) = kind else {
        let close = StyleKind::DEFAULTS.map(style_key).join(", ");
        return Err(SetError::UnknownKey { key: key.to_owned(), close });
    };
    let ops = groom.layers.iter_mut().flat_map(|layer| &mut layer.style);
    let alike = ops.filter(|op| op.kind.label() == kind.label());
    if key == style_key(kind) {
        let on = match value {
            "on" => true,
            "off" => false,
            _ => {
                let (key, value) = (key.to_owned(), value.to_owned());
                return Err(SetError::BadValue { key, value, takes: "on, off".to_owned() });
            }
        };
        alike.for_each(|op| op.on = on);
        return Ok(());
    }
    let word = key.rsplit('.').next().unwrap_or_default();
    if let Some(is_taken) = set_style_word(&mut StyleOp::new(kind), word, value) {
        if !is_taken {
            let takes = style_words(kind).into_iter().filter(|known| known.word == word).flat_map(|known| {
                let also = (!known.also.is_empty()).then(|| known.also.to_owned());
                known.names.into_iter().map(|(name, ..)| name).chain(also)
            });
            let takes = takes.collect::<Vec<_>>().join(", ");
            return Err(SetError::BadValue { key: key.to_owned(), value: value.to_owned(), takes });
        }
        alike.for_each(|op| {
            set_style_word(op, word, value);
        });
        return Ok(());
    }
    set_param(style_params(&mut StyleOp::new(kind)), key, value)?;
    for op in alike {
        if word == "ramp" {
            // A drawn curve would count instead.
            op.curve = Profile::default();
        }
        set_param(style_params(op), key, value)?;
    }
    Ok(())
}

fn set_param(mut params: Vec<Param<'_>>, key: &str, value: &str) -> Result<(), SetError> {
    let keys = || params.iter().map(|param| param.key.as_str()).collect::<Vec<_>>().join(", ");
    let unknown = SetError::UnknownKey { key: key.to_owned(), close: keys() };
    params.iter_mut().find(|param| param.key == key).ok_or(unknown)?.set_from_text(value)
}

#[cfg(test)]
mod tests {
    use lorelei_core::style::Blend;

    use super::*;

    #[test]
    fn layer_and_style_keys_reach_every_layer_and_every_operator_of_the_kind() {
        let mut curly = sample_layer();
        curly.style = StyleKind::DEFAULTS.map(StyleOp::new).to_vec();
        let given = Layer { style: curly.style.clone(), ..Layer::from_strands("given", Strands::default()) };
        let mut groom = Groom { layers: vec![curly, given], ..Groom::default() };
        let assignments =
            ["layer.radius=90", "layer.strands=500", "layer.tip=0.5", "style.curl.radius=1.5", "style.frizz=off"]
                .map(|text| parse_assignment(text).unwrap());
        apply(&mut groom, &assignments).unwrap();
        for layer in &groom.layers {
            assert_eq!((layer.radius_um, layer.tip_radius), (90.0, 0.5));
            for op in &layer.style {
                assert_eq!(op.on, op.kind.label() != "Frizz");
                if let StyleKind::Curl { radius, .. } = op.kind {
                    assert_eq!(radius, 1.5);
                }
            }
        }
        // Imported strands are as many as there are.
        assert_eq!([groom.layers[0].n_strands, groom.layers[1].n_strands], [500, 0]);
        for bad in ["layer.width=1", "layer.radius=-1", "style.perm.radius=1", "style.curl.bend=1", "style.curl=maybe"]
        {
            let assignment = parse_assignment(bad).unwrap();
            assert!(matches!(apply(&mut groom, &[assignment]), Err(CliError::Usage(_))), "{bad}");
        }
    }

    #[test]
    fn solo_blend_map_and_curve_of_operators_are_set_by_words() {
        let mut layer = sample_layer();
        layer.style = StyleKind::DEFAULTS.map(StyleOp::new).to_vec();
        let mut groom = Groom { layers: vec![layer], ..Groom::default() };
        let set = |groom: &mut Groom, text: &str| apply(groom, &[parse_assignment(text).unwrap()]);
        for text in [
            "style.wave.solo=on",
            "style.wave.blend=modulate",
            "style.wave.map=mask:fringe",
            "style.wave.curve=0/0.5,0.4/1,1/0",
            "style.part.ramp=2",
        ] {
            set(&mut groom, text).unwrap();
        }
        let of = |groom: &Groom, label: &str| {
            groom.layers[0].style.iter().find(|op| op.kind.label() == label).cloned().unwrap()
        };
        let wave = of(&groom, "Wave");
        assert!(wave.solo && wave.blend == Blend::Modulate && wave.map == Some(MapKind::Mask("fringe".to_owned())));
        assert_eq!(wave.curve, Profile::of(&[[0.0, 0.5], [0.4, 1.0], [1.0, 0.0]]));
        assert!(of(&groom, "Part").curve.is_empty(), "a ramp counts once it is set");
        for bad in ["style.bend.blend=modulate", "style.wave.curve=0/2,1/1", "style.wave.curve=1", "style.wave.map=x"] {
            assert!(matches!(set(&mut groom, bad), Err(CliError::Usage(_))), "{bad}");
        }
        set(&mut groom, "style.wave.curve=none").unwrap();
        set(&mut groom, "style.wave.map=none").unwrap();
        assert!(of(&groom, "Wave").curve.is_empty() && of(&groom, "Wave").map.is_none());
    }

    #[test]
    fn assignments_reach_look_movement_and_the_fibre_of_every_layer() {
        let layer = || Layer::new("a", Source::Strands(Arc::new(Strands::default())));
        let mut groom = Groom { layers: vec![layer(), layer()], ..Groom::default() };
        let assignments = ["shadowing=off", "sim.gravity=0", "hair.eumelanin=8", "hair.beta_n = 0.5"]
            .map(|t| parse_assignment(t).unwrap());
        apply(&mut groom, &assignments).unwrap();
        assert_eq!(groom.simulation.gravity, 0.0);
        assert!(groom.layers.iter().all(|layer| layer.material.eumelanin == 8.0 && layer.material.beta_n == 0.5));
        for bad in ["hair.eumelanin=x", "sim.nothing=1", "shadowing=magic", "nothing=1"] {
            let assignment = parse_assignment(bad).unwrap();
            assert!(matches!(apply(&mut Groom::default(), &[assignment]), Err(CliError::Usage(_))), "{bad}");
        }
        assert!(parse_assignment("shadowing").is_err());
    }
}
