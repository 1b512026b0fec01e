// Slot `environment`: one sample of the irradiance, as if from one light (Karis 2016; 002, section 4.4). Twin of `karis` in
// render/src/environment/lit.rs.
// slot: environment
#define_import_path lorelei::shade_environment_karis
#import lorelei::scatter_fibre::{Fibre, directions}
#import lorelei::scatter_volume::{Volume}
#import lorelei::scattering::{scatter}
#import lorelei::multiple::{multiple}
#import lorelei::environment_harmonics::{irradiance_at}
#import lorelei::environment_open::{Open}

const SHINES: bool = true;

// Added to the longitudinal roughness, radians: the light is as wide as half the sky (Karis 2016).
const AREA: f32 = 0.2;
const PI: f32 = 3.14159265358979324;
const FAR: f32 = 2.0;

fn environment(base: Fibre, heap: Volume, tangent: vec3<f32>, to_eye: vec3<f32>, open: Open) -> vec3<f32> {
    let across = to_eye - tangent * dot(to_eye, tangent);
    let normal = across / max(length(across), 1e-3);
    var fibre = base;
    fibre.beta += AREA;
    fibre.weight.y = 0.0;
    fibre.weight.x *= min(dot(normal, to_eye) + 1.0, 1.0);
    let d = directions(tangent, normal, to_eye, FAR);
    let sent = scatter(fibre, d) + multiple(base, heap, tangent, normal, to_eye, 0.0);
    let share = open.share * (1.0 + 2.0 / 3.0 * dot(open.towards, normal));
    return sent * (PI * irradiance_at(normal)) * share;
}
