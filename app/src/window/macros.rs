//! Macros: what is done between two presses of one command becomes a list of edits in a file, which
//! `lorelei apply` and the window replay.

use lorelei_core::edit::Edit;
use lorelei_core::history::Merge;
use lorelei_core::record::Macro;

use super::Studio;
use super::files::choose::Purpose;
use super::notices::Severity;

impl Studio {
    /// Begin a macro, or end the one that is being recorded and ask for its file.
    pub(super) fn record_macro(&mut self, ctx: &egui::Context) {
        // What was done up to now belongs to what was before.
        self.keep_records(false);
        match self.desk.recorder.take() {
            None => self.desk.recorder = Some(Macro::default()),
            Some(recorder) if recorder.n_steps() == 0 => {
                self.desk.notices.push(Severity::Info, "No macro", "Nothing was changed while it was recorded.");
            }
            Some(recorder) => {
                self.recorded = recorder.into_steps();
                self.choose(ctx, Purpose::SaveMacro);
            }
        }
    }

    /// Apply what a macro did to a copy of the groom, as one step.
    pub(super) fn played(&mut self, name: &str, edits: Vec<Edit>) {
        let document = &mut self.desk.document;
        let n_edits = edits.len();
        let applied =
            document.history.apply(&mut document.groom, &format!("Macro {name}"), Edit::Batch(edits), Merge::New);
        match applied {
            Ok(()) => {
                self.desk.notices.push(Severity::Info, "Macro played", format!("{name}: {n_edits} edits, one step"));
            }
            // The groom was changed while the macro was being prepared.
            Err(why) => self.desk.notices.error(format!("Could not play {name}"), format!("{why}. Play it again")),
        }
        self.desk.measure();
        self.desk.clamp_selection();
    }
}
