//! What the tests across crates share: where things are, and how pictures are compared.

pub mod covering;
pub mod golden;

use std::path::{Path, PathBuf};

/// The workspace's root folder.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the workspace").to_path_buf()
}

/// A file of the shared test data beside the checkout; `None`, said aloud, where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = root().parent()?.join("shared").join("data").join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: no ../shared/data/{name} here");
    None
}
