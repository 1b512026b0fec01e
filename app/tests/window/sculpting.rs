//! Brushing hair by hand: a lock is combed, seen, undone to the first picture; Esc gives a stroke up; cut, layers,
//! and what is saved.

use std::path::{Path, PathBuf};

use lorelei_core::document;
use serde_json::Value;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

fn n_done(state: &Value) -> u64 {
    state["n_done"].as_u64().unwrap()
}

/// The small groom in a file, open in the studio with the brushes ready; its file and the viewport.
fn with_brushes<'a>(display: &'a Display, folder: &Path) -> (Studio<'a>, PathBuf, [f64; 4]) {
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let mut studio = Studio::open(display, folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    studio.click("tool Sculpt");
    studio.wait("the tool", |state| state["tool"]["name"] == "Sculpt");
    studio.wait("the hair prepared", |state| state["tool"]["is_ready"] == true);
    (studio, file, numbers(&opened["viewport"]))
}

#[test]
fn a_lock_is_combed_seen_and_undone() {
    let Some((_alone, folder)) = begin("sculpting") else { return };
    let display = Display::start();
    let (mut studio, file, viewport) = with_brushes(&display, &folder);
    let [left, top, right, bottom] = viewport;
    let (x, y) = (0.5 * (left + right), 0.5 * (top + bottom));
    studio.move_to((left + 60.0, bottom - 60.0));
    let first = studio.screenshot("1_first");

    // Across the front to the side, in several sweeps: one step each.
    for sweep in 0..3 {
        let before = n_done(&studio.state());
        let from = (x - 20.0 + 10.0 * f64::from(sweep), y - 40.0 + 30.0 * f64::from(sweep));
        studio.drag(1, from, (from.0 + 140.0, from.1 - 40.0));
        studio.wait("a stroke", |state| n_done(state) == before + 1);
    }
    studio.move_to((left + 60.0, bottom - 60.0));
    studio.wait("the combed hair", |state| state["still"] == true);
    let combed = studio.screenshot("2_combed");
    let moved = difference(&first, &combed, viewport);
    assert!(moved > 0.0005, "the comb is seen: {moved}");
    for _ in 0..3 {
        let before = n_done(&studio.state());
        studio.key("ctrl+z");
        studio.wait("an undo", |state| n_done(state) == before - 1);
    }
    studio.wait("the first hair", |state| state["still"] == true && n_done(state) == 0);
    let undone = studio.screenshot("3_undone");
    let left_over = difference(&first, &undone, viewport);
    assert!(left_over < 0.2 * moved, "undo gives the first picture: {left_over} of {moved}");

    // The scissors by their key, and what is saved is what is seen.
    studio.key("0");
    studio.wait("the scissors", |state| state["tool"]["brush"] == "cut");
    studio.drag(1, (x - 80.0, y - 20.0), (x + 80.0, y - 20.0));
    studio.wait("a cut", |state| n_done(state) == 1 && state["still"] == true);
    studio.screenshot("4_cut");
    studio.key("ctrl+s");
    studio.wait("a save", |state| state["unsaved"] == false);
    studio.quit();
    let saved = document::open(&file).unwrap();
    let sculpt = &saved.layers[0].sculpt;
    assert_eq!(sculpt.layers.len(), 1);
    assert!(sculpt.layers[0].strokes.guides.iter().any(|guide| guide.cut < 1.0));
}

/// Type a file's name into the dialog.
fn name_file(studio: &mut Studio<'_>, name: &str) {
    studio.wait("the dialog", |state| state["dialog"] == true && state["typing"] == true && state["still"] == true);
    studio.rest();
    studio.key("ctrl+a");
    studio.type_text(name);
    studio.key("Return");
    studio.wait("no dialog", |state| state["dialog"] == false);
}

#[test]
fn a_second_sculpt_layer_is_added_brushed_weighed_and_undone() {
    let Some((_alone, folder)) = begin("sculpt_layers") else { return };
    let display = Display::start();
    let (mut studio, file, [left, top, right, bottom]) = with_brushes(&display, &folder);
    let (x, y) = (0.5 * (left + right), 0.5 * (top + bottom));
    studio.drag(1, (x - 20.0, y - 40.0), (x + 100.0, y - 60.0));
    studio.wait("a stroke", |state| n_done(state) == 1);
    // A second layer by its button: a person scrolls the panel until it is there.
    studio.scroll_to("sculpt Add", "sculpt Add", [120.0, 740.0]);
    studio.click("sculpt Add");
    studio.wait("a second layer", |state| n_done(state) == 2 && state["marks"]["sculpt layer Sculpt 2"].is_array());
    studio.screenshot("1_added");
    studio.wait("the hair prepared", |state| state["tool"]["is_ready"] == true);
    studio.drag(1, (x - 60.0, y + 10.0), (x + 90.0, y + 40.0));
    studio.wait("a stroke", |state| n_done(state) == 3 && state["still"] == true);
    let full = studio.screenshot("2_brushed");
    studio.scroll_to("sculpt Add", "value sculpt weight", [120.0, 740.0]);
    studio.click("value sculpt weight");
    studio.wait("a number to type", |state| state["typing"] == true);
    studio.key("ctrl+a");
    studio.type_text("0.5");
    studio.key("Return");
    studio.wait("the weight", |state| n_done(state) == 4 && state["typing"] == false && state["still"] == true);
    studio.move_to((left + 60.0, bottom - 60.0));
    let half = studio.screenshot("3_weighed");
    assert!(difference(&full, &half, [left, top, right, bottom]) > 0.0003, "half the weight is seen");
    studio.key("ctrl+s");
    studio.wait("a save", |state| state["unsaved"] == false);
    let saved = document::open(&file).unwrap().layers[0].sculpt.layers.clone();
    assert_eq!(saved.iter().map(|layer| layer.weight).collect::<Vec<_>>(), [1.0, 0.5]);
    assert!(saved.iter().all(|layer| !layer.strokes.ids.is_empty()), "each has its stroke");
    for left_over in (0..4).rev() {
        studio.key("ctrl+z");
        studio.wait("an undo", |state| n_done(state) == left_over);
    }
    studio.wait("the first hair", |state| state["still"] == true);
    studio.key("ctrl+s");
    studio.wait("a save", |state| state["unsaved"] == false);
    assert!(document::open(&file).unwrap().layers[0].sculpt.layers.is_empty());
    studio.quit();
}

#[test]
fn a_macro_of_two_strokes_is_played_and_undone_as_one_step() {
    let Some((_alone, folder)) = begin("sculpt_macro") else { return };
    let display = Display::start();
    let (mut studio, file, [left, top, right, bottom]) = with_brushes(&display, &folder);
    let (x, y) = (0.5 * (left + right), 0.5 * (top + bottom));
    studio.command("record a macro");
    studio.wait("a recording", |state| state["kept"]["macro_steps"] == 0);
    studio.drag(1, (x - 20.0, y - 40.0), (x + 100.0, y - 60.0));
    studio.wait("a stroke", |state| n_done(state) == 1 && state["kept"]["macro_steps"] == 1);
    studio.drag(1, (x - 40.0, y), (x + 80.0, y + 20.0));
    studio.wait("another", |state| n_done(state) == 2 && state["kept"]["macro_steps"] == 2);
    studio.key("ctrl+s");
    studio.wait("a save", |state| state["unsaved"] == false);
    let brushed = document::open(&file).unwrap();
    studio.command("record a macro");
    name_file(&mut studio, "comb.ron");
    studio.wait("the macro", |state| state["notices"].to_string().contains("Macro saved"));
    let list = std::fs::read_to_string(folder.join("comb.ron")).unwrap();
    assert_eq!(list.matches("Stroke(").count(), 2, "{list}");
    assert!(list.len() < 20_000 && !list.contains("offsets"), "strokes, not guides: {} bytes", list.len());
    for left_over in [1, 0] {
        studio.key("ctrl+z");
        studio.wait("an undo", |state| n_done(state) == left_over && state["still"] == true);
    }
    // Played on the hair that it began with it gives the same hair, in one step.
    studio.command("play a macro");
    studio.choose(folder.join("comb.ron").to_str().unwrap());
    studio.wait("the macro played", |state| n_done(state) == 1 && state["steps"].to_string().contains("Macro"));
    studio.wait("its picture", |state| state["still"] == true);
    studio.screenshot("1_played");
    let save = |studio: &mut Studio<'_>| {
        studio.key("ctrl+s");
        studio.wait("a save", |state| state["unsaved"] == false && state["jobs"] == 0);
        document::open(&file).unwrap()
    };
    assert!(save(&mut studio) == brushed, "the macro's strokes are the strokes");
    studio.key("ctrl+z");
    studio.wait("one undo", |state| n_done(state) == 0);
    studio.key("ctrl+z");
    studio.rest();
    assert_eq!(n_done(&studio.state()), 0, "there is nothing more to undo");
    studio.key("ctrl+shift+z");
    studio.wait("one redo", |state| n_done(state) == 1 && state["still"] == true);
    assert!(save(&mut studio) == brushed);
    studio.key("ctrl+z");
    studio.wait("an undo", |state| n_done(state) == 0);
    assert!(save(&mut studio).layers[0].sculpt.layers.is_empty());
    studio.quit();
}
