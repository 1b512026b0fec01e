//! What is embedded in the studio: a mannequin head and hairstyles on it. `assets/SOURCES.md` says how
//! each was made; `cargo xtask bake` makes them anew. Nothing here was fetched.

mod hairstyles;
mod head;

pub use hairstyles::{BARE, default_groom, hairstyle, hairstyle_names};
pub use head::{complete, complete_head, head, mannequin};
