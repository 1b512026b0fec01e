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

/// Nobody else gets what was pressed or typed in this frame.
pub(super) fn take_keys(ctx: &egui::Context) {
    use egui::Event;
    ctx.input_mut(|input| {
        input.keys_down.clear();
        input.events.retain(|event| {
            let is_of_keys = matches!(
                event,
                Event::Key { .. } | Event::Text(_) | Event::Ime(_) | Event::Paste(_) | Event::Copy | Event::Cut
            );
            !is_of_keys
        });
    });
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
        // Nothing behind it takes the pointer or the focus.
        let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(14);
        egui::Modal::new(egui::Id::unique("question")).frame(frame).show(ctx, |ui| {
            ui.set_width(360.0);
            ui.label(egui::RichText::new(title).strong().color(theme::TEXT_STRONG));
            ui.add_space(6.0);
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
        self.jobs.start_opening(ctx, "Recovering", move |watch| match recovery::restore(&left, watch) {
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

#[cfg(test)]
mod tests {
    use egui::{Context, Event, Key, Modifiers, PointerButton, RawInput, pos2};

    use super::super::commands::{Command, pressed};
    use super::super::tools::Tool;
    use super::take_keys;

    #[test]
    fn what_is_pressed_while_a_question_waits_is_no_command_and_the_pointer_is_left() {
        let press =
            |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
        let click = Event::PointerButton {
            pos: pos2(1.0, 1.0),
            button: PointerButton::Primary,
            pressed: true,
            modifiers: Modifiers::NONE,
        };
        let commands = |is_asked: bool| {
            let ctx = Context::default();
            let events = vec![press(Key::Space), Event::Text(" ".to_owned()), click.clone(), press(Key::Delete)];
            let (mut commands, mut n_left) = (Vec::new(), 0);
            let mut output = ctx.run_ui(RawInput { events, ..Default::default() }, |_| {
                if is_asked {
                    take_keys(&ctx);
                }
                commands.extend(std::iter::from_fn(|| pressed(&ctx, false, Tool::Select)));
                n_left = ctx.input(|input| input.events.len() + input.keys_down.len());
            });
            output.textures_delta.clear();
            (commands, n_left)
        };
        assert!(commands(false).0.contains(&Command::Play));
        assert_eq!(commands(true), (Vec::new(), 1));
    }
}
