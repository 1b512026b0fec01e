//! The slot of whatever asks what of a light arrives.

use lorelei_core::look::Shadowing;
use lorelei_shaders::Link;

/// `lorelei::shadow`: what of a light arrives, for hair and head alike.
pub fn shadowing(choice: Shadowing) -> Link<'static> {
    Link::Slot(
        "shadow",
        match choice {
            Shadowing::DeepOpacity => "shadow_deep_opacity",
            Shadowing::Off => "shadow_off",
        },
    )
}
