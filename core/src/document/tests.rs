//! Documents: what is saved comes back bit for bit, and what is no document is refused.

use std::io::{Read, Write};
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use proptest::prelude::*;

use super::{DocumentError, open, open_bytes, save};
use crate::groom::{Groom, Head, Layer, Source, StrandCount};
use crate::hair_mesh::{HairMesh, HairMeshLayer};
use crate::io::{ReadError, Space};
use crate::maps::tests::any_kind;
use crate::maps::{MapKind, ScalpMap};
use crate::mesh::{FaceGroup, TriMesh};
use crate::panorama::Panorama;
use crate::sculpt::{self, Sculpt, SculptChange, SculptGuide, SculptLayer, SculptMask, SculptRoots};
use crate::strands::Strands;

/// Any finite number, zeros of both signs and the smallest included.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        -1e3f32..1e3,
        Just(-0.0f32),
        Just(f32::MIN_POSITIVE / 8.0),
        Just(0.1f32),
        prop::num::f32::NORMAL.prop_filter("places are within a kilometre", |v| v.abs() < 1e5),
    ]
}

fn place() -> impl Strategy<Value = Vec3> {
    [number(), number(), number()].prop_map(Vec3::from_array)
}

fn some<T>(values: Vec<T>, is_there: bool) -> Vec<T> {
    if is_there { values } else { Vec::new() }
}

fn strands() -> impl Strategy<Value = Strands> {
    let strand = prop::collection::vec((place(), number(), [number(), number(), number()], number()), 2..6);
    let attributes = (any::<[bool; 5]>(), prop::collection::vec((any::<u32>(), [number(), number()]), 5));
    (prop::collection::vec(strand, 0..5), attributes).prop_map(|(curves, (has, per_strand))| {
        let mut out = Strands::default();
        for curve in &curves {
            out.points.extend(curve.iter().map(|point| point.0));
            out.radii_um.extend(curve.iter().map(|point| point.1));
            out.colours.extend(curve.iter().map(|point| point.2));
            out.opacities.extend(curve.iter().map(|point| point.3));
            out.offsets.push(out.points.len() as u32);
        }
        out.radii_um = some(out.radii_um, has[0]);
        out.colours = some(out.colours, has[1]);
        out.opacities = some(out.opacities, has[2]);
        out.ids = some(per_strand[..curves.len()].iter().map(|values| values.0).collect(), has[3]);
        out.root_uvs = some(per_strand[..curves.len()].iter().map(|values| values.1).collect(), has[4]);
        out
    })
}

/// A strip of quads, extruded; some bundles end early.
fn hair_mesh() -> impl Strategy<Value = HairMesh> {
    (1..4usize, 2..5usize, prop::collection::vec(1..5usize, 3), prop::collection::vec(place(), 40)).prop_map(
        |(n_bundles, n_layers, heights, places)| {
            let face = |bundle: usize| {
                vec![2 * bundle as u32, 2 * bundle as u32 + 2, 2 * bundle as u32 + 3, 2 * bundle as u32 + 1]
            };
            let layers = (0..n_layers)
                .map(|k| HairMeshLayer {
                    positions: (0..2 * n_bundles + 2).map(|v| places[(v + 7 * k) % 40]).collect(),
                    faces: (0..n_bundles).map(|bundle| (k < heights[bundle].max(1)).then(|| face(bundle))).collect(),
                    pinned: (0..2 * n_bundles as u32 + 2).filter(|v| (v + k as u32).is_multiple_of(3)).collect(),
                })
                .collect();
            HairMesh { layers }
        },
    )
}

fn mesh() -> impl Strategy<Value = TriMesh> {
    (prop::collection::vec(place(), 3..9), any::<[bool; 2]>(), any::<u8>()).prop_map(|(positions, has, seed)| {
        let n = positions.len() as u32;
        let triangles: Vec<[u32; 3]> = (0..n).map(|v| [v, (v + 1) % n, (v + u32::from(seed)) % n]).collect();
        let normals = some(positions.clone(), has[0]);
        let uvs = some(positions.iter().map(|p| [p.x, p.y]).collect(), has[1]);
        let groups = vec![
            FaceGroup { name: "scalp".to_owned(), triangles: vec![0, 2] },
            FaceGroup { name: "\u{e9}par \"les\"\n".to_owned(), triangles: Vec::new() },
        ];
        TriMesh { positions, normals, uvs, triangles, groups }
    })
}

