//! The studio's own file dialog, for systems where no desktop portal answers.
//!
//! A plain window, not modal: the rest of the studio stays usable. A path can be typed, places are one
//! click away, Enter opens, Backspace goes up, arrows move, Esc closes, an existing file is overwritten
//! only after a question. egui-file-dialog was rejected: it lags an egui version behind.

use std::path::{Path, PathBuf};

use egui::{Align, Align2, Key, Layout, RichText, Sense, Ui, vec2};

use super::choose::{Choice, Purpose};
use super::listing::{self, Entry, Listing, Order};
use crate::window::state_report::mark;
use crate::window::theme;

/// An open dialog.
pub struct FileDialog {
    pub purpose: Purpose,
    folder: PathBuf,
    /// What is typed into the path bar.
    path_text: String,
    listing: Listing,
    name: String,
    marked: Option<PathBuf>,
    order: Order,
    is_descending: bool,
    show_hidden: bool,
    show_all: bool,
    /// The file that would be overwritten, while it is asked.
    overwrite: Option<PathBuf>,
    new_folder: Option<String>,
    problem: Option<String>,
    back: Vec<PathBuf>,
    is_new: bool,
}

impl FileDialog {
    /// Open in a folder, with a suggested name where something is saved.
    pub fn new(ctx: &egui::Context, purpose: Purpose, folder: PathBuf, name: String) -> Self {
        let mut dialog = Self {
            purpose,
            path_text: String::new(),
            listing: Listing::Read(Vec::new()),
            folder: PathBuf::new(),
            name,
            marked: None,
            order: Order::Name,
            is_descending: false,
            show_hidden: false,
            show_all: false,
            overwrite: None,
            new_folder: None,
            problem: None,
            back: Vec::new(),
            is_new: true,
        };
        dialog.enter(ctx, folder);
        dialog.back.clear();
        dialog
    }

    fn enter(&mut self, ctx: &egui::Context, folder: PathBuf) {
        let before = std::mem::replace(&mut self.folder, folder);
        if before != self.folder {
            self.back.push(before);
        }
        self.path_text = self.folder.display().to_string();
        self.marked = None;
        self.problem = None;
        let ctx = ctx.clone();
        self.listing = Listing::start(&self.folder, move || ctx.request_repaint());
    }

