//! Makes the table of every file in `wgsl/`, so that adding a shader needs no list to be edited.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let folder = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("wgsl");
    println!("cargo::rerun-if-changed={}", folder.display());
    let mut files: Vec<PathBuf> = fs::read_dir(&folder)
        .expect("shaders/wgsl can be listed")
        .map(|entry| entry.expect("shaders/wgsl can be listed").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "wgsl"))
        .collect();
    files.sort();
    let mut table = String::from("&[\n");
    for path in files {
        println!("cargo::rerun-if-changed={}", path.display());
        let stem = path.file_stem().expect("a .wgsl file has a stem").to_string_lossy().into_owned();
        writeln!(table, "    ({stem:?}, include_str!({:?})),", path.display().to_string()).expect("a String grows");
    }
    table.push_str("]\n");
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it")).join("embedded.rs");
    fs::write(out, table).expect("OUT_DIR can be written");
}
