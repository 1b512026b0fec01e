//! The viewport: the stage's picture, navigation, handles, and what is written over it.

use egui::{Align2, Color32, Key, Rect, Sense, TextureId, Ui, pos2, vec2};
use lorelei_core::motion::HeadPose;

use super::collider_handles;
use super::desk::Desk;
use super::handles::{self, HandleDrag};
use super::navigation;
use super::pin_handles;
use super::projection::Projection;
use super::room;
use super::theme;
use super::tools::{self, Tool};
use super::{wind_handles, wind_view};

/// A head that follows the pointer after G or R, as in Blender.
#[derive(Debug, Clone, Copy)]
pub struct Grab {
    pub is_turning: bool,
    /// Where the head was, for Esc.
    pub before: HeadPose,
    was_playing: bool,
}

/// What the viewport keeps between frames.
#[derive(Default)]
pub struct Viewport {
    /// The stage's picture in egui's renderer.
    pub texture: Option<TextureId>,
    pub rect: Option<Rect>,
    /// Pixels that the picture should have.
    pub size: [u32; 2],
    /// Something is dragged in the viewport.
    pub is_interacting: bool,
    pub grab: Option<Grab>,
    /// What is being opened, in words.
    pub opening: Option<String>,
    drag: HandleDrag,
}

impl Viewport {
    pub fn start_grab(&mut self, desk: &Desk, is_turning: bool) {
        if self.grab.is_none() {
            let playback = &desk.playback;
            self.grab = Some(Grab { is_turning, before: playback.head_pose, was_playing: playback.is_playing });
        }
    }

    /// There is a picture, and not of the document that was open before: its hair is not this one's.
    pub fn shows_picture(&self, desk: &Desk) -> bool {
        self.texture.is_some() && desk.report.state.0 == desk.document.state().0
    }

    pub fn aspect(&self) -> f32 {
        self.size[0].max(1) as f32 / self.size[1].max(1) as f32
    }

