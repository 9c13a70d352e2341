//! How well a gripper holds.
//!
//! | file | job |
//! |---|---|
//! | `polar` | limits of pulses, by their directions |
//! | `frequency` | limits of vibrations, by their frequencies |
//! | `slip` | the slip of every run, over its load |

mod frequency;
mod polar;
mod slip;

use crate::study::hold::{Hold, Loads};

/// Fewer directions or frequencies than these are no curve.
const CURVE: usize = 3;

/// The picture that suits the loads: polar for directions, over frequency for vibrations, and the slip over the load where there is only
/// one of them.
pub fn hold(found: &Hold) -> String {
    match &found.plan.loads {
        Loads::Pulses { directions, .. } if *directions >= CURVE => polar::polar(found),
        Loads::Vibrations { frequencies_hz, .. } if frequencies_hz.len() >= CURVE => frequency::frequency(found),
        _ => slip::slip(found),
    }
}
