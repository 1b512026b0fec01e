//! `cargo xtask filmstrips`: every motion on every embedded style, as eight frames side by side and as numbers.
//!
//! Each strip is one run of `lorelei simulate`, so it shows what a user gets. A strip that is there is kept: an interrupted
//! command goes on, and one that is asked for by its style is made anew.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::machine::{self, Needs, binary, root};
use crate::numbers::number;
use crate::run::build_release;

const PAGE: &str = "docs/movement/filmstrips.md";
const BEGIN: &str = "<!-- measured: begin -->";
const END: &str = "<!-- measured: end -->";

/// Styles, and from where their hair is seen best: degrees around and up.
const STYLES: [(&str, &str); 8] = [
    ("long", "40,5"),
    ("bob", "40,5"),
    ("curls", "40,5"),
    ("crop", "40,5"),
    ("ponytail", "70,5"),
    ("braid", "140,5"),
    ("bun", "110,10"),
    ("knot", "110,10"),
];

/// Motions, the seconds in which most of them happens, and how far the camera has to be, cm.
const MOTIONS: [(&str, &str, &str); 6] = [
    ("turn", "3.2", "100"),
    ("nod", "2.6", "100"),
    ("shake", "2.6", "100"),
    ("walk", "4", "100"),
    ("jump", "2.2", "190"),
    ("gust", "4.4", "100"),
];

/// What the table has of a strip, by its name in the program's JSON.
const NUMBERS: [&str; 5] = ["length_error_max", "penetration_max_cm", "from_rest_rms_cm", "rest_speed_max_cm_s", "nan"];

/// `args`: styles, all of them where none is named; `--debug` takes the program as it is built for developing.
pub fn filmstrips(args: &[String]) -> Result<(), String> {
    machine::prepare(Needs::Pictures)?;
    let (flags, named): (Vec<&String>, Vec<&String>) = args.iter().partition(|arg| arg.starts_with("--"));
    let known = |name: &String| STYLES.iter().any(|(style, _)| style == name);
    if let Some(unknown) = named.iter().find(|name| !known(name)).or(flags.iter().find(|flag| **flag != "--debug")) {
        let styles: Vec<&str> = STYLES.iter().map(|(style, _)| *style).collect();
        return Err(format!("`{unknown}` is neither --debug nor a style: {}", styles.join(", ")));
    }
    let program = if flags.is_empty() {
        build_release()?;
        binary("release", "lorelei")
    } else {
        binary("debug", "lorelei")
    };
    let folder = root().join("out").join("filmstrips");
    std::fs::create_dir_all(&folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    for (style, view) in STYLES {
        let is_named = named.iter().any(|name| *name == style);
        if !named.is_empty() && !is_named {
            continue;
        }
        for (motion, seconds, distance) in MOTIONS {
            let [picture, numbers] = files(&folder, style, motion);
            if !is_named && picture.exists() && numbers.exists() {
                continue;
            }
            println!("{style}, {motion}");
            let mut simulate = Command::new(&program);
            simulate.args(["simulate", style, "--motion", motion, "--seconds", seconds, "--on", "cpu", "--json"]);
            simulate.args(["--strands", "20000", "--size", "300x320", "--rest", "2", "--camera"]);
            simulate.arg(format!("{view},{distance}")).arg("--filmstrip").arg(&picture);
            let output = simulate.output().map_err(|why| format!("lorelei could not be started: {why}"))?;
            if !output.status.success() {
                return Err(format!("lorelei simulate failed: {}", String::from_utf8_lossy(&output.stderr)));
            }
            std::fs::write(&numbers, &output.stdout).map_err(|why| format!("{}: {why}", numbers.display()))?;
        }
    }
    let table = table(&folder)?;
    let path = root().join(PAGE);
    let failed = |why: std::io::Error| format!("{}: {why}", path.display());
    let page = std::fs::read_to_string(&path).map_err(failed)?;
    let page =
        put_between(&page, &table).ok_or_else(|| format!("{PAGE}: there are no lines {BEGIN} and {END} in it"))?;
    std::fs::write(&path, page).map_err(failed)
}

fn files(folder: &Path, style: &str, motion: &str) -> [PathBuf; 2] {
    ["png", "json"].map(|extension| folder.join(format!("{style}-{motion}.{extension}")))
}

/// Of every strip that is there.
fn table(folder: &Path) -> Result<String, String> {
    let mut text = "| style | motion | length error, most | deepest, cm | 2 s after: from the style, RMS, cm | fastest, cm/s | NaN |\n\
                    |---|---|---|---|---|---|---|\n"
        .to_owned();
    for (style, _) in STYLES {
        for (motion, ..) in MOTIONS {
            let [_, numbers] = files(folder, style, motion);
            let Ok(json) = std::fs::read_to_string(numbers) else { continue };
            text += &row(style, motion, &json)?;
        }
    }
    Ok(text)
}

fn row(style: &str, motion: &str, json: &str) -> Result<String, String> {
    let mut row = format!("| {style} | {motion} |");
    for key in NUMBERS {
        let value = number(json, key)?;
        let cell = match key {
            "nan" => format!(" {value} |"),
            "length_error_max" => format!(" {:.4} % |", 100.0 * value),
            _ => format!(" {value:.3} |"),
        };
        row.push_str(&cell);
    }
    Ok(row + "\n")
}

fn put_between(page: &str, table: &str) -> Option<String> {
    let (before, rest) = page.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{table}{END}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_strip_is_a_row_and_rows_stand_between_the_marks() {
        let json = r#"{"length_error_max":0.00001,"penetration_max_cm":0.0504,"from_rest_rms_cm":1,"rest_speed_max_cm_s":2.5,"nan":0}"#;
        let row = row("bob", "nod", json).unwrap();
        assert_eq!(row, "| bob | nod | 0.0010 % | 0.050 | 1.000 | 2.500 | 0 |\n");
        let page = put_between(&format!("a\n{BEGIN}\nold\n{END}\nb"), &row).unwrap();
        assert_eq!(page, format!("a\n{BEGIN}\n{row}{END}\nb"));
        assert_eq!(put_between("no marks", &row), None);
    }
}
