//! The command palette and the shortcut sheet, both printed from the table of commands.

use egui::{Align2, Key, RichText};

use super::commands::{Command, POINTER, rows, search_rank};
use super::theme;

/// What is typed, and which answer is marked. `None` in the studio while the palette is closed.
#[derive(Debug, Default)]
pub struct Palette {
    query: String,
    marked: usize,
    had_focus: bool,
}

/// What became of the palette in this frame.
pub enum PaletteAnswer {
    StaysOpen,
    Closed,
    Run(Command),
}

impl Palette {
    /// Opened in this frame.
    pub fn new(ctx: &egui::Context) -> Self {
        let mut palette = Self::default();
        palette.take_typed(ctx);
        palette
    }

    /// What was typed in this frame, which the field does not see before it has the focus: Enter would else run the first
    /// command of all.
    fn take_typed(&mut self, ctx: &egui::Context) {
        ctx.input(|input| {
            for event in &input.events {
                if let egui::Event::Text(text) = event {
                    self.query.push_str(text);
                }
            }
        });
    }

    pub fn ui(&mut self, ctx: &egui::Context) -> PaletteAnswer {
        let mut answer = PaletteAnswer::StaysOpen;
        if !self.had_focus {
            self.take_typed(ctx);
        }
        let (up, down, enter, escape) = ctx.input_mut(|input| {
            let mut take = |key| input.consume_key(egui::Modifiers::NONE, key);
            (take(Key::ArrowUp), take(Key::ArrowDown), take(Key::Enter), take(Key::Escape))
        });
        let mut found = Vec::new();
        let window = egui::Window::new("Commands")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::CENTER_TOP, [0.0, 90.0])
            .fixed_size([460.0, 380.0])
            .order(egui::Order::Foreground)
            .show(ctx, |ui| {
                let field = egui::TextEdit::singleline(&mut self.query)
                    .hint_text("Type a command")
                    .desired_width(f32::INFINITY)
                    .margin(egui::Margin::symmetric(8, 6));
                let field = ui.add(field);
                if !self.had_focus {
                    field.request_focus();
                    self.had_focus = true;
                }
                if field.changed() {
                    self.marked = 0;
                }
                // Searched after the field: what was typed before Enter counts, though both came in one frame.
                found = rows().filter_map(|row| search_rank(&self.query, row).map(|rank| (rank, row))).collect();
                found.sort_by_key(|(rank, _)| *rank);
                self.mark(up, down, found.len());
                ui.add_space(4.0);
                egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                    for (row_idx, (_, row)) in found.iter().enumerate() {
                        let response = command_row(ui, row_idx == self.marked, row.command);
                        if (up || down) && row_idx == self.marked {
                            response.scroll_to_me(None);
                        }
                        if response.clicked() {
                            answer = PaletteAnswer::Run(row.command);
                        }
                    }
                    if found.is_empty() {
                        ui.label(RichText::new("No command is called that.").color(theme::TEXT_WEAK));
                    }
                });
            });
        if enter && let Some((_, row)) = found.get(self.marked) {
            answer = PaletteAnswer::Run(row.command);
        }
        let clicked_elsewhere = window.is_some_and(|window| window.response.clicked_elsewhere());
        if matches!(answer, PaletteAnswer::StaysOpen) && (escape || clicked_elsewhere) {
            answer = PaletteAnswer::Closed;
        }
        answer
    }

    fn mark(&mut self, up: bool, down: bool, n_found: usize) {
        if down {
            self.marked += 1;
        }
        if up {
            self.marked = self.marked.saturating_sub(1);
        }
        self.marked = self.marked.min(n_found.saturating_sub(1));
    }
}