    /// Draw it; `Some` once it was answered.
    pub fn ui(&mut self, ctx: &egui::Context) -> Option<Choice> {
        self.listing.poll();
        let mut answer = None;
        let mut is_open = true;
        let size = ctx.content_rect().size();
        let width = (size.x - 80.0).clamp(320.0, 780.0);
        let height = (size.y - 140.0).clamp(240.0, 520.0);
        egui::Window::new(self.purpose.title())
            .id(egui::Id::unique("file dialog"))
            .open(&mut is_open)
            .collapsible(false)
            .pivot(Align2::CENTER_CENTER)
            .default_pos(ctx.content_rect().center())
            .default_size([width, height])
            .order(egui::Order::Foreground)
            .show(ctx, |ui| answer = self.body(ui));
        let escape = ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, Key::Escape));
        if escape && (self.overwrite.take().is_some() || self.new_folder.take().is_some()) {
            return answer;
        }
        if answer.is_none() && (!is_open || escape) {
            answer = Some(Choice::Cancelled);
        }
        self.is_new = false;
        answer
    }

    fn body(&mut self, ui: &mut Ui) -> Option<Choice> {
        let mut answer = None;
        self.path_bar(ui);
        ui.add_space(2.0);
        egui::Panel::bottom("file dialog buttons").frame(egui::Frame::new()).show_separator_line(false).show(
            ui,
            |ui| {
                ui.add_space(6.0);
                answer = self.buttons(ui);
            },
        );
        egui::Panel::left("file dialog places")
            .frame(egui::Frame::new())
            .resizable(false)
            .exact_size(130.0)
            .show(ui, |ui| self.places(ui));
        egui::CentralPanel::no_frame().show(ui, |ui| {
            answer = self.list(ui).or(answer.take());
        });
        answer
    }

    fn path_bar(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        ui.horizontal(|ui| {
            if ui
                .add_enabled(!self.back.is_empty(), egui::Button::new("Back"))
                .on_hover_text("The folder before")
                .clicked()
                && let Some(folder) = self.back.pop()
            {
                self.enter(&ctx, folder);
                self.back.pop();
            }
            let parent = self.folder.parent().map(Path::to_owned);
            if ui
                .add_enabled(parent.is_some(), egui::Button::new("Up"))
                .on_hover_text("The folder around this one (Backspace)")
                .clicked()
                && let Some(parent) = parent
            {
                self.enter(&ctx, parent);
            }
            if self.purpose.is_save() && ui.button("New folder").on_hover_text("In the folder that is shown").clicked()
            {
                self.new_folder = Some("New folder".to_owned());
            }
            let field = egui::TextEdit::singleline(&mut self.path_text)
                .desired_width(f32::INFINITY)
                .margin(egui::Margin::symmetric(6, 4));
            let field = ui.add(field).on_hover_text("Type or paste a path");
            mark(ui.ctx(), || "dialog path".to_owned(), field.rect);
            if field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                let typed = expand_home(self.path_text.trim());
                if typed.is_dir() {
                    self.enter(&ctx, typed);
                } else if typed.is_file() {
                    self.name = typed.file_name().unwrap_or_default().to_string_lossy().into_owned();
                    if let Some(parent) = typed.parent() {
                        self.enter(&ctx, parent.to_owned());
                    }
                    self.marked = Some(typed);
                } else if let Some((folder, name)) = self.new_file(&typed) {
                    self.name = name;
                    self.enter(&ctx, folder);
                } else {
                    self.problem = Some(format!("There is no file or folder {}", typed.display()));
                }
            }
        });
        if let Some(name) = &mut self.new_folder {
            let mut is_made = false;
            let mut is_cancelled = false;
            ui.horizontal(|ui| {
                ui.label("New folder:");
                let field = ui.text_edit_singleline(name);
                is_made = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                is_made |= ui.button("Create").clicked();
                is_cancelled = ui.button("Cancel").clicked();
            });
            let folder = self.folder.join(name.trim());
            if is_made {
                match std::fs::create_dir(&folder) {
                    Ok(()) => self.enter(&ctx, folder),
                    Err(why) => self.problem = Some(format!("{}: {why}", folder.display())),
                }
            }
            if is_made || is_cancelled {
                self.new_folder = None;
            }
        }
    }

    fn places(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        for (name, folder) in places() {
            let place = ui.selectable_label(self.folder == folder, name);
            if place.on_hover_text(folder.display().to_string()).clicked() {
                self.enter(&ctx, folder);
            }
        }
    }

    fn list(&mut self, ui: &mut Ui) -> Option<Choice> {
        let ctx = ui.ctx().clone();
        let mut answer = None;
        header(ui, &mut self.order, &mut self.is_descending);
        let extensions = if self.show_all { Vec::new() } else { self.purpose.extensions() };
        let entries: Vec<Entry> = match &self.listing {
            Listing::Reading(_) => {
                ui.spinner();
                return None;
            }
            Listing::Failed(why) => {
                ui.label(RichText::new(why).color(theme::ERROR));
                return None;
            }
            Listing::Read(entries) => {
                let shown = listing::shown(entries, &extensions, self.show_hidden, self.order, self.is_descending);
                shown.into_iter().cloned().collect()
            }
        };
        let mut opened = None;
        self.keys(ui, &entries, &mut opened);
        egui::ScrollArea::vertical().auto_shrink([false, false]).show_rows(
            ui,
            theme::ROW,
            entries.len(),
            |ui, rows| {
                for entry in &entries[rows] {
                    let is_marked = self.marked.as_deref() == Some(&entry.path);
                    let response = entry_row(ui, entry, is_marked);
                    if response.clicked() {
                        self.marked = Some(entry.path.clone());
                        if !entry.is_folder {
                            self.name.clone_from(&entry.name);
                        }
                    }
                    if response.double_clicked() {
                        opened = Some(entry.clone());
                    }
                }
            },
        );
        if entries.is_empty() {
            let what = if extensions.is_empty() { "The folder is empty." } else { "No such files here." };
            ui.put(
                egui::Rect::from_min_size(ui.min_rect().min + vec2(10.0, 30.0), vec2(300.0, theme::ROW)),
                egui::Label::new(RichText::new(what).color(theme::TEXT_WEAK)),
            );
        }
        match opened {
            Some(entry) if entry.is_folder => self.enter(&ctx, entry.path),
            Some(entry) => {
                self.name = entry.name;
                answer = self.accept();
            }
            None => {}
        }
        answer
    }

    /// Arrows move the mark, Enter opens it, Backspace goes up; while no text is typed.
    fn keys(&mut self, ui: &Ui, entries: &[Entry], opened: &mut Option<Entry>) {
        let ctx = ui.ctx().clone();
        if ctx.text_edit_focused() {
            return;
        }
        let pressed = |key| ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, key));
        let at = entries.iter().position(|entry| self.marked.as_deref() == Some(&entry.path));
        let moved = match (pressed(Key::ArrowDown), pressed(Key::ArrowUp)) {
            (true, _) => Some(at.map_or(0, |at| (at + 1).min(entries.len().saturating_sub(1)))),
            (_, true) => Some(at.map_or(0, |at| at.saturating_sub(1))),
            (false, false) => None,
        };
        if let Some(entry) = moved.and_then(|at| entries.get(at)) {
            self.marked = Some(entry.path.clone());
            if !entry.is_folder {
                self.name.clone_from(&entry.name);
            }
        }
        if pressed(Key::Enter) {
            *opened = at.and_then(|at| entries.get(at)).cloned();
        }
        if pressed(Key::Backspace)
            && let Some(parent) = self.folder.parent().map(Path::to_owned)
        {
            self.enter(&ctx, parent);
        }
    }

    fn buttons(&mut self, ui: &mut Ui) -> Option<Choice> {
        let mut answer = None;
        if let Some(problem) = &self.problem {
            ui.label(RichText::new(problem).color(theme::ERROR));
        }
        if let Some(path) = self.overwrite.clone() {
            ui.horizontal(|ui| {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                ui.label(RichText::new(format!("{name} exists. Overwrite it?")).color(theme::ACCENT));
                if ui.button("Overwrite").on_hover_text("What the file holds now is lost").clicked() {
                    answer = Some(Choice::Path(path.clone()));
                }
                if ui.button("Keep it").on_hover_text("Choose another name").clicked() {
                    self.overwrite = None;
                }
            });
        }
        ui.horizontal(|ui| {
            if self.purpose.is_save() {
                ui.label("Name");
                let field = ui.add(
                    egui::TextEdit::singleline(&mut self.name)
                        .desired_width(260.0)
                        .margin(egui::Margin::symmetric(6, 4)),
                );
                if self.is_new {
                    field.request_focus();
                }
                if field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter)) {
                    answer = self.accept().or(answer.take());
                }
            } else {
                let wanted = self.purpose.extensions().iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" ");
                ui.checkbox(&mut self.show_all, "All files").on_hover_text(format!("Off: only {wanted}"));
            }
            ui.checkbox(&mut self.show_hidden, "Hidden").on_hover_text("Also what begins with a dot");
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let verb = if self.purpose.is_save() { "Save" } else { "Open" };
                let can_accept =
                    if self.purpose.is_save() { !self.name.trim().is_empty() } else { self.marked.is_some() };
                let button = egui::Button::new(RichText::new(verb).color(theme::TEXT_STRONG))
                    .fill(theme::ACCENT_DIM)
                    .min_size(vec2(76.0, 26.0));
                let accept = ui.add_enabled(can_accept, button);
                mark(ui.ctx(), || "dialog accept".to_owned(), accept.rect);
                if accept.clicked() {
                    answer = self.accept().or(answer.take());
                }
                if ui.add(egui::Button::new("Cancel").min_size(vec2(76.0, 26.0))).clicked() {
                    answer = Some(Choice::Cancelled);
                }
            });
        });
        answer
    }

    /// Where to save to and under which name, where a path is typed that is to be made.
    fn new_file(&self, typed: &Path) -> Option<(PathBuf, String)> {
        let (folder, name) = (typed.parent()?, typed.file_name()?);
        let is_new_file = self.purpose.is_save() && folder.is_dir();
        is_new_file.then(|| (folder.to_owned(), name.to_string_lossy().into_owned()))
    }

    /// The chosen path, unless it must be asked about first.
    fn accept(&mut self) -> Option<Choice> {
        if !self.purpose.is_save() {
            let marked = self.marked.clone().unwrap_or_else(|| self.folder.join(&self.name));
            if marked.is_dir() {
                self.problem = Some("That is a folder: double-click it to look into it.".to_owned());
                return None;
            }
            return Some(Choice::Path(marked));
        }
        let path = self.purpose.with_extension(self.folder.join(self.name.trim()));
        if path.exists() && self.overwrite.as_ref() != Some(&path) {
            self.overwrite = Some(path);
            return None;
        }
        Some(Choice::Path(path))
    }
}

