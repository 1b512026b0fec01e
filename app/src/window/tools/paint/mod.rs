//! Brushes on maps over the scalp: what the pointer does, and what is shown of the map meanwhile.
//!
//! A stroke is painted by `core` on the window's thread (a millisecond or two) and goes into the groom once a
//! frame as the tiles that changed, all in one step of the history. The picture shows the map at once; the
//! hair follows as soon as its strands are chosen anew.

pub mod commands;
mod panel;

use std::path::Path;
use std::sync::Arc;

use egui::{Align2, Color32, Pos2, Ui, pos2, vec2};
use glam::{Vec2, Vec3};
use lorelei_core::binding::counted_where_full;
use lorelei_core::brush::{Brush, BrushSpace};
use lorelei_core::edit::Edit;
use lorelei_core::groom::{Groom, StrandCount};
use lorelei_core::history::Merge;
use lorelei_core::maps::atlas::ScalpAtlas;
use lorelei_core::maps::paint::{Dab, PaintMode, Place, Stroke};
use lorelei_core::maps::picture::PictureKind;
use lorelei_core::maps::uvs::scalp_uvs;
use lorelei_core::maps::{MapKind, ScalpMap};
use lorelei_core::mesh::TriMesh;
use lorelei_render::overlay::{Overlay, Veil, ramp};

use super::surface::HeadSurface;
use super::{View, brush_input};
use crate::window::desk::{Desk, Selection};
use crate::window::theme;

/// Points of the window between two places of a stroke that are looked for on the head.
const STEP_POINTS: f32 = 10.0;

/// The tool's state.
pub struct PaintTool {
    pub brush: Brush,
    pub kind: MapKind,
    pub mode: PaintMode,
    /// In the map's own measure.
    pub value: f32,
    pub shows_map: bool,
    pub veil: Veil,
    /// PNG is written with 16 bits.
    pub is_16_bit: bool,
    setting: Option<brush_input::Setting>,
    wants_sample: bool,
    stroke: Option<Running>,
    n_strokes: u64,
    atlas: Option<(Arc<TriMesh>, Arc<ScalpAtlas>)>,
    /// The map that stands for one that is not there, to show it.
    default_map: Option<(MapKind, Arc<ScalpMap>)>,
    mask_name: String,
}

impl Default for PaintTool {
    fn default() -> Self {
        Self {
            brush: Brush { radius_cm: 2.0, ..Brush::default() },
            kind: MapKind::Density,
            mode: PaintMode::Paint,
            value: 0.0,
            shows_map: true,
            veil: Veil::Thin,
            is_16_bit: false,
            setting: None,
            wants_sample: false,
            stroke: None,
            n_strokes: 0,
            atlas: None,
            default_map: None,
            mask_name: "mask".to_owned(),
        }
    }
}

/// A stroke that is being painted.
struct Running {
    stroke: Stroke,
    layer_idx: usize,
    label: String,
    /// Where the pointer was last.
    at: Pos2,
}

/// The layer that is painted: the selected one, or the first.
pub fn layer_idx(desk: &Desk) -> Option<usize> {
    selected(&desk.document.groom, desk.selection)
}

fn selected(groom: &Groom, selection: Selection) -> Option<usize> {
    match selection {
        Selection::Layer(layer_idx) if layer_idx < groom.layers.len() => Some(layer_idx),
        Selection::Layer(_)
        | Selection::Head
        | Selection::Light(_)
        | Selection::Collider(_)
        | Selection::Pin(_)
        | Selection::Wind(_) => (!groom.layers.is_empty()).then_some(0),
    }
}

/// Density is to take strands away and to move none: see [`StrandCount`].
fn count_where_full(desk: &mut Desk, layer_idx: usize, kind: &MapKind) {
    let layer = &desk.document.groom.layers[layer_idx];
    if *kind == MapKind::Density && layer.count == StrandCount::Total {
        let layer = Box::new(counted_where_full(layer, desk.document.groom.head.as_ref()));
        desk.document.edit("Count strands where density is full", Edit::SetLayer { layer_idx, layer }, Merge::New);
    }
}

/// A map that was read from a file.
pub fn take_map(desk: &mut Desk, kind: MapKind, map: ScalpMap) {
    let Some(layer_idx) = layer_idx(desk) else { return };
    count_where_full(desk, layer_idx, &kind);
    let label = format!("Load {}", kind.label().to_lowercase());
    desk.document.edit(&label, Edit::SetMap { layer_idx, kind, map: Some(Arc::new(map)) }, Merge::New);
}

/// The map that is painted, where there is one.
pub fn map_to_save(desk: &Desk) -> Option<(MapKind, Arc<ScalpMap>)> {
    let kind = desk.tools.paint.kind.clone();
    let map = desk.document.groom.layers[layer_idx(desk)?].maps.get(&kind).cloned()?;
    Some((kind, map))
}

