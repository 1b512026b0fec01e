//! The compute rasteriser against the exact picture.

use super::*;
use crate::testing::{SIZE, Tangle};

fn input<'a>(scene: crate::testing::Scene<'a>, opaque: bool) -> RasterInput<'a> {
    RasterInput {
        strands: scene.strands,
        radiance: scene.radiance,
        view: scene.view,
        size: [SIZE; 2],
        head_depth: scene.head_depth,
        head_colour: scene.head_colour,
        opaque,
    }
}

fn draw(tangle: &mut Tangle, opaque: bool) -> Vec<[f64; 4]> {
    let library = ShaderLibrary::embedded();
    let mut rasteriser = Rasteriser::new(&tangle.gpu, &library).expect("the raster shaders link");
    let mut frame = |tangle: &mut Tangle| {
        let picture = tangle.draw(|gpu, encoder, scene, target| {
            rasteriser.record(gpu, &library, encoder, &input(scene, opaque), target).expect("the rasteriser binds");
        });
        let again = rasteriser.settle_now(&tangle.gpu).expect("the device is there");
        (picture, again)
    };
    let (first, again) = frame(tangle);
    if !again {
        return first;
    }
    let (second, again) = frame(tangle);
    assert!(!again, "a list that grew is long enough");
    second
}

#[test]
fn front_to_back_composites_like_the_exact_picture() {
    let Some(mut tangle) = Tangle::new(2_000) else { return };
    let picture = draw(&mut tangle, false);
    let (rmse, coverage) = tangle.against_exact(&picture);
    println!("compute: rmse {rmse:.4}, coverage {coverage:.4} of exact");
    assert!((coverage - 1.0).abs() < 0.01, "coverage {coverage} of exact");
    assert!(rmse < 0.02, "rmse {rmse}");
}

#[test]
fn opaque_pixels_are_full_or_empty() {
    let Some(mut tangle) = Tangle::new(2_000) else { return };
    let picture = draw(&mut tangle, true);
    assert!(picture.iter().all(|pixel| pixel[3] == 0.0 || pixel[3] == 1.0));
    let (_, coverage) = tangle.against_exact(&picture);
    assert!(coverage > 1.05, "opaque strands cover more than their area: {coverage}");
}
