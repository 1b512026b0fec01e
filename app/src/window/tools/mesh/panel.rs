//! The modelling tool's settings: what is selected, every operation as a button, and the numbers of the last one.

use egui::{RichText, Ui};
use lorelei_core::brush::Falloff;
use lorelei_core::hair_mesh::select::Reach;
use lorelei_core::hair_mesh::{MeshOp, Scheme, Weld};

use super::commands::MeshCommand;
use super::grab::GrabKind;
use super::selection::Element;
use super::settings::{Area, ExtrudeWay};
use super::{MeshTool, ops};
use crate::window::commands::Command;
use crate::window::desk::Desk;
use crate::window::panels::widgets::{self, section};
use crate::window::state_report::mark;
use crate::window::theme;
use crate::window::tools::brush_input;

impl MeshTool {
    pub fn panel(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let Some((_, mesh)) = ops::target(desk) else {
            self.start(ui, desk);
            return;
        };
        let text = format!(
            "{} bundles, {} layers, {} vertices",
            mesh.n_bundles(),
            mesh.layers.len().saturating_sub(1),
            mesh.n_vertices()
        );
        ui.label(RichText::new(text).color(theme::TEXT_WEAK));
        self.last_operation(ui, desk);
        section(ui, "Selection");
        ui.horizontal(|ui| {
            for (element, command) in
                Element::ALL.into_iter().zip([MeshCommand::Vertices, MeshCommand::Edges, MeshCommand::Faces])
            {
                let is_on = self.selection.element == element;
                self.command_button(ui, desk, command, Some((element.label(), is_on)));
            }
        });
        let selection = &self.selection;
        let n = match selection.element {
            Element::Vertices => selection.vertices.len(),
            Element::Edges => selection.edges.len(),
            Element::Faces => selection.faces.len(),
        };
        ui.label(RichText::new(format!("{n} selected")).color(theme::TEXT_WEAK));
        self.buttons(
            ui,
            desk,
            &[
                MeshCommand::SelectAll,
                MeshCommand::SelectNone,
                MeshCommand::Invert,
                MeshCommand::Grow,
                MeshCommand::Shrink,
                MeshCommand::Loop,
                MeshCommand::Ring,
                MeshCommand::Bundle,
                MeshCommand::Layer,
                MeshCommand::Linked,
            ],
        );
        let settings = &mut self.settings;
        choice(
            ui,
            "Drag selects",
            "With Shift it adds, with Ctrl it takes out",
            &mut settings.area,
            &[(Area::Box, "A box"), (Area::Lasso, "A lasso")],
        );
        toggle(ui, "Soft selection", "What is near follows less (O)", &mut settings.is_soft);
        if settings.is_soft {
            number(
                ui,
                "Soft radius",
                "From the nearest selected vertex",
                &mut settings.soft_radius,
                4.0,
                (0.2, 40.0),
                "cm",
            );
            let falloffs: Vec<(Falloff, &str)> = Falloff::ALL.into_iter().map(|f| (f, f.label())).collect();
            choice(ui, "Falloff", "How much less", &mut settings.soft_falloff, &falloffs);
            choice(
                ui,
                "Reaches",
                "Along the mesh, what is near but not connected stays: the other side of a parting",
                &mut settings.soft_reach,
                &[(Reach::Straight, "Through the air"), (Reach::Connected, "Along the mesh")],
            );
        }
        section(ui, "Move");
        self.buttons(
            ui,
            desk,
            &[
                MeshCommand::Move,
                MeshCommand::Rotate,
                MeshCommand::Scale,
                MeshCommand::Slide,
                MeshCommand::Extend,
                MeshCommand::Smooth,
                MeshCommand::SnapToHead,
            ],
        );
        let settings = &mut self.settings;
        let kinds = [(GrabKind::Move, "Move"), (GrabKind::Rotate, "Rotate"), (GrabKind::Scale, "Scale")];
        choice(ui, "Handles", "What the handles at the selection do", &mut settings.handle, &kinds);
        toggle(
            ui,
            "Mirror across X",
            "The other side follows, where it has the same faces",
            &mut settings.is_symmetric,
        );
        toggle(ui, "Place the inside", "Inner vertices follow after every move, unless pinned", &mut settings.relaxes);
        toggle(ui, "Stay out of the head", "Vertices do not enter it; roots stay on it", &mut settings.stays_out);
        if settings.stays_out {
            number(ui, "Clearance", "From the head", &mut settings.clearance, 0.3, (0.0, 3.0), "cm");
        }
        section(ui, "Grow and cut");
        self.buttons(
            ui,
            desk,
            &[
                MeshCommand::Extrude,
                MeshCommand::ExtrudeDown,
                MeshCommand::DeleteTips,
                MeshCommand::DeleteBundles,
                MeshCommand::InsertLayer,
                MeshCommand::RemoveLayer,
            ],
        );
        let settings = &mut self.settings;
        let ways: Vec<(ExtrudeWay, &str)> = ExtrudeWay::ALL.into_iter().map(|way| (way, way.label())).collect();
        choice(ui, "Extrude", "Which way", &mut settings.way, &ways);
        if settings.way == ExtrudeWay::Gravity {
            number(ui, "Pull", "0 the way the hair goes, 1 straight down", &mut settings.pull, 0.4, (0.0, 1.0), "");
        }
        number(ui, "Length", "Of an extrusion", &mut settings.length, 3.0, (0.1, 60.0), "cm");
        widgets::form_row(ui, "Layers", "That an extrusion is made of", settings.n_layers != 1, |ui| {
            widgets::integer(ui, &mut settings.n_layers, (1, 24), "").on_hover_text("Layers of one extrusion");
        });
        let welds = [(Weld::Neighbours, "Join neighbours"), (Weld::Apart, "Stay apart: a parting")];
        choice(
            ui,
            "New faces",
            "Whether they share vertices with what was extruded before",
            &mut settings.weld,
            &welds,
        );
        section(ui, "Topology");
        self.buttons(
            ui,
            desk,
            &[
                MeshCommand::Separate,
                MeshCommand::Weld,
                MeshCommand::DivideFace,
                MeshCommand::DivideEdge,
                MeshCommand::Subdivide,
                MeshCommand::Mirror,
            ],
        );
        let settings = &mut self.settings;
        let schemes = [(Scheme::CatmullClark, "Catmull-Clark"), (Scheme::Loop, "Loop"), (Scheme::Linear, "Linear")];
        choice(ui, "Subdivide", "By which scheme", &mut settings.scheme, &schemes);
        number(
            ui,
            "At",
            "Where a new layer or vertex is put, from the layer below or the edge's first end",
            &mut settings.at,
            0.5,
            (0.05, 0.95),
            "",
        );
        section(ui, "Inside");
        self.buttons(ui, desk, &[MeshCommand::Relax, MeshCommand::Pin, MeshCommand::Unpin]);
        let display = &mut self.settings.display;
        toggle(ui, "Show the inside", "The vertices that the studio places (I)", &mut display.shows_inside);
        toggle(ui, "See through", "Show and take what is behind (Alt+Z)", &mut display.is_x_ray);
        number(ui, "Cage", "Opacity of its faces", &mut display.opacity, 0.25, (0.0, 1.0), "");
        section(ui, "Push brush");
        let help = "Drags push the outer surface out, with Ctrl in, with Shift smooth it (T)";
        toggle(ui, "Push brush", help, &mut self.settings.is_pushing);
        if self.settings.is_pushing {
            brush_input::panel(ui, &mut self.settings.push);
        }
        section(ui, "Another hair mesh");
        self.start_button(ui, desk);
    }

