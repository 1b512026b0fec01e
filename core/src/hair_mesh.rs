//! Hair meshes: layers of polygons over the scalp through which strands are traced (Yuksel, Schaefer
//! and Keyser 2009).
//!
//! Face `j` of layer `k` stands on face `j` of layer `k - 1`, corner on corner; so a bundle is an index,
//! and the one-to-many mapping of vertices follows from the corners. Storing prisms was rejected: they
//! would repeat what the index already says.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Layers over a root layer. Layer 0 lies on the scalp.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HairMesh {
    pub layers: Vec<HairMeshLayer>,
}

/// One layer of polygons. Positions in head space, centimetres.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct HairMeshLayer {
    pub positions: Vec<Vec3>,
    /// Face of each bundle: at least three corners, as many as the bundle has in layer 0; `None` above
    /// the bundle's tip.
    pub faces: Vec<Option<Vec<u32>>>,
}