fn sculpt() -> impl Strategy<Value = Sculpt> {
    let guide = (0..6_u32, [number(), number(), number()], number());
    let layer = (prop::collection::vec(guide, 0..4), ".{0,5}", number());
    (prop::collection::vec(place(), 6), any::<bool>(), prop::collection::vec(layer, 0..3)).prop_map(
        |(positions, has_uvs, layers)| {
            let uvs = some(positions.iter().map(|p| [p.x, p.z]).collect(), has_uvs);
            let layers = layers.into_iter().map(|(guides, name, weight)| {
                let mut layer = SculptLayer { weight, mask: SculptMask::Inverted, ..SculptLayer::new(&name) };
                for (guide, offset, length) in guides {
                    let to = SculptGuide { offsets: [offset; sculpt::K], length, ..SculptGuide::default() };
                    Arc::make_mut(&mut layer.strokes).apply(&[SculptChange { guide, to: Some(Box::new(to)) }]);
                }
                layer
            });
            Sculpt { layers: layers.collect(), roots: Arc::new(SculptRoots { positions, uvs }) }
        },
    )
}

fn layer() -> impl Strategy<Value = Layer> {
    let source = prop_oneof![
        strands().prop_map(|strands| Source::Strands(Arc::new(strands))),
        strands().prop_map(|strands| Source::Guides(Arc::new(strands))),
        hair_mesh().prop_map(|mesh| Source::HairMesh(Arc::new(mesh))),
    ];
    let map = prop::collection::vec((1..90u32, 1..9u32, any::<u8>(), any_kind()), 0..3);
    (source, map, ".{0,12}", number(), any::<u32>(), sculpt()).prop_map(
        |(source, map, name, radius_um, seed, sculpt)| {
            let mut layer = Layer::new(&name, source);
            layer.sculpt = sculpt;
            layer.radius_um = radius_um;
            layer.seed = seed;
            layer.material.eumelanin = radius_um;
            layer.maps.extend(map.into_iter().map(|(width, height, first, kind)| {
                let texel = |x, y| first.wrapping_add(((x + y * width) * 37) as u8);
                (kind, Arc::new(ScalpMap::from_fn(width, height, texel).expect("a size within the limits")))
            }));
            layer
        },
    )
}

fn groom() -> impl Strategy<Value = Groom> {
    (prop::option::of(mesh()), prop::collection::vec(layer(), 0..4), ".{0,20}", number()).prop_map(
        |(mesh, layers, name, gravity)| {
            let mut groom = Groom { name, layers, ..Groom::default() };
            groom.head = mesh.map(|mesh| Head { read_as: Some(Space::default()), ..Head::new("Head", mesh) });
            groom.simulation.gravity = gravity;
            groom.panorama = (gravity > 0.0).then(|| {
                let texels = vec![gravity, 0.0, 1e6, 0.25, 3.0, gravity];
                Arc::new(Panorama { path: "sky.hdr".into(), file_size: [4, 2], width: 2, height: 1, texels })
            });
            groom
        },
    )
}

/// A groom with one of everything.
fn sample() -> Groom {
    let mut strands = Strands::default();
    for strand_idx in 0..6 {
        let x = strand_idx as f32;
        strands.push(&[Vec3::new(x, 0.1, 0.0), Vec3::new(x, -3.0, 0.2), Vec3::new(x, -7.0, 0.9)]);
    }
    strands.radii_um = vec![42.5; 18];
    let face = Some(vec![0, 1, 2]);
    let positions = vec![Vec3::X, Vec3::Y, Vec3::Z];
    let hair_mesh = HairMesh {
        layers: vec![
            HairMeshLayer { positions: positions.clone(), faces: vec![face.clone(), None], pinned: Vec::new() },
            HairMeshLayer { positions: positions.clone(), faces: vec![face, None], pinned: vec![0, 2] },
        ],
    };
    let mut first = Layer::from_strands("strands", strands);
    let map = |texels: &[u8]| Arc::new(ScalpMap::from_texels(2, 3, texels).expect("six texels"));
    first.maps.insert(MapKind::Density, map(&[0, 50, 100, 150, 200, 255]));
    first.maps.insert(MapKind::Mask("Pony \u{e9}/..:".to_owned()), map(&[9, 8, 7, 6, 5, 4]));
    let head = TriMesh { positions, triangles: vec![[0, 1, 2]], ..TriMesh::default() };
    Groom {
        head: Some(Head::new("Head", head)),
        layers: vec![first, Layer::new("mesh", Source::HairMesh(Arc::new(hair_mesh)))],
        ..Groom::default()
    }
}

