//! Controls, files, navigation and panels, each used as a person would.

use lorelei_core::document;
use lorelei_core::io::{self, Watch};
use serde_json::Value;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, numbers};

fn layout_of(state: &Value) -> String {
    state["layout"].as_str().unwrap().to_owned()
}

#[test]
fn combos_lights_head_and_numbers_follow_the_hand_and_can_be_undone() {
    let Some((_alone, folder)) = begin("controls") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");

    // Shadowing by its combo in the look panel.
    studio.wait("the camera at rest", |state| state["still"] == true);
    let [_, top, _, bottom] = numbers::<4>(&studio.state()["viewport"]);
    studio.scroll_to("slot primitive", "slot shadowing", [top + 60.0, top + 0.5 * (bottom - top)]);
    studio.click("slot shadowing");
    studio.click("choice shadowing=off");
    studio.wait("shadows off", |state| state["look"]["shadowing"] == "off");
    studio.screenshot("1_combo");
    studio.key("ctrl+z");
    studio.wait("undo", |state| state["look"]["shadowing"] == "deep-opacity" && state["unsaved"] == false);

    let [left, top, right, bottom] = numbers(&studio.state()["viewport"]);

    // A number: drag it, then reset it by its name.
    studio.wait("rest", |state| state["still"] == true);
    for _ in 0..20 {
        let (x, y) = studio.place_of("value hair.eumelanin");
        if studio.place_of("value layer.radius").1 < bottom - 30.0 {
            break;
        }
        studio.move_to((x, y.max(0.6 * bottom)));
        studio.xdotool(&["click", "5"]);
        studio.rest();
    }
    let (x, y) = studio.hover("value layer.radius");
    studio.drag(1, (x, y), (x + 30.0, y));
    studio.wait("a changed number", |state| state["radius_um"] != 300.0);
    studio.hover("name Radius");
    studio.xdotool(&["click", "--repeat", "2", "--delay", "60", "1"]);
    studio.wait("the default", |state| state["radius_um"] == 40.0);
    studio.screenshot("4_reset");

    // A light by its disc.
    let before = numbers::<3>(&studio.state()["lights"][0]);
    let n_before = studio.state()["n_done"].as_u64().unwrap();
    let (x, y) = studio.hover("light key");
    studio.drag(1, (x, y), (x - 60.0, y - 30.0));
    studio.wait("another light", |state| {
        let after = numbers::<3>(&state["lights"][0]);
        after.iter().zip(before).any(|(a, b)| (a - b).abs() > 0.05)
    });
    assert_eq!(studio.state()["n_done"], n_before + 1, "a drag is one step");
    studio.screenshot("2_light");

    // G moves the head, R turns it, Esc takes back, a click keeps.
    let (x, y) = (f64::midpoint(left, right), top + 0.8 * (bottom - top));
    for (key, part) in [("g", 0), ("r", 3)] {
        studio.move_to((x, y));
        studio.key(key);
        studio.rest();
        studio.move_to((x + 50.0, y));
        studio.wait("a grabbed head", |state| numbers::<5>(&state["head"])[part].abs() > 0.1);
        studio.xdotool(&["click", "1"]);
        studio.rest();
        studio.key("space");
        studio.wait("no movement", |state| state["playing"] == false);
    }
    studio.screenshot("3_grabbed");
    studio.key("shift+space");
    studio.wait("the head back", |state| numbers::<5>(&state["head"]).iter().all(|v| *v == 0.0));

    // The sheet.
    studio.key("F1");
    studio.wait("the sheet", |state| state["shortcuts"] == true);
    studio.screenshot("5_sheet");
    studio.key("Escape");
    studio.wait("no sheet", |state| state["shortcuts"] == false);
}

