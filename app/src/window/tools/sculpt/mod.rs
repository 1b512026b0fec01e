//! Brushes on the hair: what the pointer does, and what is prepared for it.
//!
//! A stroke moves sculpt guides on the window's thread (milliseconds) and goes into the groom once a frame as
//! the guides that changed, all in one step of the history; the strands follow on the GPU in the same frame.
//! What brushes need to know of the hair is prepared on a thread of its own when the tool is taken or the hair
//! below the brushes changes.

pub mod commands;
mod palette;
mod panel;
mod prepare;

use std::sync::Arc;

use egui::{Align2, Color32, Pos2, Ui, vec2};
use glam::{Vec2, Vec3};
use lorelei_core::brush::Brush;
use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::look::Choice;
use lorelei_core::sculpt::view::{DepthMap, View as SculptView};
use lorelei_core::sculpt::{LiveStroke, SculptBrush, SculptLayer, Stroke, StrokePoint, StrokeView, join_changes};

use super::surface::HeadSurface;
use super::{View, brush_input};
use crate::window::desk::{Desk, Selection};
use crate::window::theme;
use prepare::Preparation;

/// The tool's state.
#[derive(Default)]
pub struct SculptTool {
    pub brush: Brush,
    pub kind: SculptBrush,
    /// Which sculpt layer strokes go to.
    pub sculpt_idx: usize,
    setting: Option<brush_input::Setting>,
    preparation: Preparation,
    running: Option<Running>,
    n_strokes: u64,
    /// Where hair is nearest under the pointer, while nothing changes.
    hover: Option<((u64, u64), StrokeView, DepthMap)>,
    /// Why the last press began no stroke.
    refusal: Option<&'static str>,
}

/// A stroke that is being made.
struct Running {
    live: LiveStroke,
    layer_idx: usize,
    sculpt_idx: usize,
    label: String,
    began: f64,
    /// Something of it is in the history.
    is_done: bool,
}

/// The layer whose hair is brushed: the selected one, or the first.
pub fn layer_idx(desk: &Desk) -> Option<usize> {
    let n_layers = desk.document.groom.layers.len();
    match desk.selection {
        Selection::Layer(layer_idx) if layer_idx < n_layers => Some(layer_idx),
        Selection::Layer(_)
        | Selection::Head
        | Selection::Light(_)
        | Selection::Collider(_)
        | Selection::Pin(_)
        | Selection::Wind(_) => (n_layers > 0).then_some(0),
    }
}

impl SculptTool {
    /// Nothing but a stroke or a setting wants the keys.
    pub fn takes_keys(&self) -> bool {
        self.running.is_some() || self.setting.is_some()
    }

    /// The hair is prepared for strokes.
    pub fn is_ready(&self) -> bool {
        self.preparation.is_ready()
    }

    /// True while a stroke is drawn.
    pub fn viewport(&mut self, ui: &mut Ui, desk: &mut Desk, view: &View<'_>, _surface: &mut HeadSurface) -> bool {
        let Some(layer_idx) = layer_idx(desk) else { return false };
        let groom = &desk.document.groom;
        if self.running.is_none() {
            self.preparation.follow(ui.ctx(), &groom.layers[layer_idx], groom.head.as_ref());
        }
        let is_setting = brush_input::follow(ui, &mut self.setting, &mut self.brush)
            || brush_input::adjust(ui, view, &mut self.brush);
        self.follow_stroke(ui, desk, view, layer_idx, is_setting);
        if let Some(at) = view.pointer(ui) {
            self.cursor(ui, desk, view, layer_idx, at);
        }
        self.words(ui, desk, view);
        is_setting || self.running.is_some()
    }

    pub fn panel(&mut self, ui: &mut Ui, desk: &mut Desk) {
        panel::ui(self, ui, desk);
    }

