//! Brushing hair by hand: a lock is combed, seen, undone to the first picture; Esc gives a stroke up; cut, layers,
//! and what is saved.

use lorelei_core::document;
use serde_json::Value;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

fn n_done(state: &Value) -> u64 {
    state["n_done"].as_u64().unwrap()
}

#[test]
fn a_lock_is_combed_seen_and_undone() {
    let Some((_alone, folder)) = begin("sculpting") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    studio.click("tool Sculpt");
    studio.wait("the tool", |state| state["tool"]["name"] == "Sculpt");
    studio.wait("the hair prepared", |state| state["tool"]["is_ready"] == true);
    let [left, top, right, bottom] = numbers::<4>(&opened["viewport"]);
    let viewport = [left, top, right, bottom];
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
