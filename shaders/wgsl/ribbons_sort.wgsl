// Segments from back to front: a counting sort over logarithmic depth.
//
// One pass over 2^18 buckets instead of several over digits: a bucket is 25 um deep at a metre, less than a hair, so
// the order within one does not matter.
#import lorelei::camera::{View, project}

struct Layer {
    first_vertex: u32,
    n_strands: u32,
    vertices_per_strand: u32,
    n_segments: u32,
}

@group(0) @binding(auto) var<uniform> view: View;
@group(0) @binding(auto) var<uniform> layer: Layer;
@group(0) @binding(auto) var<storage, read> vertices: array<vec4<f32>>;
@group(0) @binding(auto) var<storage, read_write> buckets: array<atomic<u32>>;
@group(0) @binding(auto) var<storage, read_write> order: array<u32>;

const N_BUCKETS: u32 = 262144u;
const FIRST: u32 = 0x80000000u;
const LAST: u32 = 0x40000000u;

struct Segment {
    bucket: u32,
    packed: u32,
}

fn segment(segment_idx: u32) -> Segment {
    let per_strand = layer.vertices_per_strand - 1u;
    let strand_idx = segment_idx / per_strand;
    let k = segment_idx % per_strand;
    let vertex_idx = layer.first_vertex + strand_idx * layer.vertices_per_strand + k;
    let middle = 0.5 * (vertices[vertex_idx].xyz + vertices[vertex_idx + 1u].xyz);
    let depth = clamp(project(view, middle).z, view.near, view.far);
    let nearness = 1.0 - log(depth / view.near) / log(view.far / view.near);
    var out: Segment;
    out.bucket = min(u32(nearness * f32(N_BUCKETS)), N_BUCKETS - 1u);
    out.packed = vertex_idx | select(0u, FIRST, k == 0u) | select(0u, LAST, k + 1u == per_strand);
    return out;
}

@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let segment_idx = id.x + id.y * n.x * 64u;
    if segment_idx < layer.n_segments {
        atomicAdd(&buckets[segment(segment_idx).bucket], 1u);
    }
}

const N_THREADS: u32 = 256u;
var<workgroup> sums: array<u32, N_THREADS>;

// Each bucket's place in the order: one workgroup, each thread a run of buckets.
@compute @workgroup_size(256)
fn place(@builtin(local_invocation_index) thread_idx: u32) {
    let n_own = N_BUCKETS / N_THREADS;
    var sum = 0u;
    for (var i = 0u; i < n_own; i++) {
        sum += atomicLoad(&buckets[thread_idx * n_own + i]);
    }
    sums[thread_idx] = sum;
    workgroupBarrier();
    var start = 0u;
    for (var i = 0u; i < thread_idx; i++) {
        start += sums[i];
    }
    for (var i = 0u; i < n_own; i++) {
        let bucket = thread_idx * n_own + i;
        let n = atomicLoad(&buckets[bucket]);
        atomicStore(&buckets[bucket], start);
        start += n;
    }
}

@compute @workgroup_size(64)
fn scatter(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) n: vec3<u32>) {
    let segment_idx = id.x + id.y * n.x * 64u;
    if segment_idx < layer.n_segments {
        let found = segment(segment_idx);
        order[atomicAdd(&buckets[found.bucket], 1u)] = found.packed;
    }
}
