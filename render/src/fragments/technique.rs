//! What each transparency does with all fragments: which passes over them, into which buffers, and how those become
//! pixels. One exhaustive `match`; the passes are the `fragments_*.wgsl` and `composite_*.wgsl` of the same names.

use lorelei_core::look::{Antialiasing, DrawingParams, Transparency};
use lorelei_shaders::Link;

/// Samples of a pixel that are kept at a time.
const MOST_SAMPLES: u32 = 4;

/// How a transparency is made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Way {
    /// In the tiles of the rasteriser, or blended in order where a graphics pipeline draws.
    InOrder,
    /// Sorted segments blended in order, by the graphics pipeline whatever the primitive.
    Blended,
    /// The same by slices that light one another.
    Sliced,
    /// Passes over all fragments.
    Passes(Technique),
}

/// Passes over all fragments and what they need.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Technique {
    /// `keep` of the sinks: which samples of a pixel a fragment is opaque in.
    pub keep: Option<&'static str>,
    /// Numbers of 32 bits that each buffer has for each pixel.
    pub words: Vec<(&'static str, u32)>,
    /// `sink` of each pass over all fragments, in their order.
    pub sinks: Vec<&'static str>,
    /// File of the kernel that makes pixels of what the sinks have gathered.
    pub composite: &'static str,
    /// Samples of a pixel that are kept at a time, and in all.
    pub n_samples: u32,
    pub n_all_samples: u32,
    /// Times that everything is done again.
    pub n_repeats: u32,
    /// A repeat only follows where the one before found something.
    pub stops: bool,
}

impl Technique {
    /// The links of a sink.
    pub fn links(&self, sink: &'static str) -> Vec<Link<'static>> {
        let mut links = vec![Link::Slot("sink", sink)];
        links.extend(self.keep.map(|keep| Link::Slot("keep", keep)));
        links
    }
}

/// Samples of a pixel that an antialiasing tells apart.
fn samples_of(antialiasing: Antialiasing) -> u32 {
    match antialiasing {
        Antialiasing::None | Antialiasing::Analytic | Antialiasing::Super2 | Antialiasing::Super3 => 1,
        Antialiasing::Msaa4 | Antialiasing::AlphaToCoverage => 4,
    }
}

/// How a transparency is made under an antialiasing.
pub(crate) fn way(transparency: Transparency, antialiasing: Antialiasing, params: &DrawingParams) -> Way {
    let sampled = |keep, n_all_samples: u32| {
        let n_samples = n_all_samples.min(MOST_SAMPLES);
        Way::Passes(Technique {
            keep: Some(keep),
            words: vec![("nearest", n_samples), ("visible", n_samples), ("gathered", 4)],
            sinks: vec!["fragments_nearest", "fragments_visible"],
            composite: "composite_visible",
            n_samples,
            n_all_samples,
            n_repeats: n_all_samples.div_ceil(n_samples),
            stops: false,
        })
    };
    let passes = |words: &[(&'static str, u32)], sinks: &[&'static str], composite| Technique {
        keep: None,
        words: words.to_vec(),
        sinks: sinks.to_vec(),
        composite,
        n_samples: 1,
        n_all_samples: 1,
        n_repeats: 1,
        stops: false,
    };
    match transparency {
        Transparency::FrontToBack => Way::InOrder,
        Transparency::Sorted => Way::Blended,
        Transparency::HalfAngle => Way::Sliced,
        Transparency::Opaque => sampled("keep_opaque", samples_of(antialiasing)),
        Transparency::AlphaTest => sampled("keep_alpha_test", samples_of(antialiasing)),
        Transparency::Hashed => sampled("keep_hashed", samples_of(antialiasing)),
        Transparency::AlphaToCoverage => sampled("keep_alpha_to_coverage", 4),
        Transparency::Stochastic => sampled("keep_stochastic", params.n_samples.max(1)),
        Transparency::ThreeSubsets => sampled("keep_subset", 3),
        Transparency::WeightedAverage => Way::Passes(passes(&[("sums", 5)], &["fragments_sum"], "composite_weighted")),
        Transparency::DepthPeeling => Way::Passes(Technique {
            n_repeats: params.n_layers.max(1),
            stops: true,
            ..passes(
                &[("nearest", 1), ("peeled", 1), ("sums", 4), ("gathered", 4)],
                &["fragments_peel_find", "fragments_peel_add"],
                "composite_peel",
            )
        }),
        Transparency::Occupancy => Way::Passes(passes(
            &[("range", 2), ("occupied", 9), ("sums", 4)],
            &["fragments_range", "fragments_occupy", "fragments_ordered"],
            "composite_occupancy",
        )),
        Transparency::KNearest => {
            let n = params.n_nearest.max(1);
            Way::Passes(passes(
                &[("nearest", n), ("kept", 2 * n), ("slabs", 8), ("sums", 4)],
                &["fragments_k_find", "fragments_k_add", "fragments_k_tail"],
                "composite_k_nearest",
            ))
        }
    }
}

#[cfg(test)]
mod tests {
    use lorelei_core::look::Choice;

    use super::*;

    #[test]
    fn a_pixel_of_any_technique_fits_a_small_device() {
        let params = DrawingParams { n_samples: 64, n_layers: 256, n_nearest: 8, ..DrawingParams::default() };
        for &transparency in Transparency::ALL {
            for &antialiasing in Antialiasing::ALL {
                let Way::Passes(technique) = way(transparency, antialiasing, &params) else { continue };
                let words: u32 = technique.words.iter().map(|(_, words)| words).sum();
                assert!(words <= 40, "{transparency:?}: {words} words a pixel");
                assert!(technique.n_repeats * technique.n_samples >= technique.n_all_samples);
            }
        }
    }
}
