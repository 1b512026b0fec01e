//! What the window is doing, as lines of JSON in a file (`--report-state FILE`), so that a test waits for a
//! state instead of for a time.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use lorelei_core::collider::Collider;
use lorelei_core::look::Choice;
use lorelei_core::pin::Pin;
use lorelei_core::simulation::Quality;
use serde_json::json;

use super::Studio;
use super::desk::Desk;

/// Writes the state whenever it differs from what was written last.
pub struct StateReport {
    path: PathBuf,
    last: String,
}

impl StateReport {
    pub fn new(path: PathBuf) -> Self {
        Self { path, last: String::new() }
    }

    /// Append the state to the file where it is news.
    pub fn write(&mut self, studio: &Studio, ctx: &egui::Context) -> std::io::Result<()> {
        let marks: Marks = ctx.data_mut(|data| {
            let marks = data.get_temp(marks_id()).unwrap_or_default();
            data.insert_temp(marks_id(), Marks::new());
            marks
        });
        let state = describe(studio, ctx, &ctx.input(Clone::clone), &marks).to_string();
        if state == self.last {
            return Ok(());
        }
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&self.path)?;
        writeln!(file, "{state}")?;
        self.last = state;
        Ok(())
    }
}

/// Where controls are, by name, in this frame.
type Marks = BTreeMap<String, [f32; 4]>;

fn marks_id() -> egui::Id {
    egui::Id::unique("marks of the state report")
}

/// Tell the state report where a control is; nothing happens where none is written.
pub fn mark(ctx: &egui::Context, name: impl FnOnce() -> String, rect: egui::Rect) {
    ctx.data_mut(|data| {
        if let Some(mut marks) = data.get_temp::<Marks>(marks_id()) {
            marks.insert(name(), [rect.left(), rect.top(), rect.right(), rect.bottom()]);
            data.insert_temp(marks_id(), marks);
        }
    });
}

/// Where a marked control is, for tests without a window; the first call only starts to keep marks.
#[cfg(test)]
pub fn marked(ctx: &egui::Context, name: &str) -> Option<egui::Rect> {
    ctx.data_mut(|data| {
        let marks = data.get_temp_mut_or_default::<Marks>(marks_id());
        let [left, top, right, bottom] = *marks.get(name)?;
        Some(egui::Rect::from_min_max(egui::pos2(left, top), egui::pos2(right, bottom)))
    })
}

/// How evenly the window's own frames come while it draws one after the other.
#[derive(Debug, Default)]
pub struct UiClock {
    last: Option<Instant>,
    intervals_ms: std::collections::VecDeque<f32>,
}

/// Frames that the clock looks back on.
const N_INTERVALS: usize = 120;

impl UiClock {
    /// A frame begins. Only an interval that was to be a short one counts.
    pub fn tick(&mut self) {
        if let Some(last) = self.last.take() {
            if self.intervals_ms.len() == N_INTERVALS {
                self.intervals_ms.pop_front();
            }
            self.intervals_ms.push_back(last.elapsed().as_secs_f32() * 1000.0);
        }
    }

    /// The next frame is wanted at once.
    pub fn expect_next(&mut self) {
        self.last = Some(Instant::now());
    }

    /// Median and longest interval, milliseconds.
    pub fn intervals_ms(&self) -> (f32, f32) {
        let mut sorted: Vec<f32> = self.intervals_ms.iter().copied().collect();
        sorted.sort_by(f32::total_cmp);
        let median = sorted.get(sorted.len() / 2).copied().unwrap_or(0.0);
        (median, sorted.last().copied().unwrap_or(0.0))
    }
}

