//! `--set KEY=VALUE`: the look, movement, and of every layer its fibre, its counts and widths, and its style
//! operators, all through the tables behind the panels.

use std::sync::Arc;

use lorelei_core::groom::{Groom, HairMaterial, Layer, Source};
use lorelei_core::look::{Param, SetError, Slot, set};
use lorelei_core::strands::Strands;
use lorelei_core::style::{StyleKind, StyleOp};

use super::CliError;

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
    slots.push(simulation.slot());
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

/// `style.KIND.KEY`: a number of every operator of that kind in every layer; `style.KIND=on` or `=off`.
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
    set_param(style_params(&mut StyleOp::new(kind)), key, value)?;
    for op in alike {
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
