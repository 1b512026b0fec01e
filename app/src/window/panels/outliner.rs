//! What is in the groom: head, layers, lights. An eye shows or hides, a double click renames.

use egui::{Align2, Color32, Key, Sense, Stroke, Ui, pos2, vec2};
use lorelei_core::edit::Edit;
use lorelei_core::groom::Source;
use lorelei_core::history::Merge;
use lorelei_core::light::Light;
use lorelei_core::look::HeadShading;

use super::widgets::thousands;
use crate::window::commands::Command;
use crate::window::desk::{Desk, Selection};
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    group(ui, "Head", |_| {});
    head_row(ui, desk);
    ui.add_space(6.0);
    let mut action = None;
    group(ui, "Layers", |ui| {
        ui.menu_button("+", |ui| {
            if ui.button("From a file\u{2026}").clicked() {
                action = Some(Action::Ask(Command::ImportHair));
            }
        })
        .response
        .on_hover_text("Add a layer");
    });
    for layer_idx in 0..desk.document.groom.layers.len() {
        layer_row(ui, desk, layer_idx, &mut action);
    }
    ui.add_space(6.0);
    group(ui, "Lights", |ui| {
        if ui.button("+").on_hover_text("Add a light").clicked() {
            action = Some(Action::AddLight);
        }
    });
    for light_idx in 0..desk.document.groom.lights.len() {
        light_row(ui, desk, light_idx, &mut action);
    }
    if let Some(action) = action {
        act(desk, action);
    }
}

#[derive(Clone, Copy)]
enum Action {
    AddLight,
    RemoveLight(usize),
    MoveLayer(usize, usize),
    Ask(Command),
}

fn act(desk: &mut Desk, action: Action) {
    let document = &mut desk.document;
    match action {
        Action::AddLight => {
            let mut lights = document.groom.lights.clone();
            let n = lights.len();
            lights.push(Light::directional(&format!("light {}", n + 1), 0.0, 30.0, 1.0, [1.0; 3]));
            document.edit("Add light", Edit::SetLights(lights), Merge::New);
            desk.selection = Selection::Light(n);
        }
        Action::RemoveLight(light_idx) => {
            let mut lights = document.groom.lights.clone();
            lights.remove(light_idx);
            document.edit("Remove light", Edit::SetLights(lights), Merge::New);
        }
        Action::MoveLayer(from, to) => {
            document.edit("Reorder layers", Edit::MoveLayer { from, to }, Merge::New);
            desk.selection = Selection::Layer(to);
        }
        Action::Ask(command) => desk.asked.push(command),
    }
}

fn group(ui: &mut Ui, title: &str, buttons: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.label(egui::RichText::new(title).small().color(theme::TEXT_WEAK));
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), buttons);
    });
}

fn head_row(ui: &mut Ui, desk: &mut Desk) {
    let look = &desk.document.groom.look;
    let is_shown = look.head != HeadShading::Hidden;
    let (name, detail) = match &desk.document.groom.head {
        Some(head) => (head.name.clone(), format!("{} triangles", thousands(head.mesh.triangles.len() as u64))),
        None => ("No head".to_owned(), String::new()),
    };
    let row = Row { name: &name, detail: &detail, is_on: is_shown, icon: Icon::Eye, selection: Selection::Head };
    let answer = row.ui(ui, desk);
    if answer.toggled {
        let mut look = desk.document.groom.look.clone();
        look.head = if is_shown { HeadShading::Hidden } else { HeadShading::Skin };
        let label = if is_shown { "Hide head" } else { "Show head" };
        desk.document.edit(label, Edit::SetLook(Box::new(look)), Merge::New);
    }
    answer.response.context_menu(|ui| {
        if ui.button("Import another head\u{2026}").clicked() {
            desk.asked.push(Command::ImportHead);
        }
    });
}

