//! `lorelei looks`: every slot, its choices and their parameters, from the tables behind the panels. Layers
//! and style operators, which are no slots, are listed in the same shape: a layer as a slot with one choice,
//! an operator as a slot that is on or off.

use lorelei_core::groom::{HairMaterial, HairPreset};
use lorelei_core::look::{Choice, Look, Param, ParamValue, Slot};
use lorelei_core::simulation::{HairKind, SimulationSettings};
use lorelei_core::style::{StyleKind, StyleOp};
use serde_json::{Value, json};

use super::{CliError, print_line, set};

#[derive(Debug, clap::Args)]
pub struct LooksArguments {
    /// As JSON: an array of {slot, choices: [{name, label, parameters: [{key, min, max, default, unit}]}]}; a
    /// parameter that is one of a few has `choices` instead of min and max. Layers
    /// and style operators follow the slots in the same shape; they count for every layer.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &LooksArguments) -> Result<(), CliError> {
    let mut look = Look::default();
    let mut material = HairMaterial::default();
    let mut simulation = SimulationSettings::default();
    let mut slots = look.slots();
    slots.push(material.slot());
    slots.extend(simulation.slots());
    if arguments.json {
        let mut all: Vec<Value> = slots.iter().map(slot_json).collect();
        all.extend(layers_json());
        let text = serde_json::to_string_pretty(&all).map_err(CliError::failed)?;
        return print_line(&text);
    }
    for slot in &slots {
        print_line(&slot_text(slot))?;
    }
    print_line(&format!("{}  A hair colour by name, of every layer", set::PRESET_KEY))?;
    for info in HairPreset::ALL.iter().map(|preset| preset.info()) {
        print_line(&format!("   {}={}  {}", set::PRESET_KEY, info.name, info.help))?;
    }
    print_line(&format!("{}  A kind of hair, by how it moves", set::KIND_KEY))?;
    for info in HairKind::ALL.iter().map(|kind| kind.info()) {
        print_line(&format!("   {}={}  {}", set::KIND_KEY, info.name, info.help))?;
    }
    print_line("layer  Counts and widths of every layer")?;
    let mut layer = set::sample_layer();
    print_line(&params_text(&layer.params()))?;
    for kind in StyleKind::DEFAULTS {
        let key = set::style_key(kind);
        print_line(&format!("{key}  {}: every such operator of every layer", kind.help()))?;
        print_line(&format!("   {key}=on\n   {key}=off"))?;
        for word in set::style_words(kind) {
            let names: Vec<String> = word.names.iter().map(|(name, ..)| name.clone()).collect();
            let also = if word.also.is_empty() { String::new() } else { format!(", or {}", word.also) };
            print_line(&format!("   {key}.{}=  ({}{also})  {}", word.word, names.join(", "), word.help))?;
        }
        print_line(&params_text(&set::style_params(&mut StyleOp::new(kind))))?;
    }
    Ok(())
}

/// Layers and style operators in the shape of slots.
fn layers_json() -> Vec<Value> {
    let mut layer = set::sample_layer();
    let params: Vec<Value> = layer.params().iter().map(param_json).collect();
    let every = json!({ "name": "every", "label": "Every layer", "help": "", "parameters": params });
    let mut all = vec![json!({
        "slot": "layer", "label": "Layer", "help": "Counts and widths of every layer", "default": "every",
        "choices": [every],
    })];
    for kind in StyleKind::DEFAULTS {
        let mut op = StyleOp::new(kind);
        let params: Vec<Value> = set::style_params(&mut op).iter().map(param_json).collect();
        let on = json!({ "name": "on", "label": "On", "help": "Computed", "parameters": params });
        let off = json!({ "name": "off", "label": "Off", "help": "Left out", "parameters": [] });
        all.push(json!({
            "slot": set::style_key(kind), "label": kind.label(), "help": kind.help(), "default": "on",
            "choices": [on, off],
        }));
        all.extend(set::style_words(kind).into_iter().map(|word| {
            let choices: Vec<Value> = word
                .names
                .iter()
                .map(|(name, label, help)| json!({ "name": name, "label": label, "help": help, "parameters": [] }))
                .collect();
            json!({
                "slot": format!("{}.{}", set::style_key(kind), word.word), "label": format!("{}: {}", kind.label(), word.word),
                "help": word.help, "default": set::style_word_of(&op, word.word), "choices": choices,
            })
        }));
    }
    all
}

