//! What takes longer than a moment: it says how far it is, and a person need not wait for it.

use lorelei_core::document;
use lorelei_core::look::Shadowing;
use lorelei_core::motion::Movement;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin};

#[test]
fn what_takes_long_can_be_given_up_a_question_has_all_keys_and_old_hair_is_gone_at_once() {
    let Some((_alone, folder)) = begin("waiting") else { return };
    let file = folder.join("small.lorelei");
    let movement = Movement { end: 2000, ..Movement::default() };
    let mut groom = lorelei_core::groom::Groom { movement, ..small_groom() };
    // More than is prepared within a frame, were they all to move.
    groom.layers[0].n_strands = 6000;
    groom.layers[0].vertices_per_strand = 48;
    groom.look.shadowing = Shadowing::Off;
    document::save(&groom, &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let viewport: [f64; 4] = crate::studio::numbers(&opened["viewport"]);
    let seen = [viewport[1] + 70.0, viewport[1] + 0.6 * (viewport[3] - viewport[1])];

    // On the way to the last frame: pause where it has come to.
    studio.key("ctrl+Right");
    studio.wait("words", |state| state["busy"] == "Simulating up to the frame");
    studio.screenshot("1_on_the_way");
    let cancel = studio.hover("cancel");
    studio.xdotool(&["click", "1"]);
    let paused = studio.wait("a pause", |state| state["timeline"]["wanted"].is_null() && state["busy"].is_null());
    let at = paused["timeline"]["at"].as_u64().unwrap();
    assert!(at > 0 && at < 2000 && paused["playing"] == false, "{at}");
    studio.key("shift+space");
    studio.wait("rest", |state| state["timeline"]["at"] == 0 && state["still"] == true);

    // Every strand: not waited for, what moved before moves.
    studio.click("tab Movement");
    studio.scroll_to("motion none", "slot moved", seen);
    studio.click("slot moved");
    studio.click("choice moved=strands");
    studio.wait("a step", |state| state["n_done"] == 1);
    studio.move_to(cancel);
    studio.key("space");
    studio.wait("words", |state| state["busy"] == "Preparing every strand to move");
    studio.xdotool(&["click", "1"]);
    let given_up = studio.wait("what moved before", |state| state["n_done"] == 2);
    assert_eq!(given_up["steps"][1], "What moves: guides again");
    assert!(given_up["notices"][0].as_str().unwrap().starts_with("Not every strand moves"), "{given_up:#}");
    studio.wait("time", |state| state["timeline"]["at"].as_u64() > Some(3) && state["playing"] == true);
    studio.key("space");
    let before = studio.wait("a pause", |state| state["playing"] == false && state["still"] == true);

    // A question has every key until it is answered.
    studio.key("ctrl+n");
    studio.wait("the question", |state| state["question"] == "unsaved");
    studio.screenshot("3_question");
    for key in ["space", "Delete", "ctrl+z", "Right", "F3", "shift+l"] {
        studio.key(key);
    }
    studio.key("Escape");
    studio.wait("no question", |state| state["question"].is_null());
    studio.rest();
    let after = studio.state();
    for what in ["n_done", "playing", "timeline", "layers", "look", "palette"] {
        assert_eq!(after[what], before[what], "{what}");
    }

    // Another groom: what is being opened is said, and the old hair does not stand for the new.
    studio.key("ctrl+n");
    studio.wait("the question", |state| state["question"] == "unsaved");
    studio.click("answer 1");
    studio.wait("another groom", |state| state["name"] != "small" && state["still"] == true);
    studio.screenshot("4_another");
    let states = studio.states();
    let of = |name: &str| {
        let name = name.to_owned();
        states.iter().filter(move |state| (state["name"] == "small") == (name == "small")).collect::<Vec<_>>()
    };
    assert!(of("small").iter().any(|state| state["opening"].as_str().is_some_and(|what| what.starts_with("Opening"))));
    assert!(of("small").iter().skip_while(|state| state["still"] != true).all(|state| state["shows_picture"] == true));
    let new = of("new");
    assert_eq!(new[0]["shows_picture"], false, "the old hair is gone at once");
    let first_seen = new.iter().find(|state| state["shows_picture"] == true).unwrap();
    assert!(first_seen["strands"].as_u64() < new.last().unwrap()["strands"].as_u64(), "a few strands are there soon");
    studio.quit();
}