/// Column starts from the right edge: size, date.
const SIZE_COLUMN: f32 = 210.0;
const DATE_COLUMN: f32 = 124.0;

fn header(ui: &mut Ui, order: &mut Order, is_descending: &mut bool) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::hover());
    let columns = [
        ("Name", Order::Name, rect.left(), rect.right() - SIZE_COLUMN),
        ("Size", Order::Size, rect.right() - SIZE_COLUMN, rect.right() - DATE_COLUMN),
        ("Modified (UTC)", Order::Modified, rect.right() - DATE_COLUMN, rect.right()),
    ];
    for (name, column, left, right) in columns {
        let cell = egui::Rect::from_x_y_ranges(left..=right, rect.y_range());
        let response = ui.interact(cell, ui.scope_id().with(name), Sense::click());
        let arrow = match (*order == column, *is_descending) {
            (true, false) => ", rising",
            (true, true) => ", falling",
            (false, _) => "",
        };
        let small = egui::TextStyle::Small.resolve(ui.style());
        let colour = if response.hovered() { theme::TEXT_STRONG } else { theme::TEXT_WEAK };
        ui.painter().text(
            cell.left_center() + vec2(6.0, 0.0),
            Align2::LEFT_CENTER,
            format!("{name}{arrow}"),
            small,
            colour,
        );
        if response.clicked() {
            *is_descending = *order == column && !*is_descending;
            *order = column;
        }
    }
}

