//! Asking for a path: the desktop's own dialog where a portal can answer, else the studio's.

use std::path::{Path, PathBuf};
use std::sync::mpsc;

use super::dialog::FileDialog;
use lorelei_core::io::{HAIR_MESH_EXTENSIONS, MESH_EXTENSIONS, OUTPUT_EXTENSIONS, STRAND_EXTENSIONS};
use lorelei_core::maps::picture::MAP_EXTENSIONS;
use lorelei_core::panorama::read::PANORAMA_EXTENSIONS;

use crate::movement::file::EXTENSION;

/// What a path is wanted for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    Open,
    SaveAs,
    ImportHair,
    ImportHead,
    ImportHairMesh,
    ExportHairMesh,
    Export,
    SavePicture,
    SaveMacro,
    PlayMacro,
    LoadStyle,
    SaveStyle,
    LoadMap,
    SaveMap,
    LoadLook,
    LoadEnvironment,
    SaveLook,
    SaveSheet,
    SaveTurntable,
    SaveFrames,
    OpenFrames,
    LoadAnimation,
}

/// What a person answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Choice {
    Path(PathBuf),
    Cancelled,
}

impl Purpose {
    pub fn title(self) -> &'static str {
        match self {
            Self::Open => "Open",
            Self::SaveAs => "Save as",
            Self::ImportHair => "Import hair",
            Self::ImportHead => "Import head",
            Self::ImportHairMesh => "Import hair mesh",
            Self::ExportHairMesh => "Export hair mesh",
            Self::Export => "Export strands",
            Self::SavePicture => "Save picture",
            Self::SaveMacro => "Save the macro",
            Self::PlayMacro => "Play a macro",
            Self::LoadStyle => "Load style",
            Self::SaveStyle => "Save style",
            Self::LoadMap => "Load map",
            Self::SaveMap => "Save map",
            Self::LoadLook => "Load look",
            Self::LoadEnvironment => "Load environment",
            Self::SaveLook => "Save look",
            Self::SaveSheet => "Save the contact sheet",
            Self::SaveTurntable => "Save the turntable",
            Self::SaveFrames => "Simulate to a file",
            Self::OpenFrames => "Open frames",
            Self::LoadAnimation => "Load an animation",
        }
    }

    /// Extensions without dots; the first is added to a name that has none of them.
    pub fn extensions(self) -> Vec<String> {
        let all: Vec<&str> = match self {
            Self::Open => std::iter::once("lorelei").chain(STRAND_EXTENSIONS.iter().copied()).collect(),
            Self::SaveAs => vec!["lorelei"],
            Self::ImportHair => STRAND_EXTENSIONS.to_vec(),
            Self::ImportHead => MESH_EXTENSIONS.to_vec(),
            Self::ImportHairMesh => vec!["obj", "glb", "gltf"],
            Self::ExportHairMesh => HAIR_MESH_EXTENSIONS.to_vec(),
            Self::Export => OUTPUT_EXTENSIONS.to_vec(),
            Self::SavePicture | Self::SaveSheet | Self::SaveTurntable => vec!["png"],
            Self::SaveMacro | Self::PlayMacro | Self::LoadStyle | Self::SaveStyle | Self::LoadLook | Self::SaveLook => {
                vec!["ron"]
            }
            Self::LoadMap | Self::SaveMap => MAP_EXTENSIONS.to_vec(),
            Self::LoadEnvironment => PANORAMA_EXTENSIONS.to_vec(),
            Self::SaveFrames | Self::OpenFrames => vec![EXTENSION],
            Self::LoadAnimation => vec!["glb", "gltf"],
        };
        all.into_iter().map(str::to_owned).collect()
    }

    pub fn is_save(self) -> bool {
        matches!(
            self,
            Self::SaveAs
                | Self::Export
                | Self::ExportHairMesh
                | Self::SavePicture
                | Self::SaveMacro
                | Self::SaveStyle
                | Self::SaveMap
                | Self::SaveLook
                | Self::SaveSheet
                | Self::SaveTurntable
                | Self::SaveFrames
        )
    }

    /// The path with an extension that fits the purpose.
    pub fn with_extension(self, path: PathBuf) -> PathBuf {
        let extensions = self.extensions();
        if super::listing::has_extension(&path, &extensions) {
            return path;
        }
        let mut name = path.file_name().unwrap_or_default().to_os_string();
        name.push(".");
        name.push(&extensions[0]);
        path.with_file_name(name)
    }
}

