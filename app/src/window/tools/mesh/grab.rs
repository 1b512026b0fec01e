//! Moving, turning and scaling what is selected with the pointer: after a key, as in Blender, or by the handles.
//!
//! While it goes on, X, Y and Z bind it to an axis, digits give an exact amount, a click or Enter keeps it, and Esc
//! or the right button takes it back.

use egui::{Align2, Color32, Key, Pos2, Rect, Sense, Stroke, Ui, vec2};
use glam::Vec3;
use lorelei_core::hair_mesh::{HairMesh, VertexDrag, VertexMotion};

use crate::window::state_report::mark;
use crate::window::theme;
use crate::window::tools::View;

/// What the pointer does to what is selected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum GrabKind {
    #[default]
    Move,
    Rotate,
    Scale,
    /// Along the hair.
    Slide,
    /// Longer or shorter, each vertex the way its hair goes.
    Extend,
}

impl GrabKind {
    pub fn label(self) -> &'static str {
        match self {
            Self::Move => "Move",
            Self::Rotate => "Rotate",
            Self::Scale => "Scale",
            Self::Slide => "Slide",
            Self::Extend => "Extend",
        }
    }
}

/// A grab that goes on.
pub struct Grab {
    pub kind: GrabKind,
    pub drag: VertexDrag,
    /// 0 X, 1 Y, 2 Z.
    pub axis: Option<usize>,
    from: Option<Pos2>,
    typed: String,
    /// Held by a handle: it ends when the button is released.
    is_held: bool,
}

/// How a grab goes on after a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GrabEnd {
    GoesOn,
    Kept,
    TakenBack,
}

const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];
const AXIS_COLOURS: [Color32; 3] =
    [Color32::from_rgb(205, 92, 92), Color32::from_rgb(120, 170, 90), Color32::from_rgb(90, 130, 200)];
/// Length of a handle's arms, points.
const ARM: f32 = 70.0;

impl Grab {
    pub fn new(kind: GrabKind, drag: VertexDrag) -> Self {
        Self { kind, drag, axis: None, from: None, typed: String::new(), is_held: false }
    }

    /// Whether the mesh is still the one that the grab began with, but for what it did itself.
    pub fn is_of(&self, mesh: &HairMesh) -> bool {
        self.drag.start().has_same_faces(mesh)
    }

    /// Follow the pointer for a frame.
    pub fn follow(&mut self, ui: &Ui, view: &View<'_>) -> (Option<VertexMotion>, GrabEnd) {
        let Some(at) = ui.input(|input| input.pointer.latest_pos()) else { return (None, GrabEnd::GoesOn) };
        let from = *self.from.get_or_insert(at);
        self.read_keys(ui);
        let end = ui.input(|input| {
            let is_kept = if self.is_held {
                !input.pointer.primary_down()
            } else {
                input.pointer.primary_pressed() || input.key_pressed(Key::Enter)
            };
            match (input.key_pressed(Key::Escape) || input.pointer.secondary_pressed(), is_kept) {
                (true, _) => GrabEnd::TakenBack,
                (false, true) => GrabEnd::Kept,
                (false, false) => GrabEnd::GoesOn,
            }
        });
        let number: Option<f32> = self.typed.parse().ok();
        let motion = self.motion(view, from, at, number, ui.input(|input| input.modifiers.shift));
        (motion, end)
    }

    fn read_keys(&mut self, ui: &Ui) {
        let (axis, text, is_back) = ui.input(|input| {
            let axes = [Key::X, Key::Y, Key::Z];
            let axis = axes.iter().position(|&key| input.key_pressed(key));
            let text: String = input
                .events
                .iter()
                .filter_map(|event| match event {
                    egui::Event::Text(text) => Some(text.as_str()),
                    _ => None,
                })
                .collect();
            (axis, text, input.key_pressed(Key::Backspace))
        });
        if let Some(axis) = axis {
            self.axis = if self.axis == Some(axis) { None } else { Some(axis) };
        }
        self.typed.extend(text.chars().filter(|c| c.is_ascii_digit() || matches!(c, '.' | '-')));
        if is_back {
            self.typed.pop();
        }
    }

    fn motion(
        &self,
        view: &View<'_>,
        from: Pos2,
        at: Pos2,
        number: Option<f32>,
        is_fine: bool,
    ) -> Option<VertexMotion> {
        let pivot = self.drag.pivot;
        let fine = if is_fine { 0.2 } else { 1.0 };
        let axis = self.axis.map(|axis| AXES[axis]);
        let pivot_at = view.projection.point(pivot)?;
        let cm = view.projection.cm_per_point(pivot);
        Some(match self.kind {
            GrabKind::Move => VertexMotion::Move(match (axis, number) {
                (Some(axis), Some(number)) => number * axis,
                (None, Some(number)) => number * view.right(),
                (Some(axis), None) => {
                    let arm = view.projection.point(pivot + axis)? - pivot_at;
                    fine * (at - from).dot(arm) / arm.length_sq().max(1.0) * axis
                }
                (None, None) => fine * cm * ((at.x - from.x) * view.right() - (at.y - from.y) * view.up()),
            }),
            GrabKind::Rotate => {
                let forward = (pivot - view.eye).normalize_or(Vec3::NEG_Z);
                let turned = (at - pivot_at).angle() - (from - pivot_at).angle();
                let turned = (turned + std::f32::consts::PI).rem_euclid(std::f32::consts::TAU) - std::f32::consts::PI;
                let axis = axis.unwrap_or(forward);
                let sign = if axis.dot(forward) < 0.0 { -1.0 } else { 1.0 };
                VertexMotion::Rotate { axis, angle: number.map_or(fine * sign * turned, f32::to_radians) }
            }
            GrabKind::Scale => {
                let ratio = at.distance(pivot_at) / from.distance(pivot_at).max(4.0);
                let factor = number.unwrap_or(1.0 + fine * (ratio - 1.0)).clamp(-100.0, 100.0);
                VertexMotion::Scale(axis.map_or(Vec3::splat(factor), |axis| Vec3::ONE + (factor - 1.0) * axis))
            }
            GrabKind::Slide => VertexMotion::Slide(number.unwrap_or(fine * cm * (from.y - at.y))),
            GrabKind::Extend => VertexMotion::Extend(number.unwrap_or(fine * cm * (from.y - at.y))),
        })
    }

