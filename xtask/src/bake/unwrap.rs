//! Texture coordinates: one chart for the scalp, many small ones for the skin.
//!
//! The scalp is laid out by an equal-area azimuthal map of its directions and then relaxed to be as rigid
//! as possible (Liu et al. 2008): a painted map must mean the same density everywhere. The skin is cut
//! where its main direction changes and each piece projected along it: simple, and bounded to 55 degrees.
//! The scalp takes the left of the square, the skin the rest; one centimetre is one length in each.

use std::collections::{BTreeSet, HashMap};

use glam::{DVec2, Mat3, Vec2, Vec3, dvec2, vec2, vec3};

/// Share of the square's width that is the scalp's.
pub const SCALP_WIDTH: f32 = 0.62;
const MARGIN: f32 = 0.008;

/// A piece of the surface in texture space: vertices by their index in the surface.
pub struct Chart {
    pub triangles: Vec<u32>,
    pub uv_of: HashMap<u32, Vec2>,
}

/// Chart of the scalp's triangles; centimetres, before packing.
pub fn scalp_chart(positions: &[Vec3], triangles: &[[u32; 3]], of_scalp: &[u32]) -> Chart {
    // The middle of the chart is high at the back of the crown; up in the chart is forward.
    let centre = vec3(0.0, 1.5, -1.6);
    let pole = vec3(0.0, 0.80, -0.60).normalize();
    let right = Vec3::NEG_X;
    let up = pole.cross(right);
    let frame = Mat3::from_cols(right, up, pole);
    let local: BTreeSet<u32> = of_scalp.iter().flat_map(|&t| triangles[t as usize]).collect();
    let local: Vec<u32> = local.into_iter().collect();
    let index_of: HashMap<u32, usize> = local.iter().enumerate().map(|(i, &v)| (v, i)).collect();
    let mut uv: Vec<DVec2> = local
        .iter()
        .map(|&v| {
            let q = frame.transpose() * (positions[v as usize] - centre);
            let colatitude = q.z.atan2(q.x.hypot(q.y)).mul_add(-1.0, std::f32::consts::FRAC_PI_2);
            let r = 2.0 * 8.8 * (0.5 * colatitude).sin();
            let around = vec2(q.x, q.y).normalize_or_zero() * r;
            dvec2(f64::from(around.x), f64::from(around.y))
        })
        .collect();
    let faces: Vec<[usize; 3]> = of_scalp.iter().map(|&t| triangles[t as usize].map(|v| index_of[&v])).collect();
    let rest: Vec<[DVec2; 3]> = faces.iter().map(|f| flat(f.map(|i| positions[local[i] as usize]))).collect();
    relax_rigidly(&mut uv, &faces, &rest);
    let uv_of = local.iter().zip(&uv).map(|(&v, uv)| (v, uv.as_vec2())).collect();
    Chart { triangles: of_scalp.to_vec(), uv_of }
}

/// A triangle laid flat without distortion.
fn flat([a, b, c]: [Vec3; 3]) -> [DVec2; 3] {
    let x = (b - a).normalize_or(Vec3::X);
    let along = (c - a).dot(x);
    let height = (c - a - x * along).length();
    [DVec2::ZERO, dvec2(f64::from((b - a).length()), 0.0), dvec2(f64::from(along), f64::from(height))]
}

/// Neighbour, weight, triangle, corner of the vertex, corner of the neighbour.
type Spoke = (usize, f64, usize, usize, usize);

/// Local/global as-rigid-as-possible parameterisation, the global step by Gauss-Seidel.
fn relax_rigidly(uv: &mut [DVec2], faces: &[[usize; 3]], rest: &[[DVec2; 3]]) {
    let cotangent = |at: DVec2, u: DVec2, v: DVec2| {
        let (p, q) = (u - at, v - at);
        (p.dot(q) / p.perp_dot(q).abs().max(1e-6)).max(0.02)
    };
    let mut around: Vec<Vec<Spoke>> = vec![Vec::new(); uv.len()];
    for (t, face) in faces.iter().enumerate() {
        for i in 0..3 {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let weight = cotangent(rest[t][k], rest[t][i], rest[t][j]);
            around[face[i]].push((face[j], weight, t, i, j));
            around[face[j]].push((face[i], weight, t, j, i));
        }
    }
    for _ in 0..120 {
        let turns: Vec<DVec2> = faces
            .iter()
            .zip(rest)
            .map(|(face, rest)| {
                // The rotation nearest to the map of this triangle: of sum(w * uv edge * rest edge^T).
                let (mut cos, mut sin) = (0.0, 0.0);
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let weight = cotangent(rest[k], rest[i], rest[j]);
                    let (now, was) = (uv[face[j]] - uv[face[i]], rest[j] - rest[i]);
                    cos += weight * was.dot(now);
                    sin += weight * was.perp_dot(now);
                }
                dvec2(cos, sin).normalize_or(DVec2::X)
            })
            .collect();
        for _ in 0..30 {
            for v in 0..uv.len() {
                let (mut sum, mut total) = (DVec2::ZERO, 0.0);
                for &(u, weight, t, i, j) in &around[v] {
                    sum += weight * (uv[u] + turns[t].rotate(rest[t][i] - rest[t][j]));
                    total += weight;
                }
                uv[v] = sum / total;
            }
        }
    }
}