fn layer_row(ui: &mut Ui, desk: &mut Desk, layer_idx: usize, action: &mut Option<Action>) {
    let layer = &desk.document.groom.layers[layer_idx];
    let (name, is_on) = (layer.name.clone(), layer.visible);
    let kind = match &layer.source {
        Source::HairMesh(_) => "hair mesh",
        Source::Guides(_) => "guides",
        Source::Strands(_) => "strands",
    };
    let detail = format!("{kind} \u{b7} {}", thousands(u64::from(layer.n_strands)));
    let selection = Selection::Layer(layer_idx);
    let answer = Row { name: &name, detail: &detail, is_on, icon: Icon::Eye, selection }.ui(ui, desk);
    if answer.toggled {
        let label = format!("{} {name}", if is_on { "Hide" } else { "Show" });
        desk.document.edit(&label, Edit::SetLayerVisible { layer_idx, visible: !is_on }, Merge::New);
    }
    if let Some(name) = answer.renamed {
        desk.document.edit("Rename layer", Edit::SetLayerName { layer_idx, name }, Merge::New);
    }
    let n_layers = desk.document.groom.layers.len();
    answer.response.context_menu(|ui| {
        desk.selection = selection;
        if ui.button("Rename").clicked() {
            desk.renaming = Some((selection, name.clone()));
        }
        for command in
            [Command::DuplicateLayer, Command::AddFlyAways, Command::AddFrizz, Command::RemoveLayer, Command::Export]
        {
            if ui.button(command.row().label).on_hover_text(command.row().help).clicked() {
                *action = Some(Action::Ask(command));
            }
        }
        ui.separator();
        if ui.add_enabled(layer_idx > 0, egui::Button::new("Move up")).clicked() {
            *action = Some(Action::MoveLayer(layer_idx, layer_idx - 1));
        }
        if ui.add_enabled(layer_idx + 1 < n_layers, egui::Button::new("Move down")).clicked() {
            *action = Some(Action::MoveLayer(layer_idx, layer_idx + 1));
        }
    });
}

fn light_row(ui: &mut Ui, desk: &mut Desk, light_idx: usize, action: &mut Option<Action>) {
    let light = &desk.document.groom.lights[light_idx];
    let (name, is_on) = (light.name.clone(), light.on);
    let detail = format!("{:.2}", light.intensity);
    let icon = Icon::Lamp(light.colour);
    let selection = Selection::Light(light_idx);
    let answer = Row { name: &name, detail: &detail, is_on, icon, selection }.ui(ui, desk);
    let mut lights = desk.document.groom.lights.clone();
    if answer.toggled {
        lights[light_idx].on = !is_on;
        let label = format!("Switch {name} {}", if is_on { "off" } else { "on" });
        desk.document.edit(&label, Edit::SetLights(lights), Merge::New);
    } else if let Some(name) = answer.renamed {
        lights[light_idx].name = name;
        desk.document.edit("Rename light", Edit::SetLights(lights), Merge::New);
    }
    answer.response.context_menu(|ui| {
        if ui.button("Rename").clicked() {
            desk.renaming = Some((selection, name.clone()));
        }
        if ui.button("Remove").clicked() {
            *action = Some(Action::RemoveLight(light_idx));
        }
    });
}

#[derive(Clone, Copy)]
enum Icon {
    Eye,
    /// Linear RGB.
    Lamp([f32; 3]),
}

struct Row<'a> {
    name: &'a str,
    detail: &'a str,
    is_on: bool,
    icon: Icon,
    selection: Selection,
}

struct RowAnswer {
    response: egui::Response,
    toggled: bool,
    renamed: Option<String>,
}