    /// What goes on, in words beside the pointer, and the axis it is bound to.
    pub fn draw(&self, ui: &Ui, view: &View<'_>) {
        if let Some(axis) = self.axis
            && let (Some(a), Some(b)) = (
                view.projection.point(self.drag.pivot - 100.0 * AXES[axis]),
                view.projection.point(self.drag.pivot + 100.0 * AXES[axis]),
            )
        {
            ui.painter().line_segment([a, b], Stroke::new(1.0, AXIS_COLOURS[axis].gamma_multiply(0.7)));
        }
        let axis = self.axis.map_or("", |axis| [" along X", " along Y", " along Z"][axis]);
        let typed = if self.typed.is_empty() { String::new() } else { format!(": {}", self.typed) };
        let text =
            format!("{}{axis}{typed}   X Y Z axis, digits amount, click keeps, Esc takes back", self.kind.label());
        let at = view.projection.rect().left_bottom() + vec2(70.0, -18.0);
        outlined(ui, at, Align2::LEFT_CENTER, &text, theme::TEXT_STRONG);
    }
}

/// Words over the picture.
pub fn outlined(ui: &Ui, at: Pos2, align: Align2, text: &str, colour: Color32) {
    let font = egui::TextStyle::Body.resolve(ui.style());
    ui.painter().text(at + vec2(1.0, 1.0), align, text, font.clone(), Color32::from_black_alpha(200));
    ui.painter().text(at, align, text, font, colour);
}

/// The handles at what is selected; returns the axis of the one that was taken hold of.
pub fn handles(ui: &mut Ui, view: &View<'_>, kind: GrabKind, pivot: Vec3) -> Option<usize> {
    let origin = view.projection.point(pivot)?;
    let cm = view.projection.cm_per_point(pivot);
    let mut taken = None;
    for (axis, (direction, colour)) in AXES.into_iter().zip(AXIS_COLOURS).enumerate() {
        let Some(tip) = view.projection.point(pivot + ARM * cm * direction) else { continue };
        // An arm that points at the eye cannot be dragged.
        if tip.distance(origin) < 12.0 && kind != GrabKind::Rotate {
            continue;
        }
        let grip = match kind {
            GrabKind::Rotate => {
                let (x, y) = direction.any_orthonormal_pair();
                let at = |i: usize| {
                    let (sin, cos) = (i as f32 / 40.0 * std::f32::consts::TAU).sin_cos();
                    view.projection.point(pivot + 0.85 * ARM * cm * (cos * x + sin * y))
                };
                let ring: Vec<Pos2> = (0..=40).filter_map(at).collect();
                ui.painter().add(egui::Shape::line(ring, Stroke::new(1.6, colour)));
                at(5 + 11 * axis)?
            }
            GrabKind::Move | GrabKind::Scale | GrabKind::Slide | GrabKind::Extend => {
                ui.painter().line_segment([origin, tip], Stroke::new(2.0, colour));
                tip
            }
        };
        let place = Rect::from_center_size(grip, vec2(18.0, 18.0));
        let response = ui.interact(place, ui.scope_id().with(("mesh handle", axis)), Sense::click_and_drag());
        mark(ui.ctx(), || format!("handle {}", ["X", "Y", "Z"][axis]), place);
        let fill = if response.hovered() { Color32::WHITE } else { colour };
        match kind {
            GrabKind::Scale => {
                ui.painter().rect_filled(Rect::from_center_size(grip, vec2(9.0, 9.0)), 1.0, fill);
            }
            GrabKind::Rotate => {
                ui.painter().circle_filled(grip, 5.0, fill);
            }
            GrabKind::Move | GrabKind::Slide | GrabKind::Extend => {
                let along = (tip - origin).normalized();
                let side = along.rot90() * 5.0;
                let points = vec![tip + 8.0 * along, tip - 4.0 * along + side, tip - 4.0 * along - side];
                ui.painter().add(egui::Shape::convex_polygon(points, fill, Stroke::NONE));
            }
        }
        if response.drag_started_by(egui::PointerButton::Primary) {
            taken = Some(axis);
        }
        response.on_hover_text(format!("Drag to {} along this axis", kind.label().to_lowercase()));
    }
    taken
}

impl Grab {
    /// A grab that a handle began.
    pub fn held(kind: GrabKind, drag: VertexDrag, axis: usize) -> Self {
        Self { axis: Some(axis), is_held: true, ..Self::new(kind, drag) }
    }
}
