//! The levels of detail: which is drawn, what each keeps, a strip of all of them, and a target to solve for.

use egui::{RichText, Ui, vec2};
use lorelei_core::edit::Edit;
use lorelei_core::lod::{LodChoice, LodLevel, LodSettings};
use lorelei_core::maps::MOST_LOD_LEVELS;

use super::widgets;
use crate::lod_strip::LevelPicture;
use crate::window::commands::Command;
use crate::window::desk::{Desk, merge_of};
use crate::window::state_report::mark;
use crate::window::theme;

/// Sides of a level's picture, in points.
const SMALLEST_PICTURE: f32 = 72.0;
const LARGEST_PICTURE: f32 = 220.0;

/// What the panel keeps between frames.
pub struct LodPanel {
    /// Strands that a level is to be found for.
    pub target_strands: f32,
    /// Milliseconds that a level is to be found for.
    pub target_ms: f32,
    strip: Vec<(LevelPicture, egui::TextureHandle)>,
}

impl Default for LodPanel {
    fn default() -> Self {
        Self { target_strands: 20_000.0, target_ms: 16.0, strip: Vec::new() }
    }
}

impl LodPanel {
    /// Levels that were drawn.
    pub fn show(&mut self, ctx: &egui::Context, levels: Vec<LevelPicture>) {
        let texture = |drawn: &LevelPicture| {
            let size = [drawn.picture.width() as usize, drawn.picture.height() as usize];
            let image = egui::ColorImage::from_rgba_unmultiplied(size, drawn.picture.as_raw());
            ctx.load_texture(format!("level {}", drawn.level), image, egui::TextureOptions::LINEAR)
        };
        self.strip = levels.into_iter().map(|drawn| (drawn.clone(), texture(&drawn))).collect();
    }
}

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    let mut lod = desk.document.groom.lod.clone();
    let mut change = choice(ui, &mut lod);
    strip(ui, desk);
    widgets::section(ui, "Target");
    target(ui, desk, &mut lod, &mut change);
    let mut removed = None;
    let n_levels = lod.levels.len();
    for (i, level) in lod.levels.iter_mut().enumerate() {
        widgets::section(ui, &format!("Level {i}"));
        change = level_rows(ui, i, level).or(change.take());
        let can_go = i > 0 && n_levels > 2;
        let button = ui.add_enabled(can_go, egui::Button::new("Remove").small());
        if button.on_hover_text("Take this level out; its painted maps stay").clicked() {
            removed = Some(i);
        }
    }
    ui.add_space(6.0);
    let has_room = n_levels < usize::from(MOST_LOD_LEVELS);
    let button = ui.add_enabled(has_room, egui::Button::new("Add a level"));
    if button.on_hover_text("Half of the last one, seen half as large").clicked()
        && let Some(last) = lod.levels.last().copied()
    {
        let half = |x: f32| (0.5 * x).max(0.01);
        lod.levels.push(LodLevel {
            strands: half(last.strands),
            vertices: (0.75 * last.vertices).max(0.1),
            screen_size: half(last.screen_size),
            ..last
        });
        change = Some(widgets::Change::once("Add a level of detail"));
    }
    if let Some(i) = removed {
        lod.levels.remove(i);
        change = Some(widgets::Change::once(format!("Remove level {i}")));
    }
    if let Some(change) = change {
        desk.document.edit(&change.label, Edit::SetLod(Box::new(lod)), merge_of(change.drag));
    }
}

fn choice(ui: &mut Ui, lod: &mut LodSettings) -> Option<widgets::Change> {
    let mut change = None;
    let help = "Which level is drawn";
    widgets::form_row(ui, "Drawn", help, lod.choice != LodChoice::Finest, |ui| {
        let label = match lod.choice {
            LodChoice::Finest => "The finest",
            LodChoice::Automatic => "By size in the picture",
            LodChoice::Level(_) => "One of them",
        };
        let mut choice = lod.choice;
        let combo = egui::ComboBox::from_id_salt("lod choice")
            .width(ui.available_width())
            .selected_text(label)
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut choice, LodChoice::Finest, "The finest");
                ui.selectable_value(&mut choice, LodChoice::Automatic, "By size in the picture");
                ui.selectable_value(&mut choice, LodChoice::Level(1.0), "One of them");
            })
            .response
            .on_hover_text(help);
        mark(ui.ctx(), || "slot lod".to_owned(), combo.rect);
        if choice != lod.choice {
            lod.choice = choice;
            change = Some(widgets::Change::once("Level of detail"));
        }
    });
    let last = lod.last();
    if let LodChoice::Level(level) = &mut lod.choice {
        let help = "Between whole numbers a blend of two levels";
        let (_, response) =
            widgets::form_row(ui, "Level", help, false, |ui| widgets::number(ui, level, (0.0, last.max(0.01)), ""));
        let response = widgets::explained(response, help, "Drag, or click and type");
        change = widgets::Change::from_response("Level of detail", &response).or(change);
    }
    change
}