/// Name at the left, shortcut at the right, over the full width.
fn command_row(ui: &mut egui::Ui, is_marked: bool, command: Command) -> egui::Response {
    let row = command.row();
    let (rect, response) =
        ui.allocate_exact_size(egui::vec2(ui.available_width(), theme::ROW + 4.0), egui::Sense::click());
    if is_marked {
        ui.painter().rect_filled(rect, 3.0, theme::ACCENT_DIM);
    } else if response.hovered() {
        ui.painter().rect_filled(rect, 3.0, theme::CONTROL);
    }
    let painter = ui.painter();
    let font = egui::TextStyle::Body.resolve(ui.style());
    let left = rect.left_center() + egui::vec2(8.0, 0.0);
    let drawn = painter.text(left, Align2::LEFT_CENTER, row.label, font.clone(), theme::TEXT_STRONG);
    let small = egui::TextStyle::Small.resolve(ui.style());
    let after = egui::pos2(drawn.right() + 10.0, rect.center().y);
    painter.text(after, Align2::LEFT_CENTER, row.help, small, theme::TEXT_WEAK);
    if let Some(shortcut) = row.shortcuts.first() {
        let text = ui.ctx().format_shortcut(shortcut);
        let right = rect.right_center() - egui::vec2(8.0, 0.0);
        let galley = painter.layout_no_wrap(text, font, theme::TEXT);
        let text_rect = Align2::RIGHT_CENTER.anchor_size(right, galley.size());
        let fill = if is_marked { theme::ACCENT_DIM } else { ui.visuals().window_fill };
        painter.rect_filled(text_rect.expand2(egui::vec2(8.0, 2.0)), 0.0, fill);
        painter.galley(text_rect.min, galley, theme::TEXT);
    }
    response.on_hover_text(row.help)
}

/// All shortcuts by group; false once it was closed.
pub fn shortcut_sheet(ctx: &egui::Context) -> bool {
    let mut is_open = true;
    let escape = ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Escape));
    egui::Window::new("Shortcuts")
        .open(&mut is_open)
        .collapsible(false)
        .resizable(false)
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .order(egui::Order::Foreground)
        .show(ctx, |ui| {
            ui.horizontal_top(|ui| {
                for groups in [&["File", "Edit"][..], &["View", "Tools", "Help"], &["Movement", "Look", "Mesh"]] {
                    ui.vertical(|ui| {
                        ui.set_width(285.0);
                        for group in groups {
                            group_of_shortcuts(ui, group);
                        }
                    });
                    ui.add_space(14.0);
                }
            });
            ui.separator();
            ui.label(RichText::new("In the viewport").strong().color(theme::ACCENT));
            egui::Grid::new("pointer").num_columns(2).spacing([24.0, 3.0]).show(ui, |ui| {
                for (what, how) in POINTER {
                    ui.label(*what);
                    ui.label(RichText::new(*how).color(theme::TEXT_WEAK));
                    ui.end_row();
                }
            });
        });
    is_open && !escape
}

fn group_of_shortcuts(ui: &mut egui::Ui, group: &str) {
    ui.label(RichText::new(group).strong().color(theme::ACCENT));
    for row in rows().filter(|row| row.group == group && !row.shortcuts.is_empty()) {
        ui.horizontal(|ui| {
            ui.label(row.label).on_hover_text(row.help);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let keys: Vec<String> =
                    row.shortcuts.iter().map(|shortcut| ui.ctx().format_shortcut(shortcut)).collect();
                ui.label(RichText::new(keys.join("  or  ")).color(theme::TEXT_WEAK));
            });
        });
    }
    ui.add_space(8.0);
}

#[cfg(test)]
mod tests {
    use egui::{Event, Modifiers, RawInput};

    use super::*;

    #[test]
    fn what_was_typed_before_enter_counts_though_both_come_in_one_frame() {
        // In the frame in which it opens, and once it has the focus.
        for n_before in [0, 3] {
            let ctx = egui::Context::default();
            let mut palette = Palette::default();
            let mut frame = |events: Vec<Event>| {
                let mut answer = PaletteAnswer::StaysOpen;
                let mut output =
                    ctx.run_ui(RawInput { events, ..RawInput::default() }, |ui| answer = palette.ui(&ui.ctx().clone()));
                // Nobody paints.
                output.textures_delta.clear();
                answer
            };
            for _ in 0..n_before {
                assert!(matches!(frame(Vec::new()), PaletteAnswer::StaysOpen));
            }
            let enter = Event::Key {
                key: Key::Enter,
                physical_key: None,
                pressed: true,
                repeat: false,
                modifiers: Modifiers::NONE,
            };
            let answer = frame(vec![Event::Text("switch shadows".to_owned()), enter]);
            assert!(matches!(answer, PaletteAnswer::Run(Command::ToggleShadows)), "after {n_before} frames");
        }
    }
}
