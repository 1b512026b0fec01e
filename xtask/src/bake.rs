//! `cargo xtask bake`: make the embedded head and hairstyles anew.
//!
//! Everything in `assets/` comes from here: the mannequin is sculpted from signed distances, meshed,
//! unwrapped and written. Same code, same bytes: `cargo xtask bake check` bakes and compares, and writes nothing.

mod glb;
mod hairline;
mod hairstyle;
mod head;
mod mannequin;
mod mesher;
mod sdf;
mod unwrap;

use std::path::{Path, PathBuf};

/// Bake everything into `assets/`, or the head and the hairstyles that are named. After `check`, compare with what is
/// there instead.
pub fn bake(args: &[String]) -> Result<(), String> {
    let (is_check, keys) = match args {
        [first, keys @ ..] if first == "check" => (true, keys),
        keys => (false, keys),
    };
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("assets");
    if !is_check {
        return bake_into(&assets, keys).map(|_| ());
    }
    let folder = std::env::temp_dir().join(format!("lorelei-bake-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("hairstyles")).map_err(|error| error.to_string())?;
    let outcome = bake_into(&folder, keys).and_then(|files| differing(&files, &folder, &assets));
    std::fs::remove_dir_all(&folder).map_err(|error| error.to_string())?;
    match outcome?.as_slice() {
        [] => Ok(()),
        files => Err(format!("the code makes others: {}", files.join(", "))),
    }
}

/// What was written, as paths in the folder.
fn bake_into(folder: &Path, keys: &[String]) -> Result<Vec<String>, String> {
    let mannequin = mannequin::Mannequin::new();
    let head = head::head(&mannequin);
    println!("head: {} triangles, {} vertices", head.triangles.len(), head.positions.len());
    for group in &head.groups {
        println!("  {}: {} triangles", group.name, group.triangles.len());
    }
    let mut files = vec!["head.glb".to_owned()];
    let path = folder.join(&files[0]);
    std::fs::write(&path, glb::to_glb(&head, "mannequin"))
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    for (key, groom) in hairstyle::all(&head, keys)? {
        let file = format!("hairstyles/{key}.lorelei");
        lorelei_core::document::save(&groom, &folder.join(&file)).map_err(|error| error.to_string())?;
        println!("made {file}");
        files.push(file);
    }
    Ok(files)
}

/// Those of the files that are not the same in both folders.
fn differing(files: &[String], a: &Path, b: &Path) -> Result<Vec<String>, String> {
    let read = |path: PathBuf| std::fs::read(&path).map_err(|error| format!("cannot read {}: {error}", path.display()));
    let mut differing = Vec::new();
    for file in files {
        if read(a.join(file))? != read(b.join(file))? {
            differing.push(file.clone());
        }
    }
    Ok(differing)
}
