//! The mannequin as one signed distance: head, ears, neck and shoulders of a salon training head.
//!
//! Head space: centimetres, Y up, Z out of the nose, X to the model's left. The eye line is y = 0, so the
//! vertex is at 11.25 and the chin at -11.25; z = 0 is half way from glabella to occiput. Every feature is
//! one blended shape, placed by its anatomical name, so that a sculptor can find and move it. Sculpting
//! from polygons was rejected: distances give exact normals, and the same field clears the hair.

use glam::{Mat3, Vec3, vec3};

use super::sdf::{carve, cone, curve, ellipsoid, join, meet, smoothstep, tube, turned_ellipsoid};

/// Half width at which the shoulders are cut.
const SHOULDER_CUT: f32 = 19.4;
/// Height of the flat base.
const BASE: f32 = -26.0;

/// The sculpted shapes that take some preparation: curves and turned frames.
pub struct Mannequin {
    lash_line: Vec<(Vec3, f32)>,
    lid_crease: Vec<(Vec3, f32)>,
    mouth_line: Vec<(Vec3, f32)>,
    jaw: Vec<(Vec3, f32)>,
    brow: Vec<(Vec3, f32)>,
    nose: Vec<(Vec3, f32)>,
    upper_lip: Vec<(Vec3, f32)>,
    lower_lip: Vec<(Vec3, f32)>,
    collarbone: Vec<(Vec3, f32)>,
    trapezius: Vec<(Vec3, f32)>,
    cheekbone_frame: Mat3,
    ear: Ear,
}

/// Centre of the closed eye on the model's left.
const EYE: Vec3 = vec3(3.2, -0.15, 6.27);
const EYE_RADIUS: f32 = 1.5;

impl Mannequin {
    pub fn new() -> Self {
        let knots = |points: &[[f32; 4]], n| {
            curve(&points.iter().map(|k| (vec3(k[0], k[1], k[2]), k[3])).collect::<Vec<_>>(), n)
        };
        // A curve over the lid, seen from the front: place from the middle of the eye, half width.
        let on_lid = |points: &[[f32; 3]]| {
            points.iter().map(|&[x, y, r]| (vec3(EYE.x + x, EYE.y + y, 0.0), r)).collect::<Vec<_>>()
        };
        let lash = on_lid(&[
            [-1.32, -0.22, 0.03],
            [-0.9, -0.42, 0.07],
            [-0.3, -0.62, 0.09],
            [0.3, -0.64, 0.09],
            [0.85, -0.46, 0.08],
            [1.3, -0.12, 0.05],
            [1.46, 0.04, 0.02],
        ]);
        let crease = on_lid(&[
            [-1.3, 0.1, 0.02],
            [-0.95, 0.45, 0.05],
            [-0.35, 0.74, 0.07],
            [0.3, 0.8, 0.07],
            [0.9, 0.62, 0.06],
            [1.35, 0.28, 0.02],
        ]);
        Self {
            lash_line: curve(&lash, 4),
            lid_crease: curve(&crease, 4),
            mouth_line: knots(
                &[
                    [0.0, -6.78, 10.1, 0.10],
                    [0.6, -6.70, 10.02, 0.11],
                    [1.3, -6.76, 9.5, 0.11],
                    [2.0, -6.78, 8.8, 0.10],
                    [2.5, -6.72, 8.15, 0.06],
                ],
                4,
            ),
            jaw: knots(
                &[
                    [5.7, -2.6, -0.7, 0.8],
                    [5.2, -5.9, 0.0, 0.9],
                    [4.2, -7.9, 2.6, 1.0],
                    [2.5, -9.15, 5.7, 1.1],
                    [0.8, -9.75, 7.2, 1.05],
                ],
                6,
            ),
            brow: knots(
                &[
                    [1.1, 1.95, 8.55, 0.60],
                    [2.3, 2.4, 8.2, 0.62],
                    [3.7, 2.6, 7.3, 0.62],
                    [5.0, 2.1, 5.85, 0.55],
                    [5.5, 1.0, 4.9, 0.45],
                ],
                6,
            ),
            nose: knots(
                &[
                    [0.0, 1.8, 8.75, 0.75],
                    [0.0, 0.4, 8.75, 0.62],
                    [0.0, -1.3, 9.5, 0.58],
                    [0.0, -2.7, 10.25, 0.6],
                    [0.0, -3.45, 10.65, 0.68],
                ],
                6,
            ),
            upper_lip: knots(
                &[
                    [0.0, -6.38, 9.62, 0.40],
                    [0.5, -6.24, 9.58, 0.43],
                    [1.2, -6.45, 9.12, 0.40],
                    [1.9, -6.66, 8.45, 0.26],
                    [2.35, -6.74, 7.95, 0.12],
                ],
                6,
            ),
            lower_lip: knots(
                &[
                    [0.0, -7.36, 9.3, 0.58],
                    [0.7, -7.33, 9.15, 0.57],
                    [1.35, -7.14, 8.72, 0.45],
                    [1.95, -6.92, 8.2, 0.24],
                    [2.35, -6.8, 7.9, 0.12],
                ],
                6,
            ),
            collarbone: knots(
                &[
                    [1.5, -19.1, -0.5, 0.7],
                    [4.5, -18.9, -0.2, 0.6],
                    [8.5, -18.6, -1.6, 0.6],
                    [12.5, -18.5, -3.6, 0.6],
                    [15.6, -19.1, -5.0, 0.7],
                ],
                8,
            ),
            trapezius: knots(
                &[
                    [1.8, -3.6, -6.5, 0.6],
                    [2.3, -8.5, -6.2, 1.4],
                    [3.9, -13.5, -6.8, 2.1],
                    [8.0, -17.8, -6.9, 2.3],
                    [14.5, -20.2, -6.3, 2.3],
                ],
                12,
            ),
            cheekbone_frame: Mat3::from_rotation_y(0.70) * Mat3::from_rotation_z(-0.12),
            ear: Ear::new(),
        }
    }