/// Charts of all other triangles; centimetres, before packing.
pub fn skin_charts(positions: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]], of_skin: &[u32]) -> Vec<Chart> {
    let direction = |t: u32| {
        let n: Vec3 = triangles[t as usize].iter().map(|&v| normals[v as usize]).sum();
        // The face is one piece: favour the front.
        let n = vec3(n.x, n.y, n.z * if n.z > 0.0 { 1.35 } else { 1.0 });
        let axis = n.abs().max_position();
        axis * 2 + usize::from(n[axis] < 0.0)
    };
    let mut of_edge: HashMap<(u32, u32), u32> = HashMap::new();
    for &t in of_skin {
        let [a, b, c] = triangles[t as usize];
        for edge in [(a, b), (b, c), (c, a)] {
            of_edge.insert(edge, t);
        }
    }
    let neighbours = |t: u32| {
        let [a, b, c] = triangles[t as usize];
        [(b, a), (c, b), (a, c)].map(|edge| of_edge.get(&edge).copied())
    };
    let mut label: HashMap<u32, usize> = of_skin.iter().map(|&t| (t, direction(t))).collect();
    // Ragged borders follow their neighbours.
    for _ in 0..12 {
        for &t in of_skin {
            let votes: Vec<usize> = neighbours(t).into_iter().flatten().map(|u| label[&u]).collect();
            if let Some(&most) = votes.iter().find(|&&l| votes.iter().filter(|&&m| m == l).count() >= 2) {
                label.insert(t, most);
            }
        }
    }
    let mut charts = Vec::new();
    let mut seen: BTreeSet<u32> = BTreeSet::new();
    for &start in of_skin {
        if !seen.insert(start) {
            continue;
        }
        let mut piece = vec![start];
        let mut next = 0;
        while next < piece.len() {
            for u in neighbours(piece[next]).into_iter().flatten() {
                if label[&u] == label[&start] && seen.insert(u) {
                    piece.push(u);
                }
            }
            next += 1;
        }
        let uv_of = piece
            .iter()
            .flat_map(|&t| triangles[t as usize])
            .map(|v| {
                let p = positions[v as usize];
                let uv = match label[&start] {
                    0 => vec2(-p.z, p.y),
                    1 => vec2(p.z, p.y),
                    2 => vec2(p.x, -p.z),
                    3 => vec2(p.x, p.z),
                    4 => vec2(p.x, p.y),
                    _ => vec2(-p.x, p.y),
                };
                (v, uv)
            })
            .collect();
        charts.push(Chart { triangles: piece, uv_of });
    }
    charts
}

/// Place the scalp at the left and the skin's charts in rows at the right, in the unit square.
pub fn pack(scalp: &mut Chart, skin: &mut [Chart]) {
    let (min, max) = bounds(scalp);
    let scale = ((SCALP_WIDTH - 2.0 * MARGIN) / (max.x - min.x)).min((1.0 - 2.0 * MARGIN) / (max.y - min.y));
    let corner = vec2(MARGIN, 0.5 * (1.0 - scale * (max.y - min.y)));
    scalp.uv_of.values_mut().for_each(|uv| *uv = corner + scale * (*uv - min));
    // Shelves, tallest first; shrink until everything fits.
    let mut order: Vec<(usize, Vec2, Vec2)> = skin
        .iter()
        .enumerate()
        .map(|(i, chart)| {
            let (min, max) = bounds(chart);
            (i, min, max - min)
        })
        .collect();
    order.sort_by(|a, b| b.2.y.total_cmp(&a.2.y));
    let room = vec2(1.0 - SCALP_WIDTH - MARGIN, 1.0 - 2.0 * MARGIN);
    let mut scale = scale;
    let places = loop {
        let (mut at, mut shelf, mut fits) = (Vec2::ZERO, 0.0f32, true);
        let mut places = Vec::with_capacity(order.len());
        for &(_, _, size) in &order {
            let size = size * scale + Vec2::splat(0.004);
            if at.x + size.x > room.x {
                at = vec2(0.0, at.y + shelf);
                shelf = 0.0;
            }
            fits &= size.x <= room.x && at.y + size.y <= room.y;
            places.push(at);
            at.x += size.x;
            shelf = shelf.max(size.y);
        }
        if fits {
            break places;
        }
        scale *= 0.95;
    };
    for (&(i, min, _), at) in order.iter().zip(places) {
        let corner = vec2(SCALP_WIDTH, MARGIN) + at;
        skin[i].uv_of.values_mut().for_each(|uv| *uv = corner + scale * (*uv - min));
    }
}

fn bounds(chart: &Chart) -> (Vec2, Vec2) {
    chart.uv_of.values().fold((Vec2::MAX, Vec2::MIN), |(lo, hi), &uv| (lo.min(uv), hi.max(uv)))
}