fn saved(groom: &Groom) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("groom.lorelei");
    save(groom, &path).expect("a sound groom can be saved");
    std::fs::read(path).expect("it was just saved")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_saved_comes_back_bit_for_bit(groom in groom()) {
        let bytes = saved(&groom);
        let back = open_bytes("groom.lorelei", &bytes).map_err(|error| TestCaseError::fail(error.to_string()))?;
        prop_assert_eq!(&back, &groom);
        // Equal numbers may differ in bits (-0.0); equal files do not.
        prop_assert_eq!(saved(&back), bytes);
    }

    #[test]
    fn documents_with_bytes_changed_never_panic(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = saved(&sample());
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok(groom) = open_bytes("groom.lorelei", &bytes) {
            super::check::check(&groom).map_err(TestCaseError::fail)?;
        }
    }
}

#[test]
fn a_document_cut_off_anywhere_is_an_error() {
    let bytes = saved(&sample());
    for n in 0..bytes.len() {
        let error = open_bytes("groom.lorelei", &bytes[..n]).expect_err("it is cut off").to_string();
        assert!(error.starts_with("groom.lorelei: "), "{error}");
    }
}

/// An archive with other entries or another manifest.
fn rewritten(change: impl Fn(&str, Vec<u8>) -> Option<Vec<u8>>) -> Vec<u8> {
    let bytes = saved(&sample());
    let mut from = zip::ZipArchive::new(std::io::Cursor::new(bytes)).expect("an archive");
    let mut to = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for entry_idx in 0..from.len() {
        let mut entry = from.by_index(entry_idx).expect("an entry");
        let name = entry.name().expect("a name").into_owned();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).expect("readable");
        if let Some(content) = change(&name, content) {
            to.start_file(name, zip::write::SimpleFileOptions::default()).expect("a new entry");
            to.write_all(&content).expect("a vector takes everything");
        }
    }
    to.finish().expect("an archive").into_inner()
}

fn with_manifest(change: impl Fn(String) -> String) -> Vec<u8> {
    rewritten(|name, content| match name {
        "manifest.ron" => Some(change(String::from_utf8(content).expect("text")).into_bytes()),
        _ => Some(content),
    })
}

fn refusal(bytes: &[u8]) -> String {
    open_bytes("groom.lorelei", bytes).expect_err("it must be refused").to_string()
}

#[test]
fn a_newer_version_is_refused_politely_whatever_it_holds() {
    let newer = with_manifest(|_| {
        "(version: 7, made_by: \"Lorelei 9.1\", groom: Whatever(x: [Some((1, 2))]), more: {})".to_owned()
    });
    let error = open_bytes("groom.lorelei", &newer).expect_err("it is newer");
    assert!(matches!(error, DocumentError::TooNew { version: 7, .. }), "{error}");
    assert!(error.to_string().contains("Lorelei 9.1") && error.to_string().contains("Update Lorelei"));
}

#[test]
fn a_density_of_version_1_becomes_a_map() {
    let old = with_manifest(|text| {
        // Version 1 knew no `maps`.
        let begin = text.find("maps: {").expect("a field");
        let end = begin + text[begin..].find("},").expect("its end") + 2;
        let text = format!("{}density: Some((width: 2, height: 3, texels: [])),{}", &text[..begin], &text[end..]);
        text.replace("version: 2", "version: 1").replace("count: WhereFull,", "")
    });
    let groom = open_bytes("groom.lorelei", &old).expect("version 1 is still read");
    assert_eq!(groom.layers[0].maps.keys().collect::<Vec<_>>(), [&MapKind::Density]);
    assert_eq!(groom.layers[0].density(), sample().layers[0].density());
    // Density said only where.
    assert_eq!(groom.layers[0].count, StrandCount::Total);
}

#[test]
fn unknown_fields_are_passed_over_and_missing_ones_get_their_default() {
    let more = with_manifest(|text| {
        let text = text.replace("groom: (", "groom: (\nfrom_the_future: Some((a: 1, b: \"x\")),");
        assert!(text.contains("from_the_future"));
        text
    });
    assert_eq!(open_bytes("groom.lorelei", &more).expect("tolerated"), sample());
    let less = with_manifest(|text| {
        let without = text.replace("tip_radius:", "tip_radius_of_old:").replace("gravity:", "gravity_of_old:");
        assert_ne!(without, text);
        without
    });
    assert_eq!(open_bytes("groom.lorelei", &less).expect("tolerated"), sample());
}

