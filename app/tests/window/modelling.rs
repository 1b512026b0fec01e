//! From a bare head to a bob, by hand: root faces on the scalp, extruded, moved, pushed and relaxed, styled and
//! thinned with the brush; refused where the mesh would break; undone by half. And hair meshes out to a file, in from
//! one, and around guides.

use lorelei_core::document;
use lorelei_core::groom::{Groom, Source};
use lorelei_core::hair_mesh::HairMesh;
use serde_json::Value;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

fn n_done(state: &Value) -> u64 {
    state["n_done"].as_u64().unwrap()
}

/// Press a key in the viewport and wait until it made `n` steps.
fn key_and_steps(studio: &mut Studio<'_>, key: &str, n: u64) -> Value {
    let before = n_done(&studio.state());
    studio.key(key);
    studio.wait(key, |state| n_done(state) == before + n)
}

/// Extrude what is selected with a key; how much more than the panel's length is typed.
fn extrude(studio: &mut Studio<'_>, key: &str, more_cm: &str) {
    let before = n_done(&studio.state());
    studio.key(key);
    studio.wait("an extrusion", |state| n_done(state) == before + 1);
    studio.type_text(more_cm);
    studio.key("Return");
    studio.wait("its length", |state| {
        n_done(state) == before + 2 && state["steps"].as_array().unwrap().last().is_some_and(is_extended)
    });
}

fn is_extended(label: &Value) -> bool {
    label.as_str().is_some_and(|label| label.starts_with("Extend"))
}

fn mesh_of(groom: &Groom) -> &HairMesh {
    match &groom.layers[0].source {
        Source::HairMesh(mesh) => mesh,
        Source::Guides(_) | Source::Strands(_) => panic!("made of a hair mesh"),
    }
}