fn param_json(param: &Param<'_>) -> Value {
    let default = match &param.value {
        ParamValue::F32(value) => json!(shortest(**value)),
        ParamValue::U32(value) => json!(**value),
        ParamValue::Colour(rgb) => json!(rgb.map(shortest)),
        ParamValue::Choice(choice) => {
            let names: Vec<&str> = choice.infos().iter().map(|info| info.name).collect();
            return json!({
                "key": param.key, "label": param.label, "choices": names, "default": param.value.to_text(),
                "unit": param.unit, "help": param.help,
            });
        }
    };
    json!({
        "key": param.key, "label": param.label, "min": shortest(param.min), "max": shortest(param.max),
        "default": default, "unit": param.unit, "help": param.help,
    })
}

fn slot_json(slot: &Slot<'_>) -> Value {
    let choices: Vec<Value> = slot
        .choice
        .infos()
        .iter()
        .map(|info| {
            let parameters: Vec<Value> = slot
                .params
                .iter()
                .filter(|param| param.of.is_empty() || param.of.contains(&info.name))
                .map(param_json)
                .collect();
            json!({ "name": info.name, "label": info.label, "help": info.help, "parameters": parameters })
        })
        .collect();
    json!({ "slot": slot.key, "label": slot.label, "help": slot.help, "default": slot.chosen().name, "choices": choices })
}

/// The f64 that prints with the same digits as the f32.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

fn slot_text(slot: &Slot<'_>) -> String {
    let mut lines = vec![format!("{}  {}", slot.key, slot.help)];
    for info in slot.choice.infos() {
        let mark = if info == slot.chosen() { "*" } else { " " };
        lines.push(format!(" {mark} {}={:<16} {}", slot.key, info.name, info.help));
    }
    lines.push(params_text(&slot.params));
    lines.join("\n")
}

fn params_text(params: &[Param<'_>]) -> String {
    let mut lines = Vec::new();
    for param in params {
        let of = if param.of.is_empty() { String::new() } else { format!("  [{}]", param.of.join(", ")) };
        let unit = if param.unit.is_empty() { String::new() } else { format!(" {}", param.unit) };
        let value = param.value.to_text();
        let takes = match &param.value {
            ParamValue::Choice(choice) => choice.infos().iter().map(|info| info.name).collect::<Vec<_>>().join(", "),
            ParamValue::F32(_) | ParamValue::U32(_) | ParamValue::Colour(_) => {
                format!("{} to {}", param.min, param.max)
            }
        };
        lines.push(format!("   {}={value}{unit}  ({takes})  {}{of}", param.key, param.help));
    }
    lines.push(String::new());
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use lorelei_core::groom::Groom;

    use super::*;

    #[test]
    fn every_listed_key_is_taken_by_set_and_listed_once() {
        let (mut look, mut material, mut simulation) =
            (Look::default(), HairMaterial::default(), SimulationSettings::default());
        let mut all: Vec<Value> = look.slots().iter().map(slot_json).collect();
        all.push(slot_json(&material.slot()));
        all.extend(simulation.slots().iter().map(slot_json));
        all.extend(layers_json());
        let mut keys = std::collections::HashSet::new();
        for slot in &all {
            let name = slot["slot"].as_str().unwrap();
            assert!(keys.insert(name.to_owned()), "{name}");
            let mut of_slot = std::collections::HashSet::new();
            let names: Vec<&str> =
                slot["choices"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
            assert!(names.contains(&slot["default"].as_str().unwrap()), "{name}");
            if name != "layer" {
                for choice in &names {
                    set::apply(&mut Groom::default(), &[(name.to_owned(), (*choice).to_owned())]).unwrap();
                }
            }
            for choice in slot["choices"].as_array().unwrap() {
                for param in choice["parameters"].as_array().unwrap() {
                    let key = param["key"].as_str().unwrap();
                    // A parameter that belongs to two choices is listed with both.
                    assert!(!of_slot.insert(key.to_owned()) || keys.insert(key.to_owned()), "{key}");
                    let value = match &param["default"] {
                        Value::Array(rgb) => rgb.iter().map(ToString::to_string).collect::<Vec<_>>().join(","),
                        Value::String(name) => name.clone(),
                        value => value.to_string(),
                    };
                    set::apply(&mut Groom::default(), &[(key.to_owned(), value)]).unwrap();
                }
            }
        }
        assert!(keys.contains("layer.radius") && keys.contains("style.curl.radius"));
    }
}
