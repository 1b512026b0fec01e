//! Lists of edits as files: what `lorelei apply` replays and what a macro is. docs/edits.md shows every edit.
//!
//! A file is a RON list of edits, `[SetName("Fringe"), ..]`, or of steps with labels, `[(label: "..",
//! edit: SetName("Fringe")), ..]`. A step may say in place of an edit what becomes one when it is its turn:
//! `set` takes the assignments of `--set`, `import` names a file or something embedded, so that no heads and
//! hair meshes have to stand in a list as numbers. Both depend on more than the groom, so they are no edits
//! themselves: whoever replays a list resolves them.

use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::{Deserialize, Serialize};

use crate::edit::Edit;
use crate::groom::Groom;

/// One step of a list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StepText", into = "StepText")]
pub struct Step {
    /// What the history shows; may be empty.
    pub label: String,
    pub work: Work,
}

/// What a step does.
#[derive(Debug, Clone, PartialEq)]
pub enum Work {
    Edit(Edit),
    /// Assignments as `--set` takes them, such as `shadowing=off`.
    Set(Vec<String>),
    Import(Import),
}

/// What is fetched from elsewhere. Files are looked for beside the list.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Import {
    /// Put a head on: a mesh file, or the name of an embedded head.
    Head(String),
    /// Add the layers of a groom, of a hair file, or of an embedded style.
    Hair(String),
    /// Give a layer the source (hair mesh, guides or strands) that a layer of another groom has.
    Source {
        layer_idx: usize,
        from: String,
        #[serde(default)]
        from_layer: usize,
    },
}

/// A step as it is written: one of the three.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct StepText {
    #[serde(default, skip_serializing_if = "String::is_empty")]
    label: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    edit: Option<Edit>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    set: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    import: Option<Import>,
}

impl TryFrom<StepText> for Step {
    type Error = &'static str;

    fn try_from(text: StepText) -> Result<Self, Self::Error> {
        let work = match (text.edit, text.set, text.import) {
            (Some(edit), None, None) => Work::Edit(edit),
            (None, Some(assignments), None) => Work::Set(assignments),
            (None, None, Some(import)) => Work::Import(import),
            _ => return Err("a step has one of `edit`, `set` and `import`"),
        };
        Ok(Self { label: text.label, work })
    }
}

impl From<Step> for StepText {
    fn from(step: Step) -> Self {
        let mut text = Self { label: step.label, edit: None, set: None, import: None };
        match step.work {
            Work::Edit(edit) => text.edit = Some(edit.with_named_heads()),
            Work::Set(assignments) => text.set = Some(assignments),
            Work::Import(import) => text.import = Some(import),
        }
        text
    }
}

/// Read a list; the error names line and column.
pub fn parse(text: &str) -> Result<Vec<Step>, ron::error::SpannedError> {
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    let of_steps = match options.from_str::<Vec<Step>>(text) {
        Ok(steps) => return Ok(steps),
        Err(why) => why,
    };
    match options.from_str::<Vec<Edit>>(text) {
        Ok(edits) => Ok(edits.into_iter().map(|edit| Step { label: String::new(), work: Work::Edit(edit) }).collect()),
        // The shape that was meant is the one that was understood for longer.
        Err(of_edits) if place(&of_edits) > place(&of_steps) => Err(of_edits),
        Err(_) => Err(of_steps),
    }
}

fn place(error: &ron::error::SpannedError) -> (usize, usize) {
    (error.span.start.line, error.span.start.col)
}

/// Write a list.
pub fn to_text(steps: &[Step]) -> Result<String, ron::Error> {
    // Deeper than this everything is on one line: a hair mesh has thousands of places.
    let config = PrettyConfig::new().depth_limit(3).extensions(Extensions::IMPLICIT_SOME);
    let mut text = ron::ser::to_string_pretty(steps, config)?;
    text.push('\n');
    Ok(text)
}

/// Why a list was not replayed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("edit {number} of {n_steps}{}: {reason}", if label.is_empty() { String::new() } else { format!(" (`{label}`)") })]
pub struct Refusal {
    /// From 1.
    pub number: usize,
    pub n_steps: usize,
    pub label: String,
    pub reason: String,
}

/// Replay steps; `resolve` makes an edit of each for the groom as it then is. Returns the edits that were
/// applied; on a refusal the groom is as it was.
pub fn run(
    groom: &mut Groom,
    steps: &[Step],
    mut resolve: impl FnMut(&Groom, &Work) -> Result<Edit, String>,
) -> Result<Vec<Edit>, Refusal> {
    let mut edited = groom.clone();
    let mut edits = Vec::with_capacity(steps.len());
    for (step_idx, step) in steps.iter().enumerate() {
        let applied = resolve(&edited, &step.work).and_then(|edit| {
            edited.apply(edit.clone()).map_err(|why| why.to_string())?;
            Ok(edit)
        });
        let refused =
            |reason| Refusal { number: step_idx + 1, n_steps: steps.len(), label: step.label.clone(), reason };
        edits.push(applied.map_err(refused)?);
    }
    *groom = edited;
    Ok(edits)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::edit::tests::{any_edit, small_groom};

    proptest! {
        #[test]
        fn lists_read_back_in_both_shapes(edits in proptest::collection::vec(any_edit(), 0..6)) {
            let steps: Vec<Step> = edits
                .iter()
                .map(|edit| Step { label: "say \"it\"".to_owned(), work: Work::Edit(edit.clone()) })
                .collect();
            prop_assert_eq!(parse(&to_text(&steps).unwrap()).unwrap(), steps);
            let plain = parse(&ron::to_string(&edits).unwrap()).unwrap();
            prop_assert!(plain.iter().map(|step| &step.work).eq(edits.iter().cloned().map(Work::Edit).collect::<Vec<_>>().iter()));
        }
    }

    #[test]
    fn faults_are_told_where_they_are() {
        let at = |text: &str| parse(text).unwrap_err().to_string();
        assert!(at("[\n  SetName(\"a\"),\n  SetNam(\"b\"),\n]").starts_with("3:"), "{}", at("[\n SetNam(1)]"));
        assert!(at("[(label: \"a\", edit: SetName(\"b\")),\n (label: \"x\")]").contains("one of `edit`"));
        assert!(at("[(lable: \"a\", edit: SetName(\"b\"))]").contains("lable"));
    }

    #[test]
    fn a_refused_step_is_named_and_nothing_is_changed() {
        let steps = parse("[(edit: SetName(\"x\")), (label: \"Drop it\", edit: RemoveLayer(layer_idx: 7))]").unwrap();
        let mut groom = small_groom();
        let edit_of = |_: &Groom, work: &Work| match work {
            Work::Edit(edit) => Ok(edit.clone()),
            other => Err(format!("{other:?}")),
        };
        let refusal = run(&mut groom, &steps, edit_of).unwrap_err();
        assert_eq!(refusal.to_string(), "edit 2 of 2 (`Drop it`): there is no layer 7: the groom has 3");
        assert_eq!(groom, small_groom());
        assert_eq!(run(&mut groom, &steps[..1], edit_of).unwrap().len(), 1);
        assert_eq!(groom.name, "x");
    }
}
