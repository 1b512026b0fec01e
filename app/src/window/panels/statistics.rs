//! Numbers: strands, vertices, memory, frames a second, and GPU time by pass over the last frames.

use egui::{RichText, Ui};
use egui_plot::{FilledArea, Plot};

use super::widgets::{milliseconds, section, thousands};
use crate::window::desk::{Desk, N_FRAMES_KEPT};
use crate::window::theme;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    let report = &desk.report;
    egui::Grid::new("numbers").num_columns(2).spacing([18.0, 3.0]).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(RichText::new(name).color(theme::TEXT_WEAK));
            ui.add(egui::Label::new(value).truncate());
            ui.end_row();
        };
        let drawn = if report.lod < 0.999 {
            format!("{}  ({:.0} % drawn)", thousands(report.n_strands), report.lod * 100.0)
        } else {
            thousands(report.n_strands)
        };
        row("Strands", drawn);
        row("Vertices", thousands(report.n_vertices));
        row("Picture", format!("{} \u{d7} {}", report.size[0], report.size[1]));
        row("Frame", format!("{}  ({:.1} fps)", milliseconds(report.frame_ms), 1000.0 / report.frame_ms.max(0.01)));
        row("GPU memory", format!("{:.0} MiB", report.n_bytes as f64 / f64::from(1 << 20)));
        row("GPU", report.adapter.clone());
        if !report.start.picture.is_zero() {
            let [picture, shaders] = [report.start.picture, report.start.shaders].map(|t| t.as_secs_f32());
            row("First picture", format!("after {picture:.1} s; shaders {shaders:.1} s"));
        }
    });
    section(ui, "GPU time by pass");
    let passes: Vec<String> = report.pass_times.iter().map(|(pass, _)| pass.clone()).collect();
    if passes.is_empty() {
        ui.label(RichText::new("No frame was timed yet, or this GPU keeps no times.").color(theme::TEXT_WEAK));
        return;
    }
    plot(ui, desk, &passes);
    let total: f32 = desk.report.pass_times.iter().map(|(_, ms)| ms).sum();
    egui::Grid::new("passes").num_columns(2).spacing([12.0, 2.0]).show(ui, |ui| {
        for (i, (pass, ms)) in desk.report.pass_times.iter().enumerate() {
            ui.horizontal(|ui| {
                let (rect, _) = ui.allocate_exact_size(egui::vec2(9.0, 9.0), egui::Sense::hover());
                ui.painter().rect_filled(rect, 2.0, colour(i));
                ui.label(pass);
            });
            ui.label(RichText::new(milliseconds(*ms)).monospace().color(theme::TEXT_WEAK));
            ui.end_row();
        }
        ui.label(RichText::new("Sum").strong());
        ui.label(RichText::new(milliseconds(total)).monospace());
        ui.end_row();
    });
}

fn colour(pass_idx: usize) -> egui::Color32 {
    theme::SERIES[pass_idx % theme::SERIES.len()]
}

/// Passes stacked on each other, newest frame at the right.
fn plot(ui: &mut Ui, desk: &Desk, passes: &[String]) {
    let n = desk.times.len();
    let xs: Vec<f64> = (0..n).map(|i| i as f64 - n as f64).collect();
    let mut below = vec![0.0_f64; n];
    Plot::new("gpu_times")
        .height(110.0)
        .show_x(false)
        .show_axes([false, true])
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .include_x(-(N_FRAMES_KEPT as f64))
        .include_x(0.0)
        .include_y(0.0)
        .y_axis_formatter(|mark, _| milliseconds(mark.value as f32))
        .y_axis_min_width(46.0)
        .show(ui, |plot| {
            for (pass_idx, pass) in passes.iter().enumerate() {
                let above: Vec<f64> = desk
                    .times
                    .iter()
                    .zip(&below)
                    .map(|(frame, below)| {
                        let ms = frame.passes.iter().find(|(name, _)| name == pass).map_or(0.0, |(_, ms)| *ms);
                        below + f64::from(ms)
                    })
                    .collect();
                let area = FilledArea::new(pass.clone(), &xs, &below, &above).fill_color(colour(pass_idx));
                plot.add(area);
                below = above;
            }
        });
}