#[test]
fn from_a_bare_head_to_a_bob() {
    let Some((_alone, folder)) = begin("modelling") else { return };
    let file = folder.join("bob.lorelei");
    document::save(&lorelei_assets::hairstyle(lorelei_assets::BARE).unwrap(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the bare head", |state| state["still"] == true);
    assert_eq!(opened["layers"], Value::Array(Vec::new()));
    let bare = studio.screenshot("1_bare");

    // Root faces over the scalp, all selected.
    studio.key("Tab");
    studio.wait("the tool", |state| state["tool"]["name"] == "Model");
    studio.click("new hair mesh");
    let begun = studio.wait("root faces", |state| n_done(state) == 1 && state["tool"]["selected"].as_u64() > Some(20));
    assert_eq!(begun["layers"].as_array().unwrap().len(), 1);
    let [left, top, right, bottom] = numbers::<4>(&begun["viewport"]);
    studio.move_to((0.5 * (left + right), 0.5 * (top + bottom)));
    studio.screenshot("2_roots");

    // Layers: a little out of the scalp, then onwards, giving way to the weight.
    for (key, more_cm) in [("e", "-1.8"), ("shift+e", "0.5"), ("shift+e", "1"), ("shift+e", "1"), ("shift+e", "1")] {
        extrude(&mut studio, key, more_cm);
    }
    studio.wait("hair", |state| state["still"] == true && state["strands"].as_u64() > Some(1000));
    let grown = studio.screenshot("3_extruded");
    assert!(difference(&bare, &grown, [left, top, right, bottom]) > 0.01, "hair covers the head");

    // Move the tips up, along Y, by a typed amount; Esc takes another move back.
    studio.key("g");
    studio.key("y");
    studio.type_text("0.5");
    studio.key("Return");
    let moved = studio.wait("a move", |state| {
        let last = state["steps"].as_array().unwrap().last().unwrap().as_str().unwrap();
        state["tool"]["holds"] == false && last.starts_with("Move")
    });
    studio.key("g");
    studio.wait("a grab", |state| state["tool"]["holds"] == true);
    studio.move_to((0.5 * (left + right) + 60.0, 0.5 * (top + bottom)));
    studio.wait("a second move", |state| n_done(state) == n_done(&moved) + 1);
    studio.key("Escape");
    studio.wait("it taken back", |state| n_done(state) == n_done(&moved));

    // What would break the mesh is refused, with the reason.
    studio.key("m");
    studio.wait("a refusal", |state| state["tool"]["refusal"].is_string());
    assert_eq!(n_done(&studio.state()), n_done(&moved), "nothing has changed");
    studio.screenshot("4_refused");

    // Vertices: a click takes one, relaxing places the inside, the push brush is one step a stroke.
    studio.key("1");
    key_and_steps(&mut studio, "shift+r", 1);
    studio.key("t");
    let (x, y) = (0.5 * (left + right), top + 0.25 * (bottom - top));
    let before = n_done(&studio.state());
    studio.drag(1, (x - 60.0, y), (x + 60.0, y));
    studio.wait("a stroke", |state| n_done(state) == before + 1);
    studio.key("t");
    studio.wait("the picture", |state| state["still"] == true);
    studio.screenshot("5_pushed");

    // Styled from the layer's panel, and thinned on the crown by painting density.
    studio.click("tab Properties");
    studio.wait("the layer's panel", |state| state["marks"]["name Strands"].is_array());
    studio.scroll_to("tab Properties", "style presets", [0.5 * (top + bottom), bottom - 8.0]);
    let before = n_done(&studio.state());
    studio.click("style presets");
    studio.click("preset 0");
    studio.wait("a style", |state| n_done(state) == before + 1 && state["still"] == true);
    let (x, y) = (0.5 * (left + right), top + 0.3 * (bottom - top));
    studio.move_to((x, y));
    studio.key("shift+p");
    studio.wait("the paint tool", |state| state["tool"]["name"] == "Paint" && state["still"] == true);
    studio.drag(1, (x - 40.0, y), (x + 40.0, y));
    studio.wait("a stroke of density", |state| n_done(state) == before + 2 && state["still"] == true);
    studio.key("shift+p");
    studio.wait("no tool", |state| state["tool"]["name"] == "Select" && state["still"] == true);
    studio.screenshot("6_styled");

    // Half of it undone and done again; saved and checked.
    let all = n_done(&studio.state());
    for _ in 0..all / 2 {
        let before = n_done(&studio.state());
        studio.key("ctrl+z");
        studio.wait("an undo", |state| n_done(state) == before - 1);
    }
    studio.screenshot("7_half_undone");
    for _ in 0..all / 2 {
        let before = n_done(&studio.state());
        studio.key("ctrl+shift+z");
        studio.wait("a redo", |state| n_done(state) == before + 1);
    }
    studio.key("ctrl+s");
    studio.wait("the save", |state| state["unsaved"] == false && state["jobs"] == 0);
    let groom = document::open(&file).unwrap();
    let mesh = mesh_of(&groom);
    mesh.check().unwrap();
    assert_eq!(mesh.layers.len(), 6, "five extrusions");
    assert!(!groom.layers[0].style.is_empty() && groom.layers[0].density().is_some());
    studio.quit();
}

#[test]
fn hair_meshes_come_from_guides_and_go_out_and_in() {
    let Some((_alone, folder)) = begin("hair_mesh_files") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let n_layers = |state: &Value| state["layers"].as_array().unwrap().len();
    studio.wait("the first picture", |state| state["still"] == true);

    studio.command("hair mesh around");
    studio.wait("a hair mesh around the guides", |state| n_layers(state) == 2);
    let out = folder.join("out.obj");
    studio.command("export hair mesh");
    studio.wait("the dialog", |state| state["marks"]["dialog accept"].is_array() && state["typing"] == true);
    studio.key("ctrl+a");
    studio.type_text("out.obj");
    studio.key("Return");
    studio.wait("the export", |state| state["notices"].to_string().contains("Exported"));
    studio.command("import hair mesh");
    studio.choose(out.to_str().unwrap());
    studio.wait("the import", |state| n_layers(state) == 3);
    studio.key("ctrl+s");
    studio.wait("the save", |state| state["unsaved"] == false && state["jobs"] == 0);
    let groom = document::open(&file).unwrap();
    let mesh = |layer_idx: usize| match &groom.layers[layer_idx].source {
        Source::HairMesh(mesh) => HairMesh::clone(mesh),
        Source::Guides(_) | Source::Strands(_) => panic!("layer {layer_idx} is made of a hair mesh"),
    };
    let (fitted, back) = (mesh(1), mesh(2));
    assert!(fitted.n_bundles() > 10 && fitted.layers.len() > 3);
    assert!(fitted.has_same_faces(&back), "what comes back has the same faces");
    let (low, high) = fitted.bounds().unwrap();
    let (low_back, high_back) = back.bounds().unwrap();
    assert!(low.distance(low_back) < 1e-3 && high.distance(high_back) < 1e-3);

    // Each is one step.
    studio.key("ctrl+z");
    studio.wait("no import", |state| n_layers(state) == 2);
    studio.key("ctrl+z");
    studio.wait("no hair mesh", |state| n_layers(state) == 1);
    studio.key("ctrl+s");
    studio.wait("the save", |state| state["unsaved"] == false && state["jobs"] == 0);
    studio.quit();
}
