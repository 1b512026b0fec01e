//! The menus, made from the table of commands, and the transport.

use egui::{RichText, Ui, vec2};
use lorelei_core::look::presets::look_presets;

use super::commands::{Command, rows};
use super::room::commands::{RoomCommand, set_look};
use super::state_report::mark;
use super::{Next, Studio, theme};

pub fn ui(ui: &mut Ui, studio: &mut Studio) {
    let frame = egui::Frame::new().fill(theme::HEADER).inner_margin(egui::Margin::symmetric(8, 3));
    egui::Panel::top("menus").frame(frame).show_separator_line(false).show(ui, |ui| {
        egui::MenuBar::new().ui(ui, |ui| {
            ui.label(RichText::new("Lorelei").strong().color(theme::ACCENT));
            ui.add_space(8.0);
            for group in ["File", "Edit", "View", "Look", "Tools", "Mesh", "Movement", "Help"] {
                let menu_button = ui.menu_button(group, |ui| {
                    ui.set_min_width(230.0);
                    menu(ui, studio, group);
                });
                mark(ui.ctx(), || format!("menu {group}"), menu_button.response.rect);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| transport(ui, studio));
        });
    });
}

fn menu(ui: &mut Ui, studio: &mut Studio, group: &str) {
    for row in rows().filter(|row| row.group == group) {
        if matches!(row.command, Command::Quit) {
            ui.separator();
        }
        let mut button = egui::Button::new(row.label).frame(false);
        if let Some(shortcut) = row.shortcuts.first() {
            button = button.shortcut_text(ui.ctx().format_shortcut(shortcut));
        }
        let response = ui.add_enabled(studio.is_enabled(row.command), button).on_hover_text(row.help);
        if response.clicked() {
            studio.desk.asked.push(row.command);
            ui.close();
        }
        if matches!(row.command, Command::New) {
            ui.menu_button("New from", |ui| {
                let bare = (lorelei_assets::BARE, "The head without hair: model a style of your own");
                let styles = lorelei_assets::hairstyle_names().iter();
                let styles = styles.map(|key| (*key, "An embedded hairstyle as a new groom"));
                for (key, help) in std::iter::once(bare).chain(styles) {
                    if ui.button(key).on_hover_text(help).clicked() {
                        let ctx = ui.ctx().clone();
                        studio.ask_or_go_on(&ctx, Next::Hairstyle(key));
                        ui.close();
                    }
                }
            });
        }
        if row.command == Command::Room(RoomCommand::ContactSheet) {
            sheets(ui, studio);
        }
        if row.command == Command::Room(RoomCommand::LoadLook) {
            looks(ui, studio);
        }
        if matches!(row.command, Command::Open) {
            recent(ui, studio);
        }
    }
    if group == "File" {
        ui.separator();
        ui.checkbox(&mut studio.desk.settings.use_system_dialogs, "System file dialogs")
            .on_hover_text("Where a desktop portal answers; off: always the studio's own");
    }
}

fn sheets(ui: &mut Ui, studio: &mut Studio) {
    ui.menu_button("Contact sheet of", |ui| {
        for (key, label, help) in crate::sheet::slots() {
            if ui.button(label).on_hover_text(help).clicked() {
                let ctx = ui.ctx().clone();
                studio.draw_sheet(&ctx, key);
                ui.close();
            }
        }
    });
}

/// The studio's own looks.
fn looks(ui: &mut Ui, studio: &mut Studio) {
    let menu = ui.menu_button("Looks", |ui| {
        for preset in look_presets() {
            let button = ui.button(&preset.name);
            mark(ui.ctx(), || format!("look {}", preset.name), button.rect);
            if button.on_hover_text(&preset.help).clicked() {
                set_look(&mut studio.desk, &format!("Look: {}", preset.name), preset.look);
                ui.close();
            }
        }
    });
    mark(ui.ctx(), || "menu Looks".to_owned(), menu.response.rect);
}

fn recent(ui: &mut Ui, studio: &mut Studio) {
    let files = studio.desk.settings.recent.clone();
    let mut opened = None;
    ui.add_enabled_ui(!files.is_empty(), |ui| {
        ui.menu_button("Open recent", |ui| {
            for path in &files {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                if ui.button(name).on_hover_text(path.display().to_string()).clicked() {
                    opened = Some(path.clone());
                    ui.close();
                }
            }
        });
    });
    if let Some(path) = opened {
        let ctx = ui.ctx().clone();
        if path.exists() {
            studio.ask_or_go_on(&ctx, Next::Open(path));
        } else {
            studio.desk.notices.error("The file is gone", path.display());
            studio.desk.settings.recent.retain(|kept| *kept != path);
        }
    }
}

fn transport(ui: &mut Ui, studio: &mut Studio) {
    let is_playing = studio.desk.playback.is_playing;
    for (name, command, is_on) in [
        ("Reset", Command::Reset, false),
        ("Step", Command::Step, false),
        (if is_playing { "Pause" } else { "Play" }, Command::Play, is_playing),
    ] {
        let fill = if is_on { theme::ACCENT_DIM } else { theme::CONTROL };
        let button = egui::Button::new(RichText::new(name).color(theme::TEXT_STRONG)).fill(fill);
        let shortcut = command.row().shortcuts.first().map(|s| ui.ctx().format_shortcut(s)).unwrap_or_default();
        let response = ui.add(button.min_size(vec2(52.0, 22.0)));
        if response.on_hover_text(format!("{} ({shortcut})", command.row().help)).clicked() {
            studio.desk.asked.push(command);
        }
    }
}
