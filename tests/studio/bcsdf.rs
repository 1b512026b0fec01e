//! Chiang's model against the tables of an independent implementation (Mitsuba 3.9.1's hair BSDF: beta 0.3/0.3, scales
//! tilted by 2 degrees, eta 1.55, absorption 0.03/0.07/0.15 a radius). There theta_i is the eye's, theta_o the light's, and
//! scales tilt the other way.

use glam::Vec3;
use lorelei_core::groom::HairMaterial;
use lorelei_core::look::{Look, Scattering};
use lorelei_render::scattering::table::Table;
use lorelei_render::scattering::tables::{Baked, Recipe};
use lorelei_render::scattering::{Directions, Fibre, NO_OFFSET, chiang};
use lorelei_tests::shared;

const SIGMA_A: [f32; 3] = [0.03, 0.07, 0.15];

fn mitsubas() -> (Fibre, Vec<Table>) {
    let beta_m = 0.3f32;
    // Chiang et al. 2016, eq. 7: the deviation of R in theta is this, in theta_h half of it.
    let deviation = 0.726 * beta_m + 0.812 * beta_m * beta_m + 3.7 * beta_m.powi(20);
    let material = HairMaterial {
        beta_m_deg: (0.5 * deviation).to_degrees(),
        beta_n: 0.3,
        tilt_deg: -2.0,
        index_of_refraction: 1.55,
        ..HairMaterial::default()
    };
    let look = Look { scattering: Scattering::Chiang, ..Look::default() };
    let fibre = Fibre { sigma_a: SIGMA_A, ..Fibre::new(&material, &look) };
    (fibre, Baked::new(&Recipe::of(&material, &look)).azimuthal)
}

/// Light and eye by their angles in degrees; the fibre runs along y.
fn directions(theta_eye: f32, theta_light: f32, phi: f32, h: f32) -> Directions {
    let direction = |theta: f32, phi: f32| {
        let (theta, phi) = (theta.to_radians(), phi.to_radians());
        Vec3::new(theta.cos() * phi.cos(), theta.sin(), theta.cos() * phi.sin())
    };
    // phi grows from x to z.
    Directions { h, ..Directions::new(Vec3::Y, direction(theta_light, phi), direction(theta_eye, 0.0)) }
}

/// Rows of numbers of a table, its head left out.
fn rows(name: &str) -> Option<Vec<Vec<f32>>> {
    let text = std::fs::read_to_string(shared(name)?).unwrap();
    Some(text.lines().skip(1).map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect())
}

/// Worst difference as a share of the value, where it is at least `least`.
fn worst(pairs: impl Iterator<Item = (Vec3, Vec3, String)>, least: f32) -> (f32, String) {
    let mut worst = (0.0, String::new());
    for (ours, theirs, place) in pairs {
        let error = ((ours - theirs).abs() / theirs.max(Vec3::splat(least))).max_element();
        if error > worst.0 || error.is_nan() {
            worst = (error, format!("{place}: {ours} against {theirs}"));
        }
    }
    worst
}

#[test]
fn chiang_s_near_field_agrees_with_an_independent_table() {
    let Some(rows) = rows("bcsdf/near.csv") else { return };
    let (fibre, tables) = mitsubas();
    let pairs = rows.iter().map(|row| {
        let ours = chiang::scatter(&fibre, &tables, &directions(row[0], row[1], row[2], row[3]));
        (ours, Vec3::new(row[4], row[5], row[6]), format!("{:?}", &row[..4]))
    });
    // Mitsuba's Bessel series is up to 0.55 % off. 1e-3: a thousandth of what a white card shows is 3e-4.
    let (error, place) = worst(pairs, 1e-3);
    println!("near field: {} rows, worst {:.2} % at {place}", rows.len(), 100.0 * error);
    assert!(rows.len() > 10_000 && error < 0.02, "{error} at {place}");
}

#[test]
fn chiang_s_far_field_agrees_with_an_independent_table() {
    let Some(rows) = rows("bcsdf/far.csv") else { return };
    let (fibre, tables) = mitsubas();
    let pairs = rows.iter().map(|row| {
        let ours = chiang::scatter(&fibre, &tables, &directions(row[0], row[1], row[2], NO_OFFSET));
        (ours, Vec3::new(row[3], row[4], row[5]), format!("{:?}", &row[..3]))
    });
    let (error, place) = worst(pairs, 1e-3);
    println!("far field: {} rows, worst {:.2} % at {place}", rows.len(), 100.0 * error);
    assert!(rows.len() > 1000 && error < 0.02, "{error} at {place}");
}

#[test]
fn chiang_s_lobes_agree_with_an_independent_table_one_by_one() {
    let Some(rows) = rows("bcsdf/lobes.csv") else { return };
    let (fibre, tables) = mitsubas();
    for lobe in 0..4 {
        let mut alone = Fibre { sigma_a: [0.0; 3], weight: [0.0; 3], weight_rest: 0.0, ..fibre };
        if lobe < 3 {
            alone.weight[lobe] = 1.0;
        } else {
            alone.weight_rest = 1.0;
        }
        let pairs = rows.iter().map(|row| {
            let ours = chiang::scatter(&alone, &tables, &directions(row[0], row[1], row[2], row[3]));
            (ours, Vec3::splat(row[4 + lobe]), format!("lobe {lobe} {:?}", &row[..4]))
        });
        let (error, place) = worst(pairs, 1e-3);
        println!("lobe {lobe}: worst {:.2} % at {place}", 100.0 * error);
        assert!(error < 0.02, "{error} at {place}");
    }
}