#[test]
fn archives_that_lie_are_refused_and_the_part_is_named() {
    let points = "layers/0/strands/points.f32";
    let missing = refusal(&rewritten(|name, content| (name != points).then_some(content)));
    assert!(missing.contains(points), "{missing}");
    let short = refusal(&rewritten(|name, content| Some(if name == points { content[4..].to_vec() } else { content })));
    assert!(short.contains(points) && short.contains("announces"), "{short}");
    let png =
        refusal(&rewritten(|name, content| Some(if name.ends_with("png") { b"no picture".to_vec() } else { content })));
    assert!(png.contains("layers/0/density.png"), "{png}");
    let offsets = refusal(&rewritten(|name, mut content| {
        if name.ends_with("offsets.u32") {
            content[4] = 200;
        }
        Some(content)
    }));
    assert!(offsets.contains("layer `strands`") && offsets.contains("offsets"), "{offsets}");
    let triangles = refusal(&rewritten(|name, mut content| {
        if name == "head/triangles.u32" {
            content[0] = 99;
        }
        Some(content)
    }));
    assert!(triangles.contains("head"), "{triangles}");
    let no_manifest = refusal(&rewritten(|name, content| (name != "manifest.ron").then_some(content)));
    assert!(no_manifest.contains("manifest.ron"), "{no_manifest}");
    let syntax = refusal(&with_manifest(|text| text.replacen("look", "l ook", 1)));
    assert!(syntax.contains("manifest.ron") && syntax.contains(':'), "{syntax}");
}

#[test]
fn a_small_archive_that_announces_terabytes_is_refused_before_it_is_unpacked() {
    let bomb = with_manifest(|text| text.replace("n: 54", "n: 1000000000002"));
    let error = open_bytes("groom.lorelei", &bomb).expect_err("too large");
    assert!(matches!(error, DocumentError::Read(ReadError::TooLarge { .. })), "{error}");
    // And one whose manifest is the bomb.
    let spaces = rewritten(|name, content| Some(if name == "manifest.ron" { vec![b' '; 65 << 20] } else { content }));
    assert!(spaces.len() < 1 << 20);
    assert!(refusal(&spaces).contains("more than 64 MiB"));
}

#[test]
fn a_groom_that_is_not_sound_is_not_saved_over_a_good_one() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("groom.lorelei");
    save(&sample(), &path).expect("sound");
    let mut broken = sample();
    let Source::Strands(strands) = &mut broken.layers[0].source else { panic!("the sample's first layer is strands") };
    Arc::make_mut(strands).points[2] = Vec3::NAN;
    let error = save(&broken, &path).expect_err("a strand is nowhere");
    assert!(error.to_string().contains("layer `strands`: point 2"), "{error}");
    assert_eq!(open(&path).expect("still there"), sample());
    assert_eq!(std::fs::read_dir(folder.path()).expect("listable").count(), 1);
}

#[test]
fn saving_replaces_what_a_link_points_to_and_refuses_folders_and_read_only_files() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("groom.lorelei");
    save(&Groom::default(), &path).expect("writable");
    #[cfg(unix)]
    {
        let link = folder.path().join("link.lorelei");
        std::os::unix::fs::symlink(&path, &link).expect("links work");
        save(&sample(), &link).expect("writable");
        assert!(std::fs::symlink_metadata(&link).expect("there").is_symlink());
        assert_eq!(open(&path).expect("good"), sample());
    }
    assert!(matches!(save(&sample(), folder.path()), Err(DocumentError::Write(_))));
    let mut permissions = std::fs::metadata(&path).expect("there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).expect("ours");
    let error = save(&Groom::default(), &path).expect_err("read-only").to_string();
    assert!(error.contains("read-only"), "{error}");
}

#[test]
fn other_files_are_not_taken_for_documents() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("head.obj");
    std::fs::write(&path, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("writable");
    assert!(matches!(open(&path), Err(DocumentError::NotADocument { .. })));
    assert!(matches!(open(Path::new("/no/such/file.lorelei")), Err(DocumentError::Read(ReadError::Open { .. }))));
    assert!(matches!(open(folder.path()), Err(DocumentError::Read(ReadError::NotAFile { .. }))));
}

#[test]
fn arrays_are_packed() {
    let mut strands = Strands::default();
    for strand_idx in 0..1000 {
        let points: Vec<Vec3> = (0..16).map(|k| Vec3::new((strand_idx % 10) as f32, -(k as f32), 0.0)).collect();
        strands.push(&points);
    }
    let n_bytes = strands.n_bytes();
    let groom = Groom { layers: vec![Layer::from_strands("even", strands)], ..Groom::default() };
    assert!(saved(&groom).len() < n_bytes / 4);
}
