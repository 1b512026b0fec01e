//! `lorelei looks`: every slot, its choices and their parameters, from the table behind the panels.

use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Look, ParamValue, Slot};
use lorelei_core::simulation::SimulationSettings;
use serde_json::{Value, json};

use super::{CliError, print_line};

#[derive(Debug, clap::Args)]
pub struct LooksArguments {
    /// As JSON: an array of {slot, choices: [{name, label, parameters: [{key, min, max, default, unit}]}]}.
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &LooksArguments) -> Result<(), CliError> {
    let mut look = Look::default();
    let mut material = HairMaterial::default();
    let mut simulation = SimulationSettings::default();
    let mut slots = look.slots();
    slots.push(material.slot());
    slots.push(simulation.slot());
    if arguments.json {
        let slots: Vec<Value> = slots.iter().map(slot_json).collect();
        let text = serde_json::to_string_pretty(&slots).map_err(CliError::failed)?;
        return print_line(&text);
    }
    for slot in &slots {
        print_line(&slot_text(slot))?;
    }
    Ok(())
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
                .map(|param| {
                    let default = match &param.value {
                        ParamValue::F32(value) => json!(shortest(**value)),
                        ParamValue::U32(value) => json!(**value),
                        ParamValue::Colour(rgb) => json!(rgb.map(shortest)),
                    };
                    json!({
                        "key": param.key, "label": param.label, "min": shortest(param.min), "max": shortest(param.max),
                        "default": default, "unit": param.unit, "help": param.help,
                    })
                })
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
    for param in &slot.params {
        let of = if param.of.is_empty() { String::new() } else { format!("  [{}]", param.of.join(", ")) };
        let unit = if param.unit.is_empty() { String::new() } else { format!(" {}", param.unit) };
        let value = param.value.to_text();
        lines.push(format!("   {}={value}{unit}  ({} to {})  {}{of}", param.key, param.min, param.max, param.help));
    }
    lines.push(String::new());
    lines.join("\n")
}
