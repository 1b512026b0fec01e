//! `lorelei simulate` with what moves the head and the air: an animation's node, a source of wind.

use std::path::Path;

use glam::Vec3;
use lorelei_core::document;
use lorelei_core::groom::{Groom, Layer, Source};
use lorelei_core::motion::{Motion, Movement};
use lorelei_core::strands::Strands;
use serde_json::Value;

use super::animated::animated_glb;
use super::{lorelei, text};

/// Twelve guides that hang side by side.
fn curtain() -> Groom {
    let mut strands = Strands::default();
    for i in 0..12 {
        strands.push(&(0..10).map(|k| Vec3::new(i as f32 - 6.0, -1.5 * k as f32, 6.0)).collect::<Vec<_>>());
    }
    let layer = Layer { n_strands: 20_000, ..Layer::new("a", Source::Guides(strands.into())) };
    Groom {
        layers: vec![layer],
        movement: Movement { motion: Motion::None, ..Movement::default() },
        ..Groom::default()
    }
}

fn simulated(folder: &Path, arguments: &[&str]) -> Value {
    let common = ["simulate", "a.lorelei", "--on", "cpu", "--fps", "30", "--rest", "0", "--json"];
    let done = lorelei(folder, &[&common, arguments].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
    serde_json::from_slice(&done.stdout).unwrap()
}

/// The most kinetic energy of any frame, erg/g.
fn most_energy(json: &Value) -> f64 {
    let frames = json["kinetic_energy"].as_array().unwrap();
    frames.iter().map(|frame| frame.as_array().map_or(frame, |pair| &pair[1]).as_f64().unwrap()).fold(0.0, f64::max)
}

#[test]
fn a_node_of_a_file_and_a_fan_move_hair_without_a_window() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    document::save(&curtain(), &folder.join("a.lorelei")).unwrap();
    std::fs::write(folder.join("moves.glb"), animated_glb()).unwrap();

    let still = simulated(folder, &["--seconds", "0.3"]);
    assert!(most_energy(&still) < 1.0 && still["nan"] == 0, "{still}");

    // As long as the animation is, by the node that is asked for: down and to the side are other ways for hair that hangs.
    let by = |node: &str| simulated(folder, &["--animation", "moves.glb", "--node", node]);
    let (head, hips) = (by("Head"), by("hips"));
    for json in [&head, &hips] {
        assert!((json["seconds"].as_f64().unwrap() - 0.5).abs() < 1e-6 && json["nan"] == 0, "{json}");
        assert!(most_energy(json) > 100.0 && json["length_error_max"].as_f64().unwrap() < 1e-3, "{json}");
    }
    assert_ne!(head["kinetic_energy"], hips["kinetic_energy"]);
    let unknown =
        lorelei(folder, &["simulate", "a.lorelei", "--on", "cpu", "--animation", "moves.glb", "--node", "Tail"]);
    assert_eq!(unknown.status.code(), Some(2));
    let told = text(&unknown.stderr);
    assert!(told.contains("Head") && told.contains("Hips"), "{told}");

    // A fan beside it: as if nothing stood in its way, and in a grid of air that the hair slows; where it does not, the air
    // comes as fast as through nothing.
    let fan = ["--seconds", "0.3", "--wind-source", "fan,-16,-8,6,speed=900,radius=6,to=0/-8/6"];
    let free = simulated(folder, &[&fan[..], &["--set", "wind=uniform"]].concat());
    let grid = ["--set", "wind=grid", "--set", "wind.resolution=16"];
    let slowed = simulated(folder, &[&fan[..], &grid].concat());
    let through = simulated(folder, &[&fan[..], &grid, &["--set", "wind.hair_drag=0"]].concat());
    let energies = [&still, &slowed, &through, &free].map(most_energy);
    println!("still, slowed, through, free: {energies:?}");
    assert!(energies[..3].is_sorted_by(|a, b| 1.5 * a < *b) && energies[3] > 20.0, "{energies:?}");
    assert!((0.7..1.1).contains(&(energies[2] / energies[3])), "{energies:?}");
    for json in [&slowed, &through, &free] {
        assert!(json["nan"] == 0 && json["length_error_max"].as_f64().unwrap() < 1e-3, "{json}");
    }

    // In a picture too, once time has passed; where none passes, it would do nothing and is refused.
    let picture = |name: &str, more: &[&str]| {
        let common = ["render", "a.lorelei", "--size", "160x120", "--camera", "20,0,70", "--out", name];
        let done = lorelei(folder, &[&common, more].concat());
        (done.status.code(), text(&done.stderr), std::fs::read(folder.join(name)).ok())
    };
    let (_, _, calm) = picture("calm.png", &["--seconds", "0.3"]);
    let (code, told, blown) = picture("blown.png", &[&fan[2..], &["--seconds", "0.3"]].concat());
    assert_eq!(code, Some(0), "{told}");
    let pixels = |png: Option<Vec<u8>>| image::load_from_memory(&png.unwrap()).unwrap().to_rgb8();
    let (calm, blown) = (pixels(calm), pixels(blown));
    let n_other = calm.pixels().zip(blown.pixels()).filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 8).count();
    assert!(n_other > 200, "{n_other} pixels");
    let (code, told, none) = picture("none.png", &fan[2..]);
    assert!(code == Some(2) && told.contains("--seconds") && none.is_none(), "{told}");
}

