// A stable radix sort of 32-bit keys with a value each, eight bits a pass, after Satish, Harris and Garland 2009: blocks
// count their digits, a scan over all counts says where each block's items of each digit go, blocks send them there.
//
// Ranks within a block come from a bit mask for each digit: no subgroup operations, so it runs everywhere.

struct SortPass {
    n_items: u32,
    n_blocks: u32,
    shift: u32,
    pad: u32,
}

@group(0) @binding(auto) var<uniform> sort_pass: SortPass;
@group(0) @binding(auto) var<storage, read> keys_in: array<u32>;
@group(0) @binding(auto) var<storage, read> values_in: array<u32>;
@group(0) @binding(auto) var<storage, read_write> keys_out: array<u32>;
@group(0) @binding(auto) var<storage, read_write> values_out: array<u32>;
// By digit, then by block: how many; after the scan: where the first one goes.
@group(0) @binding(auto) var<storage, read_write> counts: array<u32>;
// Of each group of SCANNED counts: their sum; after the second scan: the sum of those before.
@group(0) @binding(auto) var<storage, read_write> sums: array<u32>;

const N_DIGITS: u32 = 256u;
// Rounds of 256 items that make a block.
const N_ROUNDS: u32 = 16u;
const BLOCK: u32 = N_ROUNDS * N_DIGITS;
// Counts that a workgroup scans.
const SCANNED: u32 = 1024u;

var<workgroup> shared_counts: array<atomic<u32>, N_DIGITS>;

fn digit_of(key: u32) -> u32 {
    return (key >> sort_pass.shift) & (N_DIGITS - 1u);
}

@compute @workgroup_size(256)
fn count(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    atomicStore(&shared_counts[thread], 0u);
    workgroupBarrier();
    for (var round = 0u; round < N_ROUNDS; round++) {
        let item = group.x * BLOCK + round * N_DIGITS + thread;
        if item < sort_pass.n_items {
            atomicAdd(&shared_counts[digit_of(keys_in[item])], 1u);
        }
    }
    workgroupBarrier();
    counts[thread * sort_pass.n_blocks + group.x] = atomicLoad(&shared_counts[thread]);
}

var<workgroup> partial: array<u32, 256>;

// The sum of all threads' numbers before this one; `partial[255]` is the sum of all.
fn sum_before(thread: u32, own: u32) -> u32 {
    partial[thread] = own;
    workgroupBarrier();
    for (var reach = 1u; reach < 256u; reach *= 2u) {
        var left = 0u;
        if thread >= reach {
            left = partial[thread - reach];
        }
        workgroupBarrier();
        partial[thread] += left;
        workgroupBarrier();
    }
    return partial[thread] - own;
}

// Each group of counts into sums of those before it in the group.
@compute @workgroup_size(256)
fn scan(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let n = N_DIGITS * sort_pass.n_blocks;
    let first = group.x * SCANNED + 4u * thread;
    var own = array<u32, 4>();
    var sum = 0u;
    for (var k = 0u; k < 4u; k++) {
        if first + k < n {
            own[k] = counts[first + k];
        }
        sum += own[k];
    }
    var before = sum_before(thread, sum);
    for (var k = 0u; k < 4u; k++) {
        if first + k < n {
            counts[first + k] = before;
        }
        before += own[k];
    }
    if thread == 255u {
        sums[group.x] = before;
    }
}

// The groups' sums into sums of the groups before: one workgroup, each thread a run of them.
@compute @workgroup_size(256)
fn scan_sums(@builtin(local_invocation_index) thread: u32) {
    let n = (N_DIGITS * sort_pass.n_blocks + SCANNED - 1u) / SCANNED;
    let run = (n + 255u) / 256u;
    var sum = 0u;
    for (var k = 0u; k < run; k++) {
        if thread * run + k < n {
            sum += sums[thread * run + k];
        }
    }
    var before = sum_before(thread, sum);
    for (var k = 0u; k < run; k++) {
        let at = thread * run + k;
        if at < n {
            let own = sums[at];
            sums[at] = before;
            before += own;
        }
    }
}

// A bit for each of 256 threads, for each digit.
var<workgroup> masks: array<atomic<u32>, 2048>;
var<workgroup> next: array<u32, 256>;

@compute @workgroup_size(256)
fn scatter(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    let at = thread * sort_pass.n_blocks + group.x;
    next[thread] = counts[at] + sums[at / SCANNED];
    for (var word = 0u; word < 8u; word++) {
        atomicStore(&masks[8u * thread + word], 0u);
    }
    workgroupBarrier();
    for (var round = 0u; round < N_ROUNDS; round++) {
        let item = group.x * BLOCK + round * N_DIGITS + thread;
        let is_there = item < sort_pass.n_items;
        var key = 0u;
        if is_there {
            key = keys_in[item];
        }
        let digit = digit_of(key);
        if is_there {
            atomicOr(&masks[8u * digit + thread / 32u], 1u << (thread % 32u));
        }
        workgroupBarrier();
        if is_there {
            var rank = countOneBits(atomicLoad(&masks[8u * digit + thread / 32u]) & ((1u << (thread % 32u)) - 1u));
            for (var word = 0u; word < thread / 32u; word++) {
                rank += countOneBits(atomicLoad(&masks[8u * digit + word]));
            }
            let to = next[digit] + rank;
            keys_out[to] = key;
            values_out[to] = values_in[item];
        }
        workgroupBarrier();
        // A thread looks after a digit.
        var n = 0u;
        for (var word = 0u; word < 8u; word++) {
            n += countOneBits(atomicLoad(&masks[8u * thread + word]));
            atomicStore(&masks[8u * thread + word], 0u);
        }
        next[thread] += n;
        workgroupBarrier();
    }
}
