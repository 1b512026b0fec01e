//! Every panel, drawn without a window: what a person can point at says what it is for.

use egui::{Event, Order, Pos2, RawInput, Rect, Sense, Ui, pos2, vec2};

use glam::Vec3;
use lorelei_core::collider::Collider;
use lorelei_core::maps::Maps;
use lorelei_core::pin::Pin;
use lorelei_core::style::{StyleKind, StyleOp};

use super::{history, lights, lod, look, outliner, properties, simulation, statistics, style};
use crate::window::desk::{Desk, Selection};
use crate::window::document::Document;

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
