//! The linkage of a scene with every letter of scenes and results on it, as an SVG that reads on light and dark grounds.
//!
//! | file | job |
//! |---|---|
//! | `mechanism` | the finger at its grasp: joints, contacts, angles |
//! | `marks` | what each letter names, and the lines that show it |
//! | `place` | where the labels go |
//! | `draw` | shapes, lines, letters, and the table below them |

mod draw;
mod marks;
mod mechanism;
mod place;

pub use place::Spot;

use crate::scene::Scene;

/// A drawing of a linkage.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    pub svg: String,
    /// The letters in the drawing and where they stand, in pixels.
    pub labels: Vec<(&'static str, Spot)>,
    /// Width and height of the drawing, without the table below it.
    pub size: [f64; 2],
}

/// Draws the linkage of a finger: at its grasp, or where there is none, at its start.
pub fn linkage(scene: &Scene) -> Linkage {
    let mechanism = mechanism::mechanism(scene);
    let drawn = marks::marks(scene, &mechanism);
    draw::draw(scene, &mechanism, &drawn)
}