fn describe(studio: &Studio, ctx: &egui::Context, input: &egui::InputState, marks: &Marks) -> serde_json::Value {
    let desk = &studio.desk;
    let groom = &desk.document.groom;
    let report = &desk.report;
    let pose = desk.playback.head_pose;
    let rect = studio.viewport.rect.map(|r| [r.left(), r.top(), r.right(), r.bottom()]);
    let mut look = groom.look.clone();
    let choices: serde_json::Map<String, serde_json::Value> =
        look.slots().iter().map(|slot| (slot.key.to_owned(), slot.chosen().name.into())).collect();
    let mut state = json!({
        "name": groom.name,
        "path": desk.document.path,
        "unsaved": desk.document.is_unsaved(),
        "steps": desk.document.history.labels().collect::<Vec<_>>(),
        "n_done": desk.document.history.n_done(),
        "look": choices,
        "layers": groom.layers.iter().map(|layer| layer.name.clone()).collect::<Vec<_>>(),
        "camera": [desk.camera.azimuth_deg, desk.camera.elevation_deg, desk.camera.distance],
        "tool": {
            "name": desk.tools.active.label(),
            "selected": desk.tools.mesh.selection.vertices.len(),
            "holds": desk.tools.takes_keys(),
            "refusal": desk.tools.mesh.refusal(),
            "is_ready": desk.tools.sculpt.is_ready(),
            "brush": desk.tools.sculpt.kind.info().name,
        },
        "playing": desk.playback.is_playing,
        "sim_secs": report.timeline.secs,
        "head": [pose.shift.x, pose.shift.y, pose.shift.z, pose.yaw, pose.pitch],
        "still": report.is_still && studio.is_shown(),
        "frame": report.frame_idx,
        "lod": report.lod,
        "strands": report.n_strands,
        "frame_ms": report.frame_ms,
        "marks": marks,
        "target": desk.camera.target.to_array(),
        "lights": groom.lights.iter().map(|light| light.direction_to(desk.centre()).to_array()).collect::<Vec<_>>(),
        "radius_um": groom.layers.first().map(|layer| layer.radius_um),
        "recent": desk.settings.recent,
        "layout": ron::to_string(&desk.settings.layout).unwrap_or_default(),
        "shortcuts": studio.shows_shortcuts,
        "coarseness": report.coarseness,
        "ui_ms": [studio.clock.intervals_ms().0, studio.clock.intervals_ms().1],
        "replaced": report.n_replaced,
        "start_secs": {
            "picture": report.start.picture.as_secs_f32(), "shaders": report.start.shaders.as_secs_f32(),
            "waited_for_shaders": report.start.waited_for_shaders.as_secs_f32(),
            "bind": report.start.bind.as_secs_f32(), "first_frame": report.start.first_frame.as_secs_f32(),
        },
        "kept": kept(studio),
        "busy": report.busy.map(|busy| busy.task.label()),
        "jobs": studio.jobs.running.len(),
        "notices": desk.notices.shown.iter().map(|notice| format!("{}: {}", notice.title, notice.text)).collect::<Vec<_>>(),
        "question": studio.open_question(),
        "palette": studio.palette.is_some(),
        "dialog": studio.chooser.is_some(),
        "typing": ctx.text_edit_focused(),
        "focused": input.viewport().focused.unwrap_or(false),
        "pointer": input.pointer.latest_pos().map(|at| [at.x, at.y]),
        "pointer_down": input.pointer.any_down(),
        "viewport": rect,
        "head_handle": studio.head_handle(),
    });
    let place = |collider: &Collider| collider.ends[0].extend(collider.radii[0]).to_array();
    state["colliders"] = groom.simulation.colliders.iter().map(place).collect::<Vec<_>>().into();
    let place = |pin: &Pin| pin.centre.extend(pin.radius).to_array();
    state["pins"] = groom.simulation.pins.iter().map(place).collect::<Vec<_>>().into();
    // One more entry is more than the macro expands.
    state["opening"] = studio.viewport.opening.clone().into();
    state["shows_picture"] = studio.viewport.shows_picture(desk).into();
    state["room"] = super::room::report(desk);
    let place = |p: glam::Vec3| p.to_array();
    state["held"] = json!(report.held.map(|held| [place(held.at), place(held.hand)]));
    state["timeline"] = super::timeline::report(desk);
    state["air"] = air(desk);
    state
}

/// What moves hair besides the head, and how exactly.
fn air(desk: &Desk) -> serde_json::Value {
    let simulation = &desk.document.groom.simulation;
    let sources = simulation.sources.iter().map(|source| {
        json!({"place": source.place.to_array(), "direction": source.direction.to_array(), "speed": source.speed})
    });
    json!({
        "quality": Quality::of(simulation).map(|quality| quality.info().name),
        "bend_length": simulation.bend_length,
        "wind": simulation.wind.info().name,
        "is_read": desk.report.air.is_some(),
        "sources": sources.collect::<Vec<_>>(),
    })
}

/// What is kept of what was done.
fn kept(studio: &Studio) -> serde_json::Value {
    json!({
        "records": studio.recovery.as_ref().map(super::recovery::Recovery::n_records),
        "macro_steps": studio.desk.recorder.as_ref().map(lorelei_core::record::Macro::n_steps),
        "history_bytes": studio.desk.document.history.n_bytes(),
    })
}
