//! `lorelei measure laws`: what must hold of hair that moves and of the air, measured under each solver.

use std::fmt::Write;

use lorelei_core::look::Choice;
use lorelei_core::simulation::Solver;
use lorelei_shaders::{Gpu, ShaderLibrary};
use lorelei_sim::laws::{Bound, OF_STRANDS, On, Row, Under, wind};
use serde_json::{Value, json};

use super::super::{CliError, print_line};
use super::{MeasureArguments, page};

const PAGE: &str = "docs/movement/laws.md";

/// Where the solvers are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Device {
    Cpu,
    Gpu,
}

pub(super) fn run(arguments: &MeasureArguments) -> Result<(), CliError> {
    let (on, device) = match arguments.on {
        Device::Cpu => (On::Cpu, "the CPU".to_owned()),
        Device::Gpu => {
            let gpu = Gpu::headless().map_err(CliError::failed)?;
            let name = gpu.adapter_info.name.clone();
            (On::Gpu(Box::new(gpu), ShaderLibrary::embedded()), name)
        }
    };
    let mut rows = Vec::new();
    for measure in OF_STRANDS {
        for &solver in Solver::ALL {
            rows.extend(measure(&Under { on: &on, solver }).map_err(CliError::failed)?);
        }
    }
    rows.extend(wind::of_air());
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(json_of).collect();
        let all = json!({ "device": device, "rows": rows });
        return print_line(&serde_json::to_string_pretty(&all).map_err(CliError::failed)?);
    }
    let table = table(&device, &rows);
    match &arguments.write {
        Some(path) => page::write(path, PAGE, &table),
        None => print_line(&table),
    }
}

fn json_of(row: &Row) -> Value {
    let (relation, bound) = match row.bound {
        Bound::AtMost(most) => ("at most", most),
        Bound::AtLeast(least) => ("at least", least),
    };
    json!({
        "law": row.law, "scene": row.scene, "of": row.of, "value": row.value, "unit": row.unit,
        "relation": relation, "bound": bound, "holds": row.holds(),
    })
}

/// Strands in one table with a column a solver, the air in another.
fn table(device: &str, rows: &[Row]) -> String {
    let solvers: Vec<&str> = Solver::ALL.iter().map(|solver| solver.info().name).collect();
    let (of_strands, of_air): (Vec<&Row>, Vec<&Row>) = rows.iter().partition(|row| solvers.contains(&row.of));
    let mut text = format!("Solvers on {device}; `lorelei measure laws`. What breaks its bound is **bold**.\n\n");
    write_table(&mut text, &solvers, &of_strands);
    text.push_str("\nThe air's grid, on the CPU:\n\n");
    write_table(&mut text, &["air"], &of_air);
    let held = |of: &str| {
        let (n, held) = rows
            .iter()
            .filter(|row| row.of == of)
            .fold((0, 0), |(n, held), row| (n + 1, held + usize::from(row.holds())));
        format!("{of} {held} of {n}")
    };
    let all: Vec<String> = solvers.iter().chain(&["air"]).map(|of| held(of)).collect();
    let _ = writeln!(text, "\nHeld: {}.", all.join(", "));
    text
}

fn write_table(text: &mut String, columns: &[&str], rows: &[&Row]) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "| law | scene | bound | {} |", columns.join(" | "));
    let _ = writeln!(text, "|---|---|---|{}", "---|".repeat(columns.len()));
    let mut done: Vec<(&str, &str)> = Vec::new();
    for row in rows {
        let key = (row.law, row.scene.as_str());
        if done.contains(&key) {
            continue;
        }
        done.push(key);
        let cell = |of: &&str| {
            let row = rows.iter().find(|row| row.of == *of && (row.law, row.scene.as_str()) == key);
            row.map_or_else(
                || "-".to_owned(),
                |row| {
                    let value = number(row.value);
                    if row.holds() { value } else { format!("**{value}**") }
                },
            )
        };
        let cells: Vec<String> = columns.iter().map(cell).collect();
        let (relation, bound) = match row.bound {
            Bound::AtMost(most) => ("\u{2264}", most),
            Bound::AtLeast(least) => ("\u{2265}", least),
        };
        let bound = format!("{relation} {} {}", number(bound), row.unit);
        let _ = writeln!(text, "| {} | {} | {} | {} |", row.law, row.scene, bound.trim_end(), cells.join(" | "));
    }
}

/// Two digits that count.
fn number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !value.is_finite() || !(1e-3..1e5).contains(&size) {
        format!("{value:.0e}")
    } else {
        let decimals = (1.0 - size.log10().floor()).max(0.0) as usize;
        let text = format!("{value:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        let texts = [0.0, 4.9e-7, 0.0125, 0.3, 3.0, 12.3, 1234.0, f64::NAN].map(number);
        assert_eq!(texts, ["0", "5e-7", "0.013", "0.3", "3", "12", "1234", "NaN"]);
    }

    #[test]
    fn a_row_a_scene_with_what_is_broken_in_bold() {
        let row =
            |of, value| Row { law: "law", scene: "scene".to_owned(), of, value, unit: "%", bound: Bound::AtMost(1.0) };
        let table = table("a device", &[row("rods", 0.5), row("chains", 20.0), row("air", f64::NAN)]);
        assert!(table.contains("| law | scene | \u{2264} 1 % | 0.5 | **20** |"), "{table}");
        assert!(table.contains("| law | scene | \u{2264} 1 % | **NaN** |"), "{table}");
        assert!(table.contains("Held: rods 1 of 1, chains 0 of 1, air 0 of 1."), "{table}");
    }
}
