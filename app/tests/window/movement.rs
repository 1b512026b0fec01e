//! The panel Movement as a person uses it: how exactly hair moves and of what kind it is, wind that is chosen, placed and
//! looked at, and the animation of a file.

use lorelei_core::document;
use lorelei_core::look::Shadowing;
use lorelei_core::motion::Movement;
use serde_json::Value;

use crate::animated::animated_glb;
use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

fn n_done(state: &Value) -> u64 {
    state["n_done"].as_u64().unwrap()
}

fn place(state: &Value) -> [f64; 3] {
    numbers(&state["air"]["sources"][0]["place"])
}

#[test]
fn quality_kinds_wind_and_an_animation_follow_the_hand() {
    let Some((_alone, folder)) = begin("movement") else { return };
    let file = folder.join("small.lorelei");
    let movement = Movement { end: 30, ..Movement::default() };
    let mut groom = lorelei_core::groom::Groom { movement, ..small_groom() };
    // Many pictures are drawn here.
    groom.layers[0].n_strands = 500;
    groom.look.shadowing = Shadowing::Off;
    document::save(&groom, &file).unwrap();
    std::fs::write(folder.join("moves.glb"), animated_glb()).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let viewport: [f64; 4] = numbers(&opened["viewport"]);
    let [left, top, right, bottom] = viewport;
    let seen = [top + 70.0, top + 0.6 * (bottom - top)];
    studio.click("tab Movement");

    // The animation of a file: it plays at once, and its node moves the head.
    studio.scroll_to("motion none", "load animation", seen);
    studio.click("load animation");
    studio.choose("moves.glb");
    studio.wait("the animation", |state| state["timeline"]["node"] == "Head" && state["playing"] == true);
    studio.wait("time", |state| state["timeline"]["at"].as_u64() > Some(0));
    studio.key("space");
    studio.wait("a pause", |state| state["playing"] == false);
    let at_its_end = |studio: &mut Studio, name: &str| {
        let [ruler_left, ruler_top, ruler_right, ruler_bottom] = numbers(&studio.state()["marks"]["timeline ruler"]);
        let y = f64::midpoint(ruler_top, ruler_bottom);
        studio.drag(1, (f64::midpoint(ruler_left, ruler_right), y), (ruler_right - 2.0, y));
        studio.wait("the end", |state| state["timeline"]["at"] == 30 && state["still"] == true);
        studio.move_to((f64::midpoint(left, right), bottom - 12.0));
        studio.screenshot(name)
    };
    let by_head = at_its_end(&mut studio, "1_by_its_head");
    studio.click("slot node");
    studio.click("choice node=Hips");
    studio.wait("another node", |state| state["timeline"]["node"] == "Hips" && n_done(state) == 2);
    let by_hips = at_its_end(&mut studio, "2_by_its_hips");
    assert!(difference(&by_head, &by_hips, viewport) > 0.01, "another way");
    studio.click("remove animation");
    studio.wait("no node", |state| state["timeline"]["node"].is_null() && n_done(state) == 3);
    let still = at_its_end(&mut studio, "3_without");
    assert!(difference(&by_head, &still, viewport) > 0.01 && difference(&by_hips, &still, viewport) > 0.01);
    studio.key("shift+space");

    // Quality and kinds of hair are one step each.
    studio.scroll_to("motion none", "quality high", seen);
    assert_eq!(studio.state()["air"]["quality"], "normal");
    for (n_steps, quality) in [(4, "high"), (5, "draft")] {
        studio.click(&format!("quality {quality}"));
        studio.wait(quality, |state| state["air"]["quality"] == quality && n_done(state) == n_steps);
    }
    studio.click("kind tied");
    let tied = studio.wait("tied hair", |state| state["air"]["bend_length"] == 9.0 && n_done(state) == 6);
    assert_eq!(tied["air"]["quality"], "draft", "a kind leaves the quality");
    studio.key("ctrl+z");
    studio.wait("the old hair", |state| state["air"]["bend_length"] == 2.5 && n_done(state) == 5);

    // Wind: a grid by its slot, a fan by its button, moved by its dot.
    studio.scroll_to("motion none", "slot wind", seen);
    studio.click("slot wind");
    studio.click("choice wind=grid");
    studio.wait("a grid", |state| state["air"]["wind"] == "grid" && n_done(state) == 6);
    studio.scroll_to("motion none", "add fan", seen);
    studio.click("add fan");
    let added = studio.wait("a fan", |state| state["marks"]["wind 0 Place"].is_array() && n_done(state) == 7);
    let before = place(&added);
    let (x, y) = studio.hover("wind 0 Place");
    studio.drag(1, (x, y), (x - 40.0, y - 30.0));
    let moved = studio.wait("a moved fan", |state| place(state)[0] < before[0] - 1.0);
    assert!(place(&moved)[1] > before[1] + 1.0 && n_done(&moved) == 8, "a drag is one step");
    studio.key("ctrl+z");
    studio.wait("the fan back", |state| place(state) == before && n_done(state) == 7);

    // It blows, and the air is shown in three ways.
    studio.key("space");
    studio.wait("time", |state| state["timeline"]["at"].as_u64() > Some(20));
    studio.key("space");
    studio.wait("a pause", |state| state["playing"] == false && state["still"] == true);
    let mut without = studio.screenshot("4_fan");
    for view in ["arrows", "slice", "tracers"] {
        let toggle = format!("wind {view}");
        studio.click(&toggle);
        studio.wait("the air", |state| state["air"]["is_read"] == true);
        if view == "tracers" {
            // They go with the air while time passes.
            studio.key("shift+space");
            studio.wait("the first frame", |state| state["timeline"]["at"] == 0 && state["still"] == true);
            studio.key("space");
            studio.wait("time", |state| state["timeline"]["at"].as_u64() > Some(15));
            studio.key("space");
        }
        studio.wait("a pause", |state| state["playing"] == false && state["still"] == true);
        let with = studio.screenshot(&format!("5_{view}"));
        studio.click(&toggle);
        studio.wait("no air", |state| state["air"]["is_read"] == false && state["still"] == true);
        if view == "tracers" {
            without = studio.screenshot("6_without");
        }
        let seen = difference(&without, &with, viewport);
        assert!(seen > 0.0005, "{view} are seen: {seen}");
    }
    studio.key("ctrl+s");
    studio.wait("saved", |state| state["unsaved"] == false);
    studio.quit();
}
