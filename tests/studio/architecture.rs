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

const CRATES: [&str; 8] = ["core", "shaders", "sim", "render", "app", "assets", "tests", "xtask"];

#[test]
fn nobody_builds_on_tests_or_xtask_or_on_the_app() {
    for folder in CRATES {
        assert_absent_if_any(folder, &["lorelei-tests", "xtask", "lorelei"]);
    }
}

/// As [`assert_absent`], for crates that may have no dependencies at all.
fn assert_absent_if_any(folder: &str, absent: &[&str]) {
    for name in dependencies(folder) {
        assert!(!absent.contains(&name.as_str()), "{folder} must not depend on {name}: see ARCHITECTURE.md");
    }
}

#[test]
fn nothing_is_fetched_and_what_was_rejected_is_not_there() {
    let fetching = ["reqwest", "ureq", "hyper", "curl", "isahc", "attohttpc", "tokio"];
    let rejected = ["wesl", "egui-file-dialog", "egui_file_dialog"];
    for folder in CRATES {
        assert_absent_if_any(folder, &fetching);
        assert_absent_if_any(folder, &rejected);
    }
}

#[test]
fn xtask_needs_nothing_unless_it_bakes() {
    let text = std::fs::read_to_string(root().join("xtask").join("Cargo.toml")).expect("xtask has a manifest");
    let (_, dependencies) = text.split_once("[dependencies]").expect("the baker has dependencies");
    for line in dependencies.lines().filter(|line| line.contains('=')) {
        assert!(line.contains("optional = true"), "`cargo xtask` on a bare machine would first build: {line}");
    }
}

#[test]
fn layouts_are_reflected_in_one_place_and_nowhere_written() {
    for (path, text) in all_sources() {
        if path == "shaders/src/layout.rs" || path == "tests/studio/architecture.rs" {
            continue;
        }
        for word in ["BindGroupLayoutDescriptor", "create_bind_group(", "BindGroupEntry"] {
            assert!(!text.contains(word), "{path} has a {word}: kernels bind by name");
        }
    }
}

#[test]
fn files_that_architecture_names_are_there() {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md can be read");
    let is_name = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let mut n = 0;
    for word in text.split(|c: char| !is_name(c)).map(|word| word.trim_end_matches('.')) {
        if CRATES.iter().any(|folder| word.starts_with(&format!("{folder}/"))) {
            assert!(root().join(word).exists(), "ARCHITECTURE.md names {word}, which is not there");
            n += 1;
        }
    }
    assert!(n > 10, "only {n} paths were found in ARCHITECTURE.md");
}

/// Every Rust file of the project, by its path from the root, with its text.
fn all_sources() -> Vec<(String, String)> {
    let mut files = Vec::new();
    for folder in CRATES {
        sources(&root().join(folder), &mut files);
    }
    assert!(files.len() > 20);
    let relative = |path: &String| {
        let path = Path::new(path).strip_prefix(root()).expect("sources are under the root");
        path.to_string_lossy().replace('\\', "/")
    };
    files.into_iter().map(|(path, text)| (relative(&path), text)).collect()
}

/// Every Rust file of a folder.
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
    let named = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md can be read");
    let (_, named) = named.split_once("## Unsafe").expect("it has a section on unsafe");
    let (named, _) = named.split_once("\n## ").expect("and others after it");
    for (path, text) in all_sources() {
        let is_used = text.contains("allow(unsafe_code)") && path != "tests/studio/architecture.rs";
        assert_eq!(named.contains(&path), is_used, "{path}: what ARCHITECTURE.md says of unsafe there is not so");
    }
}

#[test]
fn every_source_file_says_first_what_it_answers() {
    for (path, text) in all_sources() {
        let opens_with_doc =
            text.lines().find(|line| !line.starts_with("#![")).is_some_and(|line| line.starts_with("//!"));
        assert!(opens_with_doc, "{path} does not open with a //! line");
    }
}