#[test]
fn numbers_and_names_that_cannot_be_are_refused_by_their_own_option() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, told) in [
        (["--seconds", "-1"], "a number of seconds from 0 to 600"),
        (["--fps", "-5"], "frames a second from 1 to 480"),
        (["--strands", "0"], "0 is not in 1..=4000000"),
        (["--filmstrip", "a.txt"], "--filmstrip a.txt: let the name end in .png"),
    ] {
        let done = lorelei(folder.path(), &[&["simulate", "bob"], &arguments[..]].concat());
        assert!(done.status.code() == Some(2) && text(&done.stderr).contains(told), "{}", text(&done.stderr));
    }
}

#[test]
fn a_pin_holds_hair_whether_it_is_an_argument_or_an_edit() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    document::save(&curtain(), &folder.join("a.lorelei")).unwrap();
    let shaken = ["--seconds", "0.5", "--motion", "shake"];
    let free = simulated(folder, &shaken);
    // Around the lower half of every guide.
    let pinned = simulated(folder, &[&shaken[..], &["--pin", "0,-10,6,radius=8"]].concat());
    let off = simulated(folder, &[&shaken[..], &["--pin", "0,40,6,radius=8"]].concat());
    println!("free {}, pinned {}", most_energy(&free), most_energy(&pinned));
    assert_ne!(free["kinetic_energy"], pinned["kinetic_energy"]);
    assert_eq!(free["kinetic_energy"], off["kinetic_energy"], "a pin without hair holds none");
    assert!(pinned["nan"] == 0 && pinned["length_error_max"].as_f64().unwrap() < 1e-3, "{pinned}");

    std::fs::write(folder.join("pin.ron"), "[SetPins([(name: \"clip\", centre: (0, -10, 6), radius: 8)])]").unwrap();
    let done = lorelei(folder, &["apply", "a.lorelei", "--edits", "pin.ron", "--out", "a.lorelei"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert_eq!(document::open(&folder.join("a.lorelei")).unwrap().simulation.pins[0].name, "clip");
    assert_eq!(simulated(folder, &shaken)["kinetic_energy"], pinned["kinetic_energy"]);

    let wrong = lorelei(folder, &["simulate", "a.lorelei", "--pin", "1,2"]);
    assert!(wrong.status.code() == Some(2) && text(&wrong.stderr).contains("z is missing"), "{}", text(&wrong.stderr));
}

#[test]
fn what_is_taken_otherwise_than_it_was_asked_for_or_takes_the_place_of_something_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    document::save(&curtain(), &folder.join("a.lorelei")).unwrap();
    let warnings = |arguments: &[&str]| {
        let json = simulated(folder, &[&["--seconds", "0.1"], arguments].concat());
        json["warnings"].as_array().unwrap().iter().map(|words| words.as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let none = Vec::<String>::new();
    assert_eq!(warnings(&["--set", "wind=grid", "--set", "wind.resolution=16"]), none);
    let nearest = warnings(&["--set", "wind=grid", "--set", "wind.resolution=20"]);
    assert!(nearest.len() == 1 && nearest[0].contains("16 cells a side; it can have 16, 24, 32"), "{nearest:?}");
    // Frames: the same movement's may be made again; another one's are replaced with a word.
    assert_eq!(warnings(&["--out", "a.frames"]), none);
    assert_eq!(warnings(&["--out", "a.frames"]), none);
    let other = warnings(&["--out", "a.frames", "--set", "sim.gravity=500"]);
    assert!(other.len() == 1 && other[0].contains("a.frames held frames of another movement"), "{other:?}");
    // What an interrupted run has left is work too.
    std::fs::rename(folder.join("a.frames"), folder.join("a.frames.part")).unwrap();
    assert_eq!(warnings(&["--out", "a.frames"]).len(), 1);
    // And what is no file of frames is not written over at all.
    std::fs::write(folder.join("notes.frames"), "something else").unwrap();
    let refused =
        lorelei(folder, &["simulate", "a.lorelei", "--on", "cpu", "--seconds", "0.1", "--out", "notes.frames"]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("choose another name"), "{refused:?}");
    assert_eq!(std::fs::read(folder.join("notes.frames")).unwrap(), b"something else");
}
