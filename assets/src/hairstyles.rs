//! The embedded hairstyles: documents without a head, put on the embedded one.

use lorelei_core::document;
use lorelei_core::groom::Groom;
use lorelei_core::light::three_point_rig;
use lorelei_core::look::Look;

use crate::head::mannequin;

/// Key and file of each style; the first is the default.
const STYLES: [(&str, &[u8]); 8] = [
    ("long", include_bytes!("../hairstyles/long.lorelei")),
    ("bob", include_bytes!("../hairstyles/bob.lorelei")),
    ("curls", include_bytes!("../hairstyles/curls.lorelei")),
    ("crop", include_bytes!("../hairstyles/crop.lorelei")),
    ("ponytail", include_bytes!("../hairstyles/ponytail.lorelei")),
    ("bun", include_bytes!("../hairstyles/bun.lorelei")),
    ("braid", include_bytes!("../hairstyles/braid.lorelei")),
    ("knot", include_bytes!("../hairstyles/knot.lorelei")),
];

/// Keys that [`hairstyle`] knows; the first is the default.
pub fn hairstyle_names() -> &'static [&'static str] {
    &["long", "bob", "curls", "crop", "ponytail", "bun", "braid", "knot"]
}

/// Key of the head without hair: where a style of one's own begins.
pub const BARE: &str = "bare";

/// A hairstyle on the embedded head, or with [`BARE`] the head alone; `None` where there is none of that key.
///
/// # Panics
/// If an embedded file is damaged, which a test rules out.
pub fn hairstyle(key: &str) -> Option<Groom> {
    if key == BARE {
        return Some(Groom { name: "Bare head".to_owned(), head: Some(mannequin()), ..Groom::default() });
    }
    let (_, bytes) = STYLES.iter().find(|(name, _)| *name == key)?;
    let groom = document::open_bytes(key, bytes).expect("the embedded hairstyles are valid documents");
    // A style is shape and fibre; light and look are the studio's defaults, not those of the day it was baked.
    Some(Groom { head: Some(mannequin()), lights: three_point_rig(), look: Look::default(), ..groom })
}

/// What the studio opens with.
pub fn default_groom() -> Groom {
    hairstyle(hairstyle_names()[0]).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use lorelei_core::binding::bind_layer;
    use lorelei_core::distance_field::DistanceField;
    use lorelei_core::generate::{Pose, generate};
    use lorelei_core::groom::{Layer, Source};
    use lorelei_core::mesh::SCALP_GROUP;

    use super::*;

    /// A hairstyle's layers with `share` of their strands, in as many clumps.
    fn thinned(groom: &Groom, share: f32) -> Vec<Layer> {
        let thin = |layer: &Layer| {
            let mut layer = layer.clone();
            layer.n_strands = (layer.n_strands as f32 * share) as u32;
            for op in &mut layer.style {
                op.kind.scale_clumps(share);
            }
            layer
        };
        groom.layers.iter().map(thin).collect()
    }

    #[test]
    fn every_name_is_a_hairstyle_of_a_hundred_thousand_strands() {
        assert_eq!(hairstyle_names().len(), STYLES.len());
        for (key, (name, _)) in hairstyle_names().iter().zip(STYLES) {
            assert_eq!(*key, name);
            let groom = hairstyle(key).unwrap();
            assert_eq!(groom.n_strands(), 100_000, "{key}");
            for layer in &groom.layers {
                let Source::HairMesh(mesh) = &layer.source else { panic!("{key} is made of hair meshes") };
                mesh.check().unwrap();
                assert!((100..=250).contains(&mesh.n_bundles()), "{key}: {} bundles", mesh.n_bundles());
            }
            let Source::HairMesh(mesh) = &groom.layers[0].source else { unreachable!() };
            // What is led around something needs a layer for each bend: eight and more for a turn.
            let is_led = ["ponytail", "bun", "braid", "knot"].contains(key);
            let n_layers = if is_led { 12..=56 } else { 6..=10 };
            assert!(n_layers.contains(&mesh.layers.len()), "{key}: {} layers", mesh.layers.len());
        }
        assert!(hairstyle("mullet").is_none());
        assert_eq!(default_groom(), hairstyle(hairstyle_names()[0]).unwrap());
    }

    #[test]
    fn no_hair_runs_through_the_body() {
        let field = DistanceField::from_mesh(&crate::head(), 96).unwrap();
        for key in hairstyle_names() {
            for layer in thinned(&hairstyle(key).unwrap(), 0.15) {
                let binding = bind_layer(&layer, Some(&mannequin()));
                let pose = Pose { field: Some(&field), ..Pose::default() };
                let strands = generate(&binding, &layer, &binding.guides.positions, &pose);
                assert_eq!(strands.n_strands(), layer.n_strands as usize, "{key}, {}", layer.name);
                let deep = strands.points.iter().filter(|&&p| field.sample(p) < -0.05).count();
                let worst = strands.points.iter().map(|&p| field.sample(p)).fold(0.0, f32::min);
                // A vertex in a hundred thousand may stand in a crease that the field's half centimetre rounds off.
                let few = strands.points.len() / 100_000;
                assert!(
                    deep <= few && worst > -0.1,
                    "{key}, {}: {deep} of {} vertices, worst {worst}",
                    layer.name,
                    strands.points.len()
                );
            }
        }
    }

    #[test]
    fn hair_grows_all_over_the_scalp() {
        let head = mannequin();
        let mesh = &head.mesh;
        let scalp = mesh.group(SCALP_GROUP).unwrap();
        // Triangles whose corners are all away from the hairline.
        let mut n_around = vec![0; mesh.positions.len()];
        for &t in &scalp.triangles {
            for v in mesh.triangles[t as usize] {
                n_around[v as usize] += 1;
            }
        }
        for key in hairstyle_names() {
            let mut layers = thinned(&hairstyle(key).unwrap(), 0.05);
            let binding = bind_layer(&layers.remove(0), Some(&head));
            // 4,800 roots on 570 cm2 stand 0.34 cm apart; a bald patch is a few times that.
            let mut farthest = 0.0f32;
            for &t in &scalp.triangles {
                let middle = mesh.corners(t as usize).iter().sum::<glam::Vec3>() / 3.0;
                let is_inner = mesh.triangles[t as usize].iter().all(|&v| n_around[v as usize] >= 5);
                let map = layers[0].density();
                let sparse = map.is_some_and(|map| {
                    let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.uvs[v as usize]);
                    map.sample([(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0]) < 0.8
                });
                if is_inner && !sparse {
                    let nearest = binding.roots.iter().map(|r| r.distance_squared(middle)).fold(f32::MAX, f32::min);
                    farthest = farthest.max(nearest.sqrt());
                }
            }
            assert!(farthest < 0.8, "{key}: no root within {farthest} cm");
        }
    }

    #[test]
    fn a_hairstyle_opens_at_once() {
        let start = Instant::now();
        for key in hairstyle_names() {
            hairstyle(key).unwrap();
        }
        // The budget is 3 s each in release, binding and the first frame included; reading must be nothing.
        assert!(start.elapsed().as_secs_f32() < 3.0, "{:?}", start.elapsed());
    }
}
