//! Classes of a grasp, from the best.

use crate::criteria::Class;

/// From best to worst.
pub const CLASSES: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];