    fn follow_stroke(&mut self, ui: &Ui, desk: &mut Desk, view: &View<'_>, layer_idx: usize, is_setting: bool) {
        let (is_down, is_pressed, is_escaped) = ui.input(|input| {
            let pointer = &input.pointer;
            (pointer.primary_down(), pointer.primary_pressed(), input.key_pressed(egui::Key::Escape))
        });
        if is_escaped && let Some(running) = self.running.take() {
            if running.is_done {
                desk.document.take_back();
            }
            desk.document.history.release(None);
            return;
        }
        if is_pressed && !is_setting && !view.is_navigating && view.response.is_pointer_button_down_on() {
            self.begin(ui, desk, view, layer_idx);
        }
        if self.running.is_some() {
            self.go_on(ui, desk, view);
        }
        if !is_down && let Some(running) = self.running.take() {
            let layer = desk.document.groom.layers.get(running.layer_idx);
            if let Some(source) = layer.and_then(|layer| running.live.planted(&layer.source)) {
                let edit = Edit::SetSource { layer_idx: running.layer_idx, source };
                desk.document.edit(&running.label, edit, Merge::Stroke(self.n_strokes));
            }
            desk.document.history.end_drag();
            // What the guides became is written down as the stroke that made it so.
            let Running { live, layer_idx, sculpt_idx, .. } = running;
            let stroke = Box::new(live.stroke().clone());
            desk.document.history.release(Some(Edit::Stroke { layer_idx, sculpt_idx, stroke }));
        }
    }

    /// How the viewport looks at the hair.
    fn stroke_view(desk: &Desk, view: &View<'_>) -> StrokeView {
        let size = view.projection.rect().size();
        StrokeView { camera: desk.camera, size: [size.x, size.y], world_from_head: desk.report.world_from_head }
    }

    fn begin(&mut self, ui: &Ui, desk: &mut Desk, view: &View<'_>, layer_idx: usize) {
        self.refusal = None;
        let layer = &desk.document.groom.layers[layer_idx];
        let Some(base) = self.preparation.base(layer, desk.document.groom.head.as_ref()) else {
            self.refusal = Some("The hair is being prepared for brushes: press again in a moment");
            return;
        };
        let n_sculpts = layer.sculpt.layers.len();
        let sculpt_idx = self.sculpt_idx.min(n_sculpts.saturating_sub(1));
        self.sculpt_idx = sculpt_idx;
        if layer.sculpt.layers.get(sculpt_idx).is_some_and(|sculpt| !sculpt.on || sculpt.weight == 0.0) {
            self.refusal = Some("This sculpt layer is off: switch it on, or choose another");
            return;
        }
        let modifiers = ui.input(|input| input.modifiers);
        let kind = if modifiers.shift { SculptBrush::Smooth } else { self.kind };
        self.refusal = base.problem(kind);
        if self.refusal.is_some() {
            return;
        }
        let label = kind.info().label.to_owned();
        self.n_strokes += 1;
        let mut edits = Vec::new();
        if !Arc::ptr_eq(&layer.sculpt.roots, &base.roots) {
            edits.push(Edit::SetSculptRoots { layer_idx, roots: Arc::clone(&base.roots) });
        }
        if n_sculpts == 0 {
            let sculpt = Box::new(SculptLayer::new("Sculpt 1"));
            edits.push(Edit::AddSculpt { layer_idx, sculpt_idx, sculpt });
        }
        let is_done = !edits.is_empty();
        desk.document.history.hold();
        if is_done {
            let merge = Merge::Stroke(self.n_strokes);
            desk.document.edit(&label, Edit::Batch(edits), merge);
        }
        let stroke = Stroke {
            kind,
            brush: self.brush,
            is_inverted: modifiers.command && !modifiers.shift,
            view: Self::stroke_view(desk, view),
            points: Vec::new(),
        };
        let layer = &desk.document.groom.layers[layer_idx];
        let live = LiveStroke::begin(base, layer, sculpt_idx, &stroke);
        let began = ui.input(|input| input.time);
        self.running = Some(Running { live, layer_idx, sculpt_idx, label, began, is_done });
    }

