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
