// What a strand covers of a pixel as the antialiasing (slot `cover`) has it, whoever found the pixel.
#define_import_path lorelei::cover_of
#import lorelei::cover::{N_SAMPLES, sample_offset, settled, samples_of}
#import lorelei::coverage::{Strip, strip_coverage, is_inside}
#import lorelei::hash::{combine, unit}

struct Cover {
    // Share of the pixel.
    area: f32,
    // Samples of it.
    mask: u32,
}

// The pixel's own number in 0-1, for rounding.
fn dither_of(pixel: vec2<u32>) -> f32 {
    return unit(combine(pixel.x, pixel.y));
}

fn of_area(area: f32, pixel: vec2<u32>) -> Cover {
    let rounded = settled(area, dither_of(pixel));
    return Cover(rounded, samples_of(rounded));
}

fn of_mask(mask: u32) -> Cover {
    return Cover(f32(countOneBits(mask)) / f32(max(N_SAMPLES, 1u)), mask);
}

// Of a strip of direction `u`; `place` is the pixel's middle along and across it, `t` its share of the length.
fn cover_of_strip(strip: Strip, place: vec2<f32>, t: f32, u: vec2<f32>, pixel: vec2<u32>) -> Cover {
    if N_SAMPLES == 0u {
        return of_area(strip_coverage(strip, place, t), pixel);
    }
    var mask = 0u;
    for (var k = 0u; k < N_SAMPLES; k++) {
        let d = sample_offset(k);
        let sampled = place + vec2<f32>(dot(d, u), d.y * u.x - d.x * u.y);
        mask |= select(0u, 1u << k, is_inside(strip, sampled));
    }
    return of_mask(mask);
}

// Of a strip that the graphics pipeline draws: its share of a box as wide as a pixel, across it. `slope` is how `across`
// changes from pixel to pixel.
fn cover_of_ribbon(across: f32, slope: vec2<f32>, half_width: f32, pixel: vec2<u32>) -> Cover {
    if N_SAMPLES == 0u {
        return of_area(clamp(min(across + 0.5, half_width) - max(across - 0.5, -half_width), 0.0, 1.0), pixel);
    }
    var mask = 0u;
    for (var k = 0u; k < N_SAMPLES; k++) {
        mask |= select(0u, 1u << k, abs(across + dot(slope, sample_offset(k))) <= half_width);
    }
    return of_mask(mask);
}

// Of a line of a pixel. It has no edges to sample: its width is its alpha.
fn cover_of_line(half_width: f32, pixel: vec2<u32>) -> Cover {
    let cover = of_area(saturate(2.0 * half_width), pixel);
    return Cover(cover.area, select(cover.mask, (1u << max(N_SAMPLES, 1u)) - 1u, N_SAMPLES > 0u));
}
