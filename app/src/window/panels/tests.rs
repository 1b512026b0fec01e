//! Every panel, drawn without a window: what a person can point at says what it is for.

use egui::{Event, Order, Pos2, RawInput, Rect, Sense, Ui, pos2, vec2};

use glam::Vec3;
use lorelei_core::collider::Collider;
use lorelei_core::look::Choice;
use lorelei_core::maps::Maps;
use lorelei_core::pin::Pin;
use lorelei_core::simulation::{HairKind, Quality, SimulationSettings, Wind};
use lorelei_core::style::{StyleKind, StyleOp};

use super::{history, lights, lod, look, outliner, properties, simulation, statistics, style};
use crate::window::desk::{Desk, Selection};
use crate::window::document::Document;
use crate::window::state_report::marked;

const SIZE: egui::Vec2 = vec2(340.0, 3000.0);

/// A studio's desk with the default groom and one step of history.
fn desk() -> Desk {
    let mut desk = Desk { document: Document::new(lorelei_assets::default_groom(), None, false), ..Desk::default() };
    desk.document.edit("Nothing", lorelei_core::edit::Edit::SetLights(Vec::new()), lorelei_core::history::Merge::New);
    desk.document.undo();
    desk.measure();
    desk
}

fn draw(ctx: &egui::Context, pointer: Option<Pos2>, time: f64, panel: &mut impl FnMut(&mut Ui)) {
    let events = pointer.map(Event::PointerMoved).into_iter().collect();
    let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, SIZE));
    let input = RawInput { events, screen_rect, time: Some(time), ..RawInput::default() };
    let mut output = ctx.run_ui(input, |ui| {
        egui::CentralPanel::default().show(ui, |ui| panel(ui));
    });
    // Nobody paints.
    output.textures_delta.clear();
}

/// Point at everything that can be clicked or dragged; returns where no tooltip came up.
fn without_tooltip(name: &str, mut panel: impl FnMut(&mut Ui)) -> Vec<String> {
    let ctx = egui::Context::default();
    crate::window::theme::install(&ctx);
    ctx.all_styles_mut(|style| {
        style.interaction.tooltip_delay = 0.0;
        style.interaction.show_tooltips_only_when_still = false;
    });
    let mut time = 0.0;
    let mut step = |pointer: Option<Pos2>| {
        time += 0.1;
        draw(&ctx, pointer, time, &mut panel);
    };
    step(None);
    step(None);
    let is_control = |sense: Sense| sense.senses_click() || sense.senses_drag();
    let mut controls: Vec<Rect> = ctx.viewport(|viewport| {
        let widgets = viewport.prev_pass.widgets.layers().flat_map(|(_, widgets)| widgets.iter());
        widgets.filter(|widget| widget.enabled && is_control(widget.sense)).map(|widget| widget.interact_rect).collect()
    });
    controls.retain(Rect::is_positive);
    assert!(!controls.is_empty(), "{name} has no controls");
    let mut silent = Vec::new();
    for rect in controls {
        // Away first, so that no tooltip of the one before is still there.
        step(Some(pos2(SIZE.x - 1.0, SIZE.y - 1.0)));
        step(Some(rect.center()));
        step(Some(rect.center()));
        step(Some(rect.center()));
        let is_told = ctx
            .memory(|memory| memory.areas().visible_layer_ids().into_iter().any(|layer| layer.order == Order::Tooltip));
        if !is_told {
            silent.push(format!("{name} at {:?}", rect.center()));
        }
    }
    silent
}

#[test]
fn every_control_of_every_panel_has_a_tooltip() {
    let mut desk = desk();
    desk.document.groom.simulation.sources = vec![lorelei_core::wind::WindSource::default()];
    desk.document.groom.simulation.colliders =
        vec![Collider::capsule("arm", [Vec3::ZERO, Vec3::Y], [2.0, 1.0]), Collider::default()];
    desk.document.groom.simulation.pins = vec![Pin::default()];
    let mut silent = without_tooltip("outliner", |ui| outliner::ui(ui, &mut desk));
    for selection in [
        Selection::Head,
        Selection::Layer(0),
        Selection::Light(0),
        Selection::Collider(0),
        Selection::Pin(0),
        Selection::Wind(0),
    ] {
        desk.selection = selection;
        silent.extend(without_tooltip(&format!("{selection:?}"), |ui| properties::ui(ui, &mut desk)));
    }
    silent.extend(without_tooltip("look", |ui| look::ui(ui, &mut desk)));
    silent.extend(without_tooltip("lights", |ui| lights::ui(ui, &mut desk)));
    silent.extend(without_tooltip("movement", |ui| simulation::ui(ui, &mut desk)));
    silent.extend(without_tooltip("history", |ui| history::ui(ui, &mut desk)));
    silent.extend(without_tooltip("levels", |ui| lod::ui(ui, &mut desk)));
    assert_eq!(silent, Vec::<String>::new());
}

#[test]
fn every_control_of_every_operator_has_a_tooltip() {
    let mut ops = StyleKind::DEFAULTS.map(StyleOp::new);
    let silent = without_tooltip("operators", |ui| {
        for (op_idx, op) in ops.iter_mut().enumerate() {
            ui.push_id(op_idx, |ui| style::body(ui, op, &Maps::new()));
        }
    });
    assert_eq!(silent, Vec::<String>::new());
}

