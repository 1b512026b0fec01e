//! `lorelei apply FILE --edits EDITS.ron --out FILE`: a list of edits, replayed without a window.

use std::path::{Path, PathBuf};

use lorelei_core::io::{ImportOptions, Watch};
use serde_json::json;

use super::{CliError, print_line};
use crate::{open, script};

/// Every edit, with examples that a test replays.
const EDITS: &str = include_str!("../../../docs/edits.md");

const AFTER_HELP: &str = r#"A list of edits is RON, with labels or without:
  [
    SetName("Fringe"),
    SetLayerVisible(layer_idx: 1, visible: false),
  ]
  [
    (label: "Darker", set: ["hair.eumelanin=3", "shadowing=off"]),
    (label: "Another head", import: Head("head.obj")),
    (label: "Name it", edit: SetName("Fringe")),
  ]
`lorelei apply --list` shows every edit. The window records such lists as macros (Edit > Record a macro).
The first edit that is refused ends the work with its number, its label and the reason, and nothing is written."#;

#[derive(Debug, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct ApplyArguments {
    /// A groom or hair: .lorelei, .hair, .tfx, .data, .bin, .ply; or an embedded style.
    #[arg(required_unless_present = "list")]
    file: Option<PathBuf>,
    /// The list of edits.
    #[arg(long, value_name = "EDITS.ron", required_unless_present = "list")]
    edits: Option<PathBuf>,
    /// The groom to write: .lorelei. It may be FILE itself; what was there stays until the new one is complete.
    #[arg(long, value_name = "FILE", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// Print one JSON object: edits, layers, strands, notes, out; or refused: {number, label, reason}.
    #[arg(long)]
    json: bool,
    /// Print every edit with examples, and do nothing.
    #[arg(long)]
    list: bool,
}

pub fn run(arguments: &ApplyArguments) -> Result<(), CliError> {
    let (Some(file), Some(edits), Some(out)) = (&arguments.file, &arguments.edits, &arguments.out) else {
        return print_line(EDITS.trim_end());
    };
    if arguments.list {
        return print_line(EDITS.trim_end());
    }
    let extension = out.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    if extension.as_deref() != Some(lorelei_core::document::EXTENSION) {
        return Err(CliError::Usage(format!("--out {}: let the name end in .lorelei", out.display())));
    }
    let steps = script::read(edits).map_err(CliError::Failed)?;
    let opened = open::open(file, None, ImportOptions::default(), Watch::default()).map_err(CliError::failed)?;
    let mut groom = opened.groom;
    let folder = edits.parent().unwrap_or(Path::new(""));
    if let Err(refusal) = script::run(&mut groom, &steps, folder, Watch::default()) {
        if arguments.json {
            let refused = json!({ "number": refusal.number, "label": refusal.label, "reason": refusal.reason });
            print_line(&json!({ "refused": refused }).to_string())?;
        }
        return Err(CliError::Failed(format!(
            "{}: {refusal}\nNothing was written. Correct this edit, or apply the list to the groom that it was made for",
            edits.display()
        )));
    }
    lorelei_core::document::save(&groom, out).map_err(CliError::failed)?;
    if arguments.json {
        let json = json!({
            "edits": steps.len(), "layers": groom.layers.len(), "strands": groom.n_strands(), "notes": opened.notes,
            "out": out,
        });
        return print_line(&json.to_string());
    }
    for note in &opened.notes {
        eprintln!("note: {note}");
    }
    print_line(&format!("{}: {} edits applied", out.display(), steps.len()))
}

#[cfg(test)]
mod tests {
    use lorelei_core::edit::Edit;
    use lorelei_core::script::Work;

    use super::*;

    /// The RON of a page's code blocks.
    fn examples(page: &str) -> Vec<&str> {
        page.split("```ron\n").skip(1).map(|block| block.split("```").next().unwrap_or_default()).collect()
    }

    /// The names of all edits, as whoever misspells one is told them.
    fn names() -> &'static [&'static str] {
        match ron::from_str::<Edit>("Misspelt(1)").unwrap_err().code {
            ron::Error::NoSuchEnumVariant { expected, .. } => expected,
            other => panic!("{other}"),
        }
    }

    #[test]
    fn every_example_of_the_page_and_of_the_help_is_replayed() {
        let folder = tempfile::tempdir().unwrap();
        let head = "g scalp\nv 0 0 0\nv 0 0 10\nv 10 0 0\nf 1 2 3\n";
        std::fs::write(folder.path().join("head.obj"), head).unwrap();
        let help = AFTER_HELP.split("\n  [").skip(1).map(|list| format!("[{}\n]", list.split("\n  ]").next().unwrap()));
        let all: Vec<String> = examples(EDITS).into_iter().map(str::to_owned).chain(help).collect();
        assert!(all.len() > 6);
        for example in all {
            let mut groom = lorelei_assets::hairstyle("bob").unwrap();
            groom.layers.truncate(2);
            let steps = lorelei_core::script::parse(&example).unwrap_or_else(|why| panic!("{why} in\n{example}"));
            let before = groom.clone();
            let edits = script::run(&mut groom, &steps, folder.path(), Watch::default());
            let edits = edits.unwrap_or_else(|why| panic!("{why} in\n{example}"));
            assert!(groom != before, "no change by\n{example}");
            let mut again = before.clone();
            let undo = again.apply(Edit::Batch(edits)).unwrap();
            assert!(again == groom);
            again.apply(undo).unwrap();
            assert!(again == before, "not undone by\n{example}");
        }
    }

    #[test]
    fn every_edit_has_an_example() {
        fn used(edit: &Edit, names: &mut Vec<String>) {
            let text = ron::to_string(edit).unwrap();
            names.push(text.split('(').next().unwrap_or_default().to_owned());
            if let Edit::Batch(edits) = edit {
                for edit in edits {
                    used(edit, names);
                }
            }
        }
        let mut in_examples = Vec::new();
        for example in examples(EDITS) {
            for step in lorelei_core::script::parse(example).unwrap() {
                if let Work::Edit(edit) = &step.work {
                    used(edit, &mut in_examples);
                }
            }
        }
        let without: Vec<_> = names().iter().filter(|name| !in_examples.iter().any(|used| used == *name)).collect();
        assert!(without.is_empty(), "docs/edits.md has no example of {without:?}");
    }
}