impl PaintTool {
    /// How a map is written to a path; `None` where its extension says neither PNG nor EXR.
    pub fn picture_kind(&self, path: &Path) -> Option<PictureKind> {
        PictureKind::of_path(path).map(|kind| match kind {
            PictureKind::Png8 if self.is_16_bit => PictureKind::Png16,
            kind => kind,
        })
    }

    /// Paint another map: its value starts where a stroke shows.
    fn take_kind(&mut self, kind: MapKind) {
        if self.kind != kind {
            self.value = if kind.default_value() > 0.0 { 0.5 * kind.default_value() } else { 1.0 };
            self.kind = kind;
        }
    }

    /// What the picture shows on the scalp.
    pub fn overlay(&self, groom: &Groom, selection: Selection) -> Option<Overlay> {
        let layer = groom.layers.get(selected(groom, selection)?)?;
        let map = layer.maps.get(&self.kind).or(match &self.default_map {
            Some((kind, map)) if *kind == self.kind => Some(map),
            Some(_) | None => None,
        })?;
        self.shows_map.then(|| Overlay { map: Arc::clone(map), full_texel: 255, veil: self.veil })
    }

    /// True while a stroke is drawn.
    pub fn viewport(&mut self, ui: &mut Ui, desk: &mut Desk, view: &View<'_>, surface: &mut HeadSurface) -> bool {
        if self.default_map.as_ref().is_none_or(|(kind, _)| *kind != self.kind) {
            self.default_map = Some((self.kind.clone(), Arc::new(self.kind.empty_map())));
        }
        let is_setting = brush_input::follow(ui, &mut self.setting, &mut self.brush)
            || brush_input::adjust(ui, view, &mut self.brush);
        if self.shows_map {
            legend(ui, view, &self.kind);
        }
        let at = view.pointer(ui);
        let hit = at.and_then(|at| surface.hit(desk.document.groom.head.as_ref(), view, at));
        if std::mem::take(&mut self.wants_sample)
            && let Some((head, hit)) = desk.document.groom.head.as_ref().zip(hit)
            && let Some(layer_idx) = layer_idx(desk)
        {
            let uvs = scalp_uvs(&head.mesh);
            let corners = head.mesh.triangles[hit.triangle_idx as usize].map(|v| Vec2::from(uvs[v as usize]));
            let w = hit.barycentric;
            let uv = w.x * corners[0] + w.y * corners[1] + w.z * corners[2];
            self.value = self.kind.sample(&desk.document.groom.layers[layer_idx].maps, uv.to_array());
        }
        let is_down = ui.input(|input| input.pointer.primary_down()) && !is_setting;
        if !is_down {
            self.stroke = None;
        } else if self.stroke.is_none()
            && view.response.is_pointer_button_down_on()
            && ui.input(|input| input.pointer.primary_pressed())
            && let Some(at) = ui.input(|input| input.pointer.press_origin())
        {
            self.begin(ui, desk, at);
        }
        if self.stroke.is_some() && !view.is_navigating {
            self.go_on(ui, desk, view, surface);
        }
        if let Some(at) = at {
            let place = hit.map(|hit| (hit.position, (view.eye - hit.position).normalize_or(Vec3::Z)));
            let brush = self.brush.under_pressure(brush_input::pressure(ui));
            brush_input::ring(ui, view, &brush, at, place, Color32::WHITE);
            if brush.is_symmetric
                && let Some((position, _)) = place
            {
                let mirrored = position * Vec3::new(-1.0, 1.0, 1.0);
                if let Some(at) = view.projection.point(mirrored) {
                    ui.painter().circle_filled(at, 2.5, Color32::WHITE.gamma_multiply(0.6));
                }
            }
        }
        is_setting || self.stroke.is_some()
    }

    fn begin(&mut self, ui: &Ui, desk: &Desk, at: Pos2) {
        let Some(layer_idx) = layer_idx(desk) else { return };
        let groom = &desk.document.groom;
        let Some(mesh) = groom.head.as_ref().map(|head| &head.mesh) else { return };
        let map = groom.layers[layer_idx].maps.get(&self.kind);
        let map = map.map_or_else(|| self.kind.empty_map(), |map| ScalpMap::clone(map));
        let is_known = |(of, atlas): &(Arc<TriMesh>, Arc<ScalpAtlas>)| Arc::ptr_eq(of, mesh) && atlas.fits(&map);
        let atlas = match self.atlas.take().filter(is_known) {
            Some((_, atlas)) => atlas,
            None => Arc::new(ScalpAtlas::new(mesh, map.width(), map.height())),
        };
        self.atlas = Some((Arc::clone(mesh), Arc::clone(&atlas)));
        let modifiers = ui.input(|input| input.modifiers);
        let mode = match (modifiers.shift, modifiers.command) {
            (true, _) => PaintMode::Smooth,
            (false, true) => self.mode.inverted(),
            (false, false) => self.mode,
        };
        let stroke = Stroke::new(atlas, map, &self.kind, self.brush.falloff, mode, self.value);
        let label = format!("{} {}", mode.label(), self.kind.label().to_lowercase());
        self.n_strokes += 1;
        self.stroke = Some(Running { stroke, layer_idx, label, at });
    }

