//! What the studio remembers between runs and what is no part of a document.

use std::path::{Path, PathBuf};

use egui_tiles::Tree;
use serde::{Deserialize, Serialize};

use super::layout::{Panel, default_layout};

/// Recent files kept.
const MAX_RECENT: usize = 12;

/// Saved by eframe under [`SETTINGS_KEY`].
#[derive(Serialize, Deserialize)]
#[serde(default)]
pub struct Settings {
    /// Newest first.
    pub recent: Vec<PathBuf>,
    pub layout: Tree<Panel>,
    /// The system's file dialogs where a portal answers; off: always the studio's own.
    pub use_system_dialogs: bool,
    /// Folder of the last file dialog.
    pub folder: Option<PathBuf>,
    /// Milliseconds that a frame may take while something moves.
    pub moving_budget_ms: f32,
    /// What the steps of the history may keep alive, MiB.
    pub history_mib: u32,
    /// What kept frames of a movement may take, MiB.
    pub frames_mib: u32,
}

/// Where [`Settings`] are in eframe's storage. The number changes when old layouts no longer fit.
pub const SETTINGS_KEY: &str = "lorelei.settings.1";

impl Default for Settings {
    fn default() -> Self {
        Self {
            recent: Vec::new(),
            layout: default_layout(),
            use_system_dialogs: true,
            folder: None,
            moving_budget_ms: 50.0,
            history_mib: 1024,
            frames_mib: 1024,
        }
    }
}

impl Settings {
    /// Put a file at the top of the recent ones.
    pub fn remember(&mut self, path: &Path) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        self.folder = path.parent().map(Path::to_owned);
        self.recent.retain(|kept| *kept != path);
        self.recent.insert(0, path);
        self.recent.truncate(MAX_RECENT);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recent_files_are_unique_newest_first_and_few() {
        let mut settings = Settings::default();
        for i in 0..20 {
            settings.remember(Path::new(&format!("/a/{}.lorelei", i % 15)));
        }
        assert_eq!(settings.recent.len(), MAX_RECENT);
        assert_eq!(settings.recent[0], Path::new("/a/4.lorelei"));
        assert_eq!(settings.folder.as_deref(), Some(Path::new("/a")));
    }
}
