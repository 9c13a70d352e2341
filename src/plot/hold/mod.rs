//! Plots of the largest loads at which a gripper holds its object.
//!
//! | file | job |
//! |---|---|
//! | `polar` | largest pulse in each direction, as a polar plot |
//! | `frequency` | largest vibration over its frequency |
//! | `slip` | slip of every run over its load |

mod frequency;
mod polar;
mod slip;

use crate::study::hold::{Hold, Loads};

/// Minimum number of directions or frequencies of a curve.
const MIN_CURVE_POINTS: usize = 3;

/// Draws the plot that suits the loads: limits by direction for pulses, by frequency for vibrations, or the slip over
/// the load if there are too few of them.
pub fn hold(found: &Hold) -> String {
    match &found.plan.loads {
        Loads::Pulses { directions, .. } if *directions >= MIN_CURVE_POINTS => polar::polar(found),
        Loads::Vibrations { frequencies_hz, .. } if frequencies_hz.len() >= MIN_CURVE_POINTS => {
            frequency::frequency(found)
        }
        _ => slip::slip(found),
    }
}