    /// Go on to where the pointer has been since the last frame.
    fn go_on(&mut self, ui: &Ui, desk: &mut Desk, view: &View<'_>) {
        let Some(running) = &mut self.running else { return };
        let (places, time) = ui.input(|input| {
            // On a slow frame the way to the press, the press and the way from it may come together.
            let press = input.events.iter().rposition(|event| {
                matches!(event, egui::Event::PointerButton { button: egui::PointerButton::Primary, pressed: true, .. })
            });
            let places = input.events[press.unwrap_or(0)..].iter().filter_map(|event| match event {
                egui::Event::PointerMoved(at) => Some(*at),
                egui::Event::PointerButton { pos, pressed: true, button: egui::PointerButton::Primary, .. } => {
                    Some(*pos)
                }
                _ => None,
            });
            (places.collect::<Vec<Pos2>>(), input.time)
        });
        let pressure = brush_input::pressure(ui);
        let origin = view.projection.rect().min;
        let mut changes = Vec::new();
        for at in places {
            let at = at - origin;
            let point = StrokePoint { at: [at.x, at.y], pressure, secs: (time - running.began) as f32 };
            let mut later = running.live.extend(point);
            // The later state of a guide is the one that counts.
            join_changes(&mut later, &changes);
            changes = later;
        }
        if changes.is_empty() {
            return;
        }
        let edit = Edit::Sculpt { layer_idx: running.layer_idx, sculpt_idx: running.sculpt_idx, changes };
        desk.document.edit(&running.label, edit, Merge::Stroke(self.n_strokes));
        running.is_done = true;
    }

    /// The brush's rim, on the hair or the head under the pointer.
    fn cursor(&mut self, ui: &Ui, desk: &Desk, view: &View<'_>, layer_idx: usize, at: Pos2) {
        let local = at - view.projection.rect().min;
        let local = Vec2::new(local.x, local.y);
        let layer = &desk.document.groom.layers[layer_idx];
        let place = match (&self.running, self.preparation.base(layer, desk.document.groom.head.as_ref())) {
            (Some(running), _) => running.live.pick(local),
            (None, Some(base)) => {
                let (state, of) = (desk.document.state(), Self::stroke_view(desk, view));
                let seen = SculptView::new(&of);
                if self.hover.as_ref().is_none_or(|(known, known_of, _)| (*known, *known_of) != (state, of)) {
                    self.hover = Some((state, of, base.depths(&seen, layer, &base.shown(layer))));
                }
                self.hover.as_ref().and_then(|(_, _, depths)| base.pick(&seen, depths, self.kind, local))
            }
            (None, None) => None,
        };
        let facing = place.map(|place| (place, (view.eye - place).normalize_or(Vec3::Z)));
        let colour = if ui.input(|input| input.modifiers.command) { theme::ACCENT } else { Color32::WHITE };
        let brush = self.brush.under_pressure(brush_input::pressure(ui));
        brush_input::ring(ui, view, &brush, at, facing, colour);
        if brush.is_symmetric
            && let Some(place) = place
            && let Some(at) = view.projection.point(place * Vec3::new(-1.0, 1.0, 1.0))
        {
            ui.painter().circle_filled(at, 2.5, Color32::WHITE.gamma_multiply(0.6));
        }
    }

    /// What a person should know now, at the viewport's lower edge.
    fn words(&self, ui: &Ui, desk: &Desk, view: &View<'_>) {
        let words = if let Some(refusal) = self.refusal {
            refusal
        } else if self.preparation.is_busy() {
            "Preparing the hair for brushes\u{2026}"
        } else if desk.playback.is_playing {
            "The hair moves: strokes act on its shape at rest"
        } else {
            return;
        };
        let at = view.projection.rect().center_bottom() - vec2(0.0, 18.0);
        let font = egui::TextStyle::Small.resolve(ui.style());
        for (by, colour) in [(vec2(1.0, 1.0), Color32::from_black_alpha(190)), (vec2(0.0, 0.0), theme::TEXT_STRONG)] {
            ui.painter().text(at + by, Align2::CENTER_BOTTOM, words, font.clone(), colour);
        }
    }
}
