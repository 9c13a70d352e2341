//! Draws the linkage of a scene with the symbols used in scenes and results, as SVG for light and dark
//! backgrounds.
//!
//! | file | job |
//! |---|---|
//! | `mechanism` | posture, joints and contacts of the drawn finger |
//! | `annotations` | symbols, and the lines that show their meaning |
//! | `label_placement` | placement of labels without overlaps |
//! | `draw` | shapes, lines, symbols, and the table below them |

mod annotations;
mod draw;
mod label_placement;
mod mechanism;

pub use label_placement::LabelBox;

use crate::scene::Scene;

/// Drawing of a linkage.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    pub svg: String,
    /// The symbols in the drawing and their boxes, in pixels.
    pub labels: Vec<(&'static str, LabelBox)>,
    /// Width and height of the drawing, without the table below it.
    pub size: [f64; 2],
}

/// Draws the linkage of a finger in its final grasp, or at its start if it has none.
pub fn linkage(scene: &Scene) -> Linkage {
    let mechanism = mechanism::mechanism(scene);
    let annotations = annotations::annotations(scene, &mechanism);
    draw::draw(scene, &mechanism, &annotations)
}