    pub fn ui(&mut self, ui: &mut Ui, desk: &mut Desk) {
        let rect = ui.max_rect();
        let scale = ui.ctx().pixels_per_point();
        self.rect = Some(rect);
        self.size = [rect.width(), rect.height()].map(|side| ((side * scale).round() as u32).clamp(1, 8192));
        if std::mem::take(&mut desk.wants_frame) {
            desk.frame_all(self.aspect());
        }
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        ui.painter().rect_filled(rect, 0.0, Color32::from_gray(40));
        if let Some(texture) = self.texture.filter(|_| self.shows_picture(desk)) {
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, rect, uv, Color32::WHITE);
        }
        let mut child = ui.new_child(egui::UiBuilder::new().max_rect(rect));
        let ui = &mut child;
        ui.set_clip_rect(rect.intersect(ui.clip_rect()));
        let has_moved = navigation::navigate(&mut desk.camera, &response, ui);
        let projection = Projection::new(&desk.camera, rect);
        wind_view::ui(ui, desk, projection);
        let mut is_dragging_handle = false;
        let is_tool_busy = tools::viewport(ui, desk, projection, &response, has_moved || self.grab.is_some());
        if desk.show_handles && self.grab.is_none() && desk.tools.active == Tool::Select {
            handles::lights(ui, desk, projection, &mut self.drag);
            is_dragging_handle = handles::head(ui, desk, projection);
            is_dragging_handle |= collider_handles::colliders(ui, desk, projection);
            is_dragging_handle |= pin_handles::pins(ui, desk, projection);
            is_dragging_handle |= wind_handles::sources(ui, desk, projection);
        }
        let is_wiping = room::viewport(ui, desk, rect, &response);
        self.follow_grab(ui, desk, rect);
        self.is_interacting =
            has_moved || response.dragged() || is_tool_busy || is_dragging_handle || is_wiping || self.grab.is_some();
        self.overlay(ui, desk, rect);
    }

    fn follow_grab(&mut self, ui: &Ui, desk: &mut Desk, rect: Rect) {
        let Some(grab) = self.grab else { return };
        let (delta, is_kept, is_taken_back) = ui.input(|input| {
            let is_kept = input.pointer.primary_pressed() || input.key_pressed(Key::Enter);
            let is_taken_back = input.pointer.secondary_pressed() || input.key_pressed(Key::Escape);
            (input.pointer.delta(), is_kept, is_taken_back)
        });
        handles::drag_head(desk, delta, rect.height(), grab.is_turning);
        ui.ctx().set_cursor_icon(egui::CursorIcon::Grabbing);
        if is_taken_back {
            desk.playback.head_pose = grab.before;
            desk.playback.is_playing = grab.was_playing;
        }
        if is_kept || is_taken_back {
            self.grab = None;
        }
    }

    /// Words over the picture: what is being done, what is being prepared, how much is drawn.
    fn overlay(&self, ui: &Ui, desk: &Desk, rect: Rect) {
        let report = &desk.report;
        let font = egui::TextStyle::Small.resolve(ui.style());
        let mut lines = Vec::new();
        if let Some(grab) = self.grab {
            let what = if grab.is_turning { "Turning the head" } else { "Moving the head" };
            lines.push(format!("{what}: click or Enter keeps it, Esc takes it back"));
        }
        lines.extend(self.opening.clone());
        if let Some(busy) = report.busy {
            lines.push(match busy.share {
                Some(share) => format!("{}\u{2026} {:.0} %", busy.task.label(), 100.0 * share),
                None => format!("{}\u{2026}", busy.task.label()),
            });
        } else if report.is_refining {
            lines.push("Drawing every strand\u{2026}".to_owned());
        } else if report.lod < 0.995 && report.lod > 0.0 {
            lines.push(format!("{:.0} % of the strands while moving", report.lod * 100.0));
        }
        for (i, line) in lines.iter().enumerate() {
            let at = rect.left_top() + vec2(12.0, 12.0 + 16.0 * i as f32);
            for (offset, colour) in [(vec2(1.0, 1.0), Color32::from_black_alpha(190)), (vec2(0.0, 0.0), theme::TEXT)] {
                ui.painter().text(at + offset, Align2::LEFT_TOP, line, font.clone(), colour);
            }
        }
        if !self.shows_picture(desk) {
            let text = report.busy.map_or("No picture yet", |busy| busy.task.label());
            let font = egui::TextStyle::Body.resolve(ui.style());
            ui.painter().text(rect.center(), Align2::CENTER_CENTER, text, font, theme::TEXT_WEAK);
        }
        axes(ui, desk, rect);
    }
}

/// A small cross of axes in the lower left corner.
fn axes(ui: &Ui, desk: &Desk, rect: Rect) {
    let origin = rect.left_bottom() + vec2(34.0, -34.0);
    let view_from_world = desk.camera.view_from_world();
    let mut arms: Vec<(glam::Vec3, &str, Color32)> = vec![
        (glam::Vec3::X, "X", Color32::from_rgb(205, 92, 92)),
        (glam::Vec3::Y, "Y", Color32::from_rgb(120, 170, 90)),
        (glam::Vec3::Z, "Z", Color32::from_rgb(90, 130, 200)),
    ];
    arms.sort_by(|(a, ..), (b, ..)| {
        let depth = |axis: &glam::Vec3| view_from_world.transform_vector3(*axis).z;
        depth(a).total_cmp(&depth(b))
    });
    let font = egui::FontId::proportional(9.0);
    for (axis, name, colour) in arms {
        let seen = view_from_world.transform_vector3(axis);
        let tip = origin + vec2(seen.x, -seen.y) * 20.0;
        let colour = if seen.z < 0.0 { colour.gamma_multiply(0.55) } else { colour };
        ui.painter().line_segment([origin, tip], egui::Stroke::new(1.5, colour));
        ui.painter().circle_filled(tip, 6.0, colour);
        ui.painter().text(tip, Align2::CENTER_CENTER, name, font.clone(), Color32::from_gray(20));
    }
}
