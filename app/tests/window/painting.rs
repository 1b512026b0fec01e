//! Painting in the viewport with a real pointer, on a head that has no texture coordinates of its own.

use lorelei_core::document;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

#[test]
fn a_stroke_of_density_is_one_step_takes_hair_away_and_is_undone() {
    let Some((_alone, folder)) = begin("painting") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let n_strands = opened["strands"].as_u64().unwrap();
    let viewport = numbers(&opened["viewport"]);
    let [left, top, right, bottom] = viewport;
    let before = studio.screenshot("1_opened");

    // The map covers the scalp, the hair is thin.
    studio.key("shift+p");
    studio.wait("the tool", |state| state["tool"]["name"] == "Paint" && state["still"] == true);
    let shown = studio.screenshot("2_map");
    assert!(difference(&before, &shown, viewport) > 0.01, "the map is seen");

    let (x, y) = (f64::midpoint(left, right), top + 0.45 * (bottom - top));
    studio.drag(1, (x - 50.0, y), (x + 50.0, y));
    let painted = studio.wait("a stroke", |state| state["n_done"] == 1 && state["still"] == true);
    assert_eq!(painted["steps"], serde_json::json!(["Paint density"]));
    let after = studio.screenshot("3_painted");
    assert!(difference(&shown, &after, viewport) > 0.001, "the stroke is seen");

    // All of the hair again: some strands are gone, and undo brings them back.
    studio.key("shift+p");
    let thinned = studio.wait("fewer strands", |state| state["tool"]["name"] == "Select" && state["still"] == true);
    assert!(thinned["strands"].as_u64().unwrap() < n_strands, "{} of {n_strands}", thinned["strands"]);
    studio.key("ctrl+z");
    studio.wait("all strands", |state| state["n_done"] == 0 && state["still"] == true && state["strands"] == n_strands);
    studio.quit();
}