    /// Signed distance to the skin.
    pub fn distance(&self, p: Vec3) -> f32 {
        let p = mirrored(p);
        self.ear.add(p, self.body(p))
    }

    /// Unit normal of the skin.
    pub fn normal(&self, p: Vec3) -> Vec3 {
        // Four samples on a tetrahedron; 0.02 cm is finer than the finest groove.
        const CORNERS: [Vec3; 4] =
            [vec3(1.0, -1.0, -1.0), vec3(-1.0, -1.0, 1.0), vec3(-1.0, 1.0, -1.0), vec3(1.0, 1.0, 1.0)];
        CORNERS.iter().map(|&c| c * self.distance(p + 0.02 * c)).sum::<Vec3>().normalize_or(Vec3::Y)
    }

    /// The point of the skin near `p`.
    pub fn project(&self, mut p: Vec3) -> Vec3 {
        for _ in 0..4 {
            let d = self.distance(p);
            if d.abs() < 1e-4 {
                break;
            }
            p -= 0.9 * d * self.normal(p);
        }
        p
    }

    /// How far outside the ears, their roots included, a point is.
    pub fn ear_distance(&self, p: Vec3) -> f32 {
        self.ear.distance(self.ear.from_head * (mirrored(p) - EAR_CENTRE))
    }

    fn body(&self, p: Vec3) -> f32 {
        let head = self.face(p, Self::skull(p));
        Self::sternomastoid(p, join(head, self.neck_and_shoulders(p), 2.2))
    }

