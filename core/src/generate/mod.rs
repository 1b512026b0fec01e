//! Strands from guides, on the CPU: the reference that `generate.wgsl` repeats with the same names.
//!
//! A strand is the Catmull-Rom curve through its blended guides, ironed, cut to its length, drawn into its
//! clumps and wisps, turned by bends and partings, displaced around its path by the other operators, moved as
//! brushes moved it, kept out of the head, and given a width. All is evaluated directly: a strand reads the
//! paths of its clumps' middle strands at its own parameter, so
//! no strand waits for another. One strand is one thread's work on the GPU, because the twist-free frame
//! and the arc length are carried from vertex to vertex.

use glam::{Affine3A, Vec3};
use rayon::prelude::*;

use crate::binding::LayerBinding;
use crate::curve::catmull_rom_weights;
use crate::distance_field::DistanceField;
use crate::groom::Layer;
use crate::hash::random;
use crate::lod::LodBlend;
use crate::sculpt::{Composite, compose::Composed, near::Share};
use crate::simulation::Interpolated;
use crate::strands::Strands;
use crate::style::StyleKind;
use plan::Plan;
pub use sculpt::root_frame;
use sculpt::{Chain, Sculpted};
use single_guide::{Hit, first_hits};
use style::{FOR_KEEP_OUT, RootFrame, Shape, clumped, displacement, smoothstep, turned};

pub mod plan;
mod sculpt;
pub mod single_guide;
mod style;
#[cfg(test)]
mod tests;

/// What changes from frame to frame.
#[derive(Debug, Clone, Copy)]
pub struct Pose<'a> {
    pub world_from_head: Affine3A,
    /// The head's, in head space.
    pub field: Option<&'a DistanceField>,
    /// Level of detail: share of the strands that are drawn, 0-1.
    pub lod: f32,
    /// The levels that are blended; their share of the strands comes on top of `lod`.
    pub blend: LodBlend,
    /// How strands that lie between moved guides are kept out of the head; `None` where guides are at rest.
    pub interpolated: Option<Interpolated>,
}

impl Default for Pose<'_> {
    fn default() -> Self {
        Self {
            world_from_head: Affine3A::IDENTITY,
            field: None,
            lod: 1.0,
            blend: LodBlend::default(),
            interpolated: None,
        }
    }
}

/// Distance from the head below which strands are pushed out, in centimetres; half to one and a half of
/// it from strand to strand, so that pushed hair is no sheet.
pub const KEEP_OUT: f32 = 0.3;
/// Arc length over which a strand grows out of the scalp to that distance, in centimetres.
pub const GROW_OUT: f32 = 2.0;
/// Share of a strand, at its tip, over which it tapers (look.md: the last tenth).
pub const TAPER: f32 = 0.1;
/// Strands at the end of the order of detail that are getting thinner, as a share of those drawn.
pub const LOD_FADE: f32 = 0.1;

/// How many strands of a layer are drawn at a level of detail, and how wide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lod {
    pub n_drawn: u32,
    /// Strand `s` has this much of its width: `scale * clamp((end - s) / fade, 0, 1)`.
    pub scale: f32,
    pub end: f32,
    pub fade: f32,
}

impl Lod {
    /// Continuous in `lod`: strands thin out before they vanish, and the others widen so that the sum of
    /// the widths stays.
    pub fn new(n_strands: usize, lod: f32) -> Self {
        let n = n_strands as f32;
        let full = (lod.clamp(0.0, 1.0) * n).max(n.min(1.0));
        let fade = LOD_FADE * full;
        let end = full + fade;
        // The integral over the strands of clamp((end - s) / fade, 0, 1).
        let cropped = (end - n).max(0.0);
        let sum = full + (fade * fade - cropped * cropped) / (2.0 * fade).max(1e-6);
        Self { n_drawn: (end.ceil() as u32).min(n_strands as u32), scale: n / sum.max(1e-3), end, fade: fade.max(1e-6) }
    }

    /// Width of strand `strand_idx` as a share of its width at level of detail 1.
    pub fn width(&self, strand_idx: usize) -> f32 {
        self.painted_width(strand_idx, 1.0)
    }

    /// The same where a painted map keeps this share of the strands.
    pub fn painted_width(&self, strand_idx: usize, kept: f32) -> f32 {
        self.scale * ((self.end - strand_idx as f32 / kept.max(1e-6)) / self.fade).clamp(0.0, 1.0)
    }
}

