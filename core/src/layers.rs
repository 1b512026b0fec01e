//! Several layers of one source: the same hair mesh (or guides) traced by another group of strands with a style
//! of its own, as for the frizzy strands of Yuksel, Schaefer and Keyser 2009, fig. 11.
//!
//! Layers share a source by sharing its `Arc`: nothing names a source, so nothing can name a wrong one. An edit
//! of a hair mesh counts for all layers that share it ([`Groom::apply`] lets them go on sharing it). A list of sources beside the layers
//! was rejected: every edit, file and import would have to keep its indices right.

use std::sync::Arc;

use crate::groom::{Groom, Layer, Source};
use crate::hair_mesh::HairMesh;
use crate::strands::Strands;
use crate::style::presets::{Preset, presets};
use crate::style::{StyleKind, StyleOp};

/// A layer to add beside another, on its source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Companion {
    /// A few strands that stand away.
    FlyAways,
    /// More of them, short and crinkled, that break the outline.
    Frizz,
}

impl Companion {
    pub const ALL: [Self; 2] = [Self::FlyAways, Self::Frizz];

    pub fn label(self) -> &'static str {
        match self {
            Self::FlyAways => "Fly-aways",
            Self::Frizz => "Frizz",
        }
    }

    /// Strands for each strand of the layer beside: look.md counts 1-2 % of fly-aways.
    fn share(self) -> f32 {
        match self {
            Self::FlyAways => 0.02,
            Self::Frizz => 0.06,
        }
    }

    fn preset(self) -> Preset {
        let name = match self {
            Self::FlyAways => "Fly-aways",
            Self::Frizz => "Frizz layer",
        };
        presets().into_iter().find(|preset| preset.name == name).expect("the studio's presets have it: tested")
    }

    /// A layer like `main`, on the same source and of the same material, with fewer, finer strands elsewhere on
    /// the scalp. What gives `main` its large shape (waves, curls, bends, partings, ironing) it keeps.
    pub fn beside(self, main: &Layer) -> Layer {
        let n_strands = ((main.n_strands as f32 * self.share()) as u32).max(50);
        let keeps = |op: &&StyleOp| match op.kind {
            StyleKind::Wave { .. }
            | StyleKind::Curl { .. }
            | StyleKind::Bend { .. }
            | StyleKind::Smooth { .. }
            | StyleKind::Part { .. } => true,
            StyleKind::Length { .. }
            | StyleKind::Clump { .. }
            | StyleKind::Frizz { .. }
            | StyleKind::Deviate { .. }
            | StyleKind::Wisp { .. } => false,
        };
        let mut style: Vec<StyleOp> = main.style.iter().filter(keeps).cloned().collect();
        for op in &mut style {
            op.solo = false;
            op.kind.scale_clumps(self.share());
        }
        style.extend(self.preset().for_strands(n_strands));
        Layer {
            name: format!("{} {}", main.name, self.label().to_lowercase()),
            visible: true,
            n_strands,
            radius_um: 0.85 * main.radius_um,
            seed: main.seed.wrapping_add(1 + self as u32),
            style,
            ..main.clone()
        }
    }
}

impl Source {
    /// The same source, shared with no layer: an edit of it then counts for one layer alone.
    pub fn detached(&self) -> Self {
        match self {
            Self::HairMesh(mesh) => Self::HairMesh(Arc::new(HairMesh::clone(mesh))),
            Self::Guides(guides) => Self::Guides(Arc::new(Strands::clone(guides))),
            Self::Strands(strands) => Self::Strands(Arc::new(Strands::clone(strands))),
        }
    }
}

impl Groom {
    /// The layers that trace the same source as layer `layer_idx`, itself among them, ascending; empty where there
    /// is no such layer.
    pub fn layers_sharing(&self, layer_idx: usize) -> Vec<usize> {
        let Some(layer) = self.layers.get(layer_idx) else { return Vec::new() };
        (0..self.layers.len()).filter(|&other| layer.source.is_same(&self.layers[other].source)).collect()
    }

    /// Let layers whose sources are equal share one: files hold a source once a layer.
    pub fn share_equal_sources(&mut self) {
        for later in 1..self.layers.len() {
            let (before, rest) = self.layers.split_at_mut(later);
            if let Some(same) = before.iter().find(|layer| layer.source == rest[0].source) {
                rest[0].source = same.source.clone();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hair_mesh::tests::straight_grid;
    use crate::style::left_out;

    #[test]
    fn companions_share_the_hair_mesh_and_have_a_style_and_a_count_of_their_own() {
        let style = StyleKind::DEFAULTS.map(StyleOp::new).to_vec();
        let mesh = Source::HairMesh(Arc::new(straight_grid(2, 2)));
        let main = Layer { style, ..Layer::new("Hair", mesh) };
        let mut groom = Groom { layers: vec![main.clone()], ..Groom::default() };
        for companion in Companion::ALL {
            let beside = companion.beside(&main);
            assert_eq!(left_out(&beside.style), None);
            assert!(beside.n_strands < main.n_strands / 10 && beside.seed != main.seed);
            assert!(beside.style != main.style && beside.name != main.name);
            groom.layers.push(beside);
        }
        groom.layers.push(Layer::new("Other", Source::HairMesh(Arc::new(straight_grid(2, 2)))));
        assert_eq!(groom.layers_sharing(1), [0, 1, 2]);
        assert_eq!(groom.layers_sharing(3), [3]);
        assert!(groom.layers_sharing(9).is_empty());
        let own = groom.layers[2].source.detached();
        groom.layers[2].source = own;
        assert_eq!((groom.layers_sharing(1), groom.layers_sharing(2)), (vec![0, 1], vec![2]));
        // What was read from a file as two equal sources is one again.
        groom.share_equal_sources();
        assert_eq!(groom.layers_sharing(1), [0, 1, 2, 3]);
    }
}