    fn skull(p: Vec3) -> f32 {
        let cranium = ellipsoid(p, vec3(0.0, 2.75, -1.7), vec3(7.6, 8.5, 8.05));
        let forehead = ellipsoid(p, vec3(0.0, 3.6, 2.0), vec3(6.6, 6.1, 7.0));
        let occiput = ellipsoid(p, vec3(0.0, 0.6, -4.2), vec3(6.2, 5.6, 5.5));
        let d = join(cranium, forehead, 2.5);
        let d = join(d, occiput, 2.5);
        // The temples are flatter than an ellipsoid.
        let temple = ellipsoid(p, vec3(9.1, 1.8, 5.4), vec3(1.6, 3.4, 3.4));
        carve(d, temple, 3.0)
    }

    fn face(&self, p: Vec3, skull: f32) -> f32 {
        let mut d = skull;
        // Masses: mid-face, muzzle, jaw, chin.
        d = join(d, ellipsoid(p, vec3(0.0, -2.7, 2.3), vec3(5.75, 6.9, 6.3)), 2.2);
        d = join(d, ellipsoid(p, vec3(0.0, -6.1, 4.6), vec3(4.1, 4.3, 4.6)), 2.4);
        d = join(d, tube(p, &self.jaw), 2.6);
        d = join(d, ellipsoid(p, vec3(0.0, -9.6, 7.1), vec3(1.6, 1.4, 1.75)), 1.6);
        // Cheeks: bone high and turned outwards, a soft hollow below it.
        let cheekbone = turned_ellipsoid(p, vec3(4.3, -2.0, 4.9), &self.cheekbone_frame, vec3(1.8, 1.2, 1.55));
        d = join(d, cheekbone, 2.4);
        d = join(d, cone(p, vec3(4.9, -1.9, 4.0), vec3(6.2, -1.2, 0.2), 0.8, 0.7), 2.4);
        let hollow = ellipsoid(p, vec3(8.1, -5.6, 4.6), vec3(1.2, 2.2, 2.6));
        d = carve(d, hollow, 2.6);
        // Brow ridge over the sockets.
        d = join(d, tube(p, &self.brow), 1.6);
        let socket = ellipsoid(p, vec3(3.15, 0.2, 8.9), vec3(2.0, 1.2, 1.6));
        d = carve(d, socket, 1.5);
        d = self.eye(p, d);
        d = self.nose(p, d);
        self.mouth(p, d)
    }

    fn eye(&self, p: Vec3, d: f32) -> f32 {
        if (p - EYE).length_squared() > 16.0 {
            return d;
        }
        let ball = ellipsoid(p, EYE, vec3(EYE_RADIUS, EYE_RADIUS * 0.93, EYE_RADIUS));
        let mut d = join(d, ball - 0.02, 0.8);
        // The upper lid lies over the lower one along the lash line.
        let q = p - EYE;
        let lash_y = -0.66 + 0.24 * q.x * q.x + 0.1 * q.x;
        let upper = meet(ball - 0.08, lash_y - q.y, 0.18);
        let upper = meet(upper, q.x.abs() - 1.5, 0.4);
        d = join(d, upper, 0.2);
        // Grooves press the skin in along curves seen from the front: they cannot undercut it.
        let flat = vec3(p.x, p.y, 0.0);
        let lash = smoothstep(0.11, -0.09, tube(flat, &self.lash_line));
        let crease = smoothstep(0.14, -0.08, tube(flat, &self.lid_crease));
        d + 0.09 * lash + 0.08 * crease
    }

    fn nose(&self, p: Vec3, d: f32) -> f32 {
        if (p - vec3(0.0, -1.5, 9.5)).length_squared() > 49.0 {
            return d;
        }
        let mut d = join(d, tube(p, &self.nose), 1.1);
        // Side walls, wings, the point, the septum.
        d = join(d, cone(p, vec3(0.7, -0.6, 8.5), vec3(0.95, -3.2, 9.0), 0.35, 0.65), 1.0);
        d = join(d, ellipsoid(p, vec3(1.12, -3.8, 9.35), vec3(0.55, 0.58, 0.85)), 0.6);
        d = join(d, ellipsoid(p, vec3(0.0, -3.55, 10.65), vec3(0.78, 0.66, 0.72)), 0.7);
        d = join(d, cone(p, vec3(0.0, -4.35, 9.4), vec3(0.0, -3.95, 10.6), 0.36, 0.4), 0.5);
        let wing_fold = ellipsoid(p, vec3(1.98, -3.8, 9.15), vec3(0.15, 0.6, 0.45));
        d = carve(d, wing_fold, 0.5);
        let nostril =
            turned_ellipsoid(p, vec3(0.62, -4.5, 9.75), &Mat3::from_rotation_y(-0.35), vec3(0.28, 0.32, 0.55));
        carve(d, nostril, 0.25)
    }

