// Slot `sink`: fragments weighted by what those in front of them let through, their number taken from the occupancy map.
// 001, section 3.4.
// slot: sink
#define_import_path lorelei::fragments_ordered
#import lorelei::fragment::{Fragment, depth_of, fixed, fixed_colour, unfixed}
#import lorelei::occupancy::{slice_place, order_of}

@group(0) @binding(auto) var<storage, read> range: array<u32>;
@group(0) @binding(auto) var<storage, read> occupied: array<u32>;
// Of each pixel: weight x radiance, and weight.
@group(0) @binding(auto) var<storage, read_write> sums: array<atomic<u32>>;

fn sink(fragment: Fragment) {
    let nearest = depth_of(range[2u * fragment.place]);
    let farthest = bitcast<f32>(range[2u * fragment.place + 1u]);
    let at = 9u * fragment.place;
    let slabs = vec4<u32>(occupied[at + 4u], occupied[at + 5u], occupied[at + 6u], occupied[at + 7u]);
    let bits = vec4<u32>(occupied[at], occupied[at + 1u], occupied[at + 2u], occupied[at + 3u]);
    let order = order_of(slice_place(fragment.depth, nearest, farthest), slabs, bits);
    // The paper has one alpha for all: here it is the pixel's mean.
    let n = f32(slabs.x + slabs.y + slabs.z + slabs.w);
    let weight = fragment.alpha * exp(-order * unfixed(occupied[at + 8u]) / n);
    let colour = fixed_colour(weight, fragment.colour);
    let to = 4u * fragment.place;
    atomicAdd(&sums[to], colour.x);
    atomicAdd(&sums[to + 1u], colour.y);
    atomicAdd(&sums[to + 2u], colour.z);
    atomicAdd(&sums[to + 3u], fixed(weight));
}
