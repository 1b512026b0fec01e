// Colours of false-colour views, as light: a display encodes them again. Twin of core/src/look/view.rs.
#define_import_path lorelei::view_ramp

// A display's value as light (IEC 61966-2-1).
fn light_of(encoded: vec3<f32>) -> vec3<f32> {
    let power = pow((max(encoded, vec3<f32>(0.0)) + 0.055) / 1.055, vec3<f32>(2.4));
    return select(power, encoded / 12.92, encoded <= vec3<f32>(0.04045));
}

// A display's colour for a share of 0 to 1: a polynomial (M. Zucker 2019, public domain) through viridis.
fn ramp(share: f32) -> vec3<f32> {
    let x = saturate(share);
    var colour = vec3<f32>(-5.435455855934631, 4.645852612178535, 26.3124352495832);
    colour = colour * x + vec3<f32>(4.776384997670288, -13.74514537774601, -65.35303263337234);
    colour = colour * x + vec3<f32>(6.228269936347081, 14.17993336680509, 56.69055260068105);
    colour = colour * x + vec3<f32>(-4.634230498983486, -5.799100973351585, -19.33244095627987);
    colour = colour * x + vec3<f32>(-0.3308618287255563, 0.214847559468213, 0.09509516302823659);
    colour = colour * x + vec3<f32>(0.1050930431085774, 1.404613529898575, 1.384590162594685);
    colour = colour * x + vec3<f32>(0.2777273272234177, 0.005407344544966578, 0.3340998053353061);
    return saturate(colour);
}
