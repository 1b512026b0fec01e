//! The groom document and everything about it that needs no GPU and no window.
//!
//! Units: centimetres, grams, seconds; right-handed, Y up, Z towards the viewer. Angles are radians
//! unless a name ends in `_deg`. Radii that a person edits are micrometres (`_um`).

pub mod binding;
pub mod brush;
pub mod camera;
pub mod clumps;
pub mod collider;
pub mod curve;
pub mod distance_field;
pub mod document;
pub mod edit;
pub mod generate;
pub mod groom;
pub mod grow;
pub mod guides;
pub mod hair_mesh;
pub mod hash;
pub mod history;
pub mod io;
pub mod layers;
pub mod light;
pub mod lod;
pub mod look;
pub mod maps;
pub mod material;
pub mod mean_value;
pub mod mesh;
pub mod mesh_query;
pub mod motion;
pub mod moved;
pub mod panorama;
pub mod pin;
pub mod point_grid;
pub mod record;
pub mod roots;
pub mod script;
pub mod sculpt;
pub mod simulation;
pub mod strands;
pub mod style;
pub mod take_over;
pub mod wind;
