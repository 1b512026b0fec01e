//! `--in-unit` and `--in-up`: what an imported file's numbers are, where the guess is wrong.

use lorelei_core::io::{Axis, ImportOptions, Unit};

#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct ReadAs {
    /// The unit of the hair file's numbers: cm, m, mm or in. Without it: guessed from the size of the hair.
    #[arg(id = "in_unit", long = "in-unit", value_name = "UNIT")]
    unit: Option<Unit>,
    /// The axis that points up in the hair file: y, z, x, -x, -y or -z. Without it: guessed from how the hair falls.
    #[arg(id = "in_up", long = "in-up", value_name = "AXIS", allow_hyphen_values = true)]
    up: Option<Axis>,
    /// The axis that the face looks along in the hair file. Without it: what is usual for the axis that is up.
    #[arg(id = "in_front", long = "in-front", value_name = "AXIS", allow_hyphen_values = true)]
    front: Option<Axis>,
}

impl ReadAs {
    pub fn options(self) -> ImportOptions {
        ImportOptions { unit: self.unit, up: self.up, front: self.front }
    }
}
