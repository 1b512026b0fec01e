//! Replaying lists of edits: what their steps name is fetched here, for the command line and for macros.

use std::path::Path;

use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, Layer};
use lorelei_core::io::{ImportOptions, Watch};
use lorelei_core::script::{self, Import, Refusal, Step, Work};

use crate::cli::set;
use crate::open;

/// Read a list from a file; the error says where the fault is.
pub fn read(path: &Path) -> Result<Vec<Step>, String> {
    let text = std::fs::read_to_string(path).map_err(|why| format!("{}: {why}", path.display()))?;
    script::parse(&text).map_err(|why| {
        format!("{}:{why}\n`lorelei apply --list` shows every edit and how it is written", path.display())
    })
}

/// Replay a list on a groom; files are looked for in `folder`. Returns the edits that were applied; on a
/// refusal the groom is as it was.
pub fn run(groom: &mut Groom, steps: &[Step], folder: &Path, watch: Watch<'_>) -> Result<Vec<Edit>, Refusal> {
    script::run(groom, steps, |groom, work| resolve(groom, work, folder, watch))
}

/// Put the meshes of embedded heads back, which a written edit only names.
pub fn complete(edit: &mut Edit) {
    edit.visit_heads(&mut lorelei_assets::complete_head);
}

/// The edit that a step is for this groom.
fn resolve(groom: &Groom, work: &Work, folder: &Path, watch: Watch<'_>) -> Result<Edit, String> {
    if watch.cancelled() {
        return Err("cancelled".to_owned());
    }
    match work {
        Work::Edit(edit) => {
            let mut edit = edit.clone();
            complete(&mut edit);
            Ok(edit)
        }
        Work::Set(assignments) => set_edit(groom, assignments),
        Work::Import(Import::Head(name)) if name == "mannequin" => Ok(Edit::SetHead(Some(lorelei_assets::mannequin()))),
        Work::Import(Import::Head(name)) => {
            let (head, _) = open::read_head(&folder.join(name), watch).map_err(|why| why.to_string())?;
            Ok(Edit::SetHead(Some(head)))
        }
        Work::Import(Import::Hair(name)) => {
            let opened = open_beside(folder, name, watch)?;
            let n_layers = groom.layers.len();
            let add = |(n, layer)| Edit::AddLayer { layer_idx: n_layers + n, layer: Box::new(layer) };
            let mut edits: Vec<Edit> = opened.layers.into_iter().enumerate().map(add).collect();
            if groom.head.is_none() && opened.head.is_some() {
                edits.insert(0, Edit::SetHead(opened.head));
            }
            Ok(Edit::Batch(edits))
        }
        Work::Import(Import::Source { layer_idx, from, from_layer }) => {
            let n_layers = groom.layers.len();
            let layer = groom.layers.get(*layer_idx);
            let layer = layer.ok_or_else(|| format!("there is no layer {layer_idx}: the groom has {n_layers}"))?;
            let opened = open_beside(folder, from, watch)?;
            let n_theirs = opened.layers.len();
            let theirs = opened.layers.into_iter().nth(*from_layer);
            let theirs =
                theirs.ok_or_else(|| format!("{from} has {n_theirs} layers, so none is number {from_layer}"))?;
            let layer = Layer { source: theirs.source, read_as: theirs.read_as, ..layer.clone() };
            Ok(Edit::SetLayer { layer_idx: *layer_idx, layer: Box::new(layer) })
        }
    }
}

fn open_beside(folder: &Path, name: &str, watch: Watch<'_>) -> Result<Groom, String> {
    let beside = folder.join(name);
    let path = if beside.exists() { beside.as_path() } else { Path::new(name) };
    let opened = open::open(path, None, ImportOptions::default(), watch).map_err(|why| why.to_string())?;
    Ok(opened.groom)
}

/// What assignments change, as an edit.
fn set_edit(groom: &Groom, assignments: &[String]) -> Result<Edit, String> {
    let pairs: Result<Vec<_>, String> = assignments.iter().map(|text| set::parse_assignment(text)).collect();
    let mut changed = groom.clone();
    set::apply(&mut changed, &pairs?).map_err(|why| why.to_string())?;
    let mut edits = Vec::new();
    if changed.look != groom.look {
        edits.push(Edit::SetLook(Box::new(changed.look)));
    }
    if changed.simulation != groom.simulation {
        edits.push(Edit::SetSimulation(Box::new(changed.simulation)));
    }
    for (layer_idx, (layer, before)) in changed.layers.into_iter().zip(&groom.layers).enumerate() {
        if layer != *before {
            edits.push(Edit::SetLayer { layer_idx, layer: Box::new(layer) });
        }
    }
    Ok(Edit::Batch(edits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_fetch_what_they_name_and_say_what_they_miss() {
        let folder = tempfile::tempdir().unwrap();
        let obj = "g scalp\nv 0 0 0\nv 0 0 10\nv 10 0 0\nf 1 2 3\n";
        std::fs::write(folder.path().join("head.obj"), obj).unwrap();
        let play =
            |text: &str, groom: &mut Groom| run(groom, &script::parse(text).unwrap(), folder.path(), Watch::default());
        let mut groom = Groom::default();
        play(
            "[(import: Hair(\"bob\")), (import: Head(\"head.obj\")), (set: [\"shadowing=off\", \"layer.radius=60\"])]",
            &mut groom,
        )
        .unwrap();
        let bob = lorelei_assets::hairstyle("bob").unwrap();
        assert_eq!(groom.layers.len(), bob.layers.len());
        assert_eq!(groom.head.as_ref().map(|head| head.name.as_str()), Some("head"));
        assert!(groom.layers.iter().all(|layer| layer.radius_um == 60.0));
        play("[(import: Source(layer_idx: 0, from: \"curls\"))]", &mut groom).unwrap();
        assert_eq!(groom.layers[0].source, lorelei_assets::hairstyle("curls").unwrap().layers[0].source);
        play("[SetHead(Some((name: \"Mannequin\", embedded: Some(\"mannequin\"))))]", &mut groom).unwrap();
        assert_eq!(groom.head, Some(lorelei_assets::mannequin()));
        let before = groom.clone();
        for (text, says) in [
            ("[(import: Head(\"none.obj\"))]", "none.obj"),
            ("[(import: Source(layer_idx: 9, from: \"bob\"))]", "there is no layer 9"),
            ("[(import: Source(layer_idx: 0, from: \"bob\", from_layer: 8))]", "none is number 8"),
            ("[(set: [\"shadowing=magic\"])]", "shadowing"),
            ("[(set: [\"nonsense\"])]", "KEY=VALUE"),
        ] {
            let refusal = play(text, &mut groom).unwrap_err();
            assert!(refusal.reason.contains(says), "{refusal}");
        }
        assert!(groom == before);
    }
}
