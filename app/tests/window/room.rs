//! Look development as a person does it: two looks side by side, what is under the pointer, a look kept in a file, one
//! term alone, false colours, contact sheets, a turntable, and what choices cost.

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
    let path = folder.join("look.ron");
    studio.command("save look");
    studio.click("dialog accept");
    studio.wait("the saved look", |state| state["notices"].to_string().contains("Look saved"));
    assert_eq!(LookPreset::open(&path).unwrap().name, "look");
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

#[test]
fn false_colours_costs_sheets_and_turntables_come_from_the_window() {
    let Some((_alone, folder)) = begin("room_pictures") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let viewport: [f64; 4] = numbers(&opened["viewport"]);
    let [left, top, right, bottom] = viewport;
    // The last row stays near the lower end of its panel.
    let in_panel = [top + 60.0, top + 0.63 * (bottom - top)];
    let light = studio.screenshot("1_light");
    let cost = |state: &serde_json::Value, choice: &str| state["room"]["costs"][choice].as_f64();

    // False colours from the panel, with what they mean beside them.
    studio.scroll_to("slot primitive", "slot view", in_panel);
    studio.rest();
    studio.click("slot view");
    studio.click("choice view=overdraw");
    let coloured = studio.wait("false colours", |state| {
        state["look"]["view"] == "overdraw" && state["still"] == true && state["marks"]["legend"].is_array()
    });
    assert!(cost(&coloured, "shadowing=deep-opacity") > Some(0.0), "{}", coloured["room"]["costs"]);
    studio.move_to((left + 0.3 * (right - left), bottom - 20.0));
    let shown = studio.screenshot("2_overdraw");
    assert!(difference(&shown, &light, viewport) > 0.01);
    assert!(difference(&shown, &light, numbers(&coloured["marks"]["legend"])) > 0.05, "the legend is drawn");
    studio.command("final picture");
    studio.wait("light", |state| state["look"]["view"] == "final" && state["still"] == true);

    // Another choice costs something else, and what the first cost is still known.
    studio.click("slot background");
    studio.click("choice background=plain");
    let plain = studio.wait("another background", |state| {
        state["look"]["background"] == "plain" && state["still"] == true && !state["marks"]["legend"].is_array()
    });
    assert!(cost(&plain, "tonemapping=agx").is_some() && cost(&plain, "view=overdraw").is_some());

    // Every choice of the slot that was used last, in one picture.
    studio.command("contact sheet");
    studio.click("dialog accept");
    studio
        .wait("the saved sheet", |state| state["notices"].to_string().contains("background.png") && state["jobs"] == 0);
    let sheet = image::open(folder.join("background.png")).unwrap().to_rgb8();
    assert!(sheet.width() > 900 && sheet.height() > 300, "three tiles: {:?}", sheet.dimensions());

    // All around, as files.
    studio.command("turntable");
    studio.click("dialog accept");
    studio
        .wait("the turntable", |state| state["notices"].to_string().contains("Turntable saved") && state["jobs"] == 0);
    let place = |idx: u32| folder.join(format!("turntable-{idx:03}.png"));
    assert!(place(35).exists() && !place(36).exists());
    let picture = |idx: u32| image::open(place(idx)).unwrap().to_rgb8();
    let (front, side) = (picture(0), picture(9));
    let size = [0.0, 0.0, f64::from(front.width()), f64::from(front.height())];
    assert_eq!([front.width(), front.height()], [(right - left) as u32, (bottom - top) as u32]);
    assert!(difference(&front, &side, size) > 0.002, "the groom has turned");
}
