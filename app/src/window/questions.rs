//! Questions that must be answered before something is lost, and what goes on after them.

use super::files::jobs::Done;
use super::recovery::{self, Left};
use super::{Studio, state_report, theme};

/// A question that must be answered before something is lost. Nothing else waits for the answer.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Question {
    /// Save before what comes next?
    Unsaved(Next),
    /// Take what a crashed run left?
    Recover,
}

/// What goes on once unsaved changes were saved or given up.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Next {
    Close,
    New,
    /// An embedded hairstyle as a new document.
    Hairstyle(&'static str),
    AskForFile,
    Open(std::path::PathBuf),
}

impl Studio {
    pub(super) fn questions(&mut self, ctx: &egui::Context) {
        let Some(question) = self.question.clone() else { return };
        let (title, text, buttons): (_, String, [&str; 3]) = match &question {
            Question::Unsaved(_) => (
                "Save the changes?",
                format!("{} has changes that are in no file.", self.desk.document.title()),
                ["Save", "Do not save", "Cancel"],
            ),
            Question::Recover => (
                "Recover unsaved work?",
                "The studio ended without saving the last time. What was changed up to the last moments is here."
                    .to_owned(),
                ["Recover", "Throw away", "Later"],
            ),
        };
        let mut pressed = None;
        egui::Window::new(title)
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, -60.0])
            .order(egui::Order::Foreground)
            .show(ctx, |ui| {
                ui.set_width(360.0);
                ui.add(egui::Label::new(text).wrap());
                ui.add_space(10.0);
                ui.horizontal(|ui| {
                    for (i, label) in buttons.into_iter().enumerate() {
                        let fill = if i == 0 { theme::ACCENT_DIM } else { theme::CONTROL };
                        let text = egui::RichText::new(label).color(theme::TEXT_STRONG);
                        let button = egui::Button::new(text).fill(fill).min_size(egui::vec2(90.0, 28.0));
                        let button = ui.add(button);
                        state_report::mark(ctx, || format!("answer {i}"), button.rect);
                        if button.clicked() {
                            pressed = Some(i);
                        }
                    }
                });
            });
        if ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
            pressed = Some(2);
        }
        let Some(pressed) = pressed else { return };
        self.question = None;
        match (question, pressed) {
            (Question::Unsaved(next), 0) => {
                self.after_save = Some(next);
                self.save(ctx);
            }
            (Question::Unsaved(next), 1) => self.go_on(ctx, next),
            (Question::Recover, 0) => {
                if let Some(left) = self.recovery.as_ref().and_then(|recovery| recovery.left.first()).cloned() {
                    self.recover(ctx, left);
                }
            }
            (Question::Recover, 1) => {
                if let Some(recovery) = &mut self.recovery {
                    recovery.forget_left();
                }
            }
            (Question::Unsaved(_) | Question::Recover, _) => {}
        }
    }

    pub(super) fn recover(&mut self, ctx: &egui::Context, left: Left) {
        self.jobs.start(ctx, "Recovering", move |watch| match recovery::restore(&left, watch) {
            Ok(restored) => Done::Recovered { restored: Box::new(restored), replaces: left.files },
            Err(_) if watch.cancelled() => Done::Cancelled,
            Err(why) => Done::Failed { title: "The unsaved work could not be read".to_owned(), why },
        });
    }

    pub(super) fn open_question(&self) -> Option<&'static str> {
        match self.question {
            Some(Question::Unsaved(_)) => Some("unsaved"),
            Some(Question::Recover) => Some("recover"),
            None => None,
        }
    }
}