    fn mouth(&self, p: Vec3, d: f32) -> f32 {
        if (p - vec3(0.0, -7.0, 8.6)).length_squared() > 36.0 {
            return d;
        }
        // The philtrum: two columns and the groove between them.
        let mut d = join(d, cone(p, vec3(0.42, -4.9, 9.45), vec3(0.62, -6.05, 9.35), 0.22, 0.28), 0.55);
        d = carve(d, cone(p, vec3(0.0, -4.9, 9.98), vec3(0.0, -6.1, 9.98), 0.2, 0.26), 0.35);
        d = join(d, tube(p, &self.upper_lip), 0.32);
        d = join(d, tube(p, &self.lower_lip), 0.32);
        d = carve(d, tube(p, &self.mouth_line), 0.16);
        // Corners sink, and the chin begins below a fold.
        d = carve(d, ellipsoid(p, vec3(2.75, -6.75, 8.5), vec3(0.22, 0.28, 0.4)), 0.7);
        carve(d, ellipsoid(p, vec3(0.0, -8.5, 9.85), vec3(1.9, 0.5, 0.75)), 0.9)
    }

    fn neck_and_shoulders(&self, p: Vec3) -> f32 {
        // The neck leans forward 17 degrees.
        let squeezed = vec3(p.x * 1.03, p.y, p.z);
        let neck = cone(squeezed, vec3(0.0, -4.0, -1.4), vec3(0.0, -19.0, -5.7), 5.3, 5.65);
        let mut d = join(neck, tube(p, &self.trapezius), 2.8);
        let girdle = cone(p, vec3(0.0, -21.5, -5.6), vec3(15.2, -22.3, -5.6), 4.2, 3.9);
        let ribs = ellipsoid(p, vec3(0.0, -27.5, -4.4), vec3(16.0, 9.5, 8.0));
        let deltoid = ellipsoid(p, vec3(16.6, -23.4, -5.4), vec3(3.7, 5.2, 4.3));
        let torso = join(join(girdle, ribs, 3.0), deltoid, 2.0);
        d = join(d, torso, 3.2);
        d = join(d, tube(p, &self.collarbone), 1.6);
        // The hollow over the breast bone.
        d = carve(d, ellipsoid(p, vec3(0.0, -18.2, 0.75), vec3(0.9, 0.9, 0.6)), 1.4);
        let cut = meet(p.x - SHOULDER_CUT, BASE - p.y, 4.0);
        meet(d, cut, 2.4)
    }

    /// The muscle from behind the ear to the breast bone, and the larynx.
    fn sternomastoid(p: Vec3, d: f32) -> f32 {
        let d = join(d, cone(p, vec3(5.0, -5.2, -2.6), vec3(1.2, -18.6, -0.9), 0.8, 0.6), 1.8);
        join(d, ellipsoid(p, vec3(0.0, -13.0, 0.9), vec3(0.9, 1.4, 0.8)), 2.0)
    }
}

/// The outer ear, sculpted in its own frame: x forward, y up, z out of its plate.
struct Ear {
    from_head: Mat3,
    helix: Vec<(Vec3, f32)>,
    antihelix: Vec<(Vec3, f32)>,
    tragus: Vec<(Vec3, f32)>,
}

const EAR_CENTRE: Vec3 = vec3(7.35, -1.1, -1.7);

