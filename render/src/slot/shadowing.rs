//! The slots of whatever asks what of a light arrives.

use lorelei_core::look::Shadowing;
use lorelei_shaders::Link;

/// `lorelei::shadow`: what of a light arrives, for hair and head alike; and `lorelei::shadow_technique` where that is
/// looked up in a map for each light.
pub fn shadowing(choice: Shadowing) -> Vec<Link<'static>> {
    let in_maps = |technique| vec![Link::Slot("shadow", "shadow_maps"), Link::Slot("shadow_technique", technique)];
    match choice {
        Shadowing::DeepOpacity => in_maps("shadow_deep_opacity"),
        Shadowing::Off => vec![Link::Slot("shadow", "shadow_off")],
        Shadowing::ShadowMap => in_maps("shadow_pcf"),
        Shadowing::Exponential => in_maps("shadow_exponential"),
        Shadowing::OpacityMaps => in_maps("shadow_opacity_maps"),
        Shadowing::Clusters => in_maps("shadow_density_clusters"),
        Shadowing::Occupancy => in_maps("shadow_occupancy"),
        Shadowing::DeepShadow => in_maps("shadow_deep_shadow"),
        Shadowing::Voxels => vec![Link::Slot("shadow", "shadow_voxels")],
    }
}
