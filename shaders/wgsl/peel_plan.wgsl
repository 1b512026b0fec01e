// The next layer's passes, or none where the last one found nothing: the occlusion query of depth peeling, answered without
// leaving the GPU.

// Workgroups over segments, over pixels (4 numbers each, the fourth unused), and vertices and instances of a draw.
@group(0) @binding(auto) var<storage, read> full_arguments: array<u32>;
@group(0) @binding(auto) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(auto) var<storage, read_write> n_peeled: atomic<u32>;

override IS_FIRST: u32 = 0u;

@compute @workgroup_size(1)
fn plan() {
    let goes_on = IS_FIRST == 1u || atomicLoad(&n_peeled) > 0u;
    for (var k = 0u; k < 12u; k++) {
        arguments[k] = select(0u, full_arguments[k], goes_on);
    }
    atomicStore(&n_peeled, 0u);
}
