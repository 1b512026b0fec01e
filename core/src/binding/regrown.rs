//! The same strands on a hair mesh that was built otherwise above its root layer: a layer more or less, faces
//! pulled out further, vertices separated or welded. Where strands stand and what they weigh at their corners
//! says the root layer alone, so a topology that changes above it changes which guides the corners have, and
//! which bundles may share a clump: milliseconds, where choosing the places anew takes most of a second.

use std::sync::Arc;

use super::LayerBinding;
use crate::clumps::BundleReach;
use crate::guides::GuideSet;
use crate::hair_mesh::HairMesh;

impl LayerBinding {
    /// The binding of the same layer with `mesh` in place of `before`, as [`super::bind_layer`] would make it;
    /// `None` where other strands grow on it: see [`HairMesh::grows_the_same_strands`].
    pub fn regrown(&self, before: &HairMesh, mesh: &HairMesh) -> Option<Self> {
        if !before.grows_the_same_strands(mesh) || mesh.check().is_err() {
            return None;
        }
        let old_guides = before.chains().of_bundle;
        let chains = mesh.chains();
        let (guides, knots) = GuideSet::of_chains(mesh, &chains);
        let mut regrown = Self { guides, knots, ..self.clone() };
        for (strand_idx, &bundle) in self.bundles.iter().enumerate() {
            let (old, new) = (&old_guides[bundle as usize], &chains.of_bundle[bundle as usize]);
            let of_strand =
                self.influence_offsets[strand_idx] as usize..self.influence_offsets[strand_idx + 1] as usize;
            for influence in &mut regrown.influences[of_strand] {
                let corner = old.iter().position(|&guide| guide == influence.guide_idx)?;
                influence.guide_idx = new[corner];
            }
        }
        regrown.first_knots = regrown.first_knots_in(mesh);
        regrown.measure_offsets();
        let reach = BundleReach::of(mesh);
        if let Some(known) = self.reach.as_deref().filter(|known| **known != reach) {
            regrown.clumps = self.clumps.reaching(&regrown.paths(), known, &reach);
            regrown.reach = Some(Arc::new(reach));
        }
        Some(regrown)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::binding::bind_layer;
    use crate::groom::{Layer, Source};
    use crate::hair_mesh::tests::straight_grid;
    use crate::hair_mesh::{Along, EdgeId, FaceCut, MeshOp, Weld};
    use crate::style::{StyleKind, StyleOp};
    use glam::Vec3;

    fn layer_of(mesh: HairMesh) -> Layer {
        let clump = |strands_per_clump| StyleOp::new(StyleKind::Clump { strands_per_clump, flare: 0.0, stray: 0.0 });
        let mut layer = Layer::new("test", Source::HairMesh(Arc::new(mesh)));
        layer.n_strands = 3000;
        layer.style = vec![clump(20.0), clump(150.0)];
        layer
    }

    #[test]
    fn a_mesh_built_otherwise_above_the_roots_binds_as_if_from_scratch() {
        let mesh = straight_grid(5, 3);
        let before = bind_layer(&layer_of(mesh.clone()), None);
        let along = Along::Direction(Vec3::new(0.2, 1.0, 0.0));
        let shared = |a: usize, b: usize| {
            let (a, b) = (mesh.face(1, a).unwrap(), mesh.face(1, b).unwrap());
            let ends: Vec<u32> = a.iter().copied().filter(|v| b.contains(v)).collect();
            EdgeId::new(1, ends[0], ends[1])
        };
        let ops = [
            MeshOp::Extrude { bundles: vec![3, 4, 8], along, length_cm: 2.0, n_layers: 2, weld: Weld::Neighbours },
            MeshOp::InsertLayer { bundles: vec![0], layer: 1, at: 0.3 },
            MeshOp::RemoveLayer { bundles: vec![0], layer: 2 },
            MeshOp::DeleteTips { bundles: vec![0, 1, 7] },
            MeshOp::SeparateEdges { edges: (0..5).map(|row| shared(2 + 5 * row, 3 + 5 * row)).collect() },
        ];
        let mut n_reach = 0;
        for op in ops {
            let mut changed = mesh.clone();
            changed.apply(&op).unwrap();
            let scratch = bind_layer(&layer_of(changed.clone()), None);
            let regrown = before.regrown(&mesh, &changed).expect("the root layer is the same");
            n_reach += usize::from(regrown.reach != before.reach);
            assert!(regrown == scratch, "{op:?}");
            // And back again.
            assert!(scratch.regrown(&changed, &mesh).is_some_and(|back| back == before), "{op:?} taken back");
        }
        assert!(n_reach > 0, "no operation opened a parting");
    }

    #[test]
    fn another_root_layer_grows_other_strands() {
        let mesh = straight_grid(3, 2);
        let before = bind_layer(&layer_of(mesh.clone()), None);
        let mut divided = mesh.clone();
        divided.apply(&MeshOp::DivideFace { bundle: 4, cut: FaceCut::Fan }).unwrap();
        let mut cropped = mesh.clone();
        cropped.apply(&MeshOp::DeleteBundles { bundles: vec![4] }).unwrap();
        let mut moved = mesh.clone();
        moved.move_vertices(0, |_, p| 1.1 * p);
        for other in [divided, cropped, moved] {
            assert!(before.regrown(&mesh, &other).is_none());
        }
    }
}