    /// Go on to where the pointer has been since the last frame.
    fn go_on(&mut self, ui: &Ui, desk: &mut Desk, view: &View<'_>, surface: &mut HeadSurface) {
        let Some(running) = &mut self.stroke else { return };
        let moved = ui.input(|input| {
            // On a slow frame the way to the press, the press and the way from it may come together.
            let is_press = |event: &egui::Event| {
                matches!(event, egui::Event::PointerButton { button: egui::PointerButton::Primary, pressed: true, .. })
            };
            let first = input.events.iter().rposition(is_press).map_or(0, |press| press + 1);
            let places = input.events[first..].iter().filter_map(|event| match event {
                egui::Event::PointerMoved(at) => Some(*at),
                _ => None,
            });
            std::iter::once(running.at).chain(places).collect::<Vec<_>>()
        });
        let brush = self.brush.under_pressure(brush_input::pressure(ui));
        let before = running.stroke.map().clone();
        let mut to_dab = |at: Pos2| {
            let place = match brush.space {
                BrushSpace::Screen => Place::Screen {
                    screen_from_head: view.projection.screen_from_world(),
                    at: Vec2::new(at.x, at.y),
                    radius: brush.radius_points,
                },
                BrushSpace::Surface => {
                    let hit = surface.hit(desk.document.groom.head.as_ref(), view, at)?;
                    Place::Surface { centre: hit.position, radius: brush.radius_cm }
                }
            };
            let eye = (!brush.has_back_faces).then_some(view.eye);
            Some(Dab { place, strength: brush.strength, eye, is_symmetric: brush.is_symmetric })
        };
        let mut go_to = |stroke: &mut Stroke, at: Pos2| match to_dab(at) {
            Some(dab) => drop(stroke.go_on(&dab)),
            // Off the head.
            None => stroke.lift(),
        };
        if moved.len() == 1 {
            go_to(&mut running.stroke, running.at);
        }
        for &to in &moved[1..] {
            let from = running.at;
            let n = (from.distance(to) / STEP_POINTS).ceil().max(1.0) as u32;
            for i in 1..=n {
                go_to(&mut running.stroke, from + (to - from) * (i as f32 / n as f32));
            }
            running.at = to;
        }
        let tiles = running.stroke.map().changed_from(&before);
        if tiles.is_empty() {
            return;
        }
        let merge = Merge::Drag(0x9A17_0000 + self.n_strokes);
        let (layer_idx, label, kind) = (running.layer_idx, running.label.clone(), self.kind.clone());
        let Some(layer) = desk.document.groom.layers.get(layer_idx) else { return };
        if kind == MapKind::Density && layer.count == StrandCount::Total {
            let layer = Box::new(counted_where_full(layer, desk.document.groom.head.as_ref()));
            desk.document.edit(&label, Edit::SetLayer { layer_idx, layer }, merge);
        }
        desk.document.edit(&label, Edit::PaintTiles { layer_idx, kind, tiles }, merge);
    }

    pub fn panel(&mut self, ui: &mut Ui, desk: &mut Desk) {
        panel::ui(self, ui, desk);
    }
}

/// The colours of the values, at the viewport's lower right.
fn legend(ui: &Ui, view: &View<'_>, kind: &MapKind) {
    let rect = view.projection.rect();
    let (width, height) = (180.0, 10.0);
    let min = pos2(rect.right() - width - 16.0, rect.bottom() - 40.0);
    let painter = ui.painter();
    let frame = egui::Rect::from_min_size(min - vec2(8.0, 22.0), vec2(width + 16.0, 54.0));
    painter.rect_filled(frame, 4.0, Color32::from_black_alpha(150));
    let n = 60;
    for i in 0..n {
        let share = i as f32 / (n - 1) as f32;
        let [r, g, b] = ramp(share).map(|c| (255.0 * c) as u8);
        let left = min.x + width * i as f32 / n as f32;
        let bar = egui::Rect::from_min_size(pos2(left, min.y), vec2(width / n as f32 + 0.5, height));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(r, g, b));
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    let title = format!("{}: {}", kind.label(), kind.unit());
    painter.text(min - vec2(0.0, 5.0), Align2::LEFT_BOTTOM, title, font.clone(), theme::TEXT);
    for share in [0.0, 0.5, 1.0] {
        let at = min + vec2(share * width, height + 3.0);
        let align = [Align2::LEFT_TOP, Align2::CENTER_TOP, Align2::RIGHT_TOP][(2.0 * share) as usize];
        painter.text(at, align, format!("{:.2}", share * kind.max_value()), font.clone(), theme::TEXT);
    }
}