    fn start(&mut self, ui: &mut Ui, desk: &mut Desk) {
        ui.label("A hair mesh is the volume of the hair in layers of polygons, from the scalp to the tips. Strands are traced through it.");
        ui.add_space(6.0);
        self.start_button(ui, desk);
    }

    fn start_button(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let help = "About the side of a root face";
        number(ui, "Root faces", help, &mut self.settings.new_spacing, 2.5, (1.0, 8.0), "cm");
        let button = ui.button("New hair mesh on the scalp");
        mark(ui.ctx(), || "new hair mesh".to_owned(), button.rect);
        if button.on_hover_text("A layer of its own: root faces over the scalp, ready to be extruded").clicked() {
            ops::new_on_scalp(self, desk);
        }
    }

    fn command_button(&self, ui: &mut Ui, desk: &mut Desk, command: MeshCommand, shown: Option<(&str, bool)>) {
        let row = Command::Mesh(command).row();
        let (label, is_on) = shown.unwrap_or((row.label, false));
        let fill = if is_on { theme::ACCENT_DIM } else { theme::CONTROL };
        let is_enabled = self.is_enabled(desk, command);
        let button = ui.add_enabled(is_enabled, egui::Button::new(label).fill(fill));
        mark(ui.ctx(), || format!("mesh {label}"), button.rect);
        let key = row.shortcuts.first().map(|s| format!(" ({})", ui.ctx().format_shortcut(s))).unwrap_or_default();
        let help = if row.help.is_empty() { row.label } else { row.help };
        let text = format!("{help}{key}");
        if button.on_hover_text(&text).on_disabled_hover_text(text).clicked() {
            desk.asked.push(Command::Mesh(command));
        }
    }

