//! Add: deleted hair comes back.

use super::delete::thin_out;
use super::{Dab, Hair};

pub(super) fn add(hair: &mut Hair<'_>, dab: &Dab<'_>) {
    thin_out(hair, -dab.sign());
}
