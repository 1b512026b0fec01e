//! Hair is pulled with the mouse while it plays, and while it stands still.

use lorelei_core::document;
use lorelei_core::motion::{AtEnd, Movement};
use serde_json::Value;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, difference, numbers};

#[test]
fn hair_comes_along_with_the_hand_and_the_groom_stays_as_it_is() {
    let Some((_alone, folder)) = begin("pulling") else { return };
    let file = folder.join("small.lorelei");
    let movement = Movement { at_end: AtEnd::GoOn, ..Movement::default() };
    document::save(&lorelei_core::groom::Groom { movement, ..small_groom() }, &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let viewport: [f64; 4] = numbers(&opened["viewport"]);
    let [left, top, right, bottom] = viewport;
    // The tips at the side of the ball.
    let hair = (left + 0.2 * (right - left), top + 0.57 * (bottom - top));
    let aside = (hair.0 + 10.0, hair.1 - 70.0);
    let before = studio.screenshot("1_opened");

    studio.key("shift+g");
    studio.wait("the tool", |state| state["tool"]["name"] == "Pull" && state["still"] == true);
    let held = |state: &Value| -> Option<[[f64; 3]; 2]> {
        let places = state["held"].as_array()?;
        Some([numbers(&places[0]), numbers(&places[1])])
    };
    let distance = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let apart = |state: &Value| held(state).map(|[at, hand]| distance(at, hand));

    // While it plays, hair comes to the pointer.
    studio.key("space");
    studio.wait("time", |state| state["playing"] == true && state["timeline"]["at"].as_u64() > Some(1));
    studio.move_to(hair);
    studio.xdotool(&["mousedown", "1"]);
    let [taken, _] = held(&studio.wait("held hair", |state| held(state).is_some())).unwrap();
    studio.move_to(aside);
    studio.wait("hair at the hand", |state| {
        held(state).is_some_and(|[at, hand]| distance(at, taken) > 2.0 && distance(at, hand) < 2.0)
    });
    let pulled = studio.screenshot("2_pulled");
    assert!(difference(&before, &pulled, viewport) > 0.001, "the hair has moved");
    assert_eq!(studio.state()["timeline"]["by_hand"], true);
    studio.xdotool(&["mouseup", "1"]);
    studio.wait("none held", |state| held(state).is_none());

    // While time stands still the pull waits for it.
    studio.key("shift+space");
    studio.wait("rest", |state| state["playing"] == false && state["timeline"]["at"] == 0 && state["still"] == true);
    studio.move_to(hair);
    studio.xdotool(&["mousedown", "1"]);
    studio.wait("held hair", |state| held(state).is_some());
    studio.move_to(aside);
    studio.wait("a waiting pull", |state| apart(state) > Some(2.0));
    studio.screenshot("3_waiting");
    studio.xdotool(&["key", "space"]);
    studio.wait("hair at the hand", |state| apart(state).is_some_and(|apart| apart < 2.0));
    studio.screenshot("4_pulled");
    studio.xdotool(&["mouseup", "1"]);
    studio.wait("none held", |state| held(state).is_none());

    // Nothing of it is in the document, and another tool's press pulls nothing.
    let state = studio.state();
    assert_eq!((&state["n_done"], &state["unsaved"]), (&Value::from(0), &Value::from(false)));
    studio.key("shift+g");
    studio.wait("no tool", |state| state["tool"]["name"] == "Select");
    studio.drag(1, hair, aside);
    assert!(held(&studio.state()).is_none());
    studio.quit();
}