    fn buttons(&self, ui: &mut Ui, desk: &mut Desk, commands: &[MeshCommand]) {
        ui.horizontal_wrapped(|ui| {
            for &command in commands {
                self.command_button(ui, desk, command, None);
            }
        });
    }

    fn last_operation(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let state = desk.document.state();
        let Some(last) = self.last.as_ref().filter(|last| last.state == state) else { return };
        let mut op = last.op.clone();
        let shown = |ui: &mut Ui, rows: &mut dyn FnMut(&mut Ui)| {
            section(ui, &format!("Last: {}", last.label));
            rows(ui);
        };
        match &mut op {
            MeshOp::Extrude { length_cm, n_layers, .. } => shown(ui, &mut |ui| {
                let before = *length_cm;
                number(ui, "Last length", "Of the extrusion", length_cm, before, (0.1, 60.0), "cm");
                widgets::form_row(ui, "Last layers", "Of the extrusion", false, |ui| {
                    widgets::integer(ui, n_layers, (1, 24), "").on_hover_text("Of the extrusion");
                });
            }),
            MeshOp::InsertLayer { at, .. } | MeshOp::DivideEdge { at, .. } => shown(ui, &mut |ui| {
                let before = *at;
                number(ui, "Last place", "Along the way", at, before, (0.05, 0.95), "");
            }),
            MeshOp::SmoothVertices { strength, n_times, .. } => shown(ui, &mut |ui| {
                let before = *strength;
                number(ui, "Last strength", "Of the smoothing", strength, before, (0.0, 1.0), "");
                widgets::form_row(ui, "Last times", "How often", false, |ui| {
                    widgets::integer(ui, n_times, (1, 50), "").on_hover_text("How often");
                });
            }),
            MeshOp::Subdivide { scheme, .. } => shown(ui, &mut |ui| {
                let schemes =
                    [(Scheme::CatmullClark, "Catmull-Clark"), (Scheme::Loop, "Loop"), (Scheme::Linear, "Linear")];
                choice(ui, "Last scheme", "Of the subdivision", scheme, &schemes);
            }),
            _ => {}
        }
        if op != last.op {
            self.redo_last(desk, op);
        }
    }
}

fn number(ui: &mut Ui, name: &str, help: &str, value: &mut f32, default: f32, range: (f32, f32), unit: &str) {
    let is_changed = (*value - default).abs() > 1e-6;
    let (is_reset, response) =
        widgets::form_row(ui, name, help, is_changed, |ui| widgets::number(ui, value, range, unit));
    response.on_hover_text(help);
    if is_reset {
        *value = default;
    }
}

fn toggle(ui: &mut Ui, name: &str, help: &str, value: &mut bool) {
    widgets::form_row(ui, name, help, false, |ui| widgets::switch(ui, value).on_hover_text(help));
}

fn choice<T: Copy + PartialEq>(ui: &mut Ui, name: &str, help: &str, value: &mut T, all: &[(T, &str)]) {
    widgets::form_row(ui, name, help, false, |ui| {
        let text = all.iter().find(|(one, _)| one == value).map_or("", |(_, label)| label);
        egui::ComboBox::from_id_salt(name)
            .selected_text(text)
            .width(ui.available_width())
            .show_ui(ui, |ui| {
                for (one, label) in all {
                    ui.selectable_value(value, *one, *label);
                }
            })
            .response
            .on_hover_text(help);
    });
}
