// Colours of layers, slices and clusters. Twin of core/src/look/view.rs.
#define_import_path lorelei::view_parts

// Hair that is in none.
const NO_PART: u32 = 0xFFFFFFFFu;

// From red over green to violet; neighbours are told apart by every second one being darker.
fn part_colour(part: u32, n: u32) -> vec3<f32> {
    let hue = 0.8 * (f32(part) + 0.5) / f32(max(n, 1u));
    let wave = abs(fract(hue + 1.0 - vec3<f32>(0.0, 1.0 / 3.0, 2.0 / 3.0)) * 6.0 - 3.0) - 1.0;
    let value = select(1.0, 0.75, part % 2u == 1u);
    return value * (1.0 - 0.85 * (1.0 - saturate(wave)));
}