/// A question that is on screen.
pub enum Chooser {
    Own(Box<FileDialog>),
    System { purpose: Purpose, answer: mpsc::Receiver<Option<PathBuf>> },
}

impl Chooser {
    pub fn new(ctx: &egui::Context, purpose: Purpose, use_system: bool, folder: Option<&Path>, name: String) -> Self {
        let home = || directories::UserDirs::new().map(|dirs| dirs.home_dir().to_owned());
        let folder = folder.filter(|folder| folder.is_dir()).map(Path::to_owned);
        let folder = folder.or_else(|| std::env::current_dir().ok()).or_else(home).unwrap_or_default();
        if use_system && has_portal() {
            return Self::ask_system(ctx, purpose, &folder, &name);
        }
        Self::Own(Box::new(FileDialog::new(ctx, purpose, folder, name)))
    }

    fn ask_system(ctx: &egui::Context, purpose: Purpose, folder: &Path, name: &str) -> Self {
        let (sender, answer) = mpsc::channel();
        let dialog = rfd::AsyncFileDialog::new()
            .set_title(purpose.title())
            .set_directory(folder)
            .set_file_name(name)
            .add_filter(purpose.title(), &purpose.extensions())
            .add_filter("All files", &["*"]);
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            let chosen = if purpose.is_save() {
                pollster::block_on(dialog.save_file())
            } else {
                pollster::block_on(dialog.pick_file())
            };
            // The studio may have been closed meanwhile: then nobody listens.
            let _ = sender.send(chosen.map(|file| file.path().to_owned()));
            ctx.request_repaint();
        });
        Self::System { purpose, answer }
    }

    /// `Some` once it was answered.
    pub fn ui(&mut self, ctx: &egui::Context) -> Option<(Purpose, Choice)> {
        match self {
            Self::Own(dialog) => dialog.ui(ctx).map(|choice| (dialog.purpose, choice)),
            Self::System { purpose, answer } => match answer.try_recv() {
                Ok(Some(path)) if purpose.is_save() => Some((*purpose, Choice::Path(purpose.with_extension(path)))),
                Ok(Some(path)) => Some((*purpose, Choice::Path(path))),
                Ok(None) | Err(mpsc::TryRecvError::Disconnected) => Some((*purpose, Choice::Cancelled)),
                Err(mpsc::TryRecvError::Empty) => None,
            },
        }
    }
}

/// Whether a desktop portal can be expected to answer. rfd cannot tell "no portal" from "cancelled", so it is
/// looked up as the bus itself would: a session bus, and a service file for the portal's name.
fn has_portal() -> bool {
    if !cfg!(target_os = "linux") {
        return true;
    }
    let runtime_bus = std::env::var_os("XDG_RUNTIME_DIR").map(|dir| Path::new(&dir).join("bus"));
    let has_bus =
        std::env::var_os("DBUS_SESSION_BUS_ADDRESS").is_some() || runtime_bus.is_some_and(|socket| socket.exists());
    let data_dirs = std::env::var("XDG_DATA_DIRS").unwrap_or_else(|_| "/usr/local/share:/usr/share".to_owned());
    let has_service =
        |dir: &str| Path::new(dir).join("dbus-1/services/org.freedesktop.portal.Desktop.service").exists();
    has_bus && data_dirs.split(':').any(has_service)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_without_a_fitting_extension_gets_one() {
        let with = |purpose: Purpose, name: &str| purpose.with_extension(PathBuf::from(name));
        assert_eq!(with(Purpose::SaveAs, "/a/bob"), Path::new("/a/bob.lorelei"));
        assert_eq!(with(Purpose::SaveAs, "/a/bob.v2"), Path::new("/a/bob.v2.lorelei"));
        assert_eq!(with(Purpose::SaveAs, "/a/bob.LORELEI"), Path::new("/a/bob.LORELEI"));
        assert_eq!(with(Purpose::Export, "bob.usda"), Path::new("bob.usda"));
    }
}
