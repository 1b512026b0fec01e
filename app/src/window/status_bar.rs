//! The line at the bottom: what runs, what the pointer can do, and how quick frames are.

use egui::{RichText, Ui};

use super::commands::Command;
use super::panels::widgets::{milliseconds, thousands};
use super::state_report::mark;
use super::{Studio, theme, tools};

pub fn ui(ui: &mut Ui, studio: &mut Studio) {
    let frame = egui::Frame::new().fill(theme::HEADER).inner_margin(egui::Margin::symmetric(10, 3));
    egui::Panel::bottom("status").frame(frame).show_separator_line(false).show(ui, |ui| {
        ui.horizontal(|ui| {
            let report = &studio.desk.report;
            let cancellable = report.busy.and_then(|busy| Some((busy, busy.task.after_cancel()?)));
            if let Some((busy, after_cancel)) = cancellable {
                let cancel = ui.small_button("Cancel").on_hover_text(after_cancel);
                mark(ui.ctx(), || "cancel".to_owned(), cancel.rect);
                let bar = egui::ProgressBar::new(busy.share.unwrap_or(0.0));
                ui.add(bar.desired_width(120.0).desired_height(8.0));
                ui.label(busy.task.label());
                if cancel.clicked()
                    && let Some(stage) = &studio.stage
                {
                    stage.cancel();
                }
            } else if studio.jobs.running.is_empty() {
                let hint = tools::hint(&studio.desk);
                ui.label(RichText::new(hint).small().color(theme::TEXT_WEAK));
            } else {
                studio.jobs.ui(ui);
            }
            if let Some(recorder) = &studio.desk.recorder {
                ui.separator();
                let text = format!("\u{25cf} recording a macro: {} steps", recorder.n_steps());
                ui.label(RichText::new(text).small().color(theme::ACCENT));
                let stop = ui.small_button("Stop").on_hover_text("End the macro and choose its file");
                if stop.clicked() {
                    studio.desk.asked.push(Command::RecordMacro);
                }
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let weak = |text: String| RichText::new(text).small().color(theme::TEXT_WEAK);
                ui.label(weak(report.adapter.clone()));
                ui.separator();
                ui.label(weak(format!("frame {}", milliseconds(report.frame_ms))));
                ui.separator();
                ui.label(weak(format!("{} strands", thousands(report.n_strands))));
                if let Some(busy) = report.busy.filter(|_| cancellable.is_none()) {
                    ui.separator();
                    ui.label(RichText::new(format!("{}\u{2026}", busy.task.label())).small().color(theme::ACCENT));
                    ui.add(egui::Spinner::new().size(12.0));
                }
            });
        });
    });
}
