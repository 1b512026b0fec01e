//! Deep shadow maps (Lokovic and Veach 2000): every fragment of every texel, sorted, made into a polyline of transmittance
//! over depth that is off by no more than a stated share of the light.
//!
//! Fragments are counted, given room, and scattered. How many there are is known on the GPU alone, so that the room is a
//! guess. Where it is too small (curls are longer than the ball is wide), every texel keeps its share of its fragments, and
//! these stand for the others: grain, and no hole. Nodes take the place of the fragments: compression makes look-ups
//! shorter, and no buffer smaller.
//!
//! Waiting for the count was rejected: a frame would take as long as the way to the GPU and back.

use super::params::MapSize;
use super::plan::{Plan, SceneSize, Step, Words};

/// Texels of a thread that gives room. Twin of `N_PER_THREAD` in `shadow_lists.wgsl`.
const N_PER_THREAD: u64 = 16;

/// Coarser maps show more than fewer, wider strands do, texels.
const LEAST_RESOLUTION: u64 = 256;

pub(super) fn plan(size: MapSize, scene: &SceneSize) -> Plan {
    // A segment touches a texel more than its run is long. Strands are taken to run once through the map, the ball's
    // diameter, on the average: hair is mostly shorter, and is seen at an angle.
    let n_of_a_light = scene.n_strands * u64::from(size.resolution) + scene.n_segments;
    let of_lists = |entry| Step::Items { file: "shadow_lists", entry, n: size.n_texels().div_ceil(N_PER_THREAD) };
    Plan {
        buffers: vec![
            Words::cleared("shadow_wanted", "shadow.deep_shadow.wanted", size.n_texels()),
            Words::cleared("shadow_counts", "shadow.deep_shadow.counts", size.n_texels()),
            Words::written("shadow_offsets", "shadow.deep_shadow.offsets", size.n_texels()),
            Words::cleared("shadow_taken", "shadow.deep_shadow.taken", 3),
            Words::written("shadow_fragments", "shadow.deep_shadow.fragments", n_of_a_light * u64::from(size.n_lights)),
        ],
        steps: vec![
            Step::Walk { sink: "shadow_sink_count" },
            of_lists("total"),
            of_lists("allocate"),
            Step::Walk { sink: "shadow_sink_scatter" },
            Step::Items { file: "shadow_lists", entry: "finish", n: size.n_texels() },
        ],
    }
}

/// Most strands that can cast: their fragments fit one binding in maps of [`LEAST_RESOLUTION`] texels.
pub(super) fn most_strands(binding_bytes: u64, n_lights: usize, segments_per_strand: u64) -> u32 {
    let n_of_a_strand = (LEAST_RESOLUTION + segments_per_strand) * n_lights.max(1) as u64;
    u32::try_from(binding_bytes / 4 / n_of_a_strand).unwrap_or(u32::MAX)
}

/// Lokovic and Veach's greedy compression of (step of depth, share of the light left) to fewer such nodes: at every point
/// the polyline is off by `tolerance` at most. Steps grow and light falls from point to point, and along the polyline. Twin of `compress` in `shadow_lists.wgsl`.
pub fn compress(points: &[(u32, f32)], tolerance: f32) -> Vec<(u32, f32)> {
    let Some(&(mut from_step, mut from_light)) = points.first() else { return Vec::new() };
    let mut nodes = vec![(from_step, from_light)];
    let (mut least, mut most, mut last_step) = (f32::MIN, f32::MAX, from_step);
    for &(step, light) in &points[1..] {
        let slope = |light: f32, from: (u32, f32)| (light - from.1) / (step - from.0) as f32;
        let (lower, upper) =
            (slope(light - tolerance, (from_step, from_light)), slope(light + tolerance, (from_step, from_light)));
        if f32::max(least, lower) > f32::min(most, upper) {
            from_light += f32::min(0.5 * (least + most), 0.0) * (last_step - from_step) as f32;
            from_step = last_step;
            nodes.push((from_step, from_light));
            least = slope(light - tolerance, (from_step, from_light));
            most = slope(light + tolerance, (from_step, from_light));
        } else {
            (least, most) = (least.max(lower), most.min(upper));
        }
        last_step = step;
    }
    if last_step > from_step {
        let slope = f32::min(0.5 * (least + most), 0.0);
        nodes.push((last_step, from_light + slope * (last_step - from_step) as f32));
    }
    nodes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_polyline_is_within_the_tolerance_at_every_point_and_much_shorter() {
        let mut light = 1.0;
        let points: Vec<(u32, f32)> = (0..300_u32)
            .map(|k| {
                light *= 1.0 - 0.03 * lorelei_core::hash::random(7, k);
                (40 * k + k * k % 17, light)
            })
            .collect();
        let mut before = usize::MAX;
        for tolerance in [0.001, 0.01, 0.05] {
            let nodes = compress(&points, tolerance);
            let at = |step: u32| {
                let behind = nodes.partition_point(|node| node.0 <= step).clamp(1, nodes.len() - 1);
                let (a, b) = (nodes[behind - 1], nodes[behind]);
                a.1 + (b.1 - a.1) * (step - a.0) as f32 / (b.0 - a.0) as f32
            };
            let most = points.iter().map(|&(step, light)| (at(step) - light).abs()).fold(0.0, f32::max);
            assert!(most <= 1.001 * tolerance + 1e-5, "{tolerance}: off by {most}");
            assert!(nodes.len() < before, "{tolerance}: {} nodes", nodes.len());
            before = nodes.len();
        }
        assert!(before < 20, "{before} nodes of 300 points");
        assert_eq!(compress(&points, 0.0).len(), points.len());
    }
}
