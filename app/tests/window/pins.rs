//! A pin is put on the hair in the middle of the picture by the panel, and dragged by its handle while hair moves.

use lorelei_core::document;
use lorelei_core::pin::Pin;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, numbers};

#[test]
fn a_pin_is_added_by_the_panel_and_dragged_while_hair_moves() {
    let Some((_alone, folder)) = begin("pins") else { return };
    let file = folder.join("small.lorelei");
    document::save(&small_groom(), &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    let opened = studio.wait("the first picture", |state| state["still"] == true);
    let [_, top, _, bottom] = numbers::<4>(&opened["viewport"]);
    let pin = |state: &serde_json::Value| numbers::<4>(&state["pins"][0]);

    studio.click("tab Movement");
    studio.scroll_to("motion none", "add pin", [top + 70.0, top + 0.61 * (bottom - top)]);
    studio.click("add pin");
    let state = studio.wait("a pin", |state| state["pins"].as_array().is_some_and(|pins| pins.len() == 1));
    assert_eq!(state["n_done"], 1);
    assert_eq!(pin(&state)[3], f64::from(Pin::default().radius));
    studio.screenshot("1_added");

    // By its rim it grows; in its middle it is taken elsewhere while time goes on.
    let before = pin(&studio.state());
    let (x, y) = studio.hover("pin 0 Rim");
    studio.drag(1, (x, y), (x + 30.0, y));
    studio.wait("a larger pin", |state| pin(state)[3] > before[3] + 0.3);
    studio.key("space");
    studio.wait("time", |state| state["playing"] == true);
    let before = pin(&studio.state());
    let (x, y) = studio.hover("pin 0 Whole");
    studio.drag(1, (x, y), (x + 40.0, y + 30.0));
    studio.wait("a pin elsewhere", |state| pin(state)[1] < before[1] - 0.3);
    studio.screenshot("2_dragged");
    studio.key("space");
    studio.wait("no time", |state| state["playing"] == false);
    studio.key("ctrl+z");
    let state = studio.wait("undo", |state| state["n_done"] == 2);
    assert_eq!(pin(&state), before, "a drag is one step");
    studio.key("ctrl+s");
    studio.wait("saved", |state| state["unsaved"] == false);
    studio.quit();
    let saved = document::open(&file).unwrap().simulation.pins;
    assert!(saved.len() == 1 && saved[0].name == "Pin 1", "{saved:?}");
}