impl Row<'_> {
    fn ui(&self, ui: &mut Ui, desk: &mut Desk) -> RowAnswer {
        let mut renamed = None;
        let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::click());
        let is_selected = desk.selection == self.selection;
        if is_selected {
            ui.painter().rect_filled(rect, 3.0, theme::ACCENT_DIM);
        } else if response.hovered() {
            ui.painter().rect_filled(rect, 3.0, theme::CONTROL);
        }
        let icon_rect = egui::Rect::from_min_size(rect.min, vec2(26.0, theme::ROW));
        let eye = ui.interact(icon_rect, response.id.with("eye"), Sense::click());
        paint_icon(ui, icon_rect.center(), self.icon, self.is_on, eye.hovered());
        let eye = eye.on_hover_text(if self.is_on { "Switch off" } else { "Switch on" });
        let text_rect = egui::Rect::from_min_max(pos2(rect.left() + 30.0, rect.top()), rect.max);
        let is_renaming = matches!(&desk.renaming, Some((renaming, _)) if *renaming == self.selection);
        if is_renaming {
            if let Some((_, text)) = &mut desk.renaming {
                let field = ui.put(text_rect, egui::TextEdit::singleline(text));
                let is_done = field.lost_focus();
                let is_kept = !ui.input(|input| input.key_pressed(Key::Escape));
                if is_done {
                    renamed = (is_kept && !text.trim().is_empty() && text != self.name).then(|| text.trim().to_owned());
                    desk.renaming = None;
                } else {
                    field.request_focus();
                }
            }
        } else {
            let colour = match (self.is_on, is_selected) {
                (false, _) => theme::TEXT_WEAK,
                (true, true) => theme::TEXT_STRONG,
                (true, false) => theme::TEXT,
            };
            let painter = ui.painter();
            let small = egui::TextStyle::Small.resolve(ui.style());
            let right = rect.right_center() - vec2(6.0, 0.0);
            let detail = painter.text(right, Align2::RIGHT_CENTER, self.detail, small, theme::TEXT_WEAK);
            let clip = egui::Rect::from_min_max(text_rect.min, pos2(detail.left() - 6.0, text_rect.bottom()));
            let font = egui::TextStyle::Body.resolve(ui.style());
            let painter = painter.with_clip_rect(clip.intersect(ui.clip_rect()));
            painter.text(text_rect.left_center(), Align2::LEFT_CENTER, self.name, font, colour);
        }
        let response = response.on_hover_text(match self.selection {
            Selection::Head => "Click to see its properties; right-click for more",
            Selection::Layer(_)
            | Selection::Light(_)
            | Selection::Collider(_)
            | Selection::Pin(_)
            | Selection::Wind(_) => "Click to see its properties; double-click to rename it; right-click for more",
        });
        if response.clicked() {
            desk.selection = self.selection;
        }
        if response.double_clicked() && !matches!(self.selection, Selection::Head) {
            desk.renaming = Some((self.selection, self.name.to_owned()));
        }
        RowAnswer { response, toggled: eye.clicked(), renamed }
    }
}

fn paint_icon(ui: &Ui, centre: egui::Pos2, icon: Icon, is_on: bool, is_hovered: bool) {
    let colour = match (is_hovered, is_on) {
        (true, _) => theme::TEXT_STRONG,
        (false, true) => theme::TEXT,
        (false, false) => Color32::from_gray(90),
    };
    let painter = ui.painter();
    match icon {
        Icon::Eye => {
            let lid = |side: f32| {
                (0..=12).map(move |i| {
                    let t = i as f32 / 12.0;
                    centre + vec2(-6.5 + 13.0 * t, side * 4.2 * (std::f32::consts::PI * t).sin())
                })
            };
            let outline: Vec<_> = lid(-1.0).collect();
            painter.add(egui::Shape::line(outline, Stroke::new(1.2, colour)));
            if is_on {
                painter.add(egui::Shape::line(lid(1.0).collect(), Stroke::new(1.2, colour)));
                painter.circle_filled(centre, 2.2, colour);
            }
        }
        Icon::Lamp(rgb) => {
            let peak = rgb.iter().copied().fold(1e-6_f32, f32::max);
            let [r, g, b] = rgb.map(|c| c / peak);
            let lamp: Color32 = egui::Rgba::from_rgb(r, g, b).into();
            if is_on {
                painter.circle_filled(centre, 4.5, lamp);
            }
            painter.circle_stroke(centre, 5.5, Stroke::new(1.0, colour));
        }
    }
}
