//! Look development as a person does it: two looks side by side, what is under the pointer, a look kept in a file, and
//! one term alone.

use lorelei_core::document;
use lorelei_core::look::presets::LookPreset;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

#[test]
fn looks_are_wiped_inspected_and_kept_with_real_events() {
    let Some((_alone, folder)) = begin("room") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let [left, top, right, bottom] = numbers(&opened["viewport"]);
    // Where neither the tools' buttons nor handles lie.
    let inside = |x0: f64, x1: f64| {
        [
            left + x0 * (right - left),
            top + 0.25 * (bottom - top),
            left + x1 * (right - left),
            top + 0.75 * (bottom - top),
        ]
    };
    studio.key("o");
    let look_b = studio.screenshot("1_look_b");

    // The look as it is becomes B; the document's loses its shadows; the line between them is dragged.
    studio.key("shift+b");
    studio.wait("a look B", |state| state["room"]["has_other"] == true);
    studio.key("shift+l");
    studio.wait("no shadows", |state| state["look"]["shadowing"] == "off" && state["still"] == true);
    let look_a = studio.screenshot("2_look_a");
    studio.key("b");
    studio.wait("a wipe", |state| state["room"]["beside"] == "Wipe" && state["still"] == true);
    let (x, y) = studio.hover("wipe");
    studio.drag(1, (x, y), (x - 0.15 * (right - left), y));
    studio.wait("a dragged line", |state| {
        let wipe = state["room"]["wipe"].as_f64().unwrap();
        (0.3..0.4).contains(&wipe) && state["still"] == true
    });
    studio.move_to((left + 0.9 * (right - left), bottom - 20.0));
    let wiped = studio.screenshot("3_wiped");
    let (left_part, right_part) = (inside(0.1, 0.3), inside(0.45, 0.9));
    assert!(difference(&wiped, &look_a, left_part) < 0.002, "left of the line is look A");
    assert!(difference(&wiped, &look_b, right_part) < 0.002, "right of the line is look B");
    assert!(difference(&wiped, &look_a, right_part) > 0.004, "which differ");
    studio.key("ctrl+b");
    studio.wait("the difference", |state| state["room"]["beside"] == "Difference" && state["still"] == true);
    studio.screenshot("4_difference");
    studio.key("ctrl+b");
    studio.wait("one look", |state| state["room"]["beside"] == "Nothing" && state["still"] == true);

    // What is under the pointer.
    studio.key("i");
    studio.move_to((f64::midpoint(left, right), top + 0.45 * (bottom - top)));
    let found = studio.wait("a strand under the pointer", |state| state["room"]["inspected"]["strand"].is_number());
    assert!(found["room"]["inspected"]["terms"].as_u64() > Some(2), "{}", found["room"]);
    studio.screenshot("5_inspected");
    studio.key("i");
    studio.wait("no inspector", |state| state["room"]["inspects"] == false);

    // A look goes into a file and comes back as one step.
    let path = folder.join("dark.ron");
    studio.command("save look");
    studio.wait("the dialog", |state| state["dialog"] == true && state["typing"] == true);
    // What is typed belongs to the name once the dialog has come to rest.
    studio.rest();
    studio.key("ctrl+a");
    studio.type_text("dark");
    studio.key("Return");
    studio.wait("the saved look", |state| state["notices"].to_string().contains("Look saved"));
    assert_eq!(LookPreset::open(&path).unwrap().name, "dark");
    studio.key("ctrl+z");
    let n_before = studio.wait("shadows again", |state| state["look"]["shadowing"] == "deep-opacity")["n_done"].clone();
    studio.command("load look");
    studio.choose(path.to_str().unwrap());
    let loaded = studio.wait("the loaded look", |state| state["look"]["shadowing"] == "off" && state["still"] == true);
    assert_eq!(loaded["n_done"].as_u64().unwrap(), n_before.as_u64().unwrap() + 1);

    // One term alone; no step is made of it.
    studio.scroll_to("slot primitive", "solo R lobe", [top + 60.0, top + 0.5 * (bottom - top)]);
    studio.click("solo R lobe");
    let alone = studio.wait("a term alone", |state| state["room"]["solo"] == "R lobe" && state["still"] == true);
    studio.screenshot("6_solo");
    assert_eq!(alone["n_done"], loaded["n_done"]);
}