/// Make the strands of a layer from the guides' present places (world space, laid out as
/// `binding.guides.positions`).
pub fn generate(binding: &LayerBinding, layer: &Layer, guide_positions: &[Vec3], pose: &Pose<'_>) -> Strands {
    assert_eq!(guide_positions.len(), binding.guides.positions.len(), "as many guide vertices as were bound");
    let n_vertices = pose.blend.n_vertices(layer.vertices_per_strand.clamp(4, 128)) as usize;
    let lod = Lod::new(binding.n_strands(), pose.lod * pose.blend.strands);
    let lod_maps = pose.blend.maps(binding);
    let n_drawn = lod.n_drawn as usize;
    let plan = Plan::new(&layer.style, binding);
    let composite = Composite::of(layer);
    // A layer that got other guides since it was bound is not sculpted before it is bound again.
    let is_bound = binding.sculpt.are_of(&layer.sculpt.roots, binding.n_strands());
    let sculpt = (is_bound && !composite.guides.is_empty()).then_some(composite.guides.as_slice());
    let hits = first_hits(binding, guide_positions, pose);
    let generator = Generator { binding, plan: &plan, sculpt, guide_positions, pose, n_vertices, hits };
    let mut points = vec![Vec3::ZERO; n_drawn * n_vertices];
    points.par_chunks_exact_mut(n_vertices).enumerate().for_each(|(strand_idx, out)| generator.strand(strand_idx, out));
    let radii_um = (0..n_drawn)
        .flat_map(|strand_idx| {
            let (kept, wider) = pose.blend.painted(binding, lod_maps, strand_idx);
            let is_deleted = generator.sculpted(strand_idx).is_some_and(|sculpted| sculpted.is_deleted);
            let scale = if is_deleted { 0.0 } else { binding.radius_scales.get(strand_idx).copied().unwrap_or(1.0) };
            let scale = scale * lod.painted_width(strand_idx, kept) * (pose.blend.thickness * wider);
            let scale = scale * binding.map_value(strand_idx, plan.width_map, 1.0);
            (0..n_vertices)
                .map(move |v| layer.radius_um * scale * taper(v as f32 / (n_vertices - 1) as f32, layer.tip_radius))
        })
        .collect();
    Strands {
        points,
        offsets: (0..=n_drawn as u32).map(|s| s * n_vertices as u32).collect(),
        ids: binding.ids[..n_drawn].to_vec(),
        radii_um,
        root_uvs: binding.root_uvs.get(..n_drawn).unwrap_or_default().to_vec(),
        ..Strands::default()
    }
}

/// Which of a layer's strands brushes took away: [`generate`] leaves a point of each at its root, so that strands
/// keep their places. One a strand that was bound.
pub fn deleted(binding: &LayerBinding, layer: &Layer) -> Vec<bool> {
    let composite = Composite::of(layer);
    if composite.guides.is_empty() || !binding.sculpt.are_of(&layer.sculpt.roots, binding.n_strands()) {
        return vec![false; binding.n_strands()];
    }
    let of_strand = |(strand_idx, share): (usize, &Share)| {
        let (seed, normal) = (binding.seeds[strand_idx], binding.root_normals[strand_idx]);
        let sculpted = Sculpted::new(&composite.guides, *share, seed, normal, &Affine3A::IDENTITY);
        sculpted.is_some_and(|sculpted| sculpted.is_deleted)
    };
    binding.sculpt.shares.iter().enumerate().map(of_strand).collect()
}

/// Radius at parameter `t` as a share of the root's.
pub fn taper(t: f32, tip_radius: f32) -> f32 {
    let x = ((t - (1.0 - TAPER)) / TAPER).clamp(0.0, 1.0);
    1.0 + x * (tip_radius - 1.0)
}

/// A strand's path before any clump: control points with the mirrored ends, world space.
#[derive(Default)]
struct StrandPath {
    controls: Vec<Vec3>,
}

impl StrandPath {
    /// Where the path is at the guides' parameter `u`, in segments.
    fn at(&self, u: f32) -> Vec3 {
        let n_segments = self.controls.len() - 3;
        let segment = (u as usize).min(n_segments - 1);
        let w = catmull_rom_weights(u - segment as f32);
        let c = &self.controls[segment..segment + 4];
        w[0] * c[0] + w[1] * c[1] + w[2] * c[2] + w[3] * c[3]
    }
}

struct Generator<'a> {
    binding: &'a LayerBinding,
    plan: &'a Plan,
    /// What brushes did to each sculpt guide; `None` where they did nothing.
    sculpt: Option<&'a [Composed]>,
    guide_positions: &'a [Vec3],
    pose: &'a Pose<'a>,
    n_vertices: usize,
    /// Every strand's; empty where strands only blend their guides.
    hits: Vec<Hit>,
}