fn level_rows(ui: &mut Ui, i: usize, level: &mut LodLevel) -> Option<widgets::Change> {
    let mut change = None;
    let rows: [(&str, &str, &mut f32, (f32, f32)); 4] = [
        ("Strands", "Share of the strands that are left", &mut level.strands, (0.001, 1.0)),
        ("Vertices", "Share of each strand's vertices; four always stay", &mut level.vertices, (0.05, 1.0)),
        ("Thickness", "Width as a multiple of what keeps the covered area", &mut level.thickness, (0.1, 4.0)),
        ("Begins at", "Height of head and hair in the picture, as a share of it", &mut level.screen_size, (0.005, 2.0)),
    ];
    for (name, help, value, range) in rows {
        let (_, response) = widgets::form_row(ui, name, help, false, |ui| widgets::number(ui, value, range, ""));
        mark(ui.ctx(), || format!("value lod {i} {name}"), response.rect);
        let response = widgets::explained(response, help, "Drag, with Shift slowly, or click and type");
        let label = format!("Level {i}: {}", name.to_lowercase());
        change = widgets::Change::from_response(&label, &response).or(change);
    }
    change
}

/// The levels side by side, as they were drawn last.
fn strip(ui: &mut Ui, desk: &mut Desk) {
    let help = Command::DrawLevels.row().help;
    let button = ui.button("Draw the levels").on_hover_text(help);
    mark(ui.ctx(), || "lod strip".to_owned(), button.rect);
    if button.clicked() {
        desk.asked.push(Command::DrawLevels);
    }
    if desk.levels.strip.is_empty() {
        return;
    }
    // All beside each other where they can still be told apart.
    let n = desk.levels.strip.len() as f32;
    let gap = ui.spacing().item_spacing.x;
    let side = ((ui.available_width() - (n - 1.0) * gap) / n).clamp(SMALLEST_PICTURE, LARGEST_PICTURE);
    egui::ScrollArea::horizontal().id_salt("lod strip").show(ui, |ui| {
        ui.horizontal_top(|ui| {
            for (drawn, texture) in &desk.levels.strip {
                ui.vertical(|ui| {
                    ui.set_width(side);
                    let picture = ui.add(egui::Image::new(texture).fit_to_exact_size(vec2(side, side)));
                    picture.on_hover_ui(|ui| {
                        ui.add(egui::Image::new(texture).fit_to_original_size(1.0 / ui.pixels_per_point()));
                    });
                    let text = format!(
                        "{}: {} strands\n{}",
                        drawn.level,
                        widgets::thousands(u64::from(drawn.n_strands)),
                        widgets::milliseconds(drawn.ms)
                    );
                    ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
                });
            }
        });
    });
}

fn target(ui: &mut Ui, desk: &mut Desk, lod: &mut LodSettings, change: &mut Option<widgets::Change>) {
    let n_strands = desk.document.groom.n_strands() as f32;
    let help = "Find the level that draws so many strands";
    widgets::form_row(ui, "Strands", help, false, |ui| {
        let button = ui.small_button("Solve").on_hover_text(help);
        mark(ui.ctx(), || "lod solve strands".to_owned(), button.rect);
        let most = n_strands.max(1.0);
        widgets::number(ui, &mut desk.levels.target_strands, (1.0, most), "").on_hover_text(help);
        if button.clicked() {
            let (level, _) = lod.solve(desk.levels.target_strands, |level| n_strands * lod.blend(level).strands);
            lod.choice = LodChoice::Level(level);
            *change = Some(widgets::Change::once("Level for a number of strands"));
        }
    });
    let help = "Find the level whose whole frame takes so long on this machine: it is drawn a few times";
    widgets::form_row(ui, "Milliseconds", help, false, |ui| {
        let button = ui.small_button("Solve").on_hover_text(help);
        mark(ui.ctx(), || "lod solve ms".to_owned(), button.rect);
        widgets::number(ui, &mut desk.levels.target_ms, (1.0, 2000.0), "ms").on_hover_text(help);
        if button.clicked() {
            desk.asked.push(Command::SolveLevel);
        }
    });
}