impl Ear {
    fn new() -> Self {
        let knots = |points: &[[f32; 4]], n| {
            curve(&points.iter().map(|k| (vec3(k[0], k[1], k[2]), k[3])).collect::<Vec<_>>(), n)
        };
        // Plate normal: out to the side, turned forward because the ear stands off behind.
        let out = vec3(0.90, 0.06, 0.43).normalize();
        let up = vec3(-0.02, 0.97, -0.22);
        let forward = up.cross(out).normalize();
        let up = out.cross(forward);
        Self {
            from_head: Mat3::from_cols(forward, up, out).transpose(),
            helix: knots(
                &[
                    [0.55, 0.15, 0.1, 0.20],
                    [1.15, 0.75, 0.25, 0.30],
                    [1.2, 1.75, 0.3, 0.33],
                    [0.65, 2.7, 0.3, 0.35],
                    [-0.35, 3.1, 0.3, 0.36],
                    [-1.3, 2.7, 0.35, 0.37],
                    [-1.85, 1.6, 0.4, 0.36],
                    [-1.85, 0.3, 0.42, 0.33],
                    [-1.45, -1.0, 0.38, 0.30],
                    [-0.85, -2.0, 0.3, 0.30],
                ],
                4,
            ),
            antihelix: knots(
                &[
                    [0.3, 2.0, 0.12, 0.22],
                    [-0.35, 1.7, 0.25, 0.28],
                    [-0.85, 0.9, 0.36, 0.32],
                    [-0.95, -0.1, 0.4, 0.32],
                    [-0.6, -1.0, 0.38, 0.32],
                    [-0.05, -1.35, 0.35, 0.30],
                ],
                4,
            ),
            tragus: knots(&[[1.05, 0.25, 0.2, 0.25], [0.8, -0.25, 0.42, 0.32], [0.75, -0.75, 0.36, 0.26]], 4),
        }
    }

    fn add(&self, p: Vec3, d: f32) -> f32 {
        let q = self.from_head * (p - EAR_CENTRE);
        if q.length_squared() > 30.0 {
            return d;
        }
        let blend = 0.35 + 0.5 * smoothstep(-1.0, 0.8, q.x);
        join(d, self.distance(q), blend)
    }

    /// Distance in the ear's own frame.
    fn distance(&self, q: Vec3) -> f32 {
        // A plate in the outline of an ear: wide above, narrow below, dished.
        let upper = ellipsoid(q, vec3(-0.3, 0.9, 0.0), vec3(1.85, 2.35, 0.42));
        let lower = ellipsoid(q, vec3(-0.25, -1.2, 0.05), vec3(1.25, 1.9, 0.4));
        let mut ear = join(upper, lower, 1.2);
        // The root that holds it to the head, in front and behind the concha.
        let root = ellipsoid(q, vec3(0.35, 0.0, -0.7), vec3(1.0, 2.0, 1.3));
        ear = join(ear, root, 0.5);
        ear = join(ear, tube(q, &self.helix), 0.3);
        // The groove between helix and antihelix, then the antihelix in it.
        let scapha = ellipsoid(q, vec3(-0.55, 1.2, 0.55), vec3(1.15, 1.55, 0.42));
        ear = carve(ear, scapha, 0.3);
        ear = join(ear, tube(q, &self.antihelix), 0.35);
        let concha = ellipsoid(q, vec3(0.15, -0.15, 0.45), vec3(0.72, 1.0, 0.95));
        ear = carve(ear, concha, 0.35);
        ear = join(ear, tube(q, &self.tragus), 0.3);
        let lobe = ellipsoid(q, vec3(0.0, -2.45, 0.28), vec3(0.85, 0.85, 0.38));
        join(ear, lobe, 0.5)
    }
}

/// Mirror to the model's left without a crease: features off the middle must meet their twins smoothly.
fn mirrored(p: Vec3) -> Vec3 {
    vec3((p.x * p.x + 0.03).sqrt(), p.y, p.z)
}