#[test]
fn the_camera_moves_as_in_blender_and_in_maya() {
    let Some((_alone, folder)) = begin("navigation") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let [left, top, right, bottom] = numbers(&studio.state()["viewport"]);
    let (x, y) = (left + 0.25 * (right - left), top + 0.8 * (bottom - top));
    let framed = numbers::<3>(&studio.state()["camera"]);

    studio.move_to((x, y));
    studio.xdotool(&["click", "4"]);
    studio.wait("a zoom by the wheel", |state| numbers::<3>(&state["camera"])[2] < framed[2] - 1.0);
    studio.key("f");
    studio.wait("all framed", |state| (numbers::<3>(&state["camera"])[2] - framed[2]).abs() < 0.5);

    let target = numbers::<3>(&studio.state()["target"]);
    studio.xdotool(&["keydown", "shift"]);
    studio.drag(2, (x, y), (x + 60.0, y));
    studio.xdotool(&["keyup", "shift"]);
    studio.wait("a pan", |state| numbers::<3>(&state["target"]).iter().zip(target).any(|(a, b)| (a - b).abs() > 1.0));

    let before = numbers::<3>(&studio.state()["camera"]);
    studio.xdotool(&["keydown", "alt"]);
    studio.drag(1, (x, y), (x + 80.0, y));
    studio.wait("an orbit with Alt", |state| (numbers::<3>(&state["camera"])[0] - before[0]).abs() > 5.0);
    studio.drag(3, (x, y), (x + 60.0, y));
    studio.xdotool(&["keyup", "alt"]);
    studio.wait("a zoom with Alt", |state| numbers::<3>(&state["camera"])[2] < before[2] - 1.0);
    assert_eq!(studio.state()["unsaved"], false, "a camera is no part of the document");
    studio.wait("the full picture", |state| state["still"] == true);
    studio.screenshot("1_moved");
}

#[test]
fn files_go_in_and_out_and_panels_stay_where_they_were_put() {
    let Some((_alone, folder)) = begin("files") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");

    // Out, and the written file read back; then in again, as a layer.
    let out = folder.join("out.hair");
    studio.key("ctrl+e");
    studio.wait("the dialog", |state| state["dialog"] == true && state["typing"] == true);
    studio.key("ctrl+a");
    studio.type_text("out.hair");
    studio.key("Return");
    studio.wait("the export", |state| state["notices"].to_string().contains("Exported"));
    let back = io::read_strands(&out, Watch::default()).unwrap();
    assert_eq!(back.strands.n_strands(), 2000);
    studio.key("ctrl+i");
    studio.choose(out.to_str().unwrap());
    studio.wait("the import", |state| state["layers"].as_array().is_some_and(|layers| layers.len() == 2));
    studio.wait("its picture", |state| state["still"] == true);
    studio.screenshot("1_imported");

    // What is no hair is refused, and the groom stays.
    let fake = folder.join("picture.hair");
    image::RgbaImage::new(4, 4).save_with_format(&fake, image::ImageFormat::Png).unwrap();
    studio.key("ctrl+i");
    studio.choose(fake.to_str().unwrap());
    let refused = studio.wait("a notice", |state| state["notices"].to_string().contains("Could not open"));
    assert_eq!(refused["layers"].as_array().unwrap().len(), 2);
    studio.screenshot("2_refused");

    // A panel that is moved is there again in the next run, and so are recent files.
    let before = layout_of(&studio.state());
    let [left, top, right, bottom] = numbers(&studio.state()["viewport"]);
    let (x, y) = studio.hover("tab History");
    studio.drag(1, (x, y), (f64::midpoint(left, right), bottom - 0.1 * (bottom - top)));
    let moved = studio.wait("a moved panel", |state| layout_of(state) != before);
    studio.screenshot("3_moved");
    studio.key("ctrl+s");
    studio.wait("the save", |state| state["unsaved"] == false);
    let shares = |layout: &str| layout.split("rects").next().unwrap_or_default().len();
    let moved = layout_of(&moved);
    studio.quit();
    let mut studio = Studio::open(&display, &folder, &[], "second");
    let again = studio.wait("the next run", |state| state["frame"].as_u64() > Some(0));
    assert_ne!(layout_of(&again), before);
    assert_eq!(shares(&layout_of(&again)), shares(&moved));
    assert!(again["recent"].to_string().contains("small.lorelei"), "{}", again["recent"]);
    studio.screenshot("4_again");
}
