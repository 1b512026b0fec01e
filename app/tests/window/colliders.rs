//! A collider is added, moved and resized with the mouse, also while hair moves.

use glam::Vec3;
use lorelei_core::collider::Collider;
use lorelei_core::document;

use crate::sample::small_groom;
use crate::studio::{Display, Studio, begin, numbers};

#[test]
fn a_collider_follows_the_hand_while_hair_moves() {
    let Some((_alone, folder)) = begin("colliders") else { return };
    let file = folder.join("small.lorelei");
    let mut groom = small_groom();
    groom.simulation.colliders = vec![Collider::sphere("ball", Vec3::new(13.0, 2.0, 3.0), 3.0)];
    document::save(&groom, &file).unwrap();
    let display = Display::start();
    let mut studio = Studio::open(&display, &folder, &[file.to_str().unwrap()], "first");
    studio.wait("the first picture", |state| state["still"] == true);
    let ball = |studio: &Studio| numbers::<4>(&studio.state()["colliders"][0]);

    // Grabbed in the middle it moves.
    let before = ball(&studio);
    let (x, y) = studio.hover("collider 0 Whole");
    studio.drag(1, (x, y), (x - 40.0, y + 20.0));
    studio.wait("a moved ball", |state| numbers::<4>(&state["colliders"][0])[0] < before[0] - 0.3);
    assert_eq!(studio.state()["n_done"], 1, "a drag is one step");
    studio.screenshot("1_moved");

    // By its rim it grows.
    let before = ball(&studio);
    let (x, y) = studio.hover("collider 0 Rim(0)");
    studio.drag(1, (x, y), (x + 40.0, y));
    studio.wait("a larger ball", |state| numbers::<4>(&state["colliders"][0])[3] > before[3] + 0.3);
    studio.screenshot("2_larger");

    // While time goes on it moves too.
    studio.wait("rest", |state| state["still"] == true);
    studio.key("space");
    studio.wait("time", |state| state["playing"] == true);
    let before = ball(&studio);
    let (x, y) = studio.hover("collider 0 Whole");
    studio.drag(1, (x, y), (x - 60.0, y));
    studio.wait("a ball in the hair", |state| numbers::<4>(&state["colliders"][0])[0] < before[0] - 0.5);
    studio.screenshot("3_playing");
    studio.key("space");
    studio.wait("no time", |state| state["playing"] == false);
    studio.key("ctrl+z");
    studio.wait("undo", |state| state["n_done"] == 2);
    assert_eq!(ball(&studio), before);
    studio.key("ctrl+s");
    studio.wait("saved", |state| state["unsaved"] == false);
    studio.quit();
}
