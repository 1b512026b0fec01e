//! Brushes on maps over the scalp: what the pointer does, and the tool's settings.

use egui::{Color32, Ui};
use lorelei_core::brush::Brush;

use super::surface::HeadSurface;
use super::{View, brush_input};
use crate::window::desk::Desk;

/// The tool's state.
#[derive(Default)]
pub struct PaintTool {
    pub brush: Brush,
}

impl PaintTool {
    /// True while a stroke is drawn.
    pub fn viewport(&mut self, ui: &mut Ui, desk: &mut Desk, view: &View<'_>, surface: &mut HeadSurface) -> bool {
        let is_setting = brush_input::adjust(ui, view, &mut self.brush);
        let Some(at) = view.pointer(ui) else { return is_setting };
        let head = desk.document.groom.head.as_ref();
        let hit = surface.hit(head, view, at);
        let place = hit.map(|hit| (hit.position, (view.eye - hit.position).normalize_or(glam::Vec3::Z)));
        let brush = self.brush.under_pressure(brush_input::pressure(ui));
        brush_input::ring(ui, view, &brush, at, place, Color32::WHITE);
        is_setting
    }

    pub fn panel(&mut self, ui: &mut Ui, _desk: &mut Desk) {
        brush_input::panel(ui, &mut self.brush);
    }
}