impl Generator<'_> {
    /// A strand's guides blended at control point `i`; `i` counts on beyond the ends, where the chain is mirrored in
    /// its end point.
    fn blended(&self, strand_idx: usize, i: i32) -> Vec3 {
        let last = self.binding.guides.n_vertices as i32 - 1;
        if i < 0 {
            return 2.0 * self.blended(strand_idx, 0) - self.blended(strand_idx, -i);
        }
        if i > last {
            return 2.0 * self.blended(strand_idx, last) - self.blended(strand_idx, 2 * last - i);
        }
        let mut p = Vec3::ZERO;
        for influence in self.binding.influences(strand_idx) {
            let at = influence.guide_idx * self.binding.guides.n_vertices + i as u32;
            p += influence.weight * self.guide_positions[at as usize];
        }
        let Some(hit) = self.hits.get(strand_idx) else { return p };
        let share = hit.share(i as u32);
        if share <= 0.0 {
            return p;
        }
        // Where the strand rests beside its strongest guide, and that guide now.
        let n = self.binding.guides.n_vertices;
        let rest = |guide_idx: u32| self.binding.guides.positions[(guide_idx * n + i as u32) as usize];
        let mut beside = -rest(hit.guide_idx);
        for influence in self.binding.influences(strand_idx) {
            beside += influence.weight * rest(influence.guide_idx);
        }
        let with_guide = self.guide_positions[(hit.guide_idx * n + i as u32) as usize]
            + self.pose.world_from_head.transform_vector3(beside);
        p + share * (with_guide - p)
    }

    /// Control point `i`, ironed where the style says so: a mean with falling weights over the neighbours. The ends
    /// stay, because there the chain is mirrored.
    fn ironed(&self, strand_idx: usize, i: i32) -> Vec3 {
        let p = self.blended(strand_idx, i);
        let Some(step) = self.plan.smooth.map(|step_idx| &self.plan.steps[step_idx]) else { return p };
        let StyleKind::Smooth { reach } = step.kind else { return p };
        let last = self.binding.guides.n_vertices as i32 - 1;
        let strength = step.envelope(self.strength(strand_idx, step)).at(i as f32 / last as f32).clamp(0.0, 1.0);
        let reach = reach * last as f32;
        let (mut sum, mut total) = (p, 1.0);
        let mut k = 1;
        while k <= last && (k as f32) < reach {
            let weight = 1.0 - k as f32 / reach;
            sum += weight * (self.blended(strand_idx, i - k) + self.blended(strand_idx, i + k));
            total += 2.0 * weight;
            k += 1;
        }
        p + strength * (sum / total - p)
    }

    /// Control point `i` in world space, with what is left there of the root's offset.
    fn control(&self, strand_idx: usize, i: i32) -> Vec3 {
        let last = self.binding.guides.n_vertices as i32 - 1;
        let left = 1.0 - smoothstep(0.0, 1.0, i as f32 / last as f32) * (1.0 - self.binding.offset_at_tip);
        let offset = self.pose.world_from_head.transform_vector3(self.binding.root_offsets[strand_idx]);
        self.ironed(strand_idx, i) + left * offset
    }

    /// The guides' own parameter, in segments, at the share `t` of a strand's length: 0 root to 1 tip.
    fn parameter(&self, strand_idx: usize, t: f32) -> f32 {
        let first = self.binding.first_knots[strand_idx] as usize;
        let knots = &self.binding.knots[first..first + self.binding.guides.n_vertices as usize];
        let segment = knots[1..knots.len() - 1].iter().take_while(|&&knot| t >= knot).count();
        let (below, above) = (knots[segment], knots[segment + 1]);
        segment as f32 + ((t - below) / (above - below).max(1e-6)).clamp(0.0, 1.0)
    }

    fn path_of(&self, strand_idx: usize) -> StrandPath {
        let n = self.binding.guides.n_vertices as i32;
        let mut controls = Vec::with_capacity(n as usize + 2);
        controls.push(Vec3::ZERO);
        controls.extend((0..n).map(|i| self.control(strand_idx, i)));
        let last = n as usize;
        controls[0] = 2.0 * controls[1] - controls[2];
        controls.push(2.0 * controls[last] - controls[last - 1]);
        StrandPath { controls }
    }

    /// Where a strand grows, world space.
    fn root_of(&self, strand_idx: usize) -> Vec3 {
        self.control(strand_idx, 0)
    }

    /// What brushes did to a strand; `None` where they did nothing.
    fn sculpted(&self, strand_idx: usize) -> Option<Sculpted<'_>> {
        let share = *self.binding.sculpt.shares.get(strand_idx)?;
        let (seed, normal) = (self.binding.seeds[strand_idx], self.binding.root_normals[strand_idx]);
        Sculpted::new(self.sculpt?, share, seed, normal, &self.pose.world_from_head)
    }

    fn strand(&self, strand_idx: usize, out: &mut [Vec3]) {
        let world_from_head = &self.pose.world_from_head;
        let seed = self.binding.seeds[strand_idx];
        let sculpted = self.sculpted(strand_idx);
        if sculpted.is_some_and(|sculpted| sculpted.is_deleted) {
            out.fill(self.root_of(strand_idx));
            return;
        }
        let cut = self.cut(strand_idx) * sculpted.map_or(1.0, |sculpted| sculpted.cut);
        let pulls = self.pulls(strand_idx);
        let path = self.path_of(strand_idx);
        let last = self.n_vertices - 1;
        // The strands of a wisp share its frame, so that what acts on the wisp moves them alike.
        let normal_in_head = self.binding.root_normals[self.wisp_middle(strand_idx)];
        let outwards = world_from_head.transform_vector3(normal_in_head);
        let side = world_from_head.transform_vector3(any_tangent(normal_in_head));
        let frame = RootFrame { outwards, side, up: outwards.cross(side) };
        let shapes = self.shapes(strand_idx, path.at(0.0), &frame);
        let turns = shapes.iter().any(Shape::turns);
        let clumped_at = |v: usize| {
            let t = cut * v as f32 / last as f32;
            // The middles are read where the strand is, by its own knots.
            clumped(&path, &pulls, t, self.parameter(strand_idx, t))
        };

        let mut unturned = clumped_at(0);
        let (mut before, mut base) = (unturned, unturned);
        let mut tangent = outwards;
        let mut right = side;
        let mut arc_length = 0.0;
        let mut chain = Chain::default();
        for v in 0..=last {
            let mut after = base;
            if v < last {
                let next = clumped_at(v + 1);
                after =
                    if turns { base + turned(&shapes, next - unturned, (v + 1) as f32 / last as f32) } else { next };
                unturned = next;
            }
            arc_length += base.distance(before);
            let new_tangent = (after - before).normalize_or(tangent);
            right = transport(right, tangent, new_tangent);
            tangent = new_tangent;
            let up = tangent.cross(right);
            let t = v as f32 / last as f32;
            let offset = displacement(&shapes, t, arc_length);
            let mut p = base + offset.x * right + offset.y * up + offset.z * outwards;
            if let Some(sculpted) = &sculpted {
                let offset = sculpted.offset(cut * t);
                if v == 0 {
                    let placed = if sculpted.has_slid() { self.onto_scalp(p + offset) } else { p };
                    chain = Chain::begin(p, placed);
                    p = placed;
                } else {
                    p = chain.next(p, offset, sculpted.length, tangent);
                }
            }
            out[v] = if v == 0 { p } else { self.keep_out(p, arc_length, seed) };
            (before, base) = (base, after);
        }
    }

    /// A root that was slid along the scalp, on it again.
    fn onto_scalp(&self, p: Vec3) -> Vec3 {
        let Some(field) = self.pose.field else { return p };
        let in_head = self.pose.world_from_head.inverse().transform_point3(p);
        let out = field.gradient(in_head).normalize_or(Vec3::ZERO);
        self.pose.world_from_head.transform_point3(in_head - field.sample(in_head) * out)
    }

    /// Push a vertex out of the head. Distances below the margin are squeezed between the skin and the
    /// margin, in their order: what lies deeper stays deeper, and nothing is flattened.
    fn keep_out(&self, p: Vec3, arc_length: f32, seed: u32) -> Vec3 {
        if self.pose.interpolated == Some(Interpolated::Free) {
            return p;
        }
        let Some(field) = self.pose.field else { return p };
        let in_head = self.pose.world_from_head.inverse().transform_point3(p);
        let margin = KEEP_OUT * (0.5 + random(seed, FOR_KEEP_OUT)) * smoothstep(0.0, GROW_OUT, arc_length) + 1e-3;
        let distance = field.sample(in_head);
        if distance >= margin {
            return p;
        }
        let wanted = margin * (distance / margin - 1.0).exp();
        let out = field.gradient(in_head).normalize_or(Vec3::ZERO);
        self.pose.world_from_head.transform_point3(in_head + (wanted - distance) * out)
    }
}

/// A unit vector across `normal`: X turned by the shortest way that takes Y to `normal`. No scalp faces
/// straight down, where this way is not unique.
fn any_tangent(normal: Vec3) -> Vec3 {
    let across = Vec3::X - normal.x / (1.0 + normal.y).max(1e-3) * (Vec3::Y + normal);
    across.normalize_or(Vec3::X)
}

/// One plus the cosine of a turn back, 154 degrees: about which axis a strand turns beyond it is rounding more and more.
const TURNED_BACK: f32 = 0.1;

/// Carry a vector across a strand from one tangent to the next by the shortest rotation: no twist. Where the strand turns
/// back the rotation fades out, and the vector stays what it was as far as it lies across the strand.
fn transport(right: Vec3, from: Vec3, to: Vec3) -> Vec3 {
    let carried = right - right.dot(to) / (1.0 + from.dot(to)).max(TURNED_BACK) * (from + to);
    (carried - carried.dot(to) * to).normalize_or(right)
}
