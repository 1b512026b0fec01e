//! The window itself, on a virtual display, driven by real events: orbit, switch shadows, play, drag the
//! head, undo, save, reopen. `controls.rs` uses every other control, `survival.rs` what goes wrong.
//!
//! Every wait is for a state that the window reports (`--report-state`), with a limit; none is for a time.
//! Skipped where Xvfb, xdotool or ImageMagick's import are absent. Screenshots stay in the folder that the
//! test prints.

mod animated;
mod colliders;
mod controls;
mod modelling;
mod movement;
mod painting;
mod pins;
mod pulling;
mod room;
mod sample;
mod sculpting;
mod studio;
mod survival;
mod timeline;
mod waiting;

use lorelei_core::document;
use lorelei_core::look::Shadowing;
use serde_json::Value;

use sample::small_groom;
use studio::{Display, Studio, begin, difference, numbers};

#[test]
fn a_session_with_real_events_keeps_what_was_saved() {
    let Some((_alone, folder)) = begin("session") else { return };
    let file = folder.join("small.lorelei");
    let groom = small_groom();
    document::save(&groom, &file).unwrap();
    let display = Display::start();

    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    assert_eq!(opened["unsaved"], false);
    assert_eq!(opened["look"]["shadowing"], "deep-opacity");
    let first = studio.screenshot("1_opened");

    // Orbit with the middle button.
    let [left, top, right, bottom] = numbers(&opened["viewport"]);
    let (x, y) = (left + 0.3 * (right - left), 0.5 * (top + bottom));
    studio.drag(2, (x, y), (x + 120.0, y + 20.0));
    let before = numbers::<3>(&opened["camera"]);
    let orbited = studio.wait("an orbit", |state| {
        state["still"] == true && (numbers::<3>(&state["camera"])[0] - before[0]).abs() > 10.0
    });
    assert_eq!(numbers::<3>(&orbited["camera"])[2], before[2], "an orbit keeps the distance");
    let second = studio.screenshot("2_orbited");
    assert!(difference(&first, &second, [left, top, right, bottom]) > 0.002, "the picture turned");

    // Switch shadows off through the palette.
    studio.key("F3");
    studio.wait("the palette", |state| state["palette"] == true && state["typing"] == true);
    studio.type_text("switch shadows");
    studio.key("Return");
    let dark = studio.wait("shadows off", |state| state["look"]["shadowing"] == "off" && state["still"] == true);
    assert_eq!(dark["unsaved"], true);
    assert_eq!(dark["n_done"], 1);
    studio.screenshot("3_without_shadows");

    // Play, and drag the head by its handle: the hair follows in time.
    studio.key("space");
    studio.wait("movement", |state| state["playing"] == true && state["sim_secs"].as_f64() > Some(0.1));
    let [hx, hy] = numbers(&studio.state()["head_handle"]);
    studio.drag(1, (hx, hy), (hx + 60.0, hy - 10.0));
    studio.wait("a dragged head", |state| numbers::<5>(&state["head"])[..3].iter().any(|cm| cm.abs() > 0.3));
    studio.screenshot("4_dragged");
    studio.key("space");
    studio.wait("rest", |state| state["playing"] == false && state["still"] == true);

    // Undo: as it was opened, and so nothing to save. Redo, save.
    studio.key("ctrl+z");
    let undone = studio.wait("undo", |state| state["look"]["shadowing"] == "deep-opacity" && state["still"] == true);
    assert_eq!((&undone["unsaved"], &undone["n_done"]), (&Value::from(false), &Value::from(0)));
    studio.key("ctrl+shift+z");
    studio.wait("redo", |state| state["look"]["shadowing"] == "off");
    studio.key("ctrl+s");
    let saved = studio.wait("the save", |state| state["unsaved"] == false && state["jobs"] == 0);
    assert_eq!(saved["notices"], Value::Array(Vec::new()));
    let mut expected = groom;
    expected.look.shadowing = Shadowing::Off;
    assert!(document::open(&file).unwrap() == expected, "the file holds the groom, with the one change");
    studio.screenshot("5_saved");

    // Save as, with the studio's own dialog.
    studio.key("ctrl+shift+s");
    studio.wait("the dialog", |state| state["dialog"] == true && state["typing"] == true);
    studio.key("ctrl+a");
    studio.type_text("other");
    studio.key("Return");
    let renamed =
        studio.wait("save as", |state| state["path"].as_str().is_some_and(|path| path.ends_with("other.lorelei")));
    assert_eq!(renamed["unsaved"], false);
    assert!(document::open(&folder.join("other.lorelei")).unwrap() == expected);

    // Unsaved changes are asked about before the window closes.
    studio.key("shift+l");
    studio.wait("a change", |state| state["unsaved"] == true);
    studio.key("ctrl+q");
    studio.wait("the question", |state| state["question"] == "unsaved");
    studio.screenshot("6_question");
    studio.key("Escape");
    studio.wait("no question", |state| state["question"].is_null());
    studio.key("ctrl+z");
    studio.wait("nothing to save", |state| state["unsaved"] == false);
    studio.quit();

    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "second");
    let reopened = studio.wait("the file again", |state| state["still"] == true);
    assert_eq!(reopened["look"]["shadowing"], "off");
    assert_eq!(reopened["layers"], opened["layers"]);
    studio.screenshot("7_reopened");
    studio.quit();
}
