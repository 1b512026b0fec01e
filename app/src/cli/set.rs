//! `--set KEY=VALUE`: the look, the fibre of every layer, and movement, all through the one table.

use lorelei_core::groom::{Groom, HairMaterial};
use lorelei_core::look::{SetError, Slot, set};

use super::CliError;

/// Split `KEY=VALUE`, for clap.
pub fn parse_assignment(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("write it as KEY=VALUE, such as shadowing=off")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}

/// Apply assignments in order.
pub fn apply(groom: &mut Groom, assignments: &[(String, String)]) -> Result<(), CliError> {
    for (key, value) in assignments {
        apply_one(groom, key, value).map_err(|why| CliError::Usage(format!("--set {key}={value}: {why}")))?;
    }
    Ok(())
}

fn apply_one(groom: &mut Groom, key: &str, value: &str) -> Result<(), SetError> {
    let head = key.split('.').next().unwrap_or_default();
    if head == "hair" {
        // Checked even where there is no layer.
        set(&mut [HairMaterial::default().slot()], key, value)?;
        return groom.layers.iter_mut().try_for_each(|layer| set(&mut [layer.material.slot()], key, value));
    }
    let Groom { look, simulation, .. } = groom;
    let mut slots: Vec<Slot<'_>> = look.slots();
    slots.push(simulation.slot());
    set(&mut slots, key, value)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use lorelei_core::groom::{Layer, Source};
    use lorelei_core::strands::Strands;

    use super::*;

    #[test]
    fn assignments_reach_look_movement_and_the_fibre_of_every_layer() {
        let layer = || Layer::new("a", Source::Strands(Arc::new(Strands::default())));
        let mut groom = Groom { layers: vec![layer(), layer()], ..Groom::default() };
        let assignments = ["shadowing=off", "sim.gravity=0", "hair.eumelanin=8", "hair.beta_n = 0.5"]
            .map(|t| parse_assignment(t).unwrap());
        apply(&mut groom, &assignments).unwrap();
        assert_eq!(groom.simulation.gravity, 0.0);
        assert!(groom.layers.iter().all(|layer| layer.material.eumelanin == 8.0 && layer.material.beta_n == 0.5));
        for bad in ["hair.eumelanin=x", "sim.nothing=1", "shadowing=magic", "nothing=1"] {
            let assignment = parse_assignment(bad).unwrap();
            assert!(matches!(apply(&mut Groom::default(), &[assignment]), Err(CliError::Usage(_))), "{bad}");
        }
        assert!(parse_assignment("shadowing").is_err());
    }
}
