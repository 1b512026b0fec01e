//! What goes wrong: a crash, and a GPU that is lost.

use lorelei_core::document;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin};

#[test]
fn unsaved_changes_are_offered_after_a_crash() {
    let Some((_alone, folder)) = begin("crash") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let arguments = [file.to_str().unwrap(), "--autosave", "1"];
    let mut studio = Studio::open(&display, &folder, &arguments, "first");
    studio.key("shift+l");
    studio.wait("a change", |state| state["unsaved"] == true);
    let recovery = folder.join("data").join("recovery");
    // Its temporary file comes first.
    let is_document = |entry: std::fs::DirEntry| entry.path().extension().is_some_and(|end| end == "lorelei");
    let is_kept = || std::fs::read_dir(&recovery).is_ok_and(|entries| entries.flatten().any(is_document));
    // The clock is looked at with every frame, and every ten seconds.
    studio.wait("the recovery file", |_| is_kept());
    studio.kill();
    let mut studio = Studio::open(&display, &folder, &arguments[..1], "second");
    studio.wait("the question", |state| state["question"] == "recover");
    studio.screenshot("1_question");
    studio.click("answer 0");
    let state = studio.wait("the work", |state| state["unsaved"] == true && state["jobs"] == 0);
    assert_eq!(state["look"]["shadowing"], "off");
    studio.wait("its picture", |state| state["still"] == true);
    studio.screenshot("2_recovered");
}

#[test]
fn every_step_up_to_the_crash_comes_back_from_the_journal() {
    let Some((_alone, folder)) = begin("journal") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let saved = std::fs::read(&file).unwrap();
    let display = Display::start();
    // No autosave comes in time.
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap(), "--autosave", "3600"], "first");
    studio.key("shift+l");
    studio.wait("shadows off", |state| state["look"]["shadowing"] == "off");
    studio.key("shift+d");
    studio.wait("another layer", |state| state["layers"].as_array().is_some_and(|layers| layers.len() == 2));
    studio.key("shift+d");
    studio.wait("a third", |state| state["layers"].as_array().is_some_and(|layers| layers.len() == 3));
    studio.key("ctrl+z");
    let last = studio.wait("undo, kept", |state| {
        state["layers"].as_array().is_some_and(|layers| layers.len() == 2) && state["kept"]["records"] == 4
    });
    studio.kill();
    assert!(std::fs::read(&file).unwrap() == saved, "the document's own file is as it was saved");
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "second");
    studio.wait("the question", |state| state["question"] == "recover");
    studio.click("answer 0");
    let state = studio.wait("the work", |state| state["unsaved"] == true && state["jobs"] == 0);
    for key in ["layers", "steps", "n_done", "look", "path"] {
        assert_eq!(state[key], last[key], "{key}");
    }
    studio.wait("its picture", |state| state["still"] == true);
    studio.screenshot("1_recovered");
    // The history came back with it, and saving goes to the document's file.
    studio.key("ctrl+shift+z");
    studio.wait("redo", |state| state["layers"].as_array().is_some_and(|layers| layers.len() == 3));
    studio.key("ctrl+s");
    studio.wait("the save", |state| state["unsaved"] == false && state["jobs"] == 0);
    assert_eq!(document::open(&file).unwrap().layers.len(), 3);
    studio.quit();
    let left = std::fs::read_dir(folder.join("data").join("recovery")).unwrap().flatten().count();
    assert_eq!(left, 0, "a studio that ends well leaves nothing");
}

#[test]
fn a_macro_is_recorded_and_saved() {
    let Some((_alone, folder)) = begin("macro") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let command = |studio: &mut Studio<'_>, words: &str| {
        studio.key("F3");
        studio.wait("the palette", |state| state["palette"] == true && state["typing"] == true);
        studio.type_text(words);
        studio.key("Return");
        studio.wait("no palette", |state| {
            state["palette"] == false && state["typing"] == (state["dialog"] == true) && state["still"] == true
        });
    };
    command(&mut studio, "record a macro");
    studio.wait("a recording", |state| state["kept"]["macro_steps"] == 0);
    studio.key("shift+l");
    studio.key("shift+d");
    studio.wait("two steps", |state| state["kept"]["macro_steps"] == 2);
    command(&mut studio, "record a macro");
    studio.wait("the dialog", |state| state["dialog"] == true && state["typing"] == true);
    studio.key("ctrl+a");
    studio.type_text("double.ron");
    studio.key("Return");
    studio.wait("the macro", |state| state["notices"].to_string().contains("Macro saved"));
    studio.screenshot("1_saved");
    let list = std::fs::read_to_string(folder.join("double.ron")).unwrap();
    assert_eq!(lorelei_core::script::parse(&list).unwrap().len(), 2, "{list}");
    studio.kill();
}

#[test]
fn a_lost_gpu_is_replaced_and_nothing_else_changes() {
    let Some((_alone, folder)) = begin("gpu") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    // On a software driver the stage has a device of its own; on a GPU the window opens again.
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    studio.key("shift+l");
    studio.wait("a change", |state| state["unsaved"] == true && state["still"] == true);
    studio.key("ctrl+shift+F9");
    let told = studio.wait("a notice", |state| state["notices"].to_string().contains("The GPU was lost"));
    assert_eq!((&told["unsaved"], &told["look"]["shadowing"]), (&true.into(), &"off".into()));
    let drawn = studio.wait("another picture", |state| state["still"] == true);
    assert_eq!(drawn["path"], file.to_str().unwrap());
    studio.screenshot("1_replaced");
}

#[test]
fn a_lost_window_opens_again_with_its_groom() {
    let Some((_alone, folder)) = begin("again") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap(), "--share-gpu"], "first");
    studio.key("shift+l");
    studio.wait("a change", |state| state["unsaved"] == true && state["still"] == true);
    studio.key("ctrl+shift+F9");
    let told = studio
        .wait("a notice", |state| state["notices"].to_string().contains("The GPU was lost") && state["still"] == true);
    assert_eq!((&told["unsaved"], &told["look"]["shadowing"]), (&true.into(), &"off".into()));
    assert_eq!(told["path"], file.to_str().unwrap());
    studio.screenshot("1_again");
}