#[test]
fn the_statistics_say_what_is_not_known_yet() {
    let ctx = egui::Context::default();
    let mut desk = desk();
    draw(&ctx, None, 0.0, &mut |ui: &mut Ui| statistics::ui(ui, &mut desk));
}

/// What stands in a panel.
fn words(desk: &mut Desk) -> Vec<String> {
    fn collect(shape: &egui::Shape, words: &mut Vec<String>) {
        match shape {
            egui::Shape::Text(text) => words.push(text.galley.text().to_owned()),
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| collect(shape, words)),
            _ => {}
        }
    }
    let ctx = egui::Context::default();
    crate::window::theme::install(&ctx);
    let mut words = Vec::new();
    for _ in 0..2 {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, SIZE));
        let mut output = ctx.run_ui(RawInput { screen_rect, ..RawInput::default() }, |ui| {
            egui::CentralPanel::default().show(ui, |ui| simulation::ui(ui, desk));
        });
        output.textures_delta.clear();
        words.clear();
        output.shapes.iter().for_each(|clipped| collect(&clipped.shape, &mut words));
    }
    words
}

#[test]
fn kind_and_quality_are_named_and_so_is_the_one_whose_numbers_hair_has() {
    let mut desk = desk();
    desk.document.groom.simulation = SimulationSettings::default();
    let n = |words: &[String], word: &str| words.iter().filter(|one| *one == word).count();
    for (kind, quality) in [(HairKind::FineStraight, Quality::Draft), (HairKind::Wet, Quality::High)] {
        desk.document.groom.simulation.take(kind);
        quality.put(&mut desk.document.groom.simulation);
        let words = words(&mut desk);
        assert!(n(&words, "Kind of hair") == 1 && n(&words, "Quality") == 1);
        for &other in HairKind::ALL {
            // Once on its button, and once beside the name where it is chosen.
            assert_eq!(n(&words, other.info().label), 1 + usize::from(other == kind), "{other:?}");
        }
        assert_eq!(n(&words, quality.info().label), 2);
        assert_eq!(n(&words, "Numbers of its own"), 0);
    }
    desk.document.groom.simulation.friction += 0.01;
    assert_eq!(n(&words(&mut desk), "Numbers of its own"), 1);
}

#[test]
fn sources_that_do_not_blow_because_air_is_still_are_said_to() {
    let mut desk = desk();
    let is_said = |desk: &mut Desk| words(desk).iter().any(|word| word.contains("no source blows"));
    desk.document.groom.simulation.wind = Wind::Off;
    assert!(!is_said(&mut desk), "there is none");
    desk.document.groom.simulation.sources = vec![lorelei_core::wind::WindSource::default()];
    assert!(is_said(&mut desk));
    for wind in [Wind::Uniform, Wind::Grid] {
        desk.document.groom.simulation.wind = wind;
        assert!(!is_said(&mut desk), "{wind:?}");
    }
}

#[test]
fn what_is_added_to_a_movement_is_named_alike() {
    let mut desk = desk();
    let ctx = egui::Context::default();
    crate::window::theme::install(&ctx);
    for name in ["add sphere", "add capsule", "add pin", "add fan", "add vortex"] {
        let mut frame = |events: Vec<Event>| {
            let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, SIZE));
            let mut output = ctx.run_ui(RawInput { events, screen_rect, ..RawInput::default() }, |ui| {
                egui::CentralPanel::default().show(ui, |ui| simulation::ui(ui, &mut desk));
            });
            output.textures_delta.clear();
        };
        marked(&ctx, name);
        frame(Vec::new());
        frame(Vec::new());
        let at = marked(&ctx, name).unwrap_or_else(|| panic!("{name}")).center();
        let button = |pressed| Event::PointerButton {
            pos: at,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: egui::Modifiers::NONE,
        };
        frame(vec![Event::PointerMoved(at)]);
        frame(vec![button(true)]);
        frame(vec![button(false)]);
    }
    let simulation = &desk.document.groom.simulation;
    let mut names: Vec<&str> = simulation.colliders.iter().map(|collider| collider.name.as_str()).collect();
    names.extend(simulation.pins.iter().map(|pin| pin.name.as_str()));
    names.extend(simulation.sources.iter().map(|source| source.name.as_str()));
    assert_eq!(names, ["Sphere 1", "Capsule 1", "Pin 1", "Fan 1", "Vortex 1"]);
}

#[test]
fn a_layer_that_is_gone_leaves_the_selection_to_one_that_is_seen() {
    let mut desk = desk();
    let layer = desk.document.groom.layers[0].clone();
    desk.document.groom.layers = vec![layer; 3];
    desk.document.groom.layers[2].visible = false;
    desk.selection = Selection::Layer(3);
    desk.clamp_selection();
    assert_eq!(desk.selection, Selection::Layer(1));
    desk.selection = Selection::Layer(2);
    desk.clamp_selection();
    assert_eq!(desk.selection, Selection::Layer(2), "it is there");
    desk.document.groom.layers.iter_mut().for_each(|layer| layer.visible = false);
    desk.selection = Selection::Layer(3);
    desk.clamp_selection();
    assert_eq!(desk.selection, Selection::Layer(2));
}
