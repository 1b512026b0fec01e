//! What ARCHITECTURE.md says is deliberately absent, is absent.

use std::path::Path;

use lorelei_tests::root;

/// The names under `[dependencies]` and `[dev-dependencies]` of one crate.
fn dependencies(folder: &str) -> Vec<String> {
    let path = root().join(folder).join("Cargo.toml");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|why| panic!("{}: {why}", path.display()));
    let mut in_dependencies = false;
    let mut names = Vec::new();
    for line in text.lines() {
        if line.starts_with('[') {
            in_dependencies = line.contains("dependencies");
        } else if in_dependencies && let Some(end) = line.find(['.', ' ', '=']) {
            names.push(line[..end].to_owned());
        }
    }
    names
}

fn assert_absent(folder: &str, absent: &[&str]) {
    let names = dependencies(folder);
    assert!(!names.is_empty(), "{folder} has no dependencies: is its Cargo.toml read rightly?");
    for name in names {
        assert!(!absent.contains(&name.as_str()), "{folder} must not depend on {name}: see ARCHITECTURE.md");
    }
}

#[test]
fn core_has_no_gpu_and_no_window() {
    assert_absent(
        "core",
        &["wgpu", "naga", "egui", "eframe", "lorelei-shaders", "lorelei-sim", "lorelei-render", "lorelei-assets"],
    );
}

#[test]
fn shaders_know_nothing_of_hair_in_rust() {
    assert_absent("shaders", &["egui", "eframe", "lorelei-core", "lorelei-sim", "lorelei-render", "lorelei-assets"]);
}

#[test]
fn sim_and_render_do_not_know_each_other_or_the_window() {
    assert_absent("sim", &["egui", "eframe", "lorelei-render"]);
    assert_absent("render", &["egui", "eframe", "lorelei-sim"]);
}

#[test]
fn assets_need_no_gpu() {
    assert_absent("assets", &["wgpu", "egui", "eframe", "lorelei-shaders", "lorelei-render", "lorelei-sim"]);
}

/// Every Rust file of the project.
fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).expect("a project folder can be read").flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push((
                path.to_string_lossy().into_owned(),
                std::fs::read_to_string(&path).expect("a source file is text"),
            ));
        }
    }
}

#[test]
fn unsafe_stands_only_where_architecture_says() {
    let mut files = Vec::new();
    for folder in ["core", "shaders", "sim", "render", "app", "assets", "tests", "xtask"] {
        sources(&root().join(folder), &mut files);
    }
    assert!(files.len() > 20);
    let named = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md can be read");
    for (path, text) in files {
        let relative = Path::new(&path)
            .strip_prefix(root())
            .expect("sources are under the root")
            .to_string_lossy()
            .replace('\\', "/");
        if text.contains("allow(unsafe_code)") && !relative.ends_with("architecture.rs") {
            assert!(named.contains(&relative), "{relative} uses unsafe and ARCHITECTURE.md does not name it");
        }
    }
}

#[test]
fn every_source_file_says_first_what_it_answers() {
    let mut files = Vec::new();
    for folder in ["core", "shaders", "sim", "render", "app", "assets", "tests", "xtask"] {
        sources(&root().join(folder), &mut files);
    }
    for (path, text) in files {
        let opens_with_doc =
            text.lines().find(|line| !line.starts_with("#![")).is_some_and(|line| line.starts_with("//!"));
        assert!(opens_with_doc, "{path} does not open with a //! line");
    }
}
