//! The command line as a process: what it says, how it exits, and what it leaves when it is killed.

#[path = "../window/animated.rs"]
mod animated;
mod hair_mesh;
mod simulate;

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use glam::Vec3;
use lorelei_core::document;
use lorelei_core::groom::{Groom, Layer};
use lorelei_core::strands::Strands;

fn lorelei(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lorelei")).args(arguments).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn groom(n_strands: u32) -> Groom {
    let mut strands = Strands::default();
    for s in 0..n_strands {
        // Numbers that do not pack well: the golden ratio's multiples.
        let at = |k: u32| ((s * 16 + k) as f32 * 0.618_034).fract();
        strands.push(&(0..16).map(|k| Vec3::new(at(k), at(k + 7), at(k + 11))).collect::<Vec<_>>());
    }
    Groom { layers: vec![Layer::from_strands("hair", strands)], ..Groom::default() }
}

#[test]
fn edits_are_replayed_and_a_refusal_says_which_and_why_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = folder.join("a.lorelei");
    document::save(&groom(3), &file).unwrap();
    let write = |name: &str, list: &str| std::fs::write(folder.join(name), list).unwrap();
    write("good.ron", "[(label: \"Name\", edit: SetName(\"x\")), (set: [\"shadowing=off\"])]");
    write("bad.ron", "[SetName(\"y\"), SetLayerName(layer_idx: 4, name: \"z\")]");
    write("typo.ron", "[\n  SetNme(\"y\"),\n]");

    let done = lorelei(folder, &["apply", "a.lorelei", "--edits", "good.ron", "--out", "b.lorelei", "--json"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!((json["edits"].as_u64(), json["strands"].as_u64()), (Some(2), Some(3)));
    let changed = document::open(&folder.join("b.lorelei")).unwrap();
    assert_eq!((changed.name.as_str(), changed.layers == groom(3).layers), ("x", true));

    let before = std::fs::read(&file).unwrap();
    let refused = lorelei(folder, &["apply", "a.lorelei", "--edits", "bad.ron", "--out", "a.lorelei", "--json"]);
    assert_eq!(refused.status.code(), Some(1));
    let json: serde_json::Value = serde_json::from_slice(&refused.stdout).unwrap();
    assert_eq!(json["refused"]["number"].as_u64(), Some(2));
    assert!(text(&refused.stderr).contains("edit 2 of 2: there is no layer 4"), "{}", text(&refused.stderr));
    assert!(std::fs::read(&file).unwrap() == before);

    let typo = lorelei(folder, &["apply", "a.lorelei", "--edits", "typo.ron", "--out", "c.lorelei"]);
    assert_eq!(typo.status.code(), Some(1));
    let told = text(&typo.stderr);
    assert!(told.contains("typo.ron:2:") && told.contains("--list"), "{told}");
    assert!(!folder.join("c.lorelei").exists());

    let usage = |arguments: &[&str]| lorelei(folder, arguments).status.code();
    assert_eq!(usage(&["apply", "a.lorelei"]), Some(2));
    assert_eq!(usage(&["apply", "a.lorelei", "--edits", "good.ron", "--out", "b.obj"]), Some(2));
    let list = lorelei(folder, &["apply", "--list"]);
    assert!(list.status.success() && text(&list.stdout).contains("SetLayerName"));
}

/// Whether a save into the folder has begun and not ended: its temporary file is there and has content.
fn is_saving(folder: &Path) -> bool {
    std::fs::read_dir(folder).unwrap().flatten().any(|entry| {
        entry.file_name().to_string_lossy().ends_with(".tmp") && entry.metadata().is_ok_and(|m| m.len() > 100_000)
    })
}

#[cfg(unix)]
#[test]
fn a_process_killed_in_the_middle_of_a_save_leaves_the_old_file_whole() {
    use std::os::unix::process::ExitStatusExt;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let file = folder.join("large.lorelei");
    // 20 MB that do not pack: saving takes a second or more.
    document::save(&groom(100_000), &file).unwrap();
    let before = std::fs::read(&file).unwrap();
    std::fs::write(folder.join("e.ron"), "[SetName(\"x\")]").unwrap();
    let mut process = Command::new(env!("CARGO_BIN_EXE_lorelei"))
        .args(["apply", "large.lorelei", "--edits", "e.ron", "--out", "large.lorelei"])
        .current_dir(folder)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !is_saving(folder) {
        assert!(process.try_wait().unwrap().is_none(), "the save was over before it was seen");
        assert!(start.elapsed() < Duration::from_mins(3), "the save never began");
        std::thread::sleep(Duration::from_millis(1));
    }
    process.kill().unwrap();
    assert_eq!(process.wait().unwrap().signal(), Some(9), "killed while it was saving");
    assert!(std::fs::read(&file).unwrap() == before, "the old file is as it was");
    // The next save goes through, and takes away what the dead one left.
    let done = lorelei(folder, &["apply", "large.lorelei", "--edits", "e.ron", "--out", "large.lorelei"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert_eq!(document::open(&file).unwrap().name, "x");
    assert!(!is_saving(folder), "the temporary file of the dead process is gone");
}
