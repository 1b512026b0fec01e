//! `cargo xtask bake`: make the embedded head and hairstyles anew.
//!
//! Everything in `assets/` comes from here: the mannequin is sculpted from signed distances, meshed,
//! unwrapped and written. Same code, same bytes.

mod glb;
mod hairline;
mod hairstyle;
mod head;
mod mannequin;
mod mesher;
mod sdf;
mod unwrap;

use std::path::Path;

/// Bake everything into `assets/`, or the head and the hairstyles that are named.
pub fn bake(keys: &[String]) -> Result<(), String> {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("assets");
    let mannequin = mannequin::Mannequin::new();
    let head = head::head(&mannequin);
    println!("head: {} triangles, {} vertices", head.triangles.len(), head.positions.len());
    for group in &head.groups {
        println!("  {}: {} triangles", group.name, group.triangles.len());
    }
    write(&assets.join("head.glb"), &glb::to_glb(&head, "mannequin"))?;
    for (key, groom) in hairstyle::all(&head, keys)? {
        let path = assets.join("hairstyles").join(format!("{key}.lorelei"));
        lorelei_core::document::save(&groom, &path).map_err(|error| error.to_string())?;
        println!("wrote {}", path.display());
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    std::fs::write(path, bytes).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    println!("wrote {} ({} KiB)", path.display(), bytes.len() / 1024);
    Ok(())
}
