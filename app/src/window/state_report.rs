//! What the window is doing, as lines of JSON in a file (`--report-state FILE`), so that a test waits for a
//! state instead of for a time.

use std::io::Write;
use std::path::PathBuf;

use serde_json::json;

use super::Studio;

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
        let state = describe(studio, ctx, &ctx.input(Clone::clone)).to_string();
        if state == self.last {
            return Ok(());
        }
        let mut file = std::fs::OpenOptions::new().create(true).append(true).open(&self.path)?;
        writeln!(file, "{state}")?;
        self.last = state;
        Ok(())
    }
}

fn describe(studio: &Studio, ctx: &egui::Context, input: &egui::InputState) -> serde_json::Value {
    let desk = &studio.desk;
    let groom = &desk.document.groom;
    let report = &desk.report;
    let pose = desk.playback.head_pose;
    let rect = studio.viewport.rect.map(|r| [r.left(), r.top(), r.right(), r.bottom()]);
    let mut look = groom.look.clone();
    let choices: serde_json::Map<String, serde_json::Value> =
        look.slots().iter().map(|slot| (slot.key.to_owned(), slot.chosen().name.into())).collect();
    json!({
        "name": groom.name,
        "path": desk.document.path,
        "unsaved": desk.document.is_unsaved(),
        "steps": desk.document.history.labels().collect::<Vec<_>>(),
        "n_done": desk.document.history.n_done(),
        "look": choices,
        "layers": groom.layers.iter().map(|layer| layer.name.clone()).collect::<Vec<_>>(),
        "camera": [desk.camera.azimuth_deg, desk.camera.elevation_deg, desk.camera.distance],
        "playing": desk.playback.is_playing,
        "sim_secs": report.sim_secs,
        "head": [pose.shift.x, pose.shift.y, pose.shift.z, pose.yaw, pose.pitch],
        "still": report.is_still && studio.is_shown(),
        "frame": report.frame_idx,
        "lod": report.lod,
        "strands": report.n_strands,
        "frame_ms": report.frame_ms,
        "busy": report.busy,
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
    })
}
