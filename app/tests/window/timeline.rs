//! Time as a person goes through it: play, loop, scrub by the mouse, step, the range in the background, and the hair as it is
//! taken over as rest.

use lorelei_core::document;
use lorelei_core::motion::{Motion, Movement};
use lorelei_core::simulation::Moved;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

#[test]
fn time_is_scrubbed_looped_simulated_and_taken_over_with_real_events() {
    let Some((_alone, folder)) = begin("timeline") else { return };
    let file = folder.join("small.lorelei");
    let movement = Movement { motion: Motion::Shake, end: 40, ..Movement::default() };
    document::save(&lorelei_core::groom::Groom { movement, ..small_groom() }, &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let viewport: [f64; 4] = numbers(&opened["viewport"]);
    let [left, top, right, bottom]: [f64; 4] = numbers(&opened["marks"]["timeline ruler"]);
    let at = |share: f64| (left + 8.0 + share * (right - left - 16.0), f64::midpoint(top, bottom));
    assert_eq!(opened["timeline"]["motion"], "Shake", "the movement is in the file");

    // Playing comes to the end of the range and begins again.
    studio.key("space");
    studio.wait("a whole round", |state| state["timeline"]["kept"] == serde_json::json!([[0, 40]]));
    studio.wait("the next one", |state| state["timeline"]["at"].as_u64() < Some(30));
    studio.key("space");
    studio.wait("a pause", |state| state["playing"] == false && state["still"] == true);

    // Scrub by dragging: forth, and back to the very same picture.
    studio.drag(1, at(0.1), at(0.5));
    studio.wait("the middle", |state| state["timeline"]["at"] == 20 && state["still"] == true);
    studio.move_to((f64::midpoint(viewport[0], viewport[2]), viewport[3] - 12.0));
    let middle = studio.screenshot("1_middle");
    studio.drag(1, at(0.5), at(0.9));
    studio.wait("later", |state| state["timeline"]["at"] == 36 && state["still"] == true);
    studio.move_to((f64::midpoint(viewport[0], viewport[2]), viewport[3] - 12.0));
    let later = studio.screenshot("2_later");
    assert!(difference(&middle, &later, viewport) > 0.002, "the hair has moved");
    studio.drag(1, at(0.9), at(0.5));
    studio.wait("the middle again", |state| state["timeline"]["at"] == 20 && state["still"] == true);
    studio.move_to((f64::midpoint(viewport[0], viewport[2]), viewport[3] - 12.0));
    let again = studio.screenshot("3_again");
    // The guides are the same to the last bit, which another test checks; what is drawn of them in parallel is nearly so.
    assert!(difference(&middle, &again, viewport) < 1e-4, "the same frame");
    studio.key("Right");
    studio.wait("a frame forward", |state| state["timeline"]["at"] == 21 && state["still"] == true);
    studio.key("Left");
    studio.wait("a frame back", |state| state["timeline"]["at"] == 20 && state["still"] == true);

    // Another movement is a step, and its frames are others; the range is simulated in the background.
    studio.command("head nods");
    // Keys go to the palette's field for as long as it has the focus.
    studio.wait("a nod", |state| {
        state["timeline"]["motion"] == "Nod" && state["playing"] == true && state["typing"] == false
    });
    studio.key("space");
    studio.wait("a pause", |state| state["playing"] == false);
    studio.key("ctrl+r");
    studio.wait("the whole range", |state| {
        state["timeline"]["kept"] == serde_json::json!([[0, 40]]) && state["notices"].to_string().contains("simulated")
    });
    studio.screenshot("4_range");

    // The hair as it is becomes its rest: one step, and undone.
    studio.command("last frame");
    studio.wait("the end", |state| state["timeline"]["at"] == 40 && state["still"] == true);
    let before = studio.state()["n_done"].as_u64().unwrap();
    studio.command("set current as rest");
    studio.wait("another rest", |state| state["n_done"] == before + 1 && state["still"] == true);
    studio.screenshot("5_rest");
    studio.key("ctrl+z");
    studio.wait("the old rest", |state| state["n_done"] == before && state["still"] == true);
}

#[test]
fn every_strand_moves_by_itself_and_is_baked_to_a_layer_of_strands() {
    let Some((_alone, folder)) = begin("every-strand") else { return };
    let file = folder.join("small.lorelei");
    let movement = Movement { motion: Motion::Shake, end: 12, ..Movement::default() };
    let mut groom = lorelei_core::groom::Groom { movement, ..small_groom() };
    groom.simulation.moved = Moved::Strands;
    document::save(&groom, &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let viewport: [f64; 4] = numbers(&opened["viewport"]);
    let at_rest = studio.screenshot("1_rest");
    studio.command("last frame");
    studio.wait("the end", |state| state["timeline"]["at"] == 12 && state["still"] == true);
    let moved = studio.screenshot("2_moved");
    assert!(difference(&at_rest, &moved, viewport) > 0.002, "the hair has moved");
    // Guides cannot rest where strands have gone: it is said, and nothing happens.
    let before = studio.state()["n_done"].as_u64().unwrap();
    studio.command("set current as rest");
    studio.wait("why not", |state| state["notices"].to_string().contains("Every strand has moved by itself"));
    assert_eq!(studio.state()["n_done"].as_u64().unwrap(), before);
    studio.command("bake to guides");
    studio.wait("a step", |state| state["n_done"] == before + 1 && state["still"] == true);
    studio.screenshot("3_baked");
}
