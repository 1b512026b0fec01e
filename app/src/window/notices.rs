//! What went wrong or is worth knowing, shown once and kept until a person dismisses it.

use egui::{Align2, Color32, Frame, Margin, RichText, Stroke};

use super::theme;

/// How a notice looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    Info,
    Warning,
    Error,
}

/// One message. The title says what, the text where and what to do next.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    pub severity: Severity,
    pub title: String,
    pub text: String,
}

/// The messages that are on screen, oldest first.
#[derive(Debug, Default)]
pub struct Notices {
    pub shown: Vec<Notice>,
}

impl Notices {
    /// Show a message; one that is already there is not repeated.
    pub fn push(&mut self, severity: Severity, title: impl Into<String>, text: impl Into<String>) {
        let notice = Notice { severity, title: title.into(), text: text.into() };
        match severity {
            Severity::Info => log::info!("{}: {}", notice.title, notice.text),
            Severity::Warning => log::warn!("{}: {}", notice.title, notice.text),
            Severity::Error => log::error!("{}: {}", notice.title, notice.text),
        }
        if !self.shown.contains(&notice) {
            self.shown.push(notice);
        }
    }

    pub fn error(&mut self, title: impl Into<String>, why: impl std::fmt::Display) {
        self.push(Severity::Error, title, why.to_string());
    }

    /// Cards in the viewport's lower right corner, where they cover no panel.
    pub fn ui(&mut self, ctx: &egui::Context, viewport: Option<egui::Rect>) {
        if self.shown.is_empty() {
            return;
        }
        let corner =
            viewport.map_or(ctx.content_rect().right_bottom(), |rect| rect.right_bottom()) - egui::vec2(12.0, 12.0);
        let mut dismissed = None;
        let mut dismiss_all = false;
        egui::Area::new(egui::Id::unique("notices"))
            .pivot(Align2::RIGHT_BOTTOM)
            .fixed_pos(corner)
            .order(egui::Order::Foreground)
            .show(ctx, |ui| {
                ui.set_max_width(400.0);
                if self.shown.len() > 1 {
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        dismiss_all = ui.button("Dismiss all").on_hover_text("They were read").clicked();
                    });
                }
                for (notice_idx, notice) in self.shown.iter().enumerate().rev().take(5) {
                    if card(ui, notice) {
                        dismissed = Some(notice_idx);
                    }
                }
            });
        if dismiss_all {
            self.shown.clear();
        } else if let Some(notice_idx) = dismissed {
            self.shown.remove(notice_idx);
        }
    }
}

/// Draw one message; true when it was dismissed.
fn card(ui: &mut egui::Ui, notice: &Notice) -> bool {
    let mark = match notice.severity {
        Severity::Info => theme::GOOD,
        Severity::Warning => theme::ACCENT,
        Severity::Error => theme::ERROR,
    };
    let mut is_dismissed = false;
    let frame = Frame::new()
        .fill(Color32::from_gray(44))
        .stroke(Stroke::new(1.0, Color32::from_gray(70)))
        .corner_radius(5)
        .inner_margin(Margin { left: 14, right: 8, top: 8, bottom: 10 })
        .shadow(ui.visuals().popup_shadow)
        .show(ui, |ui| {
            ui.set_width(376.0);
            ui.horizontal(|ui| {
                ui.label(RichText::new(&notice.title).strong().color(theme::TEXT_STRONG));
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    is_dismissed = ui.button("Dismiss").on_hover_text("It was read").clicked();
                    if ui.button("Copy").on_hover_text("Copy the message").clicked() {
                        ui.ctx().copy_text(format!("{}: {}", notice.title, notice.text));
                    }
                });
            });
            if !notice.text.is_empty() {
                ui.add(egui::Label::new(RichText::new(&notice.text).color(theme::TEXT)).wrap().selectable(true));
            }
        });
    let rect = frame.response.rect;
    let stripe = egui::Rect::from_min_max(rect.min, egui::pos2(rect.min.x + 4.0, rect.max.y));
    ui.painter().rect_filled(stripe, egui::CornerRadius { nw: 5, sw: 5, ne: 0, se: 0 }, mark);
    is_dismissed
}
