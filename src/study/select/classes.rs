//! Dynamic classes in order.

use crate::criteria::Class;

/// Dynamic classes from best to worst.
pub const CLASSES: [Class; 4] = [Class::Stable, Class::SemiStable, Class::SemiUnstable, Class::Unstable];