fn entry_row(ui: &mut Ui, entry: &Entry, is_marked: bool) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), theme::ROW), Sense::click());
    let painter = ui.painter();
    if is_marked {
        painter.rect_filled(rect, 3.0, theme::ACCENT_DIM);
    } else if response.hovered() {
        painter.rect_filled(rect, 3.0, theme::CONTROL);
    }
    let icon = egui::Rect::from_center_size(rect.left_center() + vec2(13.0, 0.0), vec2(12.0, 9.0));
    if entry.is_folder {
        let tab = egui::Rect::from_min_size(icon.min - vec2(0.0, 2.0), vec2(5.0, 3.0));
        painter.rect_filled(tab, 1.0, theme::ACCENT.gamma_multiply(0.7));
        painter.rect_filled(icon, 1.0, theme::ACCENT.gamma_multiply(0.7));
    } else {
        let sheet = egui::Rect::from_center_size(icon.center(), vec2(8.0, 11.0));
        painter.rect_stroke(sheet, 1.0, egui::Stroke::new(1.0, theme::TEXT_WEAK), egui::StrokeKind::Inside);
    }
    let font = egui::TextStyle::Body.resolve(ui.style());
    let small = egui::TextStyle::Small.resolve(ui.style());
    let clip = egui::Rect::from_x_y_ranges(rect.left()..=rect.right() - SIZE_COLUMN - 6.0, rect.y_range());
    let clipped = painter.with_clip_rect(clip.intersect(ui.clip_rect()));
    clipped.text(rect.left_center() + vec2(26.0, 0.0), Align2::LEFT_CENTER, &entry.name, font, theme::TEXT);
    let column = |from_right: f32| egui::pos2(rect.right() - from_right + 6.0, rect.center().y);
    if !entry.is_folder {
        let text = listing::size_text(entry.n_bytes);
        painter.text(column(SIZE_COLUMN), Align2::LEFT_CENTER, text, small.clone(), theme::TEXT_WEAK);
    }
    if let Some(modified) = entry.modified {
        let text = listing::date_text(modified);
        painter.text(column(DATE_COLUMN), Align2::LEFT_CENTER, text, small, theme::TEXT_WEAK);
    }
    response
}

fn places() -> Vec<(String, PathBuf)> {
    let mut places = Vec::new();
    if let Some(dirs) = directories::UserDirs::new() {
        places.push(("Home".to_owned(), dirs.home_dir().to_owned()));
        let folders = [
            ("Desktop", dirs.desktop_dir()),
            ("Documents", dirs.document_dir()),
            ("Downloads", dirs.download_dir()),
            ("Pictures", dirs.picture_dir()),
        ];
        places.extend(folders.into_iter().filter_map(|(name, dir)| Some((name.to_owned(), dir?.to_owned()))));
    }
    if let Ok(folder) = std::env::current_dir() {
        places.push(("Start folder".to_owned(), folder));
    }
    places.push(("Computer".to_owned(), PathBuf::from(std::path::MAIN_SEPARATOR_STR)));
    places.retain(|(_, folder)| folder.is_dir());
    places
}

fn expand_home(typed: &str) -> PathBuf {
    let home = directories::UserDirs::new().map(|dirs| dirs.home_dir().to_owned());
    match (typed.strip_prefix('~'), home) {
        (Some(rest), Some(home)) => home.join(rest.trim_start_matches(std::path::is_separator)),
        _ => PathBuf::from(typed),
    }
}
