// Density clustering (Mertens, Kautz, Bekaert and Van Reeth 2004): four clusters of hair a texel by k-means over depth.
// A cluster is taken to fill evenly what is sqrt(3) standard deviations before and behind its mean: that is the half
// width of an even distribution.
#define_import_path lorelei::shadow_clusters
#import lorelei::shadow_map::{front_depth}

const N_CLUSTERS: u32 = 4u;
// Numbers of a cluster. While fragments are gathered, fixed point: its opacity, opacity times depth, opacity times the
// square of the distance to the centre. In the end, floats: optical depth, mean depth and half width in cm.
const N_MOMENTS: u32 = 3u;
// Opacity 1; depth is a share of what lies between a texel's nearest and farthest fragment.
const MOMENT_FIXED_POINT: f32 = 1048576.0;

// Centimetres from the nearest to the farthest fragment, never 0.
fn extent(front: u32, back: u32) -> f32 {
    return max(bitcast<f32>(back) - front_depth(front), 1e-3);
}
